"""Sensors: from true states and noise to measurements and whether there is one.

Every sensor is a frozen set of numbers; `measure` works on arrays of any leading shape and takes
standard normal noise. World NWU, body FLU, SI. Default numbers are those of the docking study
(tables 8.2 and 8.3) where it has them.
"""

from dataclasses import dataclass, field

import numpy as np
from marine_mj.controllers.kinematics import RigidState, rotate, unrotate
from marine_mj.controllers.navigation.navigator import whole_steps

from marine_mj import frames
from marine_mj.errors import ScenarioError
from marine_mj.frames import Array

Vector = Array | tuple[float, ...]
UP = (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class Timing:
    """When a sensor samples and when its data arrive, in navigation updates.

    Attributes:
        every: updates between two samples.
        delay: updates from a sample to its arrival, less than `every`: one is under way at a time.
        dropout: share of the samples that are lost.
    """

    every: int
    delay: int = 0
    dropout: float = 0.0

    def __post_init__(self) -> None:
        """Raise ScenarioError for times that cannot be."""
        if self.every < 1 or not 0 <= self.delay < self.every:
            raise ScenarioError(
                f"sensor timing: every = {self.every}, delay = {self.delay} updates; allowed are "
                "every >= 1 and 0 <= delay < every (one sample is under way at a time)"
            )
        if not np.all((np.asarray(self.dropout) >= 0) & (np.asarray(self.dropout) <= 1)):
            raise ScenarioError(f"sensor dropout = {self.dropout}: allowed is a share, 0 to 1")

    @classmethod
    def of(cls, period: float, delay: float, dropout: float, update: float) -> "Timing":
        """Timing from seconds, for navigation that is updated every `update` s.

        Raises:
            ScenarioError: a time is not a whole number of updates, or the delay is too long.
        """
        every = whole_steps("sensor period", period, update)
        return cls(every, whole_steps("sensor delay", delay, update, least=0), dropout)

    def samples(self, step: int) -> bool:
        """Whether there is a sample at a step."""
        return step % self.every == 0

    def arrives(self, step: int) -> bool:
        """Whether the data of a sample arrive at a step."""
        return step >= self.delay and (step - self.delay) % self.every == 0


@dataclass(frozen=True)
class GaussMarkov:
    """First-order Gauss-Markov process: `b' = -b / T + w`, exactly discretised.

    Attributes:
        sigma: standard deviation; a number or one per component.
        time_constant: T, s.
    """

    sigma: float | Vector
    time_constant: float

    def __post_init__(self) -> None:
        """Raise ScenarioError for a negative deviation or a time that is not positive."""
        if not (np.all(np.asarray(self.sigma) >= 0) and np.all(np.asarray(self.time_constant) > 0)):
            raise ScenarioError(
                f"Gauss-Markov process: sigma = {self.sigma} must be >= 0 and time_constant = "
                f"{self.time_constant} s > 0"
            )

    def keep(self, elapsed: float) -> Array:
        """Share `exp(-t / T)` of the value that is left after a time."""
        return np.exp(-elapsed / np.asarray(self.time_constant, dtype=float))

    def drive(self, elapsed: float) -> Array:
        """Variance `sigma^2 (1 - exp(-2 t / T))` that is gained in a time."""
        return -np.square(self.sigma) * np.expm1(
            -2.0 * elapsed / np.asarray(self.time_constant, dtype=float)
        )

    def initial(self, noise: Array) -> Array:
        """Values (..., k) of the stationary process from normal numbers (..., k)."""
        return np.asarray(self.sigma) * noise

    def update(self, value: Array, noise: Array, elapsed: float) -> Array:
        """Values (..., k) a time later."""
        return self.keep(elapsed) * value + np.sqrt(self.drive(elapsed)) * noise


@dataclass(frozen=True)
class Imu:
    """Accelerometers and gyros at the body origin, averaged over a navigation period.

    Attributes:
        accelerometer: standard deviation of a sample, m/s2 (table 8.2).
        gyro: of a sample, rad/s (table 8.2).
        accelerometer_bias: process of each axis, m/s2 (ours).
        gyro_bias: process of each axis, rad/s (ours).
    """

    accelerometer: float = np.sqrt(0.02)
    gyro: float = 0.004
    accelerometer_bias: GaussMarkov = field(default_factory=lambda: GaussMarkov(0.02, 600.0))
    gyro_bias: GaussMarkov = field(default_factory=lambda: GaussMarkov(5e-4, 600.0))

    def measure(
        self,
        body: RigidState,
        acceleration: Array,
        bias: Array,
        noise: Array,
        period: float,
        gravity: float,
    ) -> Array:
        """Mean specific force and angular rate (..., 6) of the last period, FLU.

        The force is in the axes of the middle of the period, `f = R_mid' (a - g)`.

        Args:
            body: true state at the end of the period.
            acceleration: (..., 6) true mean acceleration in it, world axes NWU.
            bias: (..., 6) of accelerometers and gyros.
            noise: (..., 6).
            period: s.
            gravity: m/s2.
        """
        spin = rotate(body.rotation, body.velocity[..., 3:])
        rate = unrotate(body.rotation, spin - 0.5 * period * acceleration[..., 3:])
        force = unrotate(body.rotation, acceleration[..., :3] + gravity * np.array(UP))
        force = force + 0.5 * period * frames.cross(rate, force)
        true = np.concatenate([force, rate], axis=-1)
        return true + bias + self.deviations * noise

    @property
    def deviations(self) -> Array:
        """Standard deviations (..., 6) of a sample."""
        return np.stack([self.accelerometer] * 3 + [self.gyro] * 3, axis=-1)


@dataclass(frozen=True)
class Dvl:
    """Doppler log: velocity over ground of its mount, in body axes, while it sees the bottom.

    Attributes:
        timing: of the samples.
        mount: (3,) position, FLU, m.
        floor: noise at rest, m/s (table 8.3).
        slope: growth with the root of the speed, (m/s)^0.5 (table 8.3).
        seabed: depth of the sea bed, m.
        highest: largest height above it, m.
        lowest: smallest height above it, m.
    """

    timing: Timing
    mount: Vector = (0.0, 0.0, -0.15)
    floor: float = 0.00084
    slope: float = 0.038
    seabed: float = 20.0
    highest: float = 50.0
    lowest: float = 0.3

    def deviation(self, velocity: Array) -> Array:
        """Standard deviation (...,) of each component at a velocity (..., 3), m/s."""
        return self.floor + self.slope * np.sqrt(np.linalg.norm(velocity, axis=-1))

    def measure(self, body: RigidState, noise: Array) -> tuple[Array, Array]:
        """Velocity (..., 3) FLU, and whether (...,) there is bottom lock."""
        mount = np.asarray(self.mount, dtype=float)
        velocity = body.velocity[..., :3] + frames.cross(body.velocity[..., 3:], mount)
        height = body.position[..., 2] + self.seabed
        seen = (height >= self.lowest) & (height <= self.highest)
        return velocity + self.deviation(velocity)[..., None] * noise, seen


@dataclass(frozen=True)
class Pressure:
    """Pressure gauge: height of its mount from the hydrostatic pressure.

    The dynamic pressure of waves is not modelled: depth is taken to be measured with `deviation`.

    Attributes:
        timing: of the samples.
        deviation: m (table 8.2).
        mount: (3,) position, FLU, m.
    """

    timing: Timing
    deviation: float = 0.05
    mount: Vector = (0.0, 0.0, 0.0)

    def measure(self, body: RigidState, noise: Array) -> tuple[Array, Array]:
        """Height (..., 1) NWU, m, and whether (...,) the gauge is below still water."""
        arm = np.asarray(self.mount, dtype=float)
        height = (body.position + rotate(body.rotation, arm))[..., 2:]
        return height + np.asarray(self.deviation)[..., None] * noise, height[..., 0] < 0


@dataclass(frozen=True)
class Compass:
    """Heading of the body's x axis.

    Attributes:
        timing: of the samples.
        deviation: rad (ours).
    """

    timing: Timing
    deviation: float = 0.02

    def measure(self, body: RigidState, noise: Array) -> tuple[Array, Array]:
        """Heading (..., 1) rad, counter-clockwise from north, and True (...,)."""
        heading = body.heading[..., None]
        return heading + np.asarray(self.deviation)[..., None] * noise, np.full(
            heading.shape[:-1], True
        )


@dataclass(frozen=True)
class Gnss:
    """Satellite compass of the carrier: position, velocity and heading at the body origin.

    Attributes:
        timing: of the fixes.
        bias: process of each axis of the position, m (ours).
        position, velocity, heading: standard deviations of a fix, m, m/s, rad (ours).
    """

    timing: Timing
    bias: GaussMarkov = field(default_factory=lambda: GaussMarkov(0.5, 300.0))
    position: float = 0.05
    velocity: float = 0.05
    heading: float = 0.01

    @property
    def deviations(self) -> Array:
        """Standard deviations (..., 7) of position, velocity and heading."""
        each = [self.position] * 3 + [self.velocity] * 3 + [self.heading]
        return np.stack(each, axis=-1).astype(float)

    def measure(self, body: RigidState, bias: Array, noise: Array) -> Array:
        """Position, velocity NWU and heading (..., 7), from a bias (..., 3) and noise (..., 7)."""
        parts = [body.position + bias, body.linear_velocity, body.heading[..., None]]
        return np.concatenate(parts, axis=-1) + self.deviations * noise
