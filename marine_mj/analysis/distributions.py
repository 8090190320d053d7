"""Normal and gamma distributions fitted to samples, and how well they fit."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from marine_mj.analysis import _checks as check
from marine_mj.errors import AnalysisError
from marine_mj.frames import Array


@dataclass(frozen=True, eq=False)
class _Fit:
    """What both distributions share; see `NormalFit`."""

    n: int
    log_likelihood: Any
    ks: Any
    anderson_darling: Any

    def cdf(self, x: ArrayLike) -> Any:
        """Probability of a value <= x; x broadcast with the parameters."""
        raise NotImplementedError

    def quantile(self, p: ArrayLike) -> Any:
        """Value below which a sample lies with probability p; p broadcast with the parameters.

        Raises:
            AnalysisError: p outside (0, 1).
        """
        raise NotImplementedError

    def interval(self, coverage: float) -> tuple[Any, Any]:
        """(low, high) holding `coverage` of the distribution, with equal tails.

        A one-sided interval ends at `quantile(coverage)`.

        Raises:
            AnalysisError: coverage outside (0, 1).
        """
        tail = 0.5 * (1 - check.level("coverage", coverage))
        return self.quantile(tail), self.quantile(1 - tail)

    def p_value(self, resamples: int = 999, seed: check.Seed = 0) -> Any:
        """Probability of an Anderson-Darling statistic this large if the distribution were right.

        Parametric bootstrap (Stute et al. 1993): samples of the fitted distribution are fitted
        anew, so the fitted parameters are accounted for; tables of A^2 or KS for given parameters
        would accept nearly everything. Small values (< 0.05) speak against the distribution.

        Args:
            resamples: number of simulated samples, >= 1; the least p is 1 / (resamples + 1).
            seed: integer >= 0 or Generator.

        Raises:
            AnalysisError: an argument is out of range.
        """
        resamples = check.whole("resamples", resamples, 1, "999 is enough for 1 %")
        rng = check.generator(seed)
        observed = np.asarray(self.anderson_darling)
        p = np.empty(observed.shape)
        for i in np.ndindex(observed.shape):
            simulated = self._refit(self._draw(rng, i, (resamples, self.n)))
            larger = (simulated.anderson_darling >= observed[i]).sum()
            p[i] = (1 + larger) / (resamples + 1)
        return check.plain(p)

    def _draw(self, rng: np.random.Generator, i: tuple[int, ...], shape: tuple[int, int]) -> Array:
        """Samples of the i-th fitted distribution."""
        raise NotImplementedError

    def _refit(self, x: Array) -> "_Fit":
        """The same fit of other samples."""
        raise NotImplementedError


@dataclass(frozen=True, eq=False)
class NormalFit(_Fit):
    """Normal distribution fitted by `fit_normal`; floats, or arrays of the batch shape.

    Attributes:
        n: number of values of each sample.
        log_likelihood: logarithm of the density of the sample.
        ks: Kolmogorov-Smirnov distance, largest difference of the distribution functions.
        anderson_darling: A^2, the same weighted towards the tails.
        mean: sample mean.
        std: sample standard deviation, with n - 1.
    """

    mean: Any
    std: Any

    def cdf(self, x: ArrayLike) -> Any:
        """Probability of a value <= x; x broadcast with the parameters."""
        return check.plain(special.ndtr((np.asarray(x, dtype=float) - self.mean) / self.std))

    def quantile(self, p: ArrayLike) -> Any:
        """Value below which a sample lies with probability p; p broadcast with the parameters.

        Raises:
            AnalysisError: p outside (0, 1).
        """
        return check.plain(self.mean + self.std * special.ndtri(check.probability("p", p)))

    def _draw(self, rng: np.random.Generator, i: tuple[int, ...], shape: tuple[int, int]) -> Array:
        return rng.normal(np.asarray(self.mean)[i], np.asarray(self.std)[i], shape)

    def _refit(self, x: Array) -> _Fit:
        return fit_normal(x)


@dataclass(frozen=True, eq=False)
class GammaFit(_Fit):
    """Gamma distribution fitted by `fit_gamma`; floats, or arrays of the batch shape.

    Its mean is `shape scale`, its standard deviation `sqrt(shape) scale`.

    Attributes:
        n: number of values of each sample.
        log_likelihood: logarithm of the density of the sample.
        ks: Kolmogorov-Smirnov distance, largest difference of the distribution functions.
        anderson_darling: A^2, the same weighted towards the tails.
        shape: alpha.
        scale: beta, in the unit of the sample.
    """

    shape: Any
    scale: Any

    def cdf(self, x: ArrayLike) -> Any:
        """Probability of a value <= x; x broadcast with the parameters."""
        x = np.maximum(np.asarray(x, dtype=float), 0.0)
        return check.plain(special.gammainc(self.shape, x / self.scale))

    def quantile(self, p: ArrayLike) -> Any:
        """Value below which a sample lies with probability p; p broadcast with the parameters.

        Raises:
            AnalysisError: p outside (0, 1).
        """
        return check.plain(self.scale * special.gammaincinv(self.shape, check.probability("p", p)))

    def _draw(self, rng: np.random.Generator, i: tuple[int, ...], shape: tuple[int, int]) -> Array:
        return rng.gamma(np.asarray(self.shape)[i], np.asarray(self.scale)[i], shape)

    def _refit(self, x: Array) -> _Fit:
        return fit_gamma(x)


def fit_normal(x: ArrayLike) -> NormalFit:
    """Normal distribution with the mean and the standard deviation (n - 1) of the samples.

    Args:
        x: (..., n) samples, n >= 2; each row along the last axis is fitted by itself.

    Raises:
        AnalysisError: n < 2, a value is not finite, or all values of a sample are equal.
    """
    values = check.sample("x", x, 2)
    mean, std = values.mean(axis=-1), values.std(axis=-1, ddof=1)
    _check_spread(values)
    n = values.shape[-1]
    squares = ((values - mean[..., None]) ** 2).sum(axis=-1) / std**2
    log_likelihood = -0.5 * squares - n * (np.log(std) + 0.5 * np.log(2 * np.pi))
    z = (np.sort(values, axis=-1) - mean[..., None]) / std[..., None]
    ks, a2 = _goodness(special.ndtr(z), special.log_ndtr(z), special.log_ndtr(-z))
    parts = (log_likelihood, ks, a2, mean, std)
    return NormalFit(n, *(check.plain(v) for v in parts))


def fit_gamma(x: ArrayLike) -> GammaFit:
    """Gamma distribution of greatest likelihood, `p ~ x^(alpha - 1) exp(-x / beta)`.

    alpha solves `ln(alpha) - digamma(alpha) = ln(mean x) - mean(ln x)` (Choi, Wette 1969), by
    Newton's method in 1/alpha (Minka 2002); `beta = mean x / alpha`.

    Args:
        x: (..., n) samples > 0, n >= 2; each row along the last axis is fitted by itself.

    Raises:
        AnalysisError: n < 2, a value is not finite or not > 0, or the values of a sample are equal
            to within 4.5e-6 of their mean.
    """
    values = check.sample("x", x, 2)
    if (values <= 0).any():
        raise AnalysisError(
            f"x has the value {values.min():g}, allowed is > 0 for a gamma distribution: "
            "fit a normal one, or check the metric"
        )
    _check_spread(values)
    n = values.shape[-1]
    mean, log_mean = values.mean(axis=-1), np.log(values).mean(axis=-1)
    # Relative to the mean, and by log1p near it, so that values close together keep their digits.
    delta = (values - mean[..., None]) / mean[..., None]
    near = np.abs(delta) < 0.5
    far = np.log(values / mean[..., None])
    s = np.where(near, delta - np.log1p(np.where(near, delta, 0.0)), delta - far).mean(axis=-1)
    if (s < 1e-11).any():  # below, the difference of ln and digamma has lost its digits
        relative = np.sqrt(2 * max(s.min(), 0.0))
        raise AnalysisError(
            f"the values of x differ by {relative:.1g} of their mean, allowed is > 4.5e-6 for a "
            "gamma distribution: fit a normal one"
        )
    alpha = (3 - s + np.sqrt((s - 3) ** 2 + 24 * s)) / (12 * s)  # within 1.5 % (Minka)
    for _ in range(8):
        excess = np.log(alpha) - special.digamma(alpha) - s
        slope = 1 / alpha - special.polygamma(1, alpha)
        alpha = 1 / (1 / alpha + excess / (alpha**2 * slope))
    beta = mean / alpha
    log_likelihood = n * (
        (alpha - 1) * log_mean - mean / beta - special.gammaln(alpha) - alpha * np.log(beta)
    )
    scaled = np.sort(values, axis=-1) / beta[..., None]
    below, above = (f(alpha[..., None], scaled) for f in (special.gammainc, special.gammaincc))
    tiny = np.finfo(float).tiny  # a tail beyond the range of doubles counts as this
    ks, a2 = _goodness(below, *(np.log(np.maximum(v, tiny)) for v in (below, above)))
    parts = (log_likelihood, ks, a2, alpha, beta)
    return GammaFit(n, *(check.plain(v) for v in parts))


def _goodness(cdf: Array, log_cdf: Array, log_sf: Array) -> tuple[Array, Array]:
    """Kolmogorov-Smirnov distance and Anderson-Darling A^2 of sorted samples (..., n)."""
    n = cdf.shape[-1]
    i = np.arange(1, n + 1)
    ks = np.maximum(i / n - cdf, cdf - (i - 1) / n).max(axis=-1)
    a2 = -n - ((2 * i - 1) * (log_cdf + log_sf[..., ::-1])).sum(axis=-1) / n
    return ks, a2


def _check_spread(values: Array) -> None:
    """AnalysisError if all values of a sample are equal."""
    constant = np.ptp(values, axis=-1) == 0
    if constant.any():
        raise AnalysisError(
            f"all values of x are {values[constant][0, 0] if values.ndim > 1 else values[0]:g}, "
            "allowed are samples that differ: a constant has no distribution to fit"
        )
