"""Estimates from Monte Carlo runs with their intervals: shares, means, any statistic, effects.

Samples lie along the last axis, everything before it is a batch. NaN and infinite values are
refused: a run that failed is a failure to be counted, not a value to be skipped.
"""

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special, stats

from marine_mj.analysis import _checks as check
from marine_mj.analysis.distributions import GammaFit, NormalFit, fit_gamma, fit_normal
from marine_mj.analysis.proportions import (
    clopper_pearson_interval,
    interval_width,
    runs_needed,
    wilson_interval,
)
from marine_mj.errors import AnalysisError
from marine_mj.frames import Array

__all__ = [
    "Convergence",
    "EffectSize",
    "GammaFit",
    "NormalFit",
    "bootstrap_interval",
    "clopper_pearson_interval",
    "cohens_d",
    "convergence",
    "fit_gamma",
    "fit_normal",
    "interval_width",
    "mean_interval",
    "runs_needed",
    "wilson_interval",
]

BootstrapMethod = Literal["bca", "percentile"]
#: Resampled values held at a time by `bootstrap_interval`: 32 MB.
_BLOCK = 2**22


def mean_interval(x: ArrayLike, confidence: float = 0.95) -> tuple[Any, Any]:
    """Student's interval (low, high) of the mean: `mean +- t s / sqrt(n)`, n - 1 degrees.

    Args:
        x: (..., n) samples, n >= 2.
        confidence: between 0 and 1.

    Returns:
        low and high: floats, or arrays (...).

    Raises:
        AnalysisError: n < 2, a value is not finite, or confidence outside (0, 1).
    """
    values = check.sample("x", x, 2)
    n = values.shape[-1]
    t = special.stdtrit(n - 1, 0.5 * (1 + check.level("confidence", confidence)))
    half = t * values.std(axis=-1, ddof=1) / np.sqrt(n)
    mean = values.mean(axis=-1)
    return check.plain(mean - half), check.plain(mean + half)


