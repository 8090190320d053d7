"""Nested dataclasses of numbers and arrays: selecting rows, and making one of many."""

import dataclasses
from collections.abc import Sequence
from typing import Any, TypeVar

import numpy as np

T = TypeVar("T")


class StructureError(TypeError):
    """Two objects differ in more than their numbers."""


def take(tree: T, rows: Any) -> T:
    """The tree with `array[rows]` for every array in it; everything else is kept."""
    if isinstance(tree, np.ndarray):
        return tree[rows]
    if dataclasses.is_dataclass(tree) and not isinstance(tree, type):
        return _rebuilt(tree, [take(value, rows) for value in _values(tree)])
    return tree


def where(rows: np.ndarray, chosen: T, otherwise: T) -> T:
    """Of every array in two trees alike the `chosen` one's rows where `rows` (...,) is true.

    Everything but arrays is kept as in `otherwise`.
    """
    if isinstance(otherwise, np.ndarray):
        mask = np.reshape(rows, (*np.shape(rows), *[1] * (otherwise.ndim - np.ndim(rows))))
        return np.where(mask, chosen, otherwise)  # type: ignore[call-overload, no-any-return]
    if dataclasses.is_dataclass(otherwise) and not isinstance(otherwise, type):
        pairs = zip(_values(chosen), _values(otherwise), strict=True)
        return _rebuilt(otherwise, [where(rows, one, other) for one, other in pairs])
    return otherwise


def stack(trees: Sequence[T], rows: Any = slice(None)) -> T:
    """One tree for many simulations: numbers that differ become arrays with a leading row each.

    Row i belongs to the tree `rows[i]`: simulations that share a tree give it once. Numbers and
    arrays that are the same in all trees stay as they are (they broadcast). Of a field
    with the metadata `stack="first"` the first tree's value is kept unseen; one with
    `stack="same"` must be the same in all trees, and so must an object whose class says
    `stack_rule = "same"`.

    Raises:
        StructureError: the trees differ in a type, a name, a flag, a count or a shape.
    """
    first = trees[0]
    others = trees[1:]
    if all(tree is first for tree in others):
        return first
    if any(type(tree) is not type(first) for tree in others):
        raise StructureError(f"{sorted({type(tree).__name__ for tree in trees})} cannot be stacked")
    if getattr(first, "stack_rule", None) == "same":
        if all(_same(tree, first) for tree in others):
            return first
        raise StructureError(f"{type(first).__name__} differs between the simulations")
    if dataclasses.is_dataclass(first):
        return _rebuilt(
            first,
            [
                _field([getattr(tree, f.name) for tree in trees], f, rows)
                for f in dataclasses.fields(first)
            ],
        )
    numbers = isinstance(first, float | np.ndarray) or (
        isinstance(first, tuple) and all(isinstance(value, float) for value in first)
    )
    if not numbers:
        if all(tree == first for tree in others):
            return first
        raise StructureError(f"{first!r} and {next(t for t in others if t != first)!r} differ")
    arrays = [np.asarray(tree) for tree in trees]
    if any(array.shape != arrays[0].shape for array in arrays):
        raise StructureError(f"shapes {sorted({array.shape for array in arrays})} differ")
    if all(np.array_equal(array, arrays[0], equal_nan=True) for array in arrays[1:]):
        return first
    if arrays[0].dtype.kind != "f":
        raise StructureError(f"arrays of {arrays[0].dtype} differ")
    return np.stack(arrays)[rows]  # type: ignore[return-value]


def _field(values: Sequence[Any], field: dataclasses.Field, rows: Any) -> Any:
    """Values of one field made one, by the rule in its metadata."""
    rule = field.metadata.get("stack")
    if rule == "first":
        return values[0]
    if rule == "same" and not all(_same(value, values[0]) for value in values[1:]):
        raise StructureError(f"{field.name} differs between the simulations")
    return values[0] if rule == "same" else stack(values, rows)


def _same(a: Any, b: Any) -> bool:
    """Whether two trees hold the same numbers."""
    if type(a) is not type(b):
        return False
    if dataclasses.is_dataclass(a):
        return all(map(_same, _values(a), _values(b)))
    return bool(np.array_equal(a, b))


def _values(tree: Any) -> list[Any]:
    """Values of the fields of a dataclass."""
    return [getattr(tree, field.name) for field in dataclasses.fields(tree)]


def _rebuilt(tree: T, values: Sequence[Any]) -> T:
    """A (frozen) dataclass with other values, without its checks and what it keeps for itself."""
    new = object.__new__(type(tree))  # a copy would have cached properties of the old values
    for field, value in zip(dataclasses.fields(tree), values, strict=True):  # type: ignore[arg-type]
        object.__setattr__(new, field.name, value)
    return new
