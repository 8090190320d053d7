"""Navigation of the docking study: noisy planar states and two kinematic Kalman filters.

Measurement model and filter of the reference (docking digest 5.2 and 5.3; tables 8.4 to 8.7). Both
vehicles move in the vertical plane through the vehicle's start, along its heading there. Arrays
`[x, z, theta, u, w, q]` are NED in that plane: m, rad, m/s, rad/s; `(u, w)` is the velocity of the
vehicle in its body axes, that of the carrier in world axes.
"""

from dataclasses import dataclass, replace

import numpy as np
from marine_mj.controllers.kinematics import (
    RigidState,
    body_acceleration,
    heading_quaternion,
    rotate,
    unrotate,
)
from marine_mj.controllers.navigation.kernels import kalman_update, planar_predict
from marine_mj.controllers.navigation.navigator import Estimate, Truth, whole_steps
from marine_mj.controllers.navigation.noise import NoiseStream, as_seeds
from numpy.typing import NDArray

from marine_mj import frames
from marine_mj.errors import ScenarioError
from marine_mj.frames import Array

Vector = Array | tuple[float, ...]
# Channels of the noise.
_FIX, _ACCELERATION = 1, 2
# Base covariance of the accelerations (table 8.5): the filter assumes it in every scenario.
_BASE_ACCELERATION = tuple(np.sqrt((0.01, 0.01, 0.05)))
_BASE_FIX = (0.5, 0.5, 0.1, 0.05, 0.05, 0.001)


@dataclass(frozen=True)
class PlanarNoise:
    """Standard deviations of the measurements of both vehicles, and how often they come.

    Attributes:
        fix_period: t_z, time between two measurements of pose and velocity, s.
        acceleration: (3,) of the rates of u, w, q, every period: m/s2, m/s2, rad/s2.
        fix: (6,) of x, z, theta, u, w, q: m, m, rad, m/s, m/s, rad/s.
    """

    fix_period: float = 0.2
    acceleration: Vector = _BASE_ACCELERATION
    fix: Vector = _BASE_FIX

    def __post_init__(self) -> None:
        """Raise ScenarioError for a wrong number of deviations or a negative one."""
        for name, size in (("acceleration", 3), ("fix", 6)):
            values = np.asarray(getattr(self, name), dtype=float)
            least = 0.0 if name == "acceleration" else np.nextafter(0.0, 1.0)
            if values.shape != (size,) or not np.all(values >= least):
                allowed = ">= 0" if name == "acceleration" else "> 0"
                raise ScenarioError(
                    f"navigation noise {name} = {getattr(self, name)}: allowed are {size} standard "
                    f"deviations {allowed}"
                )


#: Base scenario (table 8.5) and scenarios 1 to 9 (table 8.6) of the reference.
PLANAR_SCENARIOS = {
    "base": PlanarNoise(),
    "acceleration_best": PlanarNoise(acceleration=tuple(np.sqrt((0.001, 0.001, 0.005)))),
    "acceleration_worst": PlanarNoise(acceleration=tuple(np.sqrt((0.1, 0.1, 0.5)))),
    "period_0.04": PlanarNoise(fix_period=0.04),
    "period_0.1": PlanarNoise(fix_period=0.1),
    "period_0.5": PlanarNoise(fix_period=0.5),
    "period_1": PlanarNoise(fix_period=1.0),
    "period_2": PlanarNoise(fix_period=2.0),
    "fix_best": PlanarNoise(fix=(0.05, 0.05, 0.01, 0.005, 0.005, 0.0001)),
    "fix_worst": PlanarNoise(fix=(1.0, 1.0, 0.5, 0.2, 0.2, 0.01)),
}


def planar_scenario(name: str) -> PlanarNoise:
    """Named noise of the reference.

    Raises:
        ScenarioError: the name is not one of `PLANAR_SCENARIOS`.
    """
    if name not in PLANAR_SCENARIOS:
        raise ScenarioError(
            f"navigation scenario = {name!r} does not exist; available: "
            f"{', '.join(PLANAR_SCENARIOS)}"
        )
    return PLANAR_SCENARIOS[name]


