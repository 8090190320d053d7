"""Checks of samples, probabilities and counts; each failure is an AnalysisError."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from marine_mj.errors import AnalysisError
from marine_mj.frames import Array

#: Seed of anything random here: an integer >= 0, or a Generator to draw from.
Seed = int | np.random.Generator


def sample(name: str, x: ArrayLike, least: int, ndim: int | None = None) -> Array:
    """`x` as floats, at least `least` values along the last axis, none of them NaN or infinite."""
    try:
        values = np.asarray(x, dtype=float)
    except (TypeError, ValueError) as error:
        raise AnalysisError(f"{name} is not an array of numbers ({error}): give numbers") from None
    if values.ndim == 0 or (ndim is not None and values.ndim != ndim):
        wanted = "1 or more" if ndim is None else str(ndim)
        raise AnalysisError(
            f"{name} has {values.ndim} dimensions, allowed are {wanted}: reshape it"
        )
    if values.shape[-1] < least:
        raise AnalysisError(
            f"{name} has {values.shape[-1]} values, allowed are {least} or more: run more"
        )
    return finite(name, values)


def finite(name: str, values: Array) -> Array:
    """`values` if all of them are finite."""
    bad = int((~np.isfinite(values)).sum())
    if bad:
        raise AnalysisError(
            f"{name} has {bad} NaN or infinite of {values.size} values, allowed are finite ones: "
            "take failed runs out and count them as failures"
        )
    return values


def probability(name: str, value: ArrayLike) -> Array:
    """`value` as floats strictly between 0 and 1."""
    p = np.asarray(value, dtype=float)
    bad = p[~((p > 0) & (p < 1))]
    if bad.size:
        raise AnalysisError(f"{name} is {bad[0]:g}, allowed is > 0 and < 1: write 95 % as 0.95")
    return p


def level(name: str, value: float) -> float:
    """One probability strictly between 0 and 1."""
    return float(probability(name, value))


def whole(name: str, value: Any, least: int, fix: str) -> int:
    """`value` as an integer that is at least `least`."""
    good = isinstance(value, int | np.integer) and not isinstance(value, bool)
    if not good or value < least:
        raise AnalysisError(f"{name} is {value!r}, allowed are whole numbers >= {least}: {fix}")
    return int(value)


def positive(name: str, value: ArrayLike, fix: str) -> Array:
    """`value` as finite floats > 0."""
    values = np.asarray(value, dtype=float)
    bad = values[~((values > 0) & (values < np.inf))]
    if bad.size:
        raise AnalysisError(f"{name} is {bad[0]:g}, allowed is > 0, finite: {fix}")
    return values


def choice(name: str, value: Any, allowed: tuple[str, ...]) -> str:
    """`value` if it is one of the names in `allowed`."""
    if not isinstance(value, str) or value not in allowed:
        raise AnalysisError(f"{name} is {value!r}, allowed are {', '.join(allowed)}: choose one")
    return value


def generator(seed: Any) -> np.random.Generator:
    """Random generator of an integer seed, or the Generator itself."""
    if isinstance(seed, np.random.Generator):
        return seed
    return np.random.default_rng(
        whole("seed", seed, 0, "give one, so that the result can be repeated")
    )


def plain(value: Any) -> Any:
    """Float for a scalar, else the array."""
    return float(value) if np.ndim(value) == 0 else value
