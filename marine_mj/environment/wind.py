"""Wind at 10 m height as a frozen series: steady, gusty, wandering or turning."""

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from marine_mj.environment._checks import Frozen, Seed, array, generator, number, one_of
from marine_mj.environment.series import interpolate, knots
from marine_mj.errors import SeaError
from marine_mj.frames import Array

GustSpectrum = Literal["npd", "harris", "davenport"]

#: Frequencies of the gust components, Hz: NPD holds from 1/600 Hz to 0.5 Hz.
GUST_RANGE = (1 / 600, 0.5)
GUST_COMPONENTS = 200
#: Exponent of the height profile over open sea with waves (DNV-RP-C205, Table 2-1).
OPEN_SEA = 0.12


@dataclass(frozen=True, eq=False)
class Wind(Frozen):
    """Wind velocity at 10 m height as a function of time; uniform in space.

    Attributes:
        interval: time between knots, s, > 0.
        velocity: (m, 3) velocity towards which the air moves, m/s, NWU, at t = 0, interval, ...;
            linear between knots, held after the end; m >= 1.
        air_density: kg/m3.
        height_exponent: a body feels this wind times `height_factor` at the centroid of its lateral
            area; 0: the same wind at all heights.

    Raises:
        SeaError: an array does not fit or a value is out of range.
    """

    interval: float
    velocity: Array
    air_density: float = 1.225
    height_exponent: float = OPEN_SEA

    def __post_init__(self) -> None:
        """Check and freeze."""
        interval = number("interval", self.interval, "s", "give the time between knots", above=0)
        object.__setattr__(self, "interval", interval)
        velocity = array("velocity", self.velocity, ("m", 3), "m/s")
        if len(velocity) == 0:
            raise SeaError("velocity has 0 knots, allowed are 1 or more: use no_wind() for none")
        object.__setattr__(self, "velocity", velocity)
        fix = "1.225 at 15 degrees C"
        density = number("air_density", self.air_density, "kg/m3", fix, above=0)
        object.__setattr__(self, "air_density", density)
        exponent = _exponent("height_exponent", self.height_exponent)
        object.__setattr__(self, "height_exponent", exponent)

    def velocity_at(self, t: ArrayLike) -> Array:
        """Wind velocity (..., 3) [m/s, NWU] at 10 m height and time t (s)."""
        return interpolate(self.velocity, self.interval, t)


def height_factor(height: ArrayLike, exponent: float = OPEN_SEA) -> Array:
    """Mean wind speed at `height` (m, > 0) over that at 10 m: `(height / 10)^exponent`.

    The exponent is 0.12 over open sea with waves (DNV-RP-C205, Table 2-1); Hellman's 0.4 (stable
    air over flat coast) is the value of the Viknes study.

    Raises:
        SeaError: a height is not > 0, or the exponent is not within 0 to 1.
    """
    height = np.asarray(height, dtype=float)
    if not (height > 0).all():
        raise SeaError(f"height is {height} m, allowed is > 0: give the height above the water")
    return (height / 10.0) ** _exponent("exponent", exponent)