@dataclass(frozen=True)
class PlanarFilter:
    """Kinematic Kalman filter of one vehicle (digest 5.3).

    Attributes:
        period: T between two predictions, s.
        fix: (..., 6) standard deviations of a fix.
        turned: (u, w) is the velocity in body axes; otherwise in world axes.
        process: (6,) process noise of a period: standard deviations of x, z, theta, u, w, q.
        acceleration: (3,) assumed standard deviations of the measured accelerations.
    """

    period: float
    fix: Vector
    turned: bool
    process: Vector = (0.003, 0.003, 0.001, 0.001, 0.001, 0.01)
    acceleration: Vector = _BASE_ACCELERATION

    @property
    def noise(self) -> Array:
        """Diagonal (6,) of `G Q G'`, `G = [[I, 0, 0], [0, I, T I]]`."""
        noise = np.square(np.asarray(self.process, dtype=float))
        noise[3:] += np.square(self.period * np.asarray(self.acceleration))
        return noise

    def start(self, fix: Array) -> tuple[Array, Array]:
        """Mean (..., 6) and covariance (..., 6, 6) after the first fix (..., 6): `P0 = 9 R`."""
        covariance = np.broadcast_to(9.0 * self._R, (*fix.shape, 6)).copy()
        return fix, covariance

    @property
    def _R(self) -> Array:
        """Covariance (..., 6, 6) of a fix."""
        return np.square(np.asarray(self.fix, dtype=float))[..., None] * np.eye(6)

    def predict(self, mean: Array, covariance: Array, acceleration: Array) -> tuple[Array, Array]:
        """Mean and covariance a period later, with measured accelerations (..., 3)."""
        return planar_predict(
            mean, covariance, acceleration, self.period, self.noise, bool(self.turned)
        )

    def correct(self, mean: Array, covariance: Array, fix: Array) -> tuple[Array, Array, Array]:
        """Mean, covariance and NIS (...,) after a fix (..., 6); `H = I`."""
        dx, posterior, nis = kalman_update(covariance, np.eye(6), fix - mean, self._R)
        return mean + dx, posterior, nis


@dataclass(frozen=True)
class PlanarState:
    """Memory of `PlanarNavigation`.

    Attributes:
        seeds: (...,) of the noise.
        origin: (..., 3) of the plane, NWU, m.
        plane: (..., 4) attitude of the plane, wxyz.
        side: (...,) distance of the carrier to the left of the plane, m.
        level: (..., 4) attitude of the level carrier relative to the plane, wxyz.
        mean: (..., 2, 6) of vehicle and carrier.
        covariance: (..., 2, 6, 6).
    """

    seeds: NDArray[np.uint64]
    origin: Array
    plane: Array
    side: Array
    level: Array
    mean: Array
    covariance: Array