def bootstrap_interval(
    x: ArrayLike,
    statistic: Callable[..., Any] = np.mean,
    confidence: float = 0.95,
    resamples: int = 9999,
    *,
    method: BootstrapMethod = "bca",
    seed: check.Seed = 0,
    vectorized: bool = False,
) -> tuple[float, float]:
    """Bootstrap interval (low, high) of any statistic of the runs (Efron, Tibshirani 1993).

    "percentile" takes quantiles of the statistic over samples drawn with replacement; "bca"
    corrects them for bias and skewness. Neither sees what the sample does not show: an extreme
    quantile of 60 runs needs a fitted distribution inside `statistic`.

    Args:
        x: (n, ...) one row a run, n >= 2; rows are drawn as a whole.
        statistic: function of an array shaped like x that gives one number.
        confidence: between 0 and 1.
        resamples: number of resamples, >= 1.
        method: "bca" or "percentile".
        seed: integer >= 0 or Generator; the same integer gives the same interval.
        vectorized: whether `statistic` takes `axis` and works along it; x is then (n,). Faster.

    Raises:
        AnalysisError: an argument is out of range; the statistic is not finite; or "bca" cannot
            be formed, because the statistic does not change when one run is left out.
    """
    values = check.sample("x", x, 1)
    check.sample("x", values.T, 2)  # the first axis counts the runs
    check.choice("method", method, get_args(BootstrapMethod))
    check.whole("resamples", resamples, 1, "9999 is enough for 95 %")
    check.level("confidence", confidence)
    if vectorized and values.ndim > 1:
        raise AnalysisError(
            f"x has {values.ndim} dimensions, allowed is 1 with vectorized=True: leave it out"
        )

    # Resampling row numbers lets SciPy draw whole runs of any shape.
    def of_rows(rows: Any, axis: int = -1) -> Any:
        chosen = values[rows.astype(int)]
        return statistic(chosen, axis=axis) if vectorized else statistic(chosen)

    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore", stats.DegenerateDataWarning)  # judged below
        result = stats.bootstrap(
            (np.arange(len(values)),),
            of_rows,
            n_resamples=resamples,
            batch=max(1, _BLOCK // len(values)),
            vectorized=vectorized,
            confidence_level=confidence,
            method={"bca": "BCa", "percentile": "percentile"}[method],
            random_state=check.generator(seed),
        )
    drawn = np.asarray(result.bootstrap_distribution)
    if not np.isfinite(drawn).all():
        bad = int((~np.isfinite(drawn)).sum())
        raise AnalysisError(
            f"statistic is NaN or infinite in {bad} of {resamples} resamples, allowed are finite "
            "values: let it cope with repeated runs"
        )
    low, high = (float(v) for v in result.confidence_interval)
    if np.isfinite([low, high]).all():
        return low, high
    if drawn.min() == drawn.max():
        return float(drawn.flat[0]), float(drawn.flat[0])
    raise AnalysisError(
        "method is 'bca' and the statistic does not change when one run is left out, allowed is "
        "'percentile' for such a statistic: pass method='percentile'"
    )


@dataclass(frozen=True)
class EffectSize:
    """Difference of two means in units of the pooled standard deviation.

    Attributes:
        d: Cohen's d; floats, or arrays of the batch shape, as the others.
        low: lower end of the interval of d.
        high: upper end.
        g: Hedges' g, d without its small-sample bias.
    """

    d: Any
    low: Any
    high: Any
    g: Any


def cohens_d(a: ArrayLike, b: ArrayLike, confidence: float = 0.95) -> EffectSize:
    """Cohen's d of two independent samples, `(mean a - mean b) / s`, with its interval.

    `s^2 = ((n_a - 1) s_a^2 + (n_b - 1) s_b^2) / (n_a + n_b - 2)`; below 0.2 an effect is called
    negligible (Cohen 1988). `t = d / sqrt(1/n_a + 1/n_b)` is noncentral t, and the interval is
    that of its noncentrality (Steiger, Fouladi 1997): exact for normal samples of equal variance.
    `g = d Gamma(m/2) / (sqrt(m/2) Gamma((m-1)/2))`, m = n_a + n_b - 2 (Hedges 1981).

    Args:
        a: (..., n_a) samples, n_a >= 2.
        b: (..., n_b) samples, n_b >= 2, batch broadcast with a's.
        confidence: between 0 and 1.

    Raises:
        AnalysisError: too few or non-finite values, both samples constant, or confidence outside
            (0, 1).
    """
    a, b = check.sample("a", a, 2), check.sample("b", b, 2)
    tail = 0.5 * (1 - check.level("confidence", confidence))
    n_a, n_b = a.shape[-1], b.shape[-1]
    m = n_a + n_b - 2
    s2 = ((n_a - 1) * a.var(axis=-1, ddof=1) + (n_b - 1) * b.var(axis=-1, ddof=1)) / m
    if np.any(s2 <= 0):
        raise AnalysisError(
            "the pooled standard deviation of a and b is 0, allowed is > 0: the difference of two "
            "constants has no effect size"
        )
    d = np.asarray((a.mean(axis=-1) - b.mean(axis=-1)) / np.sqrt(s2))
    root = np.sqrt(1 / n_a + 1 / n_b)
    low = root * special.nctdtrinc(m, 1 - tail, d / root)
    high = root * special.nctdtrinc(m, tail, d / root)
    unbiased = np.exp(special.gammaln(m / 2) - special.gammaln((m - 1) / 2)) / np.sqrt(m / 2)
    return EffectSize(
        check.plain(d), check.plain(low), check.plain(high), check.plain(d * unbiased)
    )


@dataclass(frozen=True, eq=False)
class Convergence:
    """Running estimate against the number of runs.

    Attributes:
        n: (k,) numbers of runs, ascending.
        estimate: (k,) estimate from the first n runs.
        low: (k,) lower end of its interval.
        high: (k,) upper end.
    """

    n: NDArray[np.int64]
    estimate: Array
    low: Array
    high: Array


def convergence(
    x: ArrayLike,
    counts: ArrayLike | None = None,
    confidence: float = 0.95,
    *,
    statistic: Callable[..., Any] | None = None,
    resamples: int = 999,
    seed: int = 0,
) -> Convergence:
    """Estimate from the first n runs, with its interval, for growing n.

    Successes (boolean x) give their share with Wilson's interval, numbers their mean with
    Student's, `statistic` its value with the percentile bootstrap's. The intervals hold for one n
    each: stopping at the first n that pleases makes them too narrow.

    Args:
        x: (n,) runs in the order they were made; n >= 1 for successes, else >= 2.
        counts: (k,) ascending numbers of runs to evaluate at; default: all (20 for `statistic`).
        confidence: between 0 and 1.
        statistic: function of a sample that gives one number.
        resamples: for `statistic`, number of bootstrap resamples.
        seed: for `statistic`, integer >= 0.

    Raises:
        AnalysisError: an argument is out of range or a value is not finite.
    """
    shares = np.asarray(x).dtype == bool and statistic is None
    least = 1 if shares else 2
    values = check.sample("x", x, least, ndim=1)
    total = len(values)
    if counts is None:
        spaced = np.geomspace(least, total, min(20, total - least + 1)).round()
        n = np.arange(least, total + 1) if statistic is None else np.unique(spaced).astype(int)
    else:
        n = np.atleast_1d(np.array(counts))
        good = n.ndim == 1 and n.size and np.issubdtype(n.dtype, np.integer)
        if not good or n[0] < least or n[-1] > total or (np.diff(n) <= 0).any():
            raise AnalysisError(
                f"counts is {counts}, allowed are ascending whole numbers from {least} to {total}: "
                "give numbers of runs"
            )
    if statistic is not None:
        ends = [
            bootstrap_interval(
                values[:i], statistic, confidence, resamples, method="percentile", seed=seed
            )
            for i in n
        ]
        estimates = np.array([float(statistic(values[:i])) for i in n])
        low, high = np.array(ends).T
        return Convergence(n, estimates, low, high)
    if shares:
        successes = np.cumsum(values)[n - 1]
        low, high = wilson_interval(successes, n, confidence)
        return Convergence(n, successes / n, low, high)
    center = values.mean()  # taken off first, so that the sums of squares keep their digits
    first, second = (np.cumsum((values - center) ** i)[n - 1] for i in (1, 2))
    variance = np.maximum(second - first**2 / n, 0) / (n - 1)
    t = special.stdtrit(n - 1, 0.5 * (1 + check.level("confidence", confidence)))
    mean, half = center + first / n, t * np.sqrt(variance / n)
    return Convergence(n, mean, mean - half, mean + half)
