"""Error-state Kalman filter of a rigid body with an IMU, and its measurements.

Mean: position and velocity NWU, quaternion wxyz, biases of accelerometers and gyros, further
states. Errors (15 + e): the same with a rotation vector in body axes, `q = q_hat exp(theta)`.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from marine_mj.controllers.kinematics import RigidState, rotate, unrotate
from marine_mj.controllers.navigation.kernels import CORE, inertial_predict, kalman_update
from marine_mj.controllers.navigation.sensors import Imu

from marine_mj import frames
from marine_mj.frames import Array

Vector = Array | tuple[float, ...]
# Places of the error states.
POSITION, VELOCITY, ATTITUDE = slice(0, 3), slice(3, 6), slice(6, 9)
FORCE_BIAS, RATE_BIAS = slice(9, 12), slice(12, 15)


@dataclass(frozen=True)
class ErrorState:
    """What the filter believes.

    Attributes:
        mean: (..., 16 + e) position, velocity, quaternion, biases, further states.
        covariance: (..., 15 + e, 15 + e) of the errors.
        rate: (..., 3) last measured angular rate without its bias, FLU, rad/s.
    """

    mean: Array
    covariance: Array
    rate: Array

    @property
    def body(self) -> RigidState:
        """Estimated state of the body, NWU/FLU."""
        quaternion = self.mean[..., 6:10]
        turn = frames.rotation_from_quaternion(quaternion)
        linear = unrotate(turn, self.mean[..., 3:6])
        velocity = np.concatenate([linear, self.rate], axis=-1)
        return RigidState(self.mean[..., :3], quaternion, velocity)

    @property
    def extra(self) -> Array:
        """Further states (..., e)."""
        return self.mean[..., CORE + 1 :]


class Linear(NamedTuple):
    """A measurement, linearised at the estimate.

    Attributes:
        residual: (..., m) measurement minus prediction.
        H: (..., m, n).
        R: (..., m, m) covariance of the noise.
    """

    residual: Array
    H: Array
    R: Array


@dataclass(frozen=True)
class ErrorStateFilter:
    """Filter with `e` further states that keep a share of their value and gain variance.

    Attributes:
        imu: its noise and bias processes.
        period: between two predictions, s.
        gravity: m/s2.
        keep: (e,) share of each further state after a period.
        drive: (e,) variance that each gains in a period.
        roughness: (2,) extra process noise of velocity and attitude for what a strapdown period
            leaves out, m/s and rad per period.
    """

    imu: Imu
    period: float
    gravity: float = 9.81
    keep: Array = field(default_factory=lambda: np.zeros(0))
    drive: Array = field(default_factory=lambda: np.zeros(0))
    roughness: Vector = (1e-5, 1e-6)

    @property
    def size(self) -> int:
        """Number of error states n."""
        return CORE + len(self.keep)

    @property
    def _steps(self) -> tuple[Array, Array]:
        """Share kept and variance gained (n,) in a period, by error state."""
        keep, drive = np.ones(self.size), np.zeros(self.size)
        T, imu = self.period, self.imu
        drive[VELOCITY] = (T * imu.accelerometer) ** 2 + self.roughness[0] ** 2
        drive[ATTITUDE] = (T * imu.gyro) ** 2 + self.roughness[1] ** 2
        for part, process in ((FORCE_BIAS, imu.accelerometer_bias), (RATE_BIAS, imu.gyro_bias)):
            keep[part], drive[part] = process.keep(T), process.drive(T)
        keep[CORE:], drive[CORE:] = self.keep, self.drive
        return keep, drive

    def start(self, body: RigidState, deviations: Array, noise: Array) -> ErrorState:
        """State whose errors have these deviations (n,), drawn with normal numbers (..., n).

        Args:
            body: true state.
            deviations: (n,) standard deviations of the errors.
            noise: (..., n).
        """
        shape = noise.shape[:-1]
        mean = np.zeros((*shape, self.size + 1))
        error = deviations * noise
        mean[..., :3], mean[..., 3:6] = body.position, body.linear_velocity
        mean[..., 6:10], mean[..., 3:6] = body.quaternion, body.linear_velocity
        covariance = np.broadcast_to(np.diag(np.square(deviations)), (*shape, self.size, self.size))
        # Biases and further states start at zero: their errors are their true values.
        error[..., 9:] = 0.0
        state = ErrorState(mean, covariance.copy(), body.velocity[..., 3:])
        return _injected(state, error)

    def predict(self, state: ErrorState, imu: Array) -> ErrorState:
        """State a period later, with the IMU's sample (..., 6) of that period."""
        keep, drive = self._steps
        mean, covariance = inertial_predict(
            state.mean,
            state.covariance,
            imu[..., :3],
            imu[..., 3:],
            self.period,
            self.gravity,
            keep,
            drive,
        )
        return ErrorState(mean, covariance, imu[..., 3:] - mean[..., 13:16])

    def correct(
        self,
        state: ErrorState,
        measured: Linear,
        gate: float = np.inf,
        valid: Array | bool = True,
    ) -> tuple[ErrorState, Array]:
        """State after a measurement, and its NIS (...,); see `kalman_update`."""
        dx, covariance, nis = kalman_update(
            state.covariance, measured.H, measured.residual, measured.R, gate, valid
        )
        corrected = _injected(state, dx)
        rate = state.rate - dx[..., RATE_BIAS]
        return ErrorState(corrected.mean, covariance, rate), nis

    def blank(self, state: ErrorState, rows: int) -> Array:
        """Measurement matrix (..., m, n) of zeros."""
        return np.zeros((*state.mean.shape[:-1], rows, self.size))


