"""Settings of the docking tasks, as they stand under `[task.settings]` of a scenario."""

from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from marine_mj.contact_success import FORCE_LIMIT
from marine_mj.controllers import (
    CPV_GAINS,
    CPVA_GAINS,
    GAINS,
    LQR_WEIGHTS,
    MPC_SETTINGS,
    SLIDING_GAINS,
    DockingPlan,
    Latch,
    PidGains,
)
from marine_mj.frames import flip
from marine_mj.settings import Settings
from marine_mj.tasks.navigation_settings import NavigationSettings

Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]


#: Target-state guidance through waypoints, or a law of `controllers.cruise`.
Guidance = Literal[
    "target_state",
    "line_of_sight",
    "proportional_navigation",
    "pure_pursuit",
    "crab_angle",
    "cross_track",
    "touchdown_alignment",
    "side_slip",
    "sliding_path",
]
Vector6 = tuple[NotNegative, NotNegative, NotNegative, NotNegative, NotNegative, NotNegative]
PredictionKind = Literal["kinematic", "constant_acceleration", "harmonic", "polynomial", "ar"]

#: Gain sets by controller; the first is the default.
GAIN_SETS: dict[str, tuple[str, ...]] = {
    "pose_pid": ("brute_force", *(name for name in GAINS if name != "brute_force")),
    "cpv": tuple(CPV_GAINS),
    "cpva": tuple(CPVA_GAINS),
    "lqr": tuple(LQR_WEIGHTS),
    "sliding": tuple(SLIDING_GAINS),
    "mpc": tuple(MPC_SETTINGS),
}


class GainValues(Settings):
    """Gains of `pose_pid` as numbers: surge, sway, heave, roll, pitch, yaw (N/m, N m/rad, ...)."""

    P: Vector6
    I: Vector6  # noqa: E741
    D: Vector6

    def gains(self) -> PidGains:
        """The gains of the controllers."""
        return PidGains(self.P, self.I, self.D)


class PredictionSettings(Settings):
    """What the controller takes the states to be a little later; see `controllers.Prediction`.

    Attributes:
        kind: "kinematic" (no acceleration), "constant_acceleration", "harmonic" (oscillation about
            the present place), "polynomial" (through the last samples), "ar" (autoregressive).
        of: whose states are predicted.
        t_pred: how far ahead, s.
        t_past: of "polynomial": time whose samples are fitted, s.
        order: of "polynomial" (1 or 2, default 1) or "ar" (default 6).
        smoothing: of "constant_acceleration" and "harmonic": low-pass on the acceleration, s.
    """

    kind: PredictionKind = "kinematic"
    of: Literal["vehicle", "carrier", "both"] = "both"
    t_pred: Positive = 0.4
    t_past: Positive = 0.03
    order: Annotated[int, Field(ge=1, le=20)] | None = None
    smoothing: NotNegative = 0.0

    @model_validator(mode="after")
    def _order_of_the_kind(self) -> "PredictionSettings":
        if self.order is not None and self.kind not in ("polynomial", "ar"):
            raise ValueError(f"order = {self.order} belongs to kind polynomial or ar")
        if self.kind == "polynomial" and self.order not in (None, 1, 2):
            raise ValueError(f"order = {self.order} is not allowed for polynomial: 1 or 2")
        return self


class PlanSettings(Settings):
    """Changes of the docking plan; see `controllers.DockingPlan` for the meaning.

    Attributes:
        goal_bias: in FRD, as the errors at the capture: surge, sway, heave, m, roll, pitch, yaw,
            rad.
    """

    approach_distance: NotNegative = 1.0
    approach_depth: Positive = 4.0
    under_depth: Positive = 2.0
    wait_depth: Positive = 1.0
    overshoot: NotNegative = 0.05
    goal_bias: tuple[float, float, float, float, float, float] = (0.0,) * 6
    acceptance: Positive = 0.3
    passing: Positive | None = None
    ride: bool = False
    commit: NotNegative | None = None
    wait_speed: Positive | None = None
    wait_time: NotNegative = 0.0
    quiet_rate: Positive | None = None
    patience: Positive = 15.0
    retreat: NotNegative = 0.0
    corridor: tuple[Positive, Positive] | None = None
    aperture: tuple[Positive, Positive] = (0.5, 0.4)
    push: NotNegative = 20.0
    lift: NotNegative = 0.0
    contact_scale: tuple[float, float, float, float, float, float] = (1.0,) * 6
    contact_time: Positive | None = None
    seat_speed: Positive = 0.15
    leave_speed: Positive = 0.3
    leave_depth: Positive = 2.0

    def plan(self) -> DockingPlan:
        """The plan of the controllers."""
        values = self.model_dump()
        values["wait_speed"] = np.inf if self.wait_speed is None else self.wait_speed
        values["contact_time"] = np.inf if self.contact_time is None else self.contact_time
        values["quiet_rate"] = np.inf if self.quiet_rate is None else self.quiet_rate
        values["commit"] = -np.inf if self.commit is None else self.commit
        values["corridor"] = (np.inf, np.inf) if self.corridor is None else self.corridor
        values["goal_bias"] = tuple(flip(self.goal_bias).tolist())
        return DockingPlan(**values)


class WaypointSettings(Settings):
    """A waypoint in the vertical plane instead of a dock; see `controllers.PursuitGuidance`.

    Attributes:
        pose: x, z, theta at the start, NED, m and rad.
        rate: m/s, rad/s.
        acceleration: m/s2, rad/s2.
    """

    pose: tuple[float, float, float]
    rate: tuple[float, float, float] = (0.0, 0.0, 0.0)
    acceleration: tuple[float, float, float] = (0.0, 0.0, 0.0)


