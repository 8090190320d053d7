"""Checks at construction, and the base of the frozen environment dataclasses."""

import math
from collections.abc import Iterable
from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from marine_mj.errors import SeaError
from marine_mj.frames import Array

Seed = int | np.random.Generator | np.random.SeedSequence


class Frozen:
    """Base of the environment dataclasses: equal by value, unpickled through the constructor.

    NumPy forgets the read-only flag of an array when it pickles or copies it; building the copy
    with the constructor sets it, and repeats the checks.
    """

    def __eq__(self, other: object) -> bool:
        """Whether `other` is of the same class and all its fields have the same values."""
        if type(other) is not type(self):
            return NotImplemented
        return all(np.array_equal(a, b) for a, b in zip(_values(self), _values(other), strict=True))

    __hash__ = None  # type: ignore[assignment]

    def __reduce__(self) -> tuple[Any, ...]:
        """Recipe for pickle and copy: the class and its fields in order."""
        return type(self), tuple(_values(self))


def _values(instance: Any) -> list[Any]:
    """Field values of a dataclass instance, in order."""
    return [getattr(instance, field.name) for field in fields(instance)]


def number(
    name: str,
    value: Any,
    unit: str,
    fix: str,
    *,
    above: float | None = None,
    low: float = -math.inf,
    high: float = math.inf,
    infinite: bool = False,
) -> float:
    """`value` as a float within its range.

    Args:
        name: what the message calls it.
        value: what was given.
        unit: unit for the message, "" for none.
        fix: what to do instead.
        above: exclusive lower bound.
        low: inclusive lower bound.
        high: inclusive upper bound.
        infinite: whether +inf is allowed.

    Raises:
        SeaError: `value` is no real number, not finite (unless `infinite`) or out of range.
    """
    if above is not None:
        allowed = f"> {above:g}"
    elif low > -math.inf:
        allowed = f">= {low:g}"
    else:
        allowed = "any value"
    if high < math.inf:
        allowed += f" and <= {high:g}"
    allowed += ", inf included" if infinite else ", finite"
    try:
        result = float(value)
    except (TypeError, ValueError):
        result = math.nan
    good = math.isfinite(result) or (infinite and result == math.inf)
    if not good or not low <= result <= high or (above is not None and result <= above):
        shown = f"{value!r} {unit}".rstrip()
        raise SeaError(f"{name} is {shown}, allowed is {allowed}: {fix}")
    return result


def one_of(name: str, value: Any, allowed: Iterable[str]) -> str:
    """`value` if it is one of the names in `allowed`, else SeaError with the list."""
    names = list(allowed)
    if not isinstance(value, str) or value not in names:
        raise SeaError(f"{name} is {value!r}, allowed are {', '.join(names)}: choose one of these")
    return value


def array(name: str, value: ArrayLike, shape: tuple[int | str, ...], unit: str) -> Array:
    """Read-only float copy of `value`; letters in `shape` stand for any length.

    Raises:
        SeaError: it has another shape, or a value that is not a finite number.
    """
    try:
        result = np.array(value, dtype=float, order="C")
    except (TypeError, ValueError) as error:
        raise SeaError(f"{name} is not an array of numbers ({error}): give {unit} values") from None
    fits = result.ndim == len(shape) and all(
        isinstance(n, str) or n == m for n, m in zip(shape, result.shape, strict=True)
    )
    if not fits:
        wanted = "(" + ", ".join(map(str, shape)) + ("," if len(shape) == 1 else "") + ")"
        raise SeaError(f"{name} has shape {result.shape}, allowed is {wanted}: reshape it")
    if not np.isfinite(result).all():
        bad = tuple(int(i) for i in np.argwhere(~np.isfinite(result))[0])
        raise SeaError(
            f"{name}{list(bad)} is {result[bad]} {unit}, allowed are finite values: fill it"
        )
    result.setflags(write=False)
    return result


def generator(seed: Any) -> np.random.Generator:
    """Random generator of a seed.

    Raises:
        SeaError: `seed` is None (a run could not be repeated) or not a seed.
    """
    if isinstance(seed, np.random.Generator | np.random.SeedSequence):
        return np.random.default_rng(seed)
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or seed < 0:
        raise SeaError(
            f"seed is {seed!r}, allowed are integers >= 0, SeedSequence and numpy Generator: "
            "give one, so that the run can be repeated"
        )
    return np.random.default_rng(int(seed))