def gust_density(frequency: ArrayLike, speed: float, spectrum: GustSpectrum = "npd") -> Array:
    """One-sided spectral density (...) of the along-wind speed at 10 m, m2/s2/Hz.

    With U the mean speed at 10 m and f the frequency (DNV-RP-C205, 2.3.4-5):

    - "npd" (Froya; ISO 19901-1), U the one-hour mean: `320 (U/10)^2 / (1 + x^n)^(5/(3n))`,
      `x = 172 f (U/10)^(-3/4)`, `n = 0.468`.
    - "harris" (1971): `f S = 4 c U^2 x / (2 + x^2)^(5/6)`, `x = 1800 m f / U`, c = 0.0026.
    - "davenport" (1961): `f S = 4 c U^2 x^2 / (1 + x^2)^(4/3)`, `x = 1200 m f / U`, c = 0.0026;
      its variance is `6 c U^2`.

    Args:
        frequency: f, any shape, Hz, > 0.
        speed: U, m/s, >= 0.
        spectrum: one of the above.

    Raises:
        SeaError: the speed is negative or the spectrum has no such name.
    """
    one_of("spectrum", spectrum, get_args(GustSpectrum))
    U = number("speed", speed, "m/s", "give the mean speed; turn the direction instead", low=0)
    f = np.asarray(frequency, dtype=float)
    if U == 0:
        return np.zeros_like(f)
    drag = 0.0026  # surface drag coefficient of rough sea, both classical spectra
    if spectrum == "npd":
        n = 0.468
        x = 172 * f * (U / 10) ** -0.75
        return 320 * (U / 10) ** 2 / (1 + x**n) ** (5 / (3 * n))
    if spectrum == "harris":
        x = 1800 * f / U
        return 4 * drag * U**2 * x / (2 + x**2) ** (5 / 6) / f
    x = 1200 * f / U
    return 4 * drag * U**2 * x**2 / (1 + x**2) ** (4 / 3) / f


def no_wind(air_density: float = 1.225) -> Wind:
    """Air at rest (kg/m3); a moving vehicle still has air drag.

    Raises:
        SeaError: the density is not > 0.
    """
    return Wind(1.0, np.zeros((1, 3)), air_density)


def steady_wind(
    speed: float,
    direction: float,
    air_density: float = 1.225,
    height_exponent: float = OPEN_SEA,
) -> Wind:
    """Constant wind of `speed` (m/s at 10 m) towards `direction` (rad, NWU), see `Wind`.

    Raises:
        SeaError: an argument is out of range.
    """
    speed = _speed(speed)
    return wind_series([speed], [direction], 1.0, air_density, height_exponent)


def wind_series(
    speed: ArrayLike,
    direction: ArrayLike,
    interval: float,
    air_density: float = 1.225,
    height_exponent: float = OPEN_SEA,
) -> Wind:
    """Wind from series of speed and direction.

    Args:
        speed: (m,) m/s at 10 m height; negative values are set to 0.
        direction: (m,) direction towards which the air moves, rad, NWU.
        interval: time between knots, s.
        air_density: kg/m3.
        height_exponent: of the height profile, see `Wind`.

    Raises:
        SeaError: an argument is out of range.
    """
    speed = np.maximum(array("speed", speed, ("m",), "m/s"), 0.0)
    angle = array("direction", direction, (len(speed),), "rad")
    velocity = np.stack([speed * np.cos(angle), speed * np.sin(angle), 0 * speed], axis=-1)
    return Wind(interval, velocity, air_density, height_exponent)


def gusty_wind(
    speed: float,
    direction: float,
    duration: float,
    *,
    spectrum: GustSpectrum = "npd",
    interval: float = 0.5,
    seed: Seed = 0,
    air_density: float = 1.225,
    height_exponent: float = OPEN_SEA,
) -> Wind:
    """Wind with gusts along its mean direction, from a gust spectrum.

    200 cosines with random phases, one at a random frequency in each of 200 bins of equal ratio
    from 1/600 Hz to 0.5 Hz, each with the variance of its bin.

    Args:
        speed: mean speed at 10 m height, m/s, >= 0.
        direction: direction towards which the air moves, rad, NWU.
        duration: length of the run, s; the last value is held afterwards.
        spectrum: see `gust_density`.
        interval: time between knots, s; 0.5 resolves the highest frequency with four knots.
        seed: integer >= 0, SeedSequence, or a Generator to draw from.
        air_density: kg/m3.
        height_exponent: of the height profile, see `Wind`.

    Raises:
        SeaError: an argument is out of range.
    """
    speed = _speed(speed)
    rng = generator(seed)
    t = np.arange(knots(duration, interval)) * interval
    edges = np.geomspace(*GUST_RANGE, GUST_COMPONENTS + 1)
    frequency = edges[:-1] * (edges[1:] / edges[:-1]) ** rng.uniform(size=GUST_COMPONENTS)
    # Simpson's rule over each bin: 1e-7 relative, the bins are 3 % wide.
    samples = [gust_density(f, speed, spectrum) for f in (edges[:-1], edges[1:])]
    middle = gust_density(0.5 * (edges[:-1] + edges[1:]), speed, spectrum)
    variance = np.diff(edges) / 6 * (samples[0] + 4 * middle + samples[1])
    phase = rng.uniform(0.0, 2 * np.pi, size=GUST_COMPONENTS)
    gust = np.zeros_like(t)
    for f, a, p in zip(frequency, np.sqrt(2 * variance), phase, strict=True):
        gust += a * np.cos(2 * np.pi * f * t + p)
    course = np.full_like(t, direction)
    return wind_series(speed + gust, course, interval, air_density, height_exponent)


