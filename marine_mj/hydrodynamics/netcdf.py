"""Variables of NetCDF 4 files by the names of their axes.

Models are loaded without xarray, whose import would take as long as that of the whole package.
"""

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from marine_mj.frames import Array


def read_variables(
    path: Path,
    wanted: Mapping[str, Sequence[str]],
    labels: Mapping[str, Sequence[str]],
    optional: Collection[str] = (),
) -> dict[str, Array]:
    """Wanted variables as float arrays.

    Args:
        path: the file.
        wanted: axes of every variable, in the wanted order.
        labels: entries of some axes, in the wanted order, by what the file calls them.
        optional: variables that are left out where the file lacks them.

    Raises:
        OSError: the file cannot be read or is no NetCDF 4 file.
        KeyError: a variable or a label is missing.
        ValueError: a variable has other axes, or is packed; omega is negative, NaN or doubled.
    """
    import h5netcdf

    found = {}
    with h5netcdf.File(path, "r") as file:
        for name, axes in wanted.items():
            if name in optional and name not in file.variables:
                continue
            variable = file.variables[name]
            if sorted(variable.dimensions) != sorted(axes):
                raise ValueError(f"{name} has the axes {', '.join(variable.dimensions)}")
            if {"scale_factor", "add_offset"} & set(variable.attrs):
                raise ValueError(f"{name} is packed with scale_factor or add_offset")
            table = np.asarray(variable[...], dtype=float)
            table = table.transpose([variable.dimensions.index(axis) for axis in axes])
            for place, axis in enumerate(axes):
                if axis in labels:
                    entries = file.variables[axis][...]
                    table = table.take(_places(entries, labels[axis]), axis=place)
            found[name] = table
    if "omega" in found:
        _check_frequencies(found["omega"])
    return found


def _check_frequencies(omega: Array) -> None:
    """ValueError for frequencies (n,) that are no rising set, 0 and infinity included."""
    bad = np.isnan(omega) | (omega < 0)
    if bad.any():
        raise ValueError(f"omega[{bad.argmax()}] is {omega[bad.argmax()]:g}, allowed is >= 0 rad/s")
    values, counts = np.unique(omega, return_counts=True)
    if (counts > 1).any():
        raise ValueError(f"omega has {values[counts > 1][0]:g} rad/s twice, allowed is once")


def read_attributes(path: Path, variables: Sequence[str], of: str | None = None) -> dict[str, Any]:
    """Attributes of a file, with the values of some of its variables where it has them.

    Args:
        path: the file.
        variables: read whole; they come before attributes of the same name.
        of: the attributes of this variable instead of the file's.

    Raises:
        OSError: the file cannot be read or is no NetCDF 4 file.
    """
    import h5netcdf

    with h5netcdf.File(path, "r") as file:
        owner = file if of is None else file.variables.get(of)
        found = {} if owner is None else {name: _plain(v) for name, v in owner.attrs.items()}
        for name in variables:
            if name in file.variables:
                found[name] = np.asarray(file.variables[name][...])
    return found


def _plain(value: Any) -> Any:
    """An attribute with its text as str."""
    return value.decode() if isinstance(value, bytes) else value


def _places(entries: NDArray, labels: Sequence[str]) -> list[int]:
    """Indices of labels among the entries of an axis: strings, or rows of characters."""
    rows = [b"".join(row).rstrip(b"\0") if entries.ndim == 2 else row for row in entries]
    texts = [row.decode() if isinstance(row, bytes) else str(row) for row in rows]
    for label in labels:
        if label not in texts:
            raise KeyError(label)
    return [texts.index(label) for label in labels]
