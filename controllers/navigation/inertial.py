"""Inertial navigation of the vehicle, aided by its sensors and by what it hears of the carrier."""

from dataclasses import dataclass, field, replace
from enum import IntEnum
from typing import ClassVar

import numpy as np
from marine_mj.controllers.kinematics import RigidState, rotate
from marine_mj.controllers.navigation.carrier import (
    BIAS_EVERY,
    CarrierNavigation,
    CarrierState,
    bias_update,
    kept,
    start_deviations,
)
from marine_mj.controllers.navigation.clones import cloned, late
from marine_mj.controllers.navigation.error_state import (
    ATTITUDE,
    ErrorState,
    ErrorStateFilter,
    Linear,
    heading,
    height,
    over_ground,
    point_in_body,
    transposed,
)
from marine_mj.controllers.navigation.kernels import CORE
from marine_mj.controllers.navigation.navigator import Estimate, Truth
from marine_mj.controllers.navigation.noise import NoiseStream, as_seeds
from marine_mj.controllers.navigation.relative_sensors import Camera, Usbl
from marine_mj.controllers.navigation.sensors import (
    Compass,
    Dvl,
    GaussMarkov,
    Imu,
    Pressure,
)
from numpy.typing import NDArray
from scipy.special import gammainccinv

from marine_mj import frames
from marine_mj.frames import Array

# Further error states: error of the believed carrier, clones of camera and USBL.
_CARRIER, _CAMERA, _USBL, _SIZE = CORE, CORE + 6, CORE + 12, CORE + 15
_OWN = slice(CORE, CORE + 6)
# Channels of the noise.
_START, _IMU, _BIAS, _DVL, _PRESSURE, _COMPASS, _USBL_NOISE, _CAMERA_NOISE = range(20, 28)


class Aid(IntEnum):
    """Measurements that aid the vehicle's filter, as `InertialState.used` counts them."""

    DVL = 0
    PRESSURE = 1
    COMPASS = 2
    USBL = 3
    CAMERA = 4


@dataclass(frozen=True)
class Waiting:
    """A measurement under way.

    Attributes:
        residual: (..., m) measurement minus what was expected at the sample.
        R: (..., m, m) covariance of its noise.
        valid: (...,) bool, whether there will be data.
    """

    residual: Array
    R: Array
    valid: Array


@dataclass(frozen=True)
class InertialState:
    """Memory of `InertialNavigation`.

    Attributes:
        seeds: (...,) of the noise.
        kalman: of the vehicle's filter.
        bias: (..., 6) true biases of its IMU.
        carrier: of the carrier's navigation and the link.
        camera, usbl: measurements under way.
        used: (..., 5) how many measurements were believed, by `Aid`.
        refused: (..., 5) how many were not, for their NIS.
        nis: (..., 5) last normalised innovation squared; NaN before and without data.
    """

    seeds: NDArray[np.uint64]
    kalman: ErrorState
    bias: Array
    carrier: CarrierState
    camera: Waiting
    usbl: Waiting
    used: Array
    refused: Array
    nis: Array


