"""Control, guidance and allocation: arrays in, arrays out; no MuJoCo here."""

from marine_mj.controllers.allocation import Allocator
from marine_mj.controllers.ar_prediction import ArPredictor
from marine_mj.controllers.cpv import CPV_GAINS, Cpv, CpvGains, CpvState, cpv_gain_set
from marine_mj.controllers.cpva import CPVA_GAINS, Cpva, CpvaGains, CpvaState, cpva_gain_set
from marine_mj.controllers.cruise import CRUISE_LAWS, CruiseGuidance, CruiseState
from marine_mj.controllers.demand import Demand, Preview
from marine_mj.controllers.docking import DockFrames, DockingPilot, PilotState
from marine_mj.controllers.docking_plan import DockingPlan
from marine_mj.controllers.hydrostatics import Hydrostatics
from marine_mj.controllers.kinematics import (
    Accelerometer,
    RigidState,
    acceleration_at,
    pose_error,
    relative_velocity,
)
from marine_mj.controllers.latch import Latch, LatchState
from marine_mj.controllers.lqr import LQR_WEIGHTS, Lqr, LqrState, LqrWeights
from marine_mj.controllers.mpc import Mpc, MpcState
from marine_mj.controllers.mpc_settings import MPC_SETTINGS, MpcSettings
from marine_mj.controllers.observer import ObserverState, VehicleModel
from marine_mj.controllers.pid import Limits, Pid, PidGains, PidState
from marine_mj.controllers.polynomial_prediction import PolynomialPredictor
from marine_mj.controllers.pose_pid import GAINS, PosePid, gain_set, limits_from_frd
from marine_mj.controllers.prediction import KinematicPredictor, Prediction, Predictor
from marine_mj.controllers.pursuit import PursuitGuidance
from marine_mj.controllers.sliding import SLIDING_GAINS, SlidingGains, SlidingMode
from marine_mj.controllers.station import StationGuidance
from marine_mj.controllers.waypoints import DockingGuidance, GuidanceState, Phase

__all__ = [
    "CPVA_GAINS",
    "CPV_GAINS",
    "CRUISE_LAWS",
    "GAINS",
    "LQR_WEIGHTS",
    "MPC_SETTINGS",
    "SLIDING_GAINS",
    "Accelerometer",
    "Allocator",
    "ArPredictor",
    "Cpv",
    "CpvGains",
    "CpvState",
    "Cpva",
    "CpvaGains",
    "CpvaState",
    "CruiseGuidance",
    "CruiseState",
    "Demand",
    "DockFrames",
    "DockingGuidance",
    "DockingPilot",
    "DockingPlan",
    "GuidanceState",
    "Hydrostatics",
    "KinematicPredictor",
    "Latch",
    "LatchState",
    "Limits",
    "Lqr",
    "LqrState",
    "LqrWeights",
    "Mpc",
    "MpcSettings",
    "MpcState",
    "ObserverState",
    "Phase",
    "Pid",
    "PidGains",
    "PidState",
    "PilotState",
    "PolynomialPredictor",
    "PosePid",
    "Prediction",
    "Predictor",
    "Preview",
    "PursuitGuidance",
    "RigidState",
    "SlidingGains",
    "SlidingMode",
    "StationGuidance",
    "VehicleModel",
    "acceleration_at",
    "cpv_gain_set",
    "cpva_gain_set",
    "gain_set",
    "limits_from_frd",
    "pose_error",
    "relative_velocity",
]
