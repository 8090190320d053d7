"""Success probabilities: intervals from counts, and the number of runs they need."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from marine_mj.analysis import _checks as check
from marine_mj.errors import AnalysisError
from marine_mj.frames import Array


def wilson_interval(
    successes: ArrayLike, n: ArrayLike, confidence: float = 0.95
) -> tuple[Any, Any]:
    """Wilson score interval (low, high) of a success probability (Wilson 1927).

    `(p + z^2 / 2n +- z sqrt(p (1 - p) / n + z^2 / 4n^2)) / (1 + z^2 / n)` with p = successes / n
    and z the two-sided normal quantile. low is exactly 0 for no success and high exactly 1 for no
    failure. The mean coverage is close to `confidence`; single p can fall below it
    (`clopper_pearson_interval` never does).

    Args:
        successes: number of successes, any shape, 0 to n.
        n: number of runs, broadcast with `successes`, >= 1.
        confidence: between 0 and 1.

    Returns:
        low and high: floats, or arrays of the broadcast shape.

    Raises:
        AnalysisError: counts are not whole, n < 1, successes outside 0 to n, or confidence
            outside (0, 1).
    """
    k, n = _counts(successes, n)
    z = _z(confidence)
    p = k / n
    center = p + z**2 / (2 * n)
    half = z * np.sqrt(p * (1 - p) / n + z**2 / (4 * n**2))
    low = np.where(k == 0, 0.0, (center - half) / (1 + z**2 / n))
    high = np.where(k == n, 1.0, (center + half) / (1 + z**2 / n))
    return check.plain(low), check.plain(high)


def clopper_pearson_interval(
    successes: ArrayLike, n: ArrayLike, confidence: float = 0.95
) -> tuple[Any, Any]:
    """Clopper-Pearson interval (low, high) of a success probability (Clopper, Pearson 1934).

    Quantiles of Beta(k, n - k + 1) and Beta(k + 1, n - k): it covers the true p at least as often
    as `confidence` says, and is wider than Wilson's for that.

    Args, Returns, Raises: as `wilson_interval`.
    """
    k, n = _counts(successes, n)
    tail = 0.5 * (1 - check.level("confidence", confidence))
    # The arguments are kept > 0 where np.where takes the other branch.
    low = np.where(k == 0, 0.0, special.betaincinv(np.maximum(k, 1), n - k + 1, tail))
    high = np.where(k == n, 1.0, special.betaincinv(k + 1, np.maximum(n - k, 1), 1 - tail))
    return check.plain(low), check.plain(high)


def interval_width(p: ArrayLike, n: ArrayLike, confidence: float = 0.95) -> Any:
    """Width high - low of Wilson's interval when the share p of n runs succeeds.

    Args:
        p: expected share, 0 to 1, any shape.
        n: number of runs, > 0, broadcast with p.
        confidence: between 0 and 1.

    Raises:
        AnalysisError: an argument is out of range.
    """
    share, n = _share(p), check.positive("n", n, "give the number of runs")
    z = _z(confidence)
    return check.plain(2 * z * np.sqrt(share * (1 - share) * n + z**2 / 4) / (n + z**2))


def runs_needed(p: ArrayLike, half_width: ArrayLike, confidence: float = 0.95) -> Any:
    """Smallest number of runs whose Wilson interval is at most +-`half_width` wide at share p.

    With m = n + z^2 the half width h obeys `h^2 m^2 - z^2 p q m - z^4 (1/4 - p q) = 0`, q = 1 - p
    (Piegorsch 2004).

    Args:
        p: expected share, 0 to 1, any shape; 0.5 is the worst case.
        half_width: wanted half width, > 0, broadcast with p.
        confidence: between 0 and 1.

    Returns:
        integer, or integer array; at least 1.

    Raises:
        AnalysisError: an argument is out of range.
    """
    share, h = _share(p), check.positive("half_width", half_width, "write +-5 % as 0.05")
    z2 = _z(confidence) ** 2
    pq = share * (1 - share)
    m = (z2 * pq + np.sqrt((z2 * pq) ** 2 + 4 * h**2 * z2**2 * (0.25 - pq))) / (2 * h**2)
    n = np.maximum(np.ceil((m - z2) * (1 - 1e-12)), 1).astype(int)  # rounding must not add a run
    return n[()] if n.ndim else int(n)


def _counts(successes: ArrayLike, n: ArrayLike) -> tuple[Array, Array]:
    """Successes and numbers of runs as float arrays, checked."""
    k, runs = (np.asarray(v, dtype=float) for v in (successes, n))
    bad = runs[~((runs >= 1) & (runs == np.floor(runs)) & (runs < np.inf))]
    if bad.size:
        raise AnalysisError(f"n is {bad[0]:g}, allowed are whole numbers >= 1: run something")
    k, runs = np.broadcast_arrays(k, runs)
    wrong = ~((k >= 0) & (k <= runs) & (k == np.floor(k)))
    if wrong.any():
        raise AnalysisError(
            f"successes is {k[wrong][0]:g}, allowed are whole numbers from 0 to n = "
            f"{runs[wrong][0]:g}: count the successful runs"
        )
    return k, runs


def _share(p: ArrayLike) -> Array:
    """A share from 0 to 1, both included."""
    share = np.asarray(p, dtype=float)
    bad = share[~((share >= 0) & (share <= 1))]
    if bad.size:
        raise AnalysisError(f"p is {bad[0]:g}, allowed is >= 0 and <= 1: write 95 % as 0.95")
    return share


def _z(confidence: float) -> float:
    """Two-sided normal quantile."""
    return float(special.ndtri(0.5 * (1 + check.level("confidence", confidence))))
