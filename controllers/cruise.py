"""Guidance that cruises into a dock entered from behind: the laws of the review (digest app. D).

Each law steers heading and surge speed in the horizontal plane; the vehicle keeps a fixed depth, a
level attitude and no sway. (The Scout has no lift: if it let sway go, it would slide on across its
heading, up to 1 m beside the dock in calm water.) It does not wait and does not turn back: the
aperture is crossed once, and `DockingGuidance` takes over there.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from marine_mj.controllers import guidance_laws as laws
from marine_mj.controllers.docking_plan import DockingPlan
from marine_mj.controllers.kinematics import RigidState, heading_quaternion
from marine_mj.controllers.waypoints import (
    DockingGuidance,
    GuidanceCommand,
    GuidanceState,
    Phase,
)

from marine_mj.errors import ScenarioError
from marine_mj.frames import Array

#: Distance at which pure pursuit and line following look ahead, and over which alignments happen,
#: m. Ours: one and a half and two hull lengths of a Scout.
_LOOKAHEAD, _START = 3.0, 4.0
# Smallest share of the speed and threshold of the sliding path, ours.
_SLOWEST, _THRESHOLD = 0.5, 1.0


@dataclass(frozen=True)
class CruiseState(GuidanceState):
    """Memory of `CruiseGuidance`.

    Attributes:
        integral: (...,) of the cross-track error, as the law defines it.
        course: (...,) heading of the last command, rad; NaN before the first.
    """

    integral: Array | float = 0.0
    course: Array | float = np.nan


@dataclass(frozen=True)
class _Look:
    """What a law sees, in the horizontal plane NWU; see `guidance_laws`."""

    position: Array
    velocity: Array
    dock: Array
    dock_velocity: Array
    axis: Array
    togo: Array
    error: Array
    rate: Array
    integral: Array
    course: Array
    current: Array
    speed: Array | float
    period: float

    def track(self) -> Array:
        """Heading (...,) of the PID on the cross-track error."""
        return laws.cross_track(self.error, self.integral, self.rate, self.axis)

    def proportional(self) -> Array:
        """Heading (...,) turned on by proportional navigation."""
        turn = laws.proportional_navigation(
            self.position, self.velocity, self.dock, self.dock_velocity
        )
        return self.course + self.period * turn


_Heading = Callable[[_Look], Array]

#: Headings of the laws; `sliding_path` has a speed and an integral of its own.
_HEADINGS: dict[str, _Heading] = {
    "line_of_sight": lambda see: laws.line_of_sight(see.position, see.dock),
    "proportional_navigation": _Look.proportional,
    "pure_pursuit": lambda see: laws.pure_pursuit(see.position, see.dock, see.axis, _LOOKAHEAD),
    "crab_angle": lambda see: laws.crab_angle(
        laws.line_of_sight(see.position, see.dock), see.speed, see.current
    ),
    "cross_track": _Look.track,
    "touchdown_alignment": lambda see: laws.touchdown_alignment(
        see.track(), see.axis, see.togo, _START
    ),
    "side_slip": lambda see: laws.side_slip(
        see.position, see.dock, see.axis, see.speed, see.current, _START, _LOOKAHEAD
    ),
}
#: Names of the laws.
CRUISE_LAWS = (*_HEADINGS, "sliding_path")


@dataclass(frozen=True)
class CruiseGuidance:
    """One of the horizontal laws at a constant surge speed, to the seat of the dock.

    Attributes:
        law: a name of `CRUISE_LAWS`.
        speed: through the water, m/s.
        plan: `approach_depth` is the depth at which the vehicle cruises; its waypoints, corridor
            and waiting do not count.
        current: (2,) known current, NWU, m/s.
    """

    law: str
    speed: float = 0.7
    plan: DockingPlan = field(default_factory=lambda: DockingPlan(axis=0))
    current: Array = field(default_factory=lambda: np.zeros(2))

    def __post_init__(self) -> None:
        """Raise ScenarioError for an unknown law or a dock that is entered from below."""
        if self.law not in CRUISE_LAWS:
            raise ScenarioError(
                f"guidance law {self.law!r} does not exist; available: {', '.join(CRUISE_LAWS)}"
            )
        if self.plan.axis != 0:
            raise ScenarioError(
                f"guidance law {self.law!r} steers in the horizontal plane: the dock must be "
                "entered from behind (funnel, pole), this one is entered from below"
            )
        never = {"wait_speed": np.inf, "quiet_rate": np.inf, "corridor": (np.inf, np.inf)}
        object.__setattr__(self, "plan", replace(self.plan, **never))

    def initial(self, shape: tuple[int, ...] = ()) -> CruiseState:
        """State at the start, under way to the aperture, for a leading shape."""
        start = vars(DockingGuidance(self.plan).initial(shape))
        start["phase"] = np.full(shape, int(Phase.ENTER))
        return CruiseState(**start, integral=np.zeros(shape), course=np.full(shape, np.nan))

    def update(
        self,
        state: CruiseState,
        vehicle: RigidState,
        carrier: RigidState,
        aperture: RigidState,
        seat: RigidState,
        latched: Array,
        period: float,
    ) -> tuple[GuidanceCommand, CruiseState]:
        """Command for the controller and the next state; see `DockingGuidance.update`."""
        docking = DockingGuidance(self.plan)
        command, following = docking.update(
            state, vehicle, carrier, aperture, seat, latched, period
        )
        cruising = following.phase == Phase.ENTER
        heading, speed, rate = self._steer(state, vehicle, aperture, seat, period)
        known = {
            "integral": np.where(cruising, state.integral + period * rate, state.integral),
            "course": np.where(cruising, heading, state.course),
        }
        own = self._target(vehicle, heading, speed)
        here = cruising[..., None]
        old = command.target
        target = RigidState(
            np.where(here, own.position, old.position),
            np.where(here, own.quaternion, old.quaternion),
            np.where(here, own.velocity, old.velocity),
        )
        return replace(
            command,
            target=target,
            follow=np.where(here, 0.0, command.follow),
        ), CruiseState(**vars(following), **known)

    def target(
        self, state: GuidanceState, carrier: RigidState, aperture: RigidState, seat: RigidState
    ) -> RigidState:
        """Target of `DockingGuidance`: laws are flown without prediction."""
        return DockingGuidance(self.plan).target(state, carrier, aperture, seat)

    def _steer(
        self,
        state: CruiseState,
        vehicle: RigidState,
        aperture: RigidState,
        seat: RigidState,
        period: float,
    ) -> tuple[Array, Array, Array]:
        """Heading (...,), surge speed (...,) and rate of the integral (...,) by the law."""
        position, dock = vehicle.position[..., :2], seat.position[..., :2]
        velocity = vehicle.linear_velocity[..., :2]
        dock_velocity = seat.linear_velocity[..., :2]
        axis = aperture.heading
        togo, error = laws.track_errors(position, dock, axis)
        slip = velocity - dock_velocity
        see = _Look(
            position=position,
            velocity=velocity,
            dock=dock,
            dock_velocity=dock_velocity,
            axis=axis,
            togo=togo,
            error=error,
            rate=np.cos(axis) * slip[..., 1] - np.sin(axis) * slip[..., 0],
            integral=np.asarray(state.integral),
            course=np.where(np.isnan(state.course), vehicle.heading, state.course),
            current=self.current,
            speed=self.speed,
            period=period,
        )
        speed = np.broadcast_to(self.speed, error.shape)
        if self.law == "sliding_path":
            return laws.sliding_path(
                position, dock, axis, see.integral, speed, self.current, 2 * _START,
                _SLOWEST * speed, _THRESHOLD, _LOOKAHEAD,
            )  # fmt: skip
        return _HEADINGS[self.law](see), speed, error

    def _target(self, vehicle: RigidState, heading: Array, speed: Array) -> RigidState:
        """Level at the depth of the plan where the vehicle is, with that heading and speed."""
        depth = np.broadcast_to(self.plan.approach_depth, heading.shape)
        position = np.concatenate([vehicle.position[..., :2], -depth[..., None]], axis=-1)
        velocity = np.zeros_like(vehicle.velocity)
        velocity[..., 0] = speed
        return RigidState(position, heading_quaternion(heading), velocity)
