"""Which factors move a metric: main effects, rank regression, Sobol indices."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy import special, stats

from marine_mj.analysis import _checks as check
from marine_mj.errors import AnalysisError
from marine_mj.frames import Array


@dataclass(frozen=True, eq=False)
class MainEffects:
    """Share of a metric's variance that each factor explains alone.

    Attributes:
        correlation_ratio: (k,) eta^2 = variance between the groups / variance, 0 to 1.
        first_order: (k,) eta^2 without the part that chance explains; may fall below 0.
        p_value: (k,) probability of an eta^2 this large if the factor had no effect (F test).
        levels: for each factor the mean factor value of its groups.
        means: for each factor the mean metric of its groups.
    """

    correlation_ratio: Array
    first_order: Array
    p_value: Array
    levels: tuple[Array, ...]
    means: tuple[Array, ...]


def main_effects(factors: ArrayLike, metric: ArrayLike, groups: int = 10) -> MainEffects:
    """First-order effects of factors from any set of runs (given-data estimate).

    The runs are grouped by each factor in turn: by its values where it has at most `groups`, else
    into equally filled groups. `eta^2 = Var(E[Y | X_i]) / Var(Y)` is the first-order Sobol index
    of independent factors (Pearson 1905; Plischke et al. 2013); chance alone makes it
    (g - 1) / (n - 1), so `first_order = 1 - (1 - eta^2) (n - 1) / (n - g)` (Kelley 1935).

    Args:
        factors: (n, k) factor values of the runs.
        metric: (n,) result of the runs.
        groups: largest number of groups g, >= 2, with 2 runs or more in each.

    Raises:
        AnalysisError: shapes do not fit, a value is not finite, the metric or a factor is
            constant, or there are fewer than 2 * groups runs.
    """
    X, Y = _runs(factors, metric)
    groups = check.whole("groups", groups, 2, "10 is enough for 100 runs")
    n = len(Y)
    if n < 2 * groups:
        raise AnalysisError(f"metric has {n} runs, allowed are {2 * groups} or more: lower groups")
    total = ((Y - Y.mean()) ** 2).sum()
    rows = []
    for x in X.T:
        values, group = np.unique(x, return_inverse=True)
        if len(values) > groups:
            # Equal values stay together: the rank of a run is that of the first with its value.
            first = np.searchsorted(np.sort(x), x)
            _, group = np.unique(first * groups // n, return_inverse=True)
        count = np.bincount(group)
        level, mean = (np.bincount(group, weights=v) / count for v in (x, Y))
        eta2 = min((count * (mean - Y.mean()) ** 2).sum() / total, 1.0)
        g = len(count)
        within = (1 - eta2) / max(n - g, 1)
        F = np.inf if within == 0 else eta2 / (g - 1) / within
        p = special.fdtrc(g - 1, max(n - g, 1), F) if np.isfinite(F) else 0.0
        rows.append((eta2, 1 - within * (n - 1), p, level, mean))
    eta2s, first_order, p_value, levels, means = zip(*rows, strict=True)
    return MainEffects(np.array(eta2s), np.array(first_order), np.array(p_value), levels, means)


@dataclass(frozen=True, eq=False)
class RankRegression:
    """Linear regression of the ranks of a metric on the ranks of the factors.

    Attributes:
        coefficients: (k,) standardised coefficients, -1 to 1: sign and strength of each factor.
        low: (k,) lower end of their intervals.
        high: (k,) upper end.
        r2: share of the rank variance explained; below about 0.7 the metric is not monotone in
            the factors and the coefficients say little.
    """

    coefficients: Array
    low: Array
    high: Array
    r2: float


def rank_regression(
    factors: ArrayLike, metric: ArrayLike, confidence: float = 0.95
) -> RankRegression:
    """Standardised rank regression coefficients (Iman, Conover 1979), Student intervals.

    Args:
        factors: (n, k) factor values of the runs, n >= k + 2.
        metric: (n,) result of the runs.
        confidence: between 0 and 1.

    Raises:
        AnalysisError: shapes do not fit, a value is not finite, the metric or a factor is
            constant, there are too few runs, or a factor follows from the others.
    """
    X, Y = _runs(factors, metric)
    n, k = X.shape
    if n < k + 2:
        raise AnalysisError(f"metric has {n} runs, allowed are {k + 2} or more: run more")
    ranks = stats.rankdata(np.column_stack([X, Y]), axis=0)
    ranks = (ranks - ranks.mean(axis=0)) / ranks.std(axis=0)
    A, y = ranks[:, :k], ranks[:, k]
    if np.linalg.matrix_rank(A) < k:
        raise AnalysisError(
            "a factor follows from the ranks of the others, allowed are factors that vary "
            "independently: take it out"
        )
    inverse = np.linalg.inv(A.T @ A)
    b = inverse @ A.T @ y
    residual = y - A @ b
    degrees = n - k - 1
    t = special.stdtrit(degrees, 0.5 * (1 + check.level("confidence", confidence)))
    half = t * np.sqrt(np.diag(inverse) * (residual @ residual) / degrees)
    return RankRegression(b, b - half, b + half, float(1 - (residual @ residual) / n))


@dataclass(frozen=True, eq=False)
class SobolIndices:
    """Variance-based sensitivity of a metric.

    Attributes:
        first_order: (k,) share of the variance from each factor alone.
        first_order_interval: (2, k) bootstrap interval (low, high).
        total: (k,) share from each factor with all its interactions.
        total_interval: (2, k).
        evaluations: number of runs made.
    """

    first_order: Array
    first_order_interval: Array
    total: Array
    total_interval: Array
    evaluations: int


def sobol_indices(
    function: Callable[[Array], ArrayLike],
    distributions: Sequence[Any],
    n: int = 1024,
    confidence: float = 0.95,
    *,
    resamples: int = 999,
    seed: check.Seed = 0,
) -> SobolIndices:
    """First-order and total Sobol indices from a designed set of n (k + 2) runs.

    Saltelli et al. (2010) estimators on scrambled Sobol points (`scipy.stats.sobol_indices`), with
    percentile bootstrap intervals over the base points.
    Runs that were made for another purpose go to `main_effects`.

    Args:
        function: metric (m,) of factor values (m, k); called once with all runs.
        distributions: (k,) one or more frozen `scipy.stats` distributions of independent factors.
        n: number of base points, a power of 2.
        confidence: between 0 and 1.
        resamples: bootstrap resamples for the intervals, >= 1.
        seed: integer >= 0 or Generator.

    Raises:
        AnalysisError: an argument is out of range, or the metric has a wrong shape, is constant
            or not finite.
    """
    n = check.whole("n", n, 2, "1024 is a good start")
    if n & (n - 1):
        raise AnalysisError(f"n is {n}, allowed are powers of 2: take {1 << n.bit_length()}")
    resamples = check.whole("resamples", resamples, 1, "999 is enough for 95 %")
    level = check.level("confidence", confidence)
    k = len(distributions)
    if not k:
        raise AnalysisError("distributions is empty, allowed is one or more: name the factors")
    rng = check.generator(seed)

    # Columns A | B; AB_i is A with its i-th column from B.
    points = stats.qmc.Sobol(2 * k, seed=rng).random(n)
    points = np.clip(points, 0.5**32, 1 - 0.5**32)  # quantiles of 0 and 1 may be infinite
    columns = [d.ppf(points[:, j::k].T) for j, d in enumerate(distributions)]
    A, B = (np.column_stack([column[half] for column in columns]) for half in (0, 1))
    mixed = np.tile(A, (k, 1, 1))
    mixed[np.arange(k), :, np.arange(k)] = B.T
    runs = np.concatenate([A[None], B[None], mixed]).reshape(-1, k)
    metric = np.asarray(function(runs), dtype=float)
    if metric.shape != (len(runs),):
        raise AnalysisError(
            f"function gave the shape {metric.shape}, allowed is ({len(runs)},): one number for "
            "each row of factors"
        )
    check.finite("function", metric)
    if np.ptp(metric) == 0:
        raise AnalysisError(
            "function gave the same value in all runs, allowed are values that differ: a constant "
            "has no sensitivity"
        )
    f = metric.reshape(k + 2, n) - metric.mean()  # centred: smaller sampling error

    first, total = _saltelli(f)
    drawn = np.array([_saltelli(f[:, rng.integers(n, size=n)]) for _ in range(resamples)])
    tail = 0.5 * (1 - level)
    first_interval, total_interval = np.quantile(drawn, [tail, 1 - tail], axis=0).swapaxes(0, 1)
    return SobolIndices(first, first_interval, total, total_interval, len(runs))


def _saltelli(f: Array) -> tuple[Array, Array]:
    """First-order and total indices (k,) from the metric at A, B, AB_1 ... AB_k, (k + 2, n)."""
    data = {"f_A": f[:1], "f_B": f[1:2], "f_AB": f[2:, None]}
    result = stats.sobol_indices(func=data, n=f.shape[1])
    return np.ravel(result.first_order), np.ravel(result.total_order)


def _runs(factors: ArrayLike, metric: ArrayLike) -> tuple[Array, Array]:
    """Factors (n, k) and metric (n,), checked."""
    Y = check.sample("metric", metric, 2, ndim=1)
    X = np.asarray(factors, dtype=float)
    if X.ndim != 2 or len(X) != len(Y) or X.shape[1] == 0:
        raise AnalysisError(
            f"factors has shape {X.shape}, allowed is ({len(Y)}, k): one row for each run"
        )
    check.finite("factors", X)
    for name, column in [("metric", Y), *((f"factors[:, {i}]", x) for i, x in enumerate(X.T))]:
        if np.ptp(column) == 0:
            raise AnalysisError(
                f"{name} is {column[0]:g} in all runs, allowed are values that differ: leave it out"
            )
    return X, Y
