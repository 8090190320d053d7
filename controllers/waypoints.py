"""Waypoints from the approach to the seat of a dock under a moving carrier (digest 6.5-6.8).

Everything is in NWU/FLU; depths are positive numbers below the still water line. All states have
a leading shape `(...,)`, so one guidance object steers any number of simulations.
"""

from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np
from marine_mj.controllers.docking_plan import DockingPlan
from marine_mj.controllers.kinematics import RigidState, heading_quaternion, rotate, unrotate
from marine_mj.controllers.undocking import end_of_way, way_out
from numpy.typing import NDArray

from marine_mj.frames import Array, length
from marine_mj.rigid_loops import row

#: Opening of the corridor under the aperture (digest 6.8): half-angle 20 deg.
CORRIDOR_SLOPE = np.tan(np.deg2rad(20.0))
# Memory of the mean square of the dock's angular velocity, s: one and a half short waves.
_MEMORY = 4.0
# An entry is given up below the aperture when the dock turns this much faster than it may at the
# start: without it the decision would chatter.
_HYSTERESIS = 1.3


class Phase(IntEnum):
    """Where the vehicle is in the docking manoeuvre."""

    APPROACH = 0  # to waypoint 1, behind the dock and deep
    UNDER = 1  # to waypoint 2, under the carrier
    WAIT = 2  # to waypoint 3, below the aperture, moving with it
    ENTER = 3  # through the aperture
    CONTACT = 4  # pushed against the seat
    LATCHED = 5
    LEAVE = 6  # the latch has opened: out along the way in
    RETURN = 7  # back to waypoint 1
    AWAY = 8  # holds waypoint 1


