"""Autopilots of the docking task: controllers, predictors and guidance that settings ask for."""

from dataclasses import replace

import numpy as np

from marine_mj.controllers import (
    CPV_GAINS,
    LQR_WEIGHTS,
    MPC_SETTINGS,
    SLIDING_GAINS,
    Accelerometer,
    ArPredictor,
    Cpv,
    Cpva,
    CruiseGuidance,
    DockingGuidance,
    DockingPilot,
    DockingPlan,
    KinematicPredictor,
    Limits,
    Lqr,
    Mpc,
    Pid,
    PolynomialPredictor,
    PosePid,
    Prediction,
    Predictor,
    PursuitGuidance,
    SlidingMode,
    StationGuidance,
    VehicleModel,
    cpv_gain_set,
    cpva_gain_set,
    gain_set,
)
from marine_mj.controllers.docking import Controller
from marine_mj.scenario import Scenario
from marine_mj.tasks.docking_physics import DockingPhysics
from marine_mj.tasks.docking_settings import DockingSettings, PredictionSettings


def docking_pilot(
    scenario: Scenario, settings: DockingSettings, physics: DockingPhysics, limits: Limits
) -> DockingPilot:
    """Autopilot of a scenario, with what the compiled scene says of its vehicle.

    Args:
        scenario: what is run.
        settings: settings of the task.
        physics: of the compiled scene.
        limits: of the wrench, FLU.
    """
    period = scenario.control_period
    plan = replace(settings.plan.plan(), axis=physics.geometry.axis)
    published = settings.controller == "cpva" and settings.gain_set == "reference"
    return DockingPilot(
        controller=_controller(scenario, settings, physics, limits),
        frames=physics.dock_frames,
        period=period,
        guidance=_guidance(scenario, settings, plan, period),
        prediction=_prediction(settings.prediction, period),
        preview=_preview(settings, period),
        # The reference knows accelerations exactly: neither smoothed nor ahead.
        meter=Accelerometer(period, smoothing=1e-9, lead=0.0) if published else None,
    )


def _guidance(
    scenario: Scenario, settings: DockingSettings, plan: DockingPlan, period: float
) -> DockingGuidance | StationGuidance | PursuitGuidance | CruiseGuidance:
    """Where the settings steer to: the dock, a station below it, or a waypoint.

    The guidance laws know the current at the surface.
    """
    if settings.station is not None:
        return StationGuidance(settings.station, plan)
    if (to := settings.waypoint) is not None:
        parts = (np.array(part) for part in (to.pose, to.rate, to.acceleration))
        return PursuitGuidance(period, *parts, plan)
    if settings.guidance == "target_state":
        return DockingGuidance(plan)
    flow = np.deg2rad(scenario.current.direction_deg)
    current = scenario.current.speed * np.array([np.cos(flow), -np.sin(flow)])
    return CruiseGuidance(settings.guidance, settings.cruise_speed, plan, current)


def _controller(
    scenario: Scenario, settings: DockingSettings, physics: DockingPhysics, limits: Limits
) -> Controller:
    """The controller that the settings ask for."""
    period, vehicle = scenario.control_period, physics.vehicle
    statics = physics.hydrostatics(vehicle, scenario.water_density)
    kind, gains = settings.controller, settings.gain_set
    if kind == "pose_pid":
        values = settings.gain_values
        chosen = gain_set(gains) if values is None else values.gains()
        error_limit = float("inf") if settings.error_limit is None else settings.error_limit
        return PosePid(Pid(chosen, limits, period), statics, error_limit)
    if kind == "cpva":
        return Cpva.from_gains(cpva_gain_set(gains), limits, period, statics)
    inertia, lag = physics.inertia(vehicle), physics.thruster_lag(vehicle)
    if kind == "cpv":
        own = VehicleModel(inertia, lag) if gains == "extended" else None
        return Cpv.from_gains(cpv_gain_set(gains), limits, period, statics, own)
    model = VehicleModel(inertia, lag, damping=physics.damping(vehicle))
    if kind == "lqr":
        return Lqr(LQR_WEIGHTS[gains], limits, period, model, statics)
    if kind == "sliding":
        return SlidingMode(SLIDING_GAINS[gains], limits, period, model, statics)
    cascade = Cpv.from_gains(CPV_GAINS["extended"], limits, period, statics, model)
    return Mpc(MPC_SETTINGS[gains], cascade)


def _prediction(settings: PredictionSettings | None, period: float) -> Prediction | None:
    """The prediction that the settings ask for."""
    if settings is None:
        return None
    vehicle, carrier = (
        _predictor(settings, period, settings.t_pred, turning) for turning in (True, False)
    )
    return Prediction(
        settings.t_pred,
        None if settings.of == "carrier" else vehicle,
        None if settings.of == "vehicle" else carrier,
    )


def _preview(settings: DockingSettings, period: float) -> Predictor | None:
    """Predictor of the dock's motion for a controller that looks ahead."""
    if settings.controller != "mpc":
        return None
    longest = max(chosen.step * chosen.steps for chosen in MPC_SETTINGS.values())
    return _predictor(PredictionSettings(kind=settings.preview), period, longest, False)


def _predictor(
    settings: PredictionSettings, period: float, horizon: float, turning: bool
) -> Predictor:
    """One predictor; `turning`: the velocity of the body turns with it (a vehicle under way)."""
    if settings.kind == "polynomial":
        return PolynomialPredictor(period, settings.order or 1, settings.t_past)
    if settings.kind == "ar":
        # Whole seconds, so that predictors with other times can share a batch.
        return ArPredictor(period, settings.order or 6, horizon=max(2.0, float(np.ceil(horizon))))
    if settings.kind == "kinematic":
        return KinematicPredictor(period, "zero", turning)
    future = "harmonic" if settings.kind == "harmonic" else "constant"
    return KinematicPredictor(period, future, smoothing=settings.smoothing)
