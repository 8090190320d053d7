"""Navigation of the carrier, and what the vehicle hears of it over an acoustic link."""

from dataclasses import dataclass, field, replace

import numpy as np
from marine_mj.controllers.kinematics import RigidState, rotate, unrotate
from marine_mj.controllers.navigation.error_state import ErrorState, ErrorStateFilter, satellite
from marine_mj.controllers.navigation.kernels import CORE
from marine_mj.controllers.navigation.noise import NoiseStream
from marine_mj.controllers.navigation.sensors import Gnss, Imu, Timing
from numpy.typing import NDArray

from marine_mj import frames
from marine_mj.frames import Array

# Channels of the noise.
_START, _IMU, _BIAS, _GNSS, _GNSS_BIAS, _LINK = range(40, 46)
#: Navigation updates between two changes of the biases of an IMU: they are slow.
BIAS_EVERY = 100
#: Deviations of the core states at the start: m, m/s, rad; biases come from their processes.
_START_DEVIATIONS = (0.5, 0.5, 0.5, 0.1, 0.1, 0.1, 0.02, 0.02, 0.02)
# Parts of a message: position, quaternion, velocity, angular velocity and their rates, world axes.
_MESSAGE = 19


@dataclass(frozen=True)
class CarrierState:
    """Memory of the carrier's navigation and of the link.

    Attributes:
        kalman: of the filter on the carrier.
        bias: (..., 6) true biases of its IMU.
        gnss_bias: (..., 3) true bias of its position, m.
        smooth: (..., 6) smoothed acceleration and angular velocity, world axes.
        sent: (..., 19) message under way.
        heard: (...,) bool, whether it will arrive.
        message: (..., 19) last message that arrived.
        age: (...,) updates since that one was made.
    """

    kalman: ErrorState
    bias: Array
    gnss_bias: Array
    smooth: Array
    sent: Array
    heard: Array
    message: Array
    age: Array