class LatchSettings(Settings):
    """Limits within which the latch closes.

    Attributes:
        position: distance from the seat, m.
        attitude_deg: angle to the seat, deg.
        speed: relative speed, m/s.
        rate_deg: relative angular speed, deg/s.
        dwell: time all limits must be kept, s.
    """

    position: Positive = 0.05
    attitude_deg: Positive = 3.0
    speed: Positive = 0.1
    rate_deg: Positive = 10.0
    dwell: NotNegative = 1.0

    def latch(self) -> Latch:
        """The latch of the controllers, in SI units and radians."""
        attitude, rate = np.deg2rad(self.attitude_deg), np.deg2rad(self.rate_deg)
        return Latch(self.position, attitude, self.speed, rate, self.dwell)


class DockingSettings(Settings):
    """Settings of the docking tasks.

    Attributes:
        vehicle: instance name of the vehicle that docks.
        carrier: instance name of the vehicle that carries the dock.
        controller: closed-loop controller: `pose_pid`, `cpv` (cascade of pose and velocity), `cpva`
            (with acceleration), `lqr`, `sliding` (sliding mode) or `mpc` (model-predictive).
        gains: gain set of the controller, see `GAIN_SETS`; default `brute_force` (pose_pid),
            `reference` (cpv, cpva), else `extended`, which is ours; with `cpv` it brings
            acceleration feed-forward and an observer.
        gain_values: numbers instead of a gain set, for `pose_pid`.
        prediction: let the controller act on predicted states; left out: on the present ones.
        preview: how `mpc` predicts the motion of the dock over its horizon.
        guidance: "target_state" (waypoints), or a horizontal law at a constant surge speed, for
            docks entered from behind; see `controllers.CruiseGuidance`.
        cruise_speed: of such a law, m/s.
        station: keep station this far below the goal instead of docking, m.
        waypoint: steer to a waypoint, at rest or under way, instead of docking.
        error_limit: longest position error that `pose_pid` sees, m; left out: no limit.
        plan: waypoints and contact phase.
        latch: when the latch closes.
        navigation: what guidance and controller know of the vehicles.
        goal_offset: largest shift of the goal by the action of the closed-loop task, m;
            0 makes the action empty.
        hold: time the episode goes on after the latch has closed, or with undocking after the
            vehicle has come back to waypoint 1 (open loop: is clear of the dock), s.
        undock_after: open the latch this long after it has closed, s, and leave the dock; left out:
            only when asked to (`Docking.undock`).
        start_docked: start latched in the dock; position and heading of the vehicle do not count.
        force_limit: peak contact force below which a docking is a `contact_success`, N.
        end_at_capture: end the episode when the aperture is entered (no contact phase).
        start_spread: standard deviation of the start position in episodes, m.
        start_heading_spread_deg: standard deviation of the start heading, deg.
        random_start_time: start each episode at a random time of the wave record.
    """

    vehicle: str = "auv"
    carrier: str = "usv"
    controller: Literal["pose_pid", "cpv", "cpva", "lqr", "sliding", "mpc"] = "pose_pid"
    gains: Literal["manual", "brute_force", "reference", "extended"] | None = None
    gain_values: GainValues | None = None
    error_limit: Positive | None = None
    prediction: PredictionSettings | None = None
    preview: PredictionKind = "ar"
    guidance: Guidance = "target_state"
    cruise_speed: Positive = 0.7
    station: Positive | None = None
    waypoint: WaypointSettings | None = None
    plan: PlanSettings = PlanSettings()
    latch: LatchSettings = LatchSettings()
    navigation: NavigationSettings = NavigationSettings()
    goal_offset: NotNegative = 0.0
    hold: NotNegative = 0.0
    undock_after: NotNegative | None = None
    start_docked: bool = False
    force_limit: Positive = FORCE_LIMIT
    end_at_capture: bool = False
    start_spread: NotNegative = 0.0
    start_heading_spread_deg: NotNegative = 0.0
    random_start_time: bool = False

    @model_validator(mode="after")
    def _gains_of_the_controller(self) -> "DockingSettings":
        sets = GAIN_SETS[self.controller]
        if self.gains is not None and self.gains not in sets:
            raise ValueError(
                f"gains = {self.gains!r} does not exist for controller {self.controller!r}; "
                f"available: {', '.join(sets)}"
            )
        if self.gain_values is not None and (self.gains or self.controller != "pose_pid"):
            raise ValueError(
                f"gain_values belong to controller 'pose_pid' without gains, got controller "
                f"{self.controller!r}, gains {self.gains!r}"
            )
        if self.station is not None and self.waypoint is not None:
            raise ValueError(
                f"station = {self.station:g} and a waypoint are two targets: leave out one"
            )
        if self.prediction is not None and self.controller == "mpc":
            raise ValueError("controller 'mpc' predicts by itself: leave out prediction")
        if self.guidance != "target_state":
            for name in ("prediction", "station"):
                if getattr(self, name) is not None:
                    raise ValueError(f"guidance = {self.guidance!r} is flown without {name}")
            if self.controller == "mpc":
                raise ValueError(
                    f"guidance = {self.guidance!r} has no target ahead of time for controller "
                    "'mpc': take another controller"
                )
        if self.undock_after is not None and (self.end_at_capture or self.station is not None):
            other = "end_at_capture" if self.end_at_capture else "station"
            raise ValueError(
                f"undock_after = {self.undock_after} needs a latch that closes: leave out {other}"
            )
        return self

    @property
    def gain_set(self) -> str:
        """Name of the gain set; "values" when the gains are numbers."""
        if self.gain_values is not None:
            return "values"
        return self.gains or GAIN_SETS[self.controller][0]