@dataclass(frozen=True)
class InertialNavigation:
    """Error-state filter of the vehicle: strapdown IMU, DVL, pressure, compass, USBL, camera.

    Six of its states are the error of the carrier it believes in, so that a relative measurement
    corrects the relative pose at once and the absolute one as far as the carrier knows its own.

    Attributes:
        period: time between updates, s.
        carrier: navigation of the carrier and the link.
        dvl, pressure, compass, usbl, camera: sensors; None: not there.
        imu: of the vehicle.
        gravity: m/s2.
        position_error: of the carrier's position as heard, each axis, m.
        attitude_error: of its attitude as heard, each axis, rad.
        rough: (2,) unexpected accelerations of the carrier since the last message, m/s2, rad/s2.
        doubt: share of good measurements that the gate on the NIS refuses.
        start: (9,) standard deviations of position, velocity and attitude at the start.
    """

    stack_rule: ClassVar[str] = "same"

    period: float
    carrier: CarrierNavigation
    dvl: Dvl | None = None
    pressure: Pressure | None = None
    compass: Compass | None = None
    usbl: Usbl | None = None
    camera: Camera | None = None
    imu: Imu = field(default_factory=Imu)
    gravity: float = 9.81
    position_error: GaussMarkov = field(default_factory=lambda: GaussMarkov(0.5, 100.0))
    attitude_error: GaussMarkov = field(default_factory=lambda: GaussMarkov(0.01, 20.0))
    rough: Array | tuple[float, float] = (0.3, 0.1)
    doubt: float = 1e-6
    start: Array | tuple[float, ...] = (0.5, 0.5, 0.5, 0.1, 0.1, 0.1, 0.02, 0.02, 0.05)

    @property
    def kalman(self) -> ErrorStateFilter:
        """The filter."""
        keep, drive = np.ones(_SIZE - CORE), np.zeros(_SIZE - CORE)
        for part, process in (
            (slice(0, 3), self.position_error),
            (slice(3, 6), self.attitude_error),
        ):
            keep[part], drive[part] = process.keep(self.period), process.drive(self.period)
        return ErrorStateFilter(self.imu, self.period, self.gravity, keep, drive)

    def initial(
        self, truth: Truth, seeds: NDArray[np.uint64], shape: tuple[int, ...] = ()
    ) -> InertialState:
        """State at the start, its errors drawn from `start`."""
        seeds = as_seeds(seeds, shape)
        extra = np.zeros(_SIZE - CORE)
        extra[:3], extra[3:6] = self.position_error.sigma, self.attitude_error.sigma
        deviations = start_deviations(self.start, self.imu, extra)
        noise = NoiseStream(seeds, _SIZE, _START).rows(0)

        def nothing(m: int) -> Waiting:
            waits = np.zeros((*shape, m)), np.zeros((*shape, m, m))
            return Waiting(*waits, np.zeros(shape, dtype=bool))

        return InertialState(
            seeds=seeds,
            kalman=self.kalman.start(truth.vehicle, deviations, noise),
            bias=deviations[9:15] * noise[..., 9:15],
            carrier=self.carrier.initial(truth.carrier, seeds, shape),
            camera=nothing(6),
            usbl=nothing(3),
            used=np.zeros((*shape, len(Aid))),
            refused=np.zeros((*shape, len(Aid))),
            nis=np.full((*shape, len(Aid)), np.nan),
        )

    def update(self, state: InertialState, truth: Truth, step: int) -> Estimate:
        """Estimate at a step; see `Navigator.update`."""
        if step > 0:
            heard = self.carrier.update(
                state.carrier, truth.carrier, truth.carrier_acceleration, state.seeds, step
            )
            state = replace(state, carrier=heard)
            state = self._strapdown(state, truth.vehicle, truth.vehicle_acceleration, step)
            state = self._prompt(state, truth.vehicle, step)
            state = self._delayed(state, truth.vehicle, truth.carrier, step)
        believed, acceleration, _ = self._carrier(state)
        return Estimate(state.kalman.body, believed, acceleration, state)

    def _strapdown(
        self, state: InertialState, vehicle: RigidState, acceleration: Array, step: int
    ) -> InertialState:
        """State after the IMU's sample."""
        bias = state.bias
        if step % BIAS_EVERY == 0:
            noise = NoiseStream(state.seeds, 6, _BIAS).rows(step)
            bias = bias_update(self.imu, bias, noise, BIAS_EVERY * self.period)
        noise = NoiseStream(state.seeds, 6, _IMU).rows(step)
        sample = self.imu.measure(vehicle, acceleration, bias, noise, self.period, self.gravity)
        return replace(state, bias=bias, kalman=self.kalman.predict(state.kalman, sample))

    def _prompt(self, state: InertialState, vehicle: RigidState, step: int) -> InertialState:
        """State after the measurements that are there at once."""
        seeds, kalman = state.seeds, self.kalman
        if self.dvl is not None and self.dvl.timing.samples(step):
            stream = NoiseStream(seeds, 3, _DVL)
            z, seen = self.dvl.measure(vehicle, stream.rows(step))
            linear = over_ground(kalman, state.kalman, z, self.dvl.mount, self.dvl.deviation)
            seen = seen & kept(stream, step, self.dvl.timing)
            state = self._corrected(state, Aid.DVL, linear, seen)
        if self.pressure is not None and self.pressure.timing.samples(step):
            stream = NoiseStream(seeds, 1, _PRESSURE)
            z, seen = self.pressure.measure(vehicle, stream.rows(step))
            gauge = self.pressure
            linear = height(kalman, state.kalman, z, gauge.mount, gauge.deviation)
            seen = seen & kept(stream, step, gauge.timing)
            state = self._corrected(state, Aid.PRESSURE, linear, seen)
        if self.compass is not None and self.compass.timing.samples(step):
            stream = NoiseStream(seeds, 1, _COMPASS)
            z, seen = self.compass.measure(vehicle, stream.rows(step))
            linear = heading(kalman, state.kalman, z, self.compass.deviation)
            seen = seen & kept(stream, step, self.compass.timing)
            state = self._corrected(state, Aid.COMPASS, linear, seen)
        return state

    def _delayed(
        self, state: InertialState, vehicle: RigidState, carrier: RigidState, step: int
    ) -> InertialState:
        """State after the samples and arrivals of the measurements that take their time."""
        usbl, camera = self.usbl, self.camera
        if usbl is not None:
            if usbl.timing.samples(step):
                state = self._ping(state, usbl, vehicle, carrier, step)
            if usbl.timing.arrives(step) and step >= usbl.timing.every:
                waits = state.usbl
                linear = late(self.kalman, state.kalman, waits.residual, waits.R, _USBL)
                state = self._corrected(state, Aid.USBL, linear, waits.valid)
        if camera is not None:
            if camera.timing.samples(step):
                state = self._picture(state, camera, vehicle, carrier, step)
            if camera.timing.arrives(step) and step >= camera.timing.every:
                waits = state.camera
                linear = late(self.kalman, state.kalman, waits.residual, waits.R, _CAMERA)
                state = self._corrected(state, Aid.CAMERA, linear, waits.valid)
        return state

    def _ping(
        self, state: InertialState, usbl: Usbl, vehicle: RigidState, carrier: RigidState, step: int
    ) -> InertialState:
        """State with a sample of the USBL under way."""
        stream = NoiseStream(state.seeds, 3, _USBL_NOISE)
        z, seen = usbl.measure(vehicle, carrier, stream.rows(step))
        believed, _, age = self._carrier(state)
        expected, H = point_in_body(
            self.kalman, state.kalman, believed, usbl.transponder, usbl.mount, _CARRIER
        )
        factor = usbl.noise.factor(expected, (0.0, 0.0, 1.0))
        R = _squares(factor) + self._drift(age)[0]
        waits = Waiting(z - expected, R, seen & kept(stream, step, usbl.timing))
        return replace(state, usbl=waits, kalman=cloned(state.kalman, H, _USBL))

    def _picture(
        self,
        state: InertialState,
        camera: Camera,
        vehicle: RigidState,
        carrier: RigidState,
        step: int,
    ) -> InertialState:
        """State with a picture under way."""
        stream = NoiseStream(state.seeds, 6, _CAMERA_NOISE)
        z, attitude, seen = camera.measure(vehicle, carrier, stream.rows(step))
        believed, _, age = self._carrier(state)
        kalman = self.kalman
        expected, place = point_in_body(
            kalman, state.kalman, believed, camera.marker, camera.mount, _CARRIER
        )
        body = state.kalman.body
        relative = frames.quaternion_multiply(
            frames.quaternion_conjugate(body.quaternion), believed.quaternion
        )
        wrong = frames.quaternion_multiply(attitude, frames.quaternion_conjugate(relative))
        H = kalman.blank(state.kalman, 6)
        H[..., :3, :] = place
        H[..., 3:, ATTITUDE] = -np.eye(3)
        H[..., 3:, _CARRIER + 3 : _CARRIER + 6] = transposed(body.rotation)
        position, turn = self._drift(age)
        R = np.zeros((*age.shape, 6, 6))
        R[..., :3, :3] = _squares(camera.noise.factor(expected, camera.axis)) + position
        R[..., 3:, 3:] = np.square(camera.attitude) * np.eye(3) + turn
        waits = Waiting(
            np.concatenate([z - expected, frames.rotation_vector(wrong)], axis=-1),
            R,
            seen & kept(stream, step, camera.timing),
        )
        return replace(state, camera=waits, kalman=cloned(state.kalman, H, _CAMERA))

    def _drift(self, age: Array) -> tuple[Array, Array]:
        """Variances (..., 3, 3) of position and attitude of a carrier heard `age` (...,) s ago."""
        moved, turned = (0.5 * np.asarray(r) * age**2 for r in self.rough)
        eye = np.eye(3)
        return moved[..., None, None] ** 2 * eye, turned[..., None, None] ** 2 * eye

    def _carrier(self, state: InertialState) -> tuple[RigidState, Array, Array]:
        """Believed carrier with its error taken out, acceleration (..., 6), age (...,) in s."""
        body, acceleration, age = self.carrier.now(state.carrier)
        error = state.kalman.extra[..., :6]
        turn = frames.quaternion_from_rotation_vector(error[..., 3:])
        quaternion = frames.quaternion_multiply(turn, body.quaternion)
        return (
            RigidState(body.position + error[..., :3], quaternion, body.velocity),
            acceleration,
            age,
        )

    def _corrected(
        self, state: InertialState, aid: Aid, measured: Linear, valid: Array
    ) -> InertialState:
        """State after a measurement, counted as believed or refused."""
        gate = float(2.0 * gammainccinv(0.5 * measured.residual.shape[-1], self.doubt))
        kalman, nis = self.kalman.correct(state.kalman, measured, gate, valid)
        used, refused, last = state.used.copy(), state.refused.copy(), state.nis.copy()
        used[..., aid] += nis <= gate
        refused[..., aid] += nis > gate
        last[..., aid] = nis
        return replace(state, kalman=kalman, used=used, refused=refused, nis=last)


def _squares(factor: Array) -> Array:
    """`B B'` (..., 3, 3)."""
    return np.stack([rotate(factor, factor[..., i, :]) for i in range(factor.shape[-2])], axis=-1)
