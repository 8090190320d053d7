"""Whether a filter knows how wrong it is: NEES and the bounds it should keep."""

import numpy as np
from scipy.special import gammaincinv

from marine_mj.errors import ScenarioError
from marine_mj.frames import Array


def nees(error: Array, covariance: Array) -> Array:
    """Normalised estimation error squared (...,): `e' P^-1 e`.

    Chi-square distributed with n degrees of freedom when the filter is consistent (Bar-Shalom, Li
    and Kirubarajan 2001, section 5.4).

    Args:
        error: (..., n) true minus estimated states.
        covariance: (..., n, n) that the filter believes.
    """
    return np.sum(error * np.linalg.solve(covariance, error[..., None])[..., 0], axis=-1)


def chi_square_bounds(size: int, runs: int, confidence: float = 0.95) -> tuple[float, float]:
    """Interval that the mean NEES (or NIS) over independent runs keeps with this confidence.

    Args:
        size: degrees of freedom of one value: states, or measured numbers.
        runs: independent values in the mean.
        confidence: 0 to 1.

    Raises:
        ScenarioError: a count is below 1 or the confidence is not between 0 and 1.
    """
    if size < 1 or runs < 1 or not 0 < confidence < 1:
        raise ScenarioError(
            f"chi-square bounds: size = {size} and runs = {runs} must be >= 1, confidence = "
            f"{confidence} between 0 and 1"
        )
    tail = 0.5 * (1 - confidence)
    low, high = 2.0 * gammaincinv(0.5 * size * runs, [tail, 1 - tail]) / runs
    return float(low), float(high)