@dataclass(frozen=True)
class CarrierNavigation:
    """Filter on the carrier with IMU and satellite compass, acoustic link, prediction to now.

    Attributes:
        period: time between updates, s.
        link: when messages are sent, how long they take, how many are lost.
        imu, gnss: sensors of the carrier.
        gravity: m/s2.
        smoothing: time constant of the acceleration in the messages, s.
        frequency: of the waves, rad/s: with it the motion goes on from the last message as
            `x'' = -frequency^2 x`; 0: with constant acceleration.
        start: (9,) standard deviations of position, velocity and attitude at the start.
    """

    period: float
    link: Timing
    gnss: Gnss
    imu: Imu = field(default_factory=Imu)
    gravity: float = 9.81
    smoothing: float = 0.1
    frequency: float = 1.25
    start: Array | tuple[float, ...] = _START_DEVIATIONS

    @property
    def kalman(self) -> ErrorStateFilter:
        """The filter; its further states are the bias of the satellite position."""
        bias, T = self.gnss.bias, self.period
        return ErrorStateFilter(
            self.imu,
            T,
            self.gravity,
            keep=np.broadcast_to(bias.keep(T), 3),
            drive=np.broadcast_to(bias.drive(T), 3),
        )

    def initial(
        self, carrier: RigidState, seeds: NDArray[np.uint64], shape: tuple[int, ...]
    ) -> CarrierState:
        """State at the start: the vehicle has just heard the first message."""
        deviations = start_deviations(
            self.start, self.imu, np.broadcast_to(self.gnss.bias.sigma, 3)
        )
        noise = NoiseStream(seeds, CORE + 3, _START).rows(0)
        state = self.kalman.start(carrier, deviations, noise)
        spin = rotate(state.body.rotation, state.rate)
        still = np.concatenate([np.zeros((*shape, 3)), spin], axis=-1)
        message = _message(state, still, np.zeros((*shape, 3)))
        return CarrierState(
            kalman=state,
            bias=deviations[9:15] * noise[..., 9:15],
            gnss_bias=deviations[15:] * noise[..., 15:],
            smooth=still,
            sent=message,
            heard=np.zeros(shape, dtype=bool),
            message=message,
            age=np.zeros(shape),
        )

    def update(
        self,
        state: CarrierState,
        carrier: RigidState,
        acceleration: Array,
        seeds: NDArray[np.uint64],
        step: int,
    ) -> CarrierState:
        """State at step 1, 2, ... of the carrier's filter and of the link.

        Args:
            state: state after the previous update.
            carrier: true state.
            acceleration: (..., 6) true mean acceleration of the last period, world axes NWU.
            seeds: (...,) of the noise.
            step: number of the update.
        """
        bias, gnss_bias = state.bias, state.gnss_bias
        if step % BIAS_EVERY == 0:
            noise = NoiseStream(seeds, 6, _BIAS).rows(step)
            bias = bias_update(self.imu, bias, noise, BIAS_EVERY * self.period)
        noise = NoiseStream(seeds, 6, _IMU).rows(step)
        sample = self.imu.measure(carrier, acceleration, bias, noise, self.period, self.gravity)
        previous, kalman = state.kalman, self.kalman
        filtered = kalman.predict(previous, sample)
        gained = (filtered.mean[..., 3:6] - previous.mean[..., 3:6]) / self.period
        if self.gnss.timing.samples(step):
            stream = NoiseStream(seeds, 7, _GNSS)
            # The bias matters at fixes only. At each it changes as much as the filter expects.
            noise = NoiseStream(seeds, 3, _GNSS_BIAS).rows(step)
            elapsed = self.gnss.timing.every * self.period
            gnss_bias = self.gnss.bias.update(gnss_bias, noise, elapsed)
            fix = self.gnss.measure(carrier, gnss_bias, stream.rows(step))
            linear = satellite(kalman, filtered, fix, self.gnss.deviations)
            valid = kept(stream, step, self.gnss.timing)
            filtered, _ = kalman.correct(filtered, linear, valid=valid)
        spin = rotate(filtered.body.rotation, filtered.rate)
        now = np.concatenate([gained, spin], axis=-1)
        smooth = state.smooth - np.expm1(-self.period / self.smoothing) * (now - state.smooth)
        turning = (spin - smooth[..., 3:]) / self.smoothing
        following = replace(
            state,
            kalman=filtered,
            bias=bias,
            gnss_bias=gnss_bias,
            smooth=smooth,
            age=state.age + 1.0,
        )
        return self._linked(following, turning, seeds, step)

    def _linked(
        self, state: CarrierState, turning: Array, seeds: NDArray[np.uint64], step: int
    ) -> CarrierState:
        """State after sending and hearing what is due."""
        link = self.link
        if link.samples(step):
            heard = kept(NoiseStream(seeds, 1, _LINK), step, link)
            state = replace(state, sent=_message(state.kalman, state.smooth, turning), heard=heard)
        if link.arrives(step) and step >= link.every:
            message = np.where(state.heard[..., None], state.sent, state.message)
            age = np.where(state.heard, float(link.delay), state.age)
            state = replace(state, message=message, age=age)
        return state

    def now(self, state: CarrierState) -> tuple[RigidState, Array, Array]:
        """Carrier as the vehicle believes it to be, from the last message.

        Returns:
            state NWU/FLU; acceleration (..., 6) world axes NWU; age (...,) of the message, s.
        """
        age = state.age * self.period
        m, t = state.message, age[..., None]
        w = np.asarray(self.frequency)[..., None]
        first = t * np.sinc(w * t / np.pi)
        second = 0.5 * t**2 * np.sinc(0.5 * w * t / np.pi) ** 2
        c = np.cos(w * t)
        twist, rate = m[..., 7:13], m[..., 13:19]
        moved = twist * first + rate * second
        velocity = twist * c + rate * first
        acceleration = rate * c - w**2 * twist * first
        quaternion = frames.quaternion_multiply(
            frames.quaternion_from_rotation_vector(moved[..., 3:]), m[..., 3:7]
        )
        turn = frames.rotation_from_quaternion(quaternion)
        nu = [unrotate(turn, velocity[..., :3]), unrotate(turn, velocity[..., 3:])]
        body = RigidState(m[..., :3] + moved[..., :3], quaternion, np.concatenate(nu, axis=-1))
        return body, acceleration, age


def start_deviations(core: Array | tuple[float, ...], imu: Imu, extra: Array) -> Array:
    """Standard deviations (15 + e,) of a filter's errors at the start.

    Args:
        core: (9,) of position, velocity and attitude.
        imu: biases start at their stationary deviation.
        extra: (e,) of the further states.
    """
    biases = [imu.accelerometer_bias.sigma, imu.gyro_bias.sigma]
    return np.concatenate(
        [np.asarray(core), *(np.broadcast_to(sigma, 3) for sigma in biases), extra]
    )


def bias_update(imu: Imu, bias: Array, noise: Array, elapsed: float) -> Array:
    """True biases (..., 6) of an IMU a time later, from normal numbers (..., 6)."""
    parts = ((imu.accelerometer_bias, slice(0, 3)), (imu.gyro_bias, slice(3, 6)))
    return np.concatenate(
        [process.update(bias[..., p], noise[..., p], elapsed) for process, p in parts], axis=-1
    )


def kept(stream: NoiseStream, step: int, timing: Timing) -> Array:
    """Where (...,) the sample of a step is not lost."""
    return stream.uniform(step)[..., 0] >= timing.dropout


def _message(state: ErrorState, smooth: Array, turning: Array) -> Array:
    """Message (..., 19) from the filter's state, smoothed acceleration and angular acceleration."""
    body = state.body
    return np.concatenate(
        [
            body.position,
            body.quaternion,
            state.mean[..., 3:6],
            rotate(body.rotation, state.rate),
            smooth[..., :3],
            turning,
        ],
        axis=-1,
    )
