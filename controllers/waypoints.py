"""Waypoints from the approach to the seat of a dock under a moving carrier (digest 6.5-6.8).

Everything is in NWU/FLU; depths are positive numbers below the still water line. All states have
a leading shape `(...,)`, so one guidance object steers any number of simulations.
"""

from dataclasses import dataclass, field

import numpy as np
from marine_mj.controllers import waypoint_loops as loops
from marine_mj.controllers.docking_plan import DockingPlan
from marine_mj.controllers.kinematics import RigidState
from marine_mj.controllers.undocking import way_out
from marine_mj.controllers.waypoint_loops import Phase
from numpy.typing import NDArray

from marine_mj.frames import Array

__all__ = ["DockingGuidance", "GuidanceCommand", "GuidanceState", "Phase"]


@dataclass(frozen=True)
class GuidanceState:
    """Memory of the guidance.

    Attributes:
        phase: (...,) int, see `Phase`.
        height: (...,) height of the vehicle above the aperture plane at the last update, m.
        progress: (...,) how far the target has moved from the aperture to the seat, 0 to 1;
            negative before the aperture on the way out.
        attempts: (...,) int, entries so far.
        calm: (...,) for how long the vehicle has been ready to enter, s.
        waited: (...,) time in WAIT since the last attempt, s.
        turning: (...,) mean square of the dock's angular velocity, with memory, rad2/s2.
        pushed: (...,) for how long the vehicle has been in contact, s.
    """

    phase: Array
    height: Array
    progress: Array
    attempts: Array
    calm: Array | float = 0.0
    waited: Array | float = 0.0
    turning: Array | float = 0.0
    pushed: Array | float = 0.0


@dataclass(frozen=True)
class GuidanceCommand:
    """What the controller has to do now.

    Attributes:
        target: state to reach, NWU/FLU.
        scale: (..., 6) factor on the pose error per axis.
        push: (..., 3) extra force, NWU, N.
        entered: (...,) bool, the aperture plane was crossed from below at this update.
        follow: (..., 6) which parts of the carrier's acceleration the target has, 0 or 1.
        acceleration: (..., 6) of the target beside that, world axes NWU, m/s2 and rad/s2.
        riding: (..., 1) bool, the target follows the carrier's origin and does not turn with it.
    """

    target: RigidState
    scale: Array
    push: Array
    entered: Array
    follow: Array
    acceleration: Array | float = 0.0
    riding: NDArray[np.bool_] | bool = False


@dataclass(frozen=True)
class DockingGuidance:
    """Target-state guidance through the waypoints of `plan`."""

    plan: DockingPlan = field(default_factory=DockingPlan)

    def initial(self, shape: tuple[int, ...] = ()) -> GuidanceState:
        """State at the start of the approach, for a leading shape."""
        return GuidanceState(
            phase=np.full(shape, int(Phase.APPROACH)),
            height=np.full(shape, -np.inf),
            progress=np.zeros(shape),
            attempts=np.zeros(shape, dtype=int),
            calm=np.zeros(shape),
            waited=np.zeros(shape),
            turning=np.zeros(shape),
            pushed=np.zeros(shape),
        )

    def update(
        self,
        state: GuidanceState,
        vehicle: RigidState,
        carrier: RigidState,
        aperture: RigidState,
        seat: RigidState,
        latched: Array,
        period: float,
    ) -> tuple[GuidanceCommand, GuidanceState]:
        """Command for the controller and the next state.

        Args:
            state: state after the previous update.
            vehicle: state of the vehicle that docks.
            carrier: state of the body that carries the dock.
            aperture: state of the goal frame, with the plan's `axis` towards the seat.
            seat: state that the vehicle has when docked.
            latched: (...,) bool.
            period: time since the previous update, s.
        """
        plan = self.plan.values
        turning, waited = loops.watch(
            state.phase, state.turning, state.waited, aperture.velocity, period
        )
        seen = self._seen(state.phase, state.progress, carrier, aperture, seat)
        waypoint = loops.target(plan, state.phase, state.progress, turning, waited, *seen)[0]
        phase, height, progress, attempts, calm, pushed, entered = map(
            np.asarray,
            loops.decide(
                plan, state.phase, state.height, state.progress, state.attempts, state.calm,
                waited, turning, state.pushed, vehicle.position, vehicle.linear_velocity,
                carrier.linear_velocity, waypoint, aperture.position, aperture.rotation,
                seat.position, latched, period,
            ),
        )  # fmt: skip
        following = GuidanceState(
            phase, height, progress, attempts, calm, np.asarray(waited), np.asarray(turning), pushed
        )
        target = loops.target(plan, phase, state.progress, turning, waited, *seen)
        course, place, twist = seen[3], carrier.position, carrier.velocity
        scale, push, follow, riding = loops.command(plan, phase, course, place, twist)
        riding = np.asarray(riding)[..., None]
        return GuidanceCommand(
            RigidState(*target), scale, push, entered, follow, riding=riding
        ), following

    def target(
        self, state: GuidanceState, carrier: RigidState, aperture: RigidState, seat: RigidState
    ) -> RigidState:
        """Target of the present phase for other states of the carrier, such as predicted ones.

        Args:
            state: state after `update`.
            carrier, aperture, seat: as in `update`; may have more leading dimensions, in front.
        """
        seen = self._seen(state.phase, state.progress, carrier, aperture, seat)
        plan, turning, waited = self.plan.values, state.turning, state.waited
        return RigidState(*loops.target(plan, state.phase, state.progress, turning, waited, *seen))

    def _seen(
        self,
        phase: Array,
        progress: Array,
        carrier: RigidState,
        aperture: RigidState,
        seat: RigidState,
    ) -> tuple[Array, ...]:
        """What `waypoint_loops.target` has to see of carrier and dock."""
        plan, out = self.plan, seat
        if np.any(phase >= Phase.LATCHED):
            out = way_out(aperture, seat, plan.axis, progress, plan.leave_speed, plan.leave_depth)
        return (
            carrier.position,
            carrier.rotation,
            carrier.linear_velocity,
            _course(carrier.heading),
            aperture.position,
            aperture.linear_velocity,
            *(part for one in (plan.goal(aperture), seat, out) for part in _parts(one)),
        )


def _course(heading: Array) -> Array:
    """Cos and sin (..., 4) of a heading and of half of it."""
    half = 0.5 * heading
    return np.stack([np.cos(heading), np.sin(heading), np.cos(half), np.sin(half)], axis=-1)


def _parts(state: RigidState) -> tuple[Array, Array, Array]:
    return state.position, state.quaternion, state.velocity
