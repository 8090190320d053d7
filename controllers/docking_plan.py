"""Distances and limits of the docking manoeuvre (digest 6.5-6.8, table 7.10)."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from marine_mj.controllers import waypoint_loops as loops
from marine_mj.controllers.kinematics import RigidState
from numpy.typing import NDArray

from marine_mj.errors import ScenarioError
from marine_mj.frames import Array, quaternion_from_euler

# Axes of the aperture plane, by the axis of the entry.
_ACROSS = {2: [0, 1], 0: [1, 2]}


@dataclass(frozen=True)
class DockingPlan:
    """Distances and limits of the manoeuvre; defaults are table 7.10 of the reference.

    Attributes:
        approach_distance: waypoint 1 behind the dock along the carrier's heading, m.
        approach_depth: depth of waypoint 1, m.
        under_depth: waypoint 2 below the carrier's origin, m.
        wait_depth: waypoint 3 below the aperture, m.
        overshoot: goal beyond the aperture plane, m.
        goal_bias: (6,) shift (m) and turn (zyx Euler angles, rad) of the goal in the axes of the
            aperture frame, FLU; minus the mean errors at the capture centres them (study 7.5.3).
        acceptance: distance at which a waypoint counts as reached, m.
        passing: ours: the same for waypoints 1 and 2, which a vehicle only passes, m; None: the
            same distance.
        ride: ours: waypoints 1 to 3 move with the carrier in the mean of its roll and pitch, as the
            water does, and `approach_depth` counts from its origin. A waypoint that rests makes a
            vehicle stand against the orbital motion.
        wait_speed: enter only below this relative speed, abort above it, m/s (inf: never wait).
        wait_time: ours: the relative speed must stay below `wait_speed` for this long, s.
        quiet_rate: ours: enter, and open the latch, only while the dock has lately turned more
            slowly than this (r.m.s. with a memory of 4 s): waves come in groups, rad/s (inf: do
            not look).
        patience: ours: after this time of waiting twice `quiet_rate` is good enough, after twice
            this time three times, and so on, s.
        retreat: ours: how much deeper the vehicle waits until the dock is quiet, m. It goes on
            moving with the dock, which moves as the water does: a vehicle that stands against the
            water meets the dock with the speed of both.
        commit: ours: no entry is given up nearer than this to the aperture plane and within the
            aperture, m: a vehicle that turns back is met by the forks (-inf: any may be).
        corridor: ours: (2,) half length and half width at the aperture of the corridor in which a
            vehicle may rise, opening downwards by 20 deg; outside it goes back to waypoint 3, m.
        aperture: (2,) half length and half width within which a crossing is an entry, m.
        missed_depth: an entered vehicle this far below the aperture again has missed, m.
        push: force towards the seat while in contact, level or upwards, N.
        lift: upward force beside it while in contact, N: keeps a vehicle under what it hooks into.
        contact_scale: (6,) factor on the pose error while in contact; 0 lets an axis go.
        contact_time: ours: a vehicle in contact that is not latched after this time goes back to
            waypoint 3 and tries again, s (inf: it goes on pushing).
        seat_speed: how fast the target moves from the aperture to the seat, m/s.
        leave_speed: ours: how fast the target leaves the dock when the latch has opened, m/s.
        leave_depth: ours: how far below the aperture it goes before it lets the dock be, m: a dock
            in rough seas comes down on what is near.
        axis: axis of the aperture frame along which the vehicle enters: 2, from below, or 0, from
            behind. "Below" in the distances above then reads "before" it, "height" "progress";
            only `approach_depth` and `under_depth` stay depths. Docks say it by their sites.
    """

    approach_distance: float = 1.0
    approach_depth: float = 4.0
    under_depth: float = 2.0
    wait_depth: float = 1.0
    overshoot: float = 0.05
    goal_bias: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    acceptance: float = 0.3
    passing: float | None = None
    ride: bool = False
    wait_speed: float = np.inf
    wait_time: float = 0.0
    quiet_rate: float = np.inf
    patience: float = 15.0
    retreat: float = 0.0
    commit: float = -np.inf
    corridor: tuple[float, float] = (np.inf, np.inf)
    aperture: tuple[float, float] = (0.5, 0.4)
    missed_depth: float = 0.3
    push: float = 20.0
    lift: float = 0.0
    contact_scale: tuple[float, ...] = (1.0, 1.0, 1.0, 1.0, 1.0, 1.0)
    contact_time: float = np.inf
    seat_speed: float = 0.15
    leave_speed: float = 0.3
    leave_depth: float = 2.0
    axis: int = 2

    def __post_init__(self) -> None:
        """Raise ScenarioError for a distance or speed that is not positive, or another axis."""
        if self.axis not in _ACROSS:
            raise ScenarioError(
                f"docking plan: axis is {self.axis}, allowed are 2 (from below) and 0 (from behind)"
            )
        for name in (
            "acceptance",
            "wait_speed",
            "missed_depth",
            "contact_time",
            "seat_speed",
            "leave_speed",
            "leave_depth",
            "quiet_rate",
            "patience",
        ):
            if not np.all(np.asarray(getattr(self, name)) > 0):
                raise ScenarioError(f"docking plan: {name} must be > 0, got {getattr(self, name)}")
        for name, what in (("contact_scale", "factors"), ("goal_bias", "values")):
            if np.shape(getattr(self, name))[-1:] != (6,):
                raise ScenarioError(
                    f"docking plan: {name} needs 6 {what}, got {getattr(self, name)}"
                )

    def split(self, inside: Array) -> tuple[Array, Array]:
        """Height (...,) beyond the aperture plane, and offsets (..., 2) in it, of (..., 3)."""
        return inside[..., self.axis], inside[..., _ACROSS[self.axis]]

    def goal(self, aperture: RigidState) -> RigidState:
        """State to reach while entering: beyond the aperture, off it by `goal_bias`."""
        return aperture.attached(*self._goal)

    @cached_property
    def _goal(self) -> tuple[Array, Array]:
        """Offset (..., 3) and turn (..., 4) of the goal from the aperture."""
        beyond = np.asarray(self.overshoot)[..., None] * np.eye(3)[self.axis]
        bias = np.asarray(self.goal_bias)
        return beyond + bias[..., :3], quaternion_from_euler(bias[..., 3:])

    @cached_property
    def values(self) -> Array:
        """All numbers (..., n) in the order of `waypoint_loops`."""
        numbers = {name: getattr(self, name) for name in loops.SCALARS}
        if self.passing is None:
            numbers["passing"] = self.acceptance
        parts = [np.asarray(number, dtype=float)[..., None] for number in numbers.values()]
        parts += [np.asarray(part) for part in (self.corridor, self.aperture, self.contact_scale)]
        leading = np.broadcast_shapes(*(part.shape[:-1] for part in parts))
        return np.concatenate(
            [np.broadcast_to(part, (*leading, part.shape[-1])) for part in parts], axis=-1
        )

    def quiet(self, turning: Array | float, waited: Array | float) -> NDArray[np.bool_]:
        """Whether (...,) the dock turns slowly enough, after waiting for so long.

        Args:
            turning: (...,) mean square of its angular velocity, rad2/s2.
            waited: (...,) time, s.
        """
        return np.asarray(loops.quiet(self.values, turning, waited))

    def clear(self, height: Array) -> NDArray[np.bool_]:
        """Whether (...,) a vehicle at that height (m) has left the dock: `leave_depth` below."""
        return np.asarray(height < np.asarray(self.acceptance) - self.leave_depth)