@dataclass(frozen=True)
class PlanarNavigation:
    """Navigation of the docking study.

    What the plane does not hold (sway, roll, yaw) is believed to stay as it was at the start.

    Attributes:
        period: time between updates, s.
        every: updates between two fixes, a whole number.
        acceleration: (3,) standard deviations of the measured accelerations.
        fix: (6,) standard deviations of a fix.
    """

    period: float
    every: float
    acceleration: Vector
    fix: Vector

    @classmethod
    def of(cls, noise: PlanarNoise, period: float) -> "PlanarNavigation":
        """Navigation with this noise.

        Raises:
            ScenarioError: `fix_period` is not a whole multiple of `period`.
        """
        every = whole_steps("navigation fix_period", noise.fix_period, period)
        return cls(period, float(every), np.asarray(noise.acceleration), np.asarray(noise.fix))

    @property
    def filters(self) -> tuple[PlanarFilter, PlanarFilter]:
        """Filters of vehicle and carrier."""
        return (
            PlanarFilter(self.period, self.fix, turned=True),
            PlanarFilter(self.period, self.fix, turned=False),
        )

    def initial(
        self, truth: Truth, seeds: NDArray[np.uint64], shape: tuple[int, ...] = ()
    ) -> PlanarState:
        """State after the first fix, at the start."""
        vehicle, carrier = truth.vehicle, truth.carrier
        plane = heading_quaternion(vehicle.heading)
        origin = vehicle.position * np.array([1.0, 1.0, 0.0])
        turn = frames.rotation_from_quaternion(plane)
        blank = np.zeros((*shape, 2, 6))
        state = PlanarState(
            seeds=as_seeds(seeds, shape),
            origin=origin,
            plane=plane,
            side=unrotate(turn, carrier.position - origin)[..., 1],
            level=heading_quaternion(carrier.heading - vehicle.heading),
            mean=blank,
            covariance=np.zeros((*shape, 2, 6, 6)),
        )
        fixes = self.fixes(state, vehicle, carrier, 0)
        return self._joined(state, [f.start(z) for f, z in zip(self.filters, fixes, strict=True)])

    def update(self, state: PlanarState, truth: Truth, step: int) -> Estimate:
        """Estimate at a step; see `Navigator.update`."""
        turn = frames.rotation_from_quaternion(state.plane)
        gained = truth.carrier_acceleration
        parts = [unrotate(turn, gained[..., :3]), unrotate(turn, gained[..., 3:])]
        noise = NoiseStream(state.seeds, 6, _ACCELERATION).rows(step)
        sigma = np.asarray(self.acceleration)
        own = _in_plane(body_acceleration(truth.vehicle, truth.vehicle_acceleration))
        own = own + sigma * noise[..., :3]
        other = _in_plane(np.concatenate(parts, axis=-1)) + sigma * noise[..., 3:]
        if step > 0:
            filters, measured = self.filters, (own, other)
            pairs = [
                f.predict(state.mean[..., i, :], state.covariance[..., i, :, :], measured[i])
                for i, f in enumerate(filters)
            ]
            due = np.mod(step, self.every) == 0
            if np.any(due):
                fixes = self.fixes(state, truth.vehicle, truth.carrier, step)
                pairs = [
                    _where(due, f.correct(*p, z)[:2], p)
                    for f, p, z in zip(filters, pairs, fixes, strict=True)
                ]
            state = self._joined(state, pairs)
        linear = rotate(turn, _from_plane(other)[..., :3])
        angular = rotate(turn, _from_plane(other)[..., 3:])
        return Estimate(
            self._vehicle(state),
            self._carrier(state),
            np.concatenate([linear, angular], axis=-1),
            state,
        )

    @staticmethod
    def _joined(state: PlanarState, pairs: list[tuple[Array, Array]]) -> PlanarState:
        """State with the means and covariances of both filters."""
        mean = np.stack([pair[0] for pair in pairs], axis=-2)
        return replace(state, mean=mean, covariance=np.stack([p[1] for p in pairs], axis=-3))

    def fixes(
        self, state: PlanarState, vehicle: RigidState, carrier: RigidState, step: int
    ) -> tuple[Array, Array]:
        """Measured `[x, z, theta, u, w, q]` (..., 6) of vehicle and carrier at a step."""
        noise = NoiseStream(state.seeds, 12, _FIX).rows(step)
        sigma = np.asarray(self.fix)
        own, other = self.true_states(state, vehicle, carrier)
        return own + sigma * noise[..., :6], other + sigma * noise[..., 6:]

    @staticmethod
    def true_states(
        state: PlanarState, vehicle: RigidState, carrier: RigidState
    ) -> tuple[Array, Array]:
        """True `[x, z, theta, u, w, q]` (..., 6) of vehicle and carrier."""
        turn = frames.rotation_from_quaternion(state.plane)
        inverse = frames.quaternion_conjugate(state.plane)
        found = []
        for body, level in ((vehicle, None), (carrier, state.level)):
            place = unrotate(turn, body.position - state.origin)
            attitude = frames.quaternion_multiply(inverse, body.quaternion)
            if level is None:
                twist = body.velocity
            else:
                back = frames.quaternion_conjugate(level)
                attitude = frames.quaternion_multiply(attitude, back)
                spin = rotate(body.rotation, body.velocity[..., 3:])
                linear = unrotate(turn, body.linear_velocity)
                twist = np.concatenate([linear, unrotate(turn, spin)], axis=-1)
            pose = np.concatenate([place, frames.rotation_vector(attitude)], axis=-1)
            found.append(np.concatenate([_in_plane(pose), _in_plane(twist)], axis=-1))
        return found[0], found[1]

    @staticmethod
    def _vehicle(state: PlanarState) -> RigidState:
        """Estimated state of the vehicle."""
        mean = state.mean[..., 0, :]
        turn = frames.rotation_from_quaternion(state.plane)
        pose, twist = _from_plane(mean[..., :3]), _from_plane(mean[..., 3:])
        attitude = frames.quaternion_multiply(state.plane, _pitched(mean[..., 2]))
        return RigidState(state.origin + rotate(turn, pose[..., :3]), attitude, twist)

    @staticmethod
    def _carrier(state: PlanarState) -> RigidState:
        """Estimated state of the carrier."""
        mean = state.mean[..., 1, :]
        turn = frames.rotation_from_quaternion(state.plane)
        pose, twist = _from_plane(mean[..., :3]), _from_plane(mean[..., 3:])
        place = pose[..., :3] + state.side[..., None] * np.array([0.0, 1.0, 0.0])
        tilted = frames.quaternion_multiply(_pitched(mean[..., 2]), state.level)
        body = frames.rotation_from_quaternion(tilted)
        velocity = [unrotate(body, twist[..., :3]), unrotate(body, twist[..., 3:])]
        return RigidState(
            state.origin + rotate(turn, place),
            frames.quaternion_multiply(state.plane, tilted),
            np.concatenate(velocity, axis=-1),
        )


def _where(
    due: NDArray[np.bool_], new: tuple[Array, Array], old: tuple[Array, Array]
) -> tuple[Array, Array]:
    """Mean and covariance with a fix where one is due (...,)."""
    rows = np.asarray(due)[..., None]
    return np.where(rows, new[0], old[0]), np.where(rows[..., None], new[1], old[1])


def _in_plane(vector: Array) -> Array:
    """Surge, heave and pitch parts (..., 3) NED of vectors (..., 6) NWU."""
    return np.stack([vector[..., 0], -vector[..., 2], -vector[..., 4]], axis=-1)


def _from_plane(vector: Array) -> Array:
    """Vectors (..., 6) NWU with these parts (..., 3) NED in the plane."""
    out = np.zeros((*vector.shape[:-1], 6))
    out[..., 0], out[..., 2], out[..., 4] = vector[..., 0], -vector[..., 1], -vector[..., 2]
    return out


def _pitched(theta: Array) -> Array:
    """Attitude (..., 4) wxyz of a body pitched by theta [rad], bow up, NWU."""
    zero = np.zeros_like(theta)
    return np.stack([np.cos(0.5 * theta), zero, -np.sin(0.5 * theta), zero], axis=-1)
