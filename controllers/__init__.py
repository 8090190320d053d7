"""Control, guidance and allocation: arrays in, arrays out; no MuJoCo here."""

from marine_mj.controllers.allocation import Allocator
from marine_mj.controllers.cpv import CPV_GAINS, Cpv, CpvGains, CpvState, cpv_gain_set
from marine_mj.controllers.docking import DockFrames, DockingPilot, PilotState
from marine_mj.controllers.kinematics import (
    Accelerometer,
    RigidState,
    acceleration_at,
    pose_error,
    relative_velocity,
)
from marine_mj.controllers.latch import Latch, LatchState
from marine_mj.controllers.observer import ObserverState, VehicleModel
from marine_mj.controllers.pid import Limits, Pid, PidGains, PidState
from marine_mj.controllers.pose_pid import GAINS, Hydrostatics, PosePid, gain_set, limits_from_frd
from marine_mj.controllers.waypoints import DockingGuidance, DockingPlan, GuidanceState, Phase

__all__ = [
    "CPV_GAINS",
    "GAINS",
    "Accelerometer",
    "Allocator",
    "Cpv",
    "CpvGains",
    "CpvState",
    "DockFrames",
    "DockingGuidance",
    "DockingPilot",
    "DockingPlan",
    "GuidanceState",
    "Hydrostatics",
    "Latch",
    "LatchState",
    "Limits",
    "ObserverState",
    "Phase",
    "Pid",
    "PidGains",
    "PidState",
    "PilotState",
    "PosePid",
    "RigidState",
    "VehicleModel",
    "acceleration_at",
    "cpv_gain_set",
    "gain_set",
    "limits_from_frd",
    "pose_error",
    "relative_velocity",
]
