"""Ocean current: a depth profile plus a frozen Gauss-Markov fluctuation."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from marine_mj.environment._checks import Frozen, Seed, array, number
from marine_mj.environment.series import gauss_markov, interpolate
from marine_mj.errors import SeaError
from marine_mj.frames import Array


def _no_series() -> Array:
    """Series without knots."""
    return np.empty((0, 3))


@dataclass(frozen=True, eq=False)
class Current(Frozen):
    """Current velocity as a function of height and time; uniform in the horizontal plane.

    Attributes:
        levels: (n,) heights z, m, NWU (0 at the still water line, negative below), ascending.
        velocity: (n, 3) velocity at the levels, m/s, NWU; linear between them, held beyond.
        interval: time between the knots of the fluctuation, s, > 0.
        fluctuation: (m, 3) velocity added at all heights, m/s, NWU, at t = 0, interval, ...;
            linear between knots, held after the end; m = 0 for a steady current.

    Raises:
        SeaError: shapes do not fit, levels do not ascend or a value is out of range.
    """

    levels: Array
    velocity: Array
    interval: float = 1.0
    fluctuation: Array = field(default_factory=_no_series)

    def __post_init__(self) -> None:
        """Check and freeze."""
        levels = array("levels", self.levels, ("n",), "m")
        if len(levels) == 0 or (np.diff(levels) <= 0).any():
            raise SeaError(
                f"levels is {levels.tolist()} m, allowed are 1 or more strictly ascending heights: "
                "order them from the deepest (most negative z) to the surface"
            )
        object.__setattr__(self, "levels", levels)
        velocity = array("velocity", self.velocity, (len(levels), 3), "m/s")
        object.__setattr__(self, "velocity", velocity)
        interval = number("interval", self.interval, "s", "give the time between knots", above=0)
        object.__setattr__(self, "interval", interval)
        series = array("fluctuation", self.fluctuation, ("m", 3), "m/s")
        object.__setattr__(self, "fluctuation", series)

    def velocity_at(self, z: ArrayLike, t: ArrayLike) -> Array:
        """Current velocity (..., 3) [m/s, NWU] at height z (m, NWU) and time t (s)."""
        z, t = np.broadcast_arrays(np.asarray(z, dtype=float), np.asarray(t, dtype=float))
        profile = [np.interp(z, self.levels, self.velocity[:, i]) for i in range(3)]
        return np.stack(profile, axis=-1) + interpolate(self.fluctuation, self.interval, t)

    def acceleration_at(self, z: ArrayLike, t: ArrayLike) -> Array:
        """Local acceleration (..., 3) [m/s2, NWU]: slope of the fluctuation after time t (s).

        It does not depend on z (m, NWU), which only takes part in the shape.
        """
        z, t = np.broadcast_arrays(np.asarray(z, dtype=float), np.asarray(t, dtype=float))
        count = len(self.fluctuation)
        if count < 2:
            return np.zeros((*t.shape, 3))
        slope = np.concatenate(
            [np.diff(self.fluctuation, axis=0) / self.interval, np.zeros((1, 3))]
        )
        index = np.clip(np.floor(t / self.interval), -1, count - 1).astype(int)
        return slope[index]  # before t = 0 the index -1 means the zero at the end


def no_current() -> Current:
    """Water at rest, apart from waves."""
    return Current(np.zeros(1), np.zeros((1, 3)))


def uniform_current(velocity: ArrayLike) -> Current:
    """Current with one velocity (3,) [m/s, NWU] everywhere and always.

    Raises:
        SeaError: `velocity` has another shape or is not finite.
    """
    return Current(np.zeros(1), array("velocity", velocity, (3,), "m/s")[None])


def fluctuating_current(
    velocity: ArrayLike,
    std: float,
    correlation_time: float,
    duration: float,
    *,
    levels: ArrayLike = (0.0,),
    interval: float | None = None,
    seed: Seed = 0,
) -> Current:
    """Current with a Gauss-Markov fluctuation of both horizontal components.

    Args:
        velocity: mean velocity, (3,) or (n, 3) at the levels, m/s, NWU.
        std: stationary standard deviation of each horizontal component, m/s.
        correlation_time: s.
        duration: length of the run, s; the last value is held afterwards.
        levels: (n,) heights z, m, NWU, ascending.
        interval: time between knots, s; default correlation_time / 20.
        seed: integer >= 0, SeedSequence, or a Generator to draw from.

    Raises:
        SeaError: an argument is out of range.
    """
    std = number("std", std, "m/s", "0 gives a steady current", low=0)
    series = gauss_markov([std, std, 0.0], correlation_time, duration, interval=interval, seed=seed)
    interval = correlation_time / 20 if interval is None else interval
    return Current(np.asarray(levels), np.atleast_2d(velocity), interval, series)
