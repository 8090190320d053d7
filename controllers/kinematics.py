"""States of rigid bodies and frames fixed to them, for any leading shape.

World NWU (z up), body FLU, quaternions wxyz body -> world, as everywhere inside marine_mj.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from marine_mj import frames, rigid_loops
from marine_mj.frames import Array

# Attitude of a frame that does not turn against its body.
_PARALLEL = np.array([1.0, 0.0, 0.0, 0.0])


def rotate(rotation: Array, vector: Array) -> Array:
    """Vectors (..., 3) turned by rotation matrices (..., 3, 3)."""
    return frames.apply(rotation, vector)


def unrotate(rotation: Array, vector: Array) -> Array:
    """Vectors (..., 3) turned by the transposed rotation matrices (..., 3, 3)."""
    return frames.apply_transposed(rotation, vector)


@dataclass(frozen=True)
class RigidState:
    """Pose and velocity of a body or of a frame fixed to one.

    Attributes:
        position: (..., 3) world position of the origin, NWU, m.
        quaternion: (..., 4) attitude, body to world, wxyz.
        velocity: (..., 6) `nu` = [linear; angular] of the frame at its origin, FLU, m/s, rad/s.
    """

    position: Array
    quaternion: Array
    velocity: Array

    @classmethod
    def at_rest(cls, shape: tuple[int, ...] = ()) -> "RigidState":
        """Level at the origin, for a leading shape."""
        quaternion = np.broadcast_to(_PARALLEL, (*shape, 4)).copy()
        return cls(np.zeros((*shape, 3)), quaternion, np.zeros((*shape, 6)))

    @cached_property
    def rotation(self) -> Array:
        """Rotation matrix (..., 3, 3), body to world."""
        return frames.rotation_from_quaternion(self.quaternion)

    @cached_property
    def linear_velocity(self) -> Array:
        """Velocity (..., 3) of the origin in world axes NWU, m/s."""
        return rotate(self.rotation, self.velocity[..., :3])

    @cached_property
    def heading(self) -> Array:
        """Direction (...,) of the x axis in the horizontal plane, rad, counter-clockwise (NWU)."""
        return np.arctan2(self.rotation[..., 1, 0], self.rotation[..., 0, 0])

    def attached(
        self, offset: Array | Sequence[float], quaternion: Array | Sequence[float] | None = None
    ) -> "RigidState":
        """State of a frame fixed to this body.

        Args:
            offset: (3,) or (..., 3) origin of the frame in this body's FLU axes, m.
            quaternion: (4,) attitude of the frame relative to this body, wxyz; default: parallel.
        """
        turn = _PARALLEL if quaternion is None else np.asarray(quaternion, dtype=float)
        offset = np.asarray(offset, dtype=float)
        return RigidState(
            *rigid_loops.attached(self.position, self.quaternion, self.velocity, offset, turn)
        )


def pose_error(target: RigidState, body: RigidState) -> Array:
    """Pose error (..., 6) of `body`: target minus body, in the body's FLU axes (m, rad).

    The attitude part is the rotation vector of `conj(q_body) * q_target` (shortest way).
    """
    return rigid_loops.pose_error(
        target.position, target.quaternion, body.position, body.quaternion, body.velocity
    )


def relative_velocity(body: RigidState, reference: RigidState) -> Array:
    """Velocity (..., 6) of `body` minus that of `reference`, both in the body's FLU axes."""
    return rigid_loops.relative_velocity(
        body.quaternion, body.velocity, reference.quaternion, reference.velocity
    )


def body_acceleration(body: RigidState, acceleration: Array | float) -> Array:
    """Rates (..., 6) of the components of `nu` of a body that accelerates so in world axes.

    Args:
        body: its state.
        acceleration: (..., 6) of its origin and of its rotation, world axes NWU, m/s2, rad/s2.
    """
    acceleration = np.broadcast_to(np.asarray(acceleration, dtype=float), body.velocity.shape)
    return rigid_loops.body_acceleration(body.quaternion, body.velocity, acceleration)


def world_velocity(body: RigidState) -> Array:
    """Velocity (..., 6) of the origin and of the rotation, world axes NWU, m/s, rad/s."""
    return rigid_loops.world_velocity(body.quaternion, body.velocity)


@dataclass(frozen=True)
class AccelerationState:
    """Memory of an `Accelerometer`.

    Attributes:
        velocity: (..., 6) at the last update, world axes; NaN before the first one.
        filtered: (..., 6) acceleration, low-passed.
    """

    velocity: Array
    filtered: Array


@dataclass(frozen=True)
class Accelerometer:
    """Acceleration of a body from its velocity, world axes: difference, low-pass, lead.

    Attributes:
        period: time between updates, s.
        smoothing: time constant of the low-pass, s.
        lead: how far ahead the result is, s: makes up for actuators that lag.
    """

    period: float
    smoothing: float = 0.1
    lead: float = 0.2

    def initial(self, shape: tuple[int, ...] = ()) -> AccelerationState:
        """State before the first update, for a leading shape."""
        return AccelerationState(np.full((*shape, 6), np.nan), np.zeros((*shape, 6)))

    def update(
        self, state: AccelerationState, body: RigidState, measured: Array | None = None
    ) -> tuple[Array, AccelerationState]:
        """Acceleration (..., 6) of origin and rotation, world axes NWU, and the next state.

        Args:
            state: state after the previous update.
            body: the body.
            measured: (..., 6) acceleration to use instead of the difference of velocities.
        """
        velocity = world_velocity(body)
        raw = np.where(np.isnan(state.velocity), 0.0, (velocity - state.velocity) / self.period)
        raw = raw if measured is None else measured
        rest = raw - state.filtered
        filtered = state.filtered - np.expm1(-self.period / self.smoothing) * rest
        ahead = filtered + self.lead / self.smoothing * (raw - filtered)
        return ahead, AccelerationState(velocity, filtered)


def acceleration_at(body: RigidState, acceleration: Array, point: Array) -> Array:
    """Acceleration (..., 6) of a point (..., 3) fixed to a body, world axes NWU."""
    return rigid_loops.acceleration_at(
        body.position, body.quaternion, body.velocity, acceleration, point
    )


def heading_quaternion(heading: Array) -> Array:
    """Attitude (..., 4) wxyz of a level body with that heading [rad], NWU."""
    half = 0.5 * np.asarray(heading, dtype=float)
    zero = np.zeros_like(half)
    return np.stack([np.cos(half), zero, zero, np.sin(half)], axis=-1)
