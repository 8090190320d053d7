"""Intervals and distribution fits."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy import stats


@dataclass(frozen=True)
class NormalFit:
    """Normal distribution with `mean` and standard deviation `std`."""

    mean: float
    std: float

    def interval(self, coverage: float = 0.95) -> tuple[float, float]:
        """Central interval that holds `coverage` of the distribution."""
        low, high = stats.norm(self.mean, self.std).interval(coverage)
        return float(low), float(high)


@dataclass(frozen=True)
class GammaFit:
    """Gamma distribution with `shape` and `scale`, from 0."""

    shape: float
    scale: float

    def interval(self, coverage: float = 0.95) -> tuple[float, float]:
        """Central interval that holds `coverage` of the distribution."""
        low, high = stats.gamma(self.shape, scale=self.scale).interval(coverage)
        return float(low), float(high)


def wilson_interval(successes: int, n: int, confidence: float = 0.95) -> tuple[float, float]:
    """Score interval (low, high) of a probability (Wilson 1927); (0, 1) when n is 0."""
    if n == 0:
        return 0.0, 1.0
    z = stats.norm.ppf(0.5 + confidence / 2)
    p = successes / n
    centre = (p + z**2 / (2 * n)) / (1 + z**2 / n)
    half = z / (1 + z**2 / n) * np.sqrt(p * (1 - p) / n + z**2 / (4 * n**2))
    return max(0.0, float(centre - half)), min(1.0, float(centre + half))


def fit_normal(x: ArrayLike) -> NormalFit:
    """Maximum-likelihood mean with the unbiased standard deviation."""
    values = np.asarray(x, float)
    return NormalFit(float(values.mean()), float(values.std(ddof=1)))


def fit_gamma(x: ArrayLike) -> GammaFit:
    """Maximum-likelihood gamma distribution of positive values."""
    shape, _, scale = stats.gamma.fit(np.asarray(x, float), floc=0)
    return GammaFit(float(shape), float(scale))