def wandering_wind(
    speed: float,
    direction: float,
    duration: float,
    *,
    speed_power: float = 1e-3,
    direction_power: float = 0.1 * (np.pi / 180) ** 2,
    correlation_time: float = np.inf,
    turn: float = 0.0,
    turn_start: float = 0.0,
    turn_time: float = 50.0,
    interval: float = 0.5,
    seed: Seed = 0,
    air_density: float = 1.225,
    height_exponent: float = OPEN_SEA,
) -> Wind:
    """Wind whose speed and direction wander slowly, and whose mean direction may turn.

    Both wanderings start at 0 and integrate white noise, variance `power * t` (the model of the
    Viknes study); a finite correlation time T bounds them, `power * T / 2` in the end. The mean
    direction follows a step of `turn` with a first-order lag.

    Args:
        speed: mean speed at 10 m height, m/s, >= 0; the sum is kept >= 0.
        direction: direction towards which the air moves, rad, NWU.
        duration: length of the run, s; the last value is held afterwards.
        speed_power: growth of the variance of speed, m2/s3, >= 0.
        direction_power: growth of the variance of direction, rad2/s, >= 0; default 0.1 deg2/s.
        correlation_time: T, s; inf for the unbounded random walk.
        turn: change of the mean direction, rad, counter-clockwise.
        turn_start: time of the step, s.
        turn_time: time constant of the lag, s.
        interval: time between knots, s.
        seed: integer >= 0, SeedSequence, or a Generator to draw from.
        air_density: kg/m3.
        height_exponent: of the height profile, see `Wind`.

    Raises:
        SeaError: an argument is out of range.
    """
    speed = _speed(speed)
    fix = "0 turns it off"
    power = [
        number("speed_power", speed_power, "m2/s3", fix, low=0),
        number("direction_power", direction_power, "rad2/s", fix, low=0),
    ]
    fix = "inf gives an unbounded random walk"
    T = number("correlation_time", correlation_time, "s", fix, above=0, infinite=True)
    turn_time = number("turn_time", turn_time, "s", "50 to 100 s are usual", above=0)
    count = knots(duration, interval)
    noise = generator(seed).standard_normal((count, 2))
    noise[0] = 0.0  # both start at 0
    q = np.exp(-interval / T)
    step = interval if np.isinf(T) else 0.5 * T * (1 - q**2)
    from scipy.signal import lfilter  # here: importing it takes a second

    wander = lfilter([1.0], [1.0, -q], noise * np.sqrt(np.multiply(power, step)), axis=0)
    since = np.maximum(np.arange(count) * interval - turn_start, 0.0)
    mean = direction + turn * (1 - np.exp(-since / turn_time))
    speeds, courses = speed + wander[:, 0], mean + wander[:, 1]
    return wind_series(speeds, courses, interval, air_density, height_exponent)


def _speed(speed: float) -> float:
    """Mean wind speed, checked."""
    return number("speed", speed, "m/s", "give the mean speed; turn the direction instead", low=0)


def _exponent(name: str, exponent: float) -> float:
    """Exponent of a height profile, checked."""
    return number(name, exponent, "", "0.12 over open sea, 0 for none", low=0, high=1)