# Which parts of the carrier's acceleration the target of each phase has.
_STILL, _LINEAR, _MOVING = [0.0] * 6, [1.0] * 3 + [0.0] * 3, [1.0] * 6
_FOLLOW = np.array([_STILL] * 2 + [_LINEAR] + [_MOVING] * 4 + [_STILL] * 2)  # up to AWAY
# Target of each phase, of those that `DockingGuidance._targets` lists.
_TARGET = np.array([0, 1, 2, 3, 4, 4, 5, 0, 0])
_UP, _LEVEL = np.array([0.0, 0.0, 1.0]), np.array([1.0, 1.0, 0.0])


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
        plan = self.plan
        inside = unrotate(aperture.rotation, vehicle.position - aperture.position)
        height, across = plan.split(inside)
        squared = np.sum(aperture.velocity[..., 3:] ** 2, axis=-1)
        turning = state.turning + period / _MEMORY * (squared - state.turning)
        waiting = state.phase == Phase.WAIT
        held = np.where(state.phase == Phase.ENTER, state.waited, 0.0)
        waited = np.where(waiting, state.waited + period, held)
        quiet = plan.quiet(turning, waited)
        rough = ~plan.quiet(turning / _HYSTERESIS**2, waited)
        targets = self._targets(state, quiet, carrier, aperture, seat)
        speed = length(vehicle.linear_velocity - carrier.linear_velocity)

        phase = state.phase
        distance = length(row(targets.position, _TARGET[phase]) - vehicle.position)
        passing = plan.acceptance if plan.passing is None else plan.passing
        reached = distance < np.where(phase < Phase.WAIT, passing, plan.acceptance)
        advance = reached & ((phase < Phase.WAIT) | (phase == Phase.RETURN))
        advance |= (phase == Phase.LEAVE) & plan.clear(height)
        # Above the aperture plane the forks guide: no abort there.
        open_ = np.asarray(plan.corridor) + CORRIDOR_SLOPE * np.maximum(-height, 0.0)[..., None]
        outside = (height < 0) & np.any(np.abs(across) > open_, axis=-1)
        ready = reached & waiting & quiet & (speed < plan.wait_speed) & ~outside
        calm = np.where(ready, state.calm + period, 0.0)
        advance |= ready & (calm > plan.wait_time)
        abort = (phase == Phase.ENTER) & ((speed > plan.wait_speed) | outside | rough)
        within = np.all(np.abs(across) <= np.asarray(plan.aperture), axis=-1)
        abort &= ~(within & (height >= -np.asarray(plan.commit)))
        # The entry counts once waypoint 2 has been reached (digest 6.5).
        armed = (phase == Phase.WAIT) | (phase == Phase.ENTER)
        entered = armed & within & (state.height < 0) & (height >= 0)
        touching = phase == Phase.CONTACT
        pushed = np.where(touching, state.pushed + period, 0.0)
        missed = touching & ((height < -plan.missed_depth) | (pushed > plan.contact_time))

        next_phase = np.where(advance, phase + 1, phase)
        next_phase = np.where(abort | missed, int(Phase.WAIT), next_phase)
        next_phase = np.where(entered, int(Phase.CONTACT), next_phase)
        next_phase = np.where(phase == Phase.LATCHED, int(Phase.LEAVE), next_phase)
        next_phase = np.where(latched, int(Phase.LATCHED), next_phase)

        travel = length(seat.position - aperture.position)
        step = plan.seat_speed * period / np.maximum(travel, 1e-9)
        in_contact = next_phase == Phase.CONTACT
        progress = np.where(in_contact, np.minimum(state.progress + step, 1.0), 0.0)
        # The way out begins where the vehicle is latched.
        latched_at = height / np.maximum(travel, 1e-9)
        progress = np.where(next_phase == Phase.LATCHED, latched_at, progress)
        back = state.progress - plan.leave_speed * period / np.maximum(travel, 1e-9)
        back = np.maximum(back, end_of_way(travel, plan.leave_depth))
        progress = np.where(next_phase == Phase.LEAVE, back, progress)
        following = GuidanceState(
            next_phase, height, progress, state.attempts + entered, calm, waited, turning, pushed
        )
        towards = _towards(plan, carrier)
        return self._command(following, entered, targets, towards), following

    def target(
        self, state: GuidanceState, carrier: RigidState, aperture: RigidState, seat: RigidState
    ) -> RigidState:
        """Target of the present phase for other states of the carrier, such as predicted ones.

        Args:
            state: state after `update`.
            carrier, aperture, seat: as in `update`; may have more leading dimensions, in front.
        """
        quiet = self.plan.quiet(state.turning, state.waited)
        targets = self._targets(state, quiet, carrier, aperture, seat)
        return _pick(targets, np.broadcast_to(state.phase, carrier.position.shape[:-1]))

    def _targets(
        self,
        state: GuidanceState,
        quiet: NDArray[np.bool_],
        carrier: RigidState,
        aperture: RigidState,
        seat: RigidState,
    ) -> RigidState:
        """Targets (..., 6, k) of APPROACH, UNDER, WAIT, ENTER, CONTACT and LEAVE, in this order."""
        plan = self.plan
        level, turn = heading_quaternion(carrier.heading), _level_rotation(carrier.heading)
        ride = np.asarray(plan.ride)[..., None]
        carried = ride * _level_twist(turn, carrier.linear_velocity)
        # Waypoints 1 and 2 lie under the point of the carrier above the aperture.
        offset = unrotate(carrier.rotation, aperture.position - carrier.position)
        above = carrier.position + rotate(carrier.rotation, offset * _LEVEL)
        towards = _towards(plan, carrier)
        if plan.axis != 2:
            above = above - np.asarray(plan.wait_depth)[..., None] * towards
        away_from_dock = np.asarray(plan.approach_distance)[..., None] * -turn[..., :2, 0]
        depth = np.broadcast_to(plan.approach_depth, above.shape[:-1])[..., None]
        height = ride * carrier.position[..., 2:] - depth
        behind = np.concatenate([above[..., :2] + away_from_dock, height], axis=-1)
        under = above - np.asarray(plan.under_depth)[..., None] * _UP
        away = (plan.retreat > 0) & np.logical_not(quiet)
        wait_depth = plan.wait_depth + plan.retreat * away
        # Riding: below where the aperture would be on a carrier that does not roll or pitch.
        centre = np.where(ride, carrier.position + rotate(turn, offset), aperture.position)
        wait = centre - wait_depth[..., None] * towards
        matched = np.where(ride, carrier.linear_velocity, aperture.linear_velocity)
        share = np.asarray(state.progress)[..., None]
        seated = RigidState(
            aperture.position + share * (seat.position - aperture.position),
            seat.quaternion,
            seat.velocity,
        )
        goal = plan.goal(aperture)
        out = way_out(aperture, seat, plan.axis, state.progress, plan.leave_speed, plan.leave_depth)
        attitudes = [level, level, level, goal.quaternion, seated.quaternion, out.quaternion]
        twist = _level_twist(turn, matched)
        twists = [carried, carried, twist, goal.velocity, seated.velocity, out.velocity]
        places = [behind, under, wait, goal.position, seated.position, out.position]
        return RigidState(*(np.stack(part, axis=-2) for part in (places, attitudes, twists)))

    def _command(
        self,
        state: GuidanceState,
        entered: Array,
        targets: RigidState,
        towards: Array,
    ) -> GuidanceCommand:
        """Command of the phase each simulation is in."""
        contact = (state.phase == Phase.CONTACT)[..., None]
        latched = (state.phase == Phase.LATCHED)[..., None]
        outside = (state.phase <= Phase.WAIT) | (state.phase >= Phase.RETURN)
        riding = (np.asarray(self.plan.ride) & outside)[..., None]
        push = np.asarray(self.plan.push)[..., None] * towards
        push = push + np.asarray(self.plan.lift)[..., None] * _UP
        return GuidanceCommand(
            target=_pick(targets, state.phase),
            # Latched: what the controller sums up rests.
            scale=np.where(
                contact, np.asarray(self.plan.contact_scale), np.where(latched, 0.0, 1.0)
            ),
            push=np.where(contact, push, 0.0),
            entered=entered,
            follow=np.where(riding, _LINEAR, _FOLLOW[state.phase]),
            riding=riding,
        )


def _towards(plan: DockingPlan, carrier: RigidState) -> Array:
    """Level or vertical unit vector (..., 3) of the entry, NWU."""
    if plan.axis == 2:
        return _UP
    c, s = np.cos(carrier.heading), np.sin(carrier.heading)
    return np.stack([c, s, np.zeros_like(c)], axis=-1)


def _pick(targets: RigidState, phase: Array) -> RigidState:
    """Of the targets (..., 6, k) by phase the one of the phase (...,) each simulation is in."""
    index = _TARGET[phase]
    return RigidState(
        row(targets.position, index),
        row(targets.quaternion, index),
        row(targets.velocity, index),
    )


def _level_twist(turn: Array, velocity: Array) -> Array:
    """Velocity (..., 6) in the axes of a level body that moves so in world axes (..., 3)."""
    return np.concatenate([unrotate(turn, velocity), np.zeros_like(velocity)], axis=-1)


def _level_rotation(heading: Array) -> Array:
    """Rotation matrix (..., 3, 3) about the vertical."""
    c, s = np.cos(heading), np.sin(heading)
    turn = np.zeros((*np.shape(heading), 3, 3))
    turn[..., 0, 0], turn[..., 0, 1] = c, -s
    turn[..., 1, 0], turn[..., 1, 1] = s, c
    turn[..., 2, 2] = 1.0
    return turn