def _injected(state: ErrorState, error: Array) -> ErrorState:
    """State with an error (..., n) put into its mean."""
    mean = state.mean.copy()
    mean[..., :6] += error[..., :6]
    turned = frames.quaternion_multiply(
        mean[..., 6:10], frames.quaternion_from_rotation_vector(error[..., ATTITUDE])
    )
    mean[..., 6:10] = turned / np.linalg.norm(turned, axis=-1)[..., None]
    mean[..., 10:] += error[..., 9:]
    return ErrorState(mean, state.covariance, state.rate)


def errors(state: ErrorState, body: RigidState, bias: Array) -> Array:
    """True minus estimated core states (..., 15), for tests of consistency.

    Args:
        state: of the filter.
        body: true state.
        bias: (..., 6) true biases of accelerometers and gyros.
    """
    mean = state.mean
    turn = frames.quaternion_multiply(frames.quaternion_conjugate(mean[..., 6:10]), body.quaternion)
    return np.concatenate(
        [
            body.position - mean[..., :3],
            body.linear_velocity - mean[..., 3:6],
            frames.rotation_vector(turn),
            bias - mean[..., 10:16],
        ],
        axis=-1,
    )


def skews(vector: Array) -> Array:
    """Cross-product matrices (..., 3, 3) of vectors (..., 3)."""
    x, y, z = vector[..., 0], vector[..., 1], vector[..., 2]
    zero = np.zeros_like(x)
    rows = [[zero, -z, y], [z, zero, -x], [-y, x, zero]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def transposed(matrix: Array) -> Array:
    """Transposed matrices (..., m, n)."""
    return np.swapaxes(matrix, -1, -2)


def over_ground(
    kalman: ErrorStateFilter,
    state: ErrorState,
    measured: Array,
    mount: Vector,
    deviation: Callable[[Array], Array],
) -> Linear:
    """Velocity (..., 3) of a mount in body axes: `R' v + w x r`.

    Args:
        kalman, state: the filter.
        measured: (..., 3) m/s.
        mount: (3,) r, FLU, m.
        deviation: standard deviation (...,) of each component at a velocity (..., 3).
    """
    body, arm = state.body, np.asarray(mount, dtype=float)
    linear = body.velocity[..., :3]
    expected = linear + frames.cross(state.rate, arm)
    H = kalman.blank(state, 3)
    H[..., VELOCITY] = transposed(body.rotation)
    H[..., ATTITUDE] = skews(linear)
    H[..., RATE_BIAS] = skews(arm)
    R = np.square(deviation(expected))[..., None, None] * np.eye(3)
    return Linear(measured - expected, H, R)


def height(
    kalman: ErrorStateFilter, state: ErrorState, measured: Array, mount: Vector, deviation: float
) -> Linear:
    """Height (..., 1) of a mount (3,), NWU."""
    body, arm = state.body, np.asarray(mount, dtype=float)
    expected = (body.position + rotate(body.rotation, arm))[..., 2:]
    H = kalman.blank(state, 1)
    H[..., 0, 2] = 1.0
    # Third row of -R [r]x: R_z' x r transposed.
    H[..., 0, ATTITUDE] = -frames.cross(body.rotation[..., 2, :], arm)
    R = np.broadcast_to(np.square(deviation), expected.shape)[..., None] * np.eye(1)
    return Linear(measured - expected, H, R)


def heading_row(rotation: Array) -> Array:
    """Derivative (..., 3) of the heading by a small turn in body axes."""
    north, west = rotation[..., 0, :], rotation[..., 1, :]
    level = north[..., 0] ** 2 + west[..., 0] ** 2
    # R (theta x e_x) = R_y theta_z - R_z theta_y
    by_z = (north[..., 0] * west[..., 1] - west[..., 0] * north[..., 1]) / level
    by_y = -(north[..., 0] * west[..., 2] - west[..., 0] * north[..., 2]) / level
    return np.stack([np.zeros_like(level), by_y, by_z], axis=-1)


def heading(
    kalman: ErrorStateFilter, state: ErrorState, measured: Array, deviation: float
) -> Linear:
    """Heading (..., 1) rad."""
    body = state.body
    H = kalman.blank(state, 1)
    H[..., 0, ATTITUDE] = heading_row(body.rotation)
    residual = frames.ssa(measured - body.heading[..., None])
    R = np.broadcast_to(np.square(deviation), residual.shape)[..., None] * np.eye(1)
    return Linear(residual, H, R)


def satellite(
    kalman: ErrorStateFilter, state: ErrorState, measured: Array, deviations: Array
) -> Linear:
    """Position, velocity and heading (..., 7), the position with the bias in the states 15 to 17.

    Args:
        kalman, state: the filter; its first three further states are the bias.
        measured: (..., 7).
        deviations: (..., 7).
    """
    body = state.body
    bias = state.extra[..., :3]
    turn = frames.ssa(measured[..., 6:] - body.heading[..., None])
    moved = measured[..., :6] - state.mean[..., :6]
    moved[..., :3] -= bias
    H = kalman.blank(state, 7)
    H[..., :6, :6] = np.eye(6)
    H[..., :3, CORE : CORE + 3] = np.eye(3)
    H[..., 6, ATTITUDE] = heading_row(body.rotation)
    R = np.square(deviations)[..., None] * np.eye(7)
    return Linear(np.concatenate([moved, turn], axis=-1), H, R)


def point_in_body(
    kalman: ErrorStateFilter,
    state: ErrorState,
    carrier: RigidState,
    point: Vector,
    mount: Vector,
    place: int,
) -> tuple[Array, Array]:
    """Predicted vector (..., 3) from a mount to a point of the carrier, FLU, and its H (..., 3, n).

    Args:
        kalman, state: the filter of the body.
        carrier: believed state of the carrier, its error already taken out.
        point: (3,) on the carrier, FLU, m.
        mount: (3,) on the body, FLU, m.
        place: first of the six further error states that hold the carrier's error: position NWU,
            then a small turn in world axes.
    """
    body = state.body
    arm = rotate(carrier.rotation, np.asarray(point, dtype=float))
    vector = unrotate(body.rotation, carrier.position + arm - body.position)
    back = transposed(body.rotation)
    H = kalman.blank(state, 3)
    H[..., POSITION] = -back
    H[..., ATTITUDE] = skews(vector)
    H[..., place : place + 3] = back
    # (theta x arm) in body axes
    H[..., place + 3 : place + 6] = -np.stack(
        [unrotate(body.rotation, column) for column in np.moveaxis(skews(arm), -1, 0)], axis=-1
    )
    return vector - np.asarray(mount), H
