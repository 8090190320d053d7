"""Settings of the docking tasks, as they stand under `[task.settings]` of a scenario."""

from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from marine_mj.controllers import CPV_GAINS, GAINS, DockingPlan, Latch
from marine_mj.settings import Settings
from marine_mj.tasks.navigation_settings import NavigationSettings

Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]


class PlanSettings(Settings):
    """Changes of the docking plan; see `controllers.DockingPlan` for the meaning."""

    approach_distance: NotNegative = 1.0
    approach_depth: Positive = 4.0
    under_depth: Positive = 2.0
    wait_depth: Positive = 1.0
    overshoot: NotNegative = 0.05
    acceptance: Positive = 0.3
    wait_speed: Positive | None = None
    wait_time: NotNegative = 0.0
    quiet_rate: Positive | None = None
    patience: Positive = 15.0
    retreat: NotNegative = 0.0
    corridor: tuple[Positive, Positive] | None = None
    push: NotNegative = 20.0
    lift: NotNegative = 0.0
    contact_scale: tuple[float, float, float, float, float, float] = (1.0,) * 6
    seat_speed: Positive = 0.15

    def plan(self) -> DockingPlan:
        """The plan of the controllers."""
        values = self.model_dump()
        values["wait_speed"] = np.inf if self.wait_speed is None else self.wait_speed
        values["quiet_rate"] = np.inf if self.quiet_rate is None else self.quiet_rate
        values["corridor"] = (np.inf, np.inf) if self.corridor is None else self.corridor
        return DockingPlan(**values)


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
        controller: closed-loop controller: `pose_pid`, or `cpv` (cascade of pose and velocity).
        gains: gain set of the controller, default `brute_force` (pose_pid) or `reference` (cpv).
            `extended` is ours; with `cpv` it brings acceleration feed-forward and an observer.
        error_limit: longest position error that `pose_pid` sees, m; left out: no limit.
        plan: waypoints and contact phase.
        latch: when the latch closes.
        navigation: what guidance and controller know of the vehicles.
        goal_offset: largest shift of the goal by the action of the closed-loop task, m;
            0 makes the action empty.
        hold: time the episode goes on after the latch has closed, s.
        end_at_capture: end the episode when the aperture is entered (no contact phase).
        start_spread: standard deviation of the start position in episodes, m.
        start_heading_spread_deg: standard deviation of the start heading, deg.
        random_start_time: start each episode at a random time of the wave record.
    """

    vehicle: str = "auv"
    carrier: str = "usv"
    controller: Literal["pose_pid", "cpv"] = "pose_pid"
    gains: Literal["manual", "brute_force", "reference", "extended"] | None = None
    error_limit: Positive | None = None
    plan: PlanSettings = PlanSettings()
    latch: LatchSettings = LatchSettings()
    navigation: NavigationSettings = NavigationSettings()
    goal_offset: NotNegative = 0.0
    hold: NotNegative = 0.0
    end_at_capture: bool = False
    start_spread: NotNegative = 0.0
    start_heading_spread_deg: NotNegative = 0.0
    random_start_time: bool = False

    @model_validator(mode="after")
    def _gains_of_the_controller(self) -> "DockingSettings":
        sets = {"pose_pid": GAINS, "cpv": CPV_GAINS}[self.controller]
        if self.gains is not None and self.gains not in sets:
            raise ValueError(
                f"gains = {self.gains!r} does not exist for controller {self.controller!r}; "
                f"available: {', '.join(sets)}"
            )
        return self

    @property
    def gain_set(self) -> str:
        """Name of the gain set."""
        default = {"pose_pid": "brute_force", "cpv": "reference"}
        return self.gains or default[self.controller]
