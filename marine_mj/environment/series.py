"""Series with equally spaced knots: sizes, linear interpolation, Gauss-Markov noise."""

import math

import numpy as np
from numpy.typing import ArrayLike

from marine_mj.environment._checks import Seed, array, generator, number
from marine_mj.errors import SeaError
from marine_mj.frames import Array

#: Longest series of knots that a constructor makes (10^6 rows of 3 are 24 MB).
MAX_KNOTS = 1_000_000


def knots(duration: float, interval: float) -> int:
    """Number of knots at 0, interval, ... that reach `duration` (s).

    Raises:
        SeaError: either is not > 0, or there would be more than `MAX_KNOTS`.
    """
    duration = number("duration", duration, "s", "give the length of the run", above=0)
    interval = number("interval", interval, "s", "give the time between knots", above=0)
    count = math.ceil(duration / interval - 1e-9) + 1
    if count > MAX_KNOTS:
        raise SeaError(
            f"duration {duration:g} s at interval {interval:g} s makes {count} knots, "
            f"allowed are {MAX_KNOTS}: use a longer interval"
        )
    return count


def interpolate(series: Array, interval: float, t: ArrayLike) -> Array:
    """Series (m, k) with knots at 0, interval, ... at times t (s): (..., k), held beyond its ends.

    An empty series is zero.
    """
    t = np.asarray(t, dtype=float)
    if len(series) == 0:
        return np.zeros((*t.shape, series.shape[1]))
    position = np.clip(t / interval, 0.0, len(series) - 1)
    index = np.minimum(position.astype(int), max(len(series) - 2, 0))
    weight = (position - index)[..., None]
    following = np.minimum(index + 1, len(series) - 1)
    return (1 - weight) * series[index] + weight * series[following]


def gauss_markov(
    std: ArrayLike,
    correlation_time: float,
    duration: float,
    *,
    interval: float | None = None,
    seed: Seed = 0,
) -> Array:
    """First-order Gauss-Markov series (m, k) that covers `duration`, in the unit of `std`.

    `T dx/dt + x = white noise` (Fossen 2021, 10.4), discretised exactly:
    `x[i+1] = q x[i] + std sqrt(1 - q^2) w`, `q = exp(-interval / T)`, started in its stationary
    state. The autocorrelation at the knots is `std^2 exp(-lag / T)`.

    Args:
        std: (k,) stationary standard deviations of k independent components, >= 0.
        correlation_time: T, s.
        duration: length of the series, s.
        interval: time between knots, s; default T / 20 (linear interpolation between knots then
            loses 1.6 % of the variance).
        seed: integer >= 0, SeedSequence, or a Generator to draw from.

    Raises:
        SeaError: an argument is out of range.
    """
    std = array("std", std, ("k",), "m/s")
    if (std < 0).any():
        raise SeaError(f"std is {std.tolist()}, allowed are values >= 0: 0 turns a component off")
    fix = "give the time after which the fluctuation is forgotten"
    T = number("correlation_time", correlation_time, "s", fix, above=0)
    interval = T / 20 if interval is None else interval
    count = knots(duration, interval)
    q = np.exp(-interval / T)
    noise = generator(seed).standard_normal((count, len(std)))
    noise[1:] *= np.sqrt(1 - q**2)
    from scipy.signal import lfilter  # here: importing it takes a second

    return std * lfilter([1.0], [1.0, -q], noise, axis=0)
