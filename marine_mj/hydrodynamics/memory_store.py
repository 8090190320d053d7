"""The radiation memory of a wave database: stored in it, or fitted when it is first needed."""

from functools import lru_cache
from pathlib import Path

import numpy as np

from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.hydrodynamics.memory import Memory, PairFit
from marine_mj.hydrodynamics.memory_fit import fit_memory
from marine_mj.hydrodynamics.netcdf import read_attributes, read_variables
from marine_mj.hydrodynamics.raos import LABELS, database_path
from marine_mj.hydrodynamics.vector_fitting import Complex
from marine_mj.hydrodynamics.wave_file import density_ratio

_PAIR = ("radiating_dof", "influenced_dof")
_POLES = ("complex", "memory_pole")
#: Variables of a stored model, with their dimensions.
VARIABLES = {"memory_poles": _POLES, "memory_residues": (*_POLES, *_PAIR)}


@lru_cache(maxsize=16)
def read_radiation(path: Path) -> tuple[dict[str, Array], dict[str, Complex]]:
    """Radiation data and the stored model of a wave database, FLU; read once.

    Returns:
        {omega (n,), added_mass (n, 6, 6), radiation_damping (n, 6, 6), infinite (6, 6)}, with
        A(inf) from `infinite_added_mass` or from the added mass at omega = inf; and
        {memory_poles (p,), memory_residues (p, 6, 6)}, empty where none is stored.

    Raises:
        ModelError: the file cannot be read or lacks one of the first four.
    """
    wanted = {"omega": ("omega",), "infinite_added_mass": _PAIR, **VARIABLES}
    wanted |= {name: ("omega", *_PAIR) for name in ("added_mass", "radiation_damping")}
    try:
        file = read_variables(path, wanted, LABELS, ("infinite_added_mass", *VARIABLES))
        order = np.argsort(file["omega"])
        omega = file["omega"][order]
        found = {name: file[name][order] for name in ("added_mass", "radiation_damping")}
        if "infinite_added_mass" in file:
            infinite = file["infinite_added_mass"]
        elif np.isinf(omega[-1]):
            infinite = found["added_mass"][-1]
        else:
            raise KeyError("infinite_added_mass")
    except (OSError, KeyError, ValueError) as error:
        raise ModelError(
            f"{path.name} has no radiation memory ({error}); needed are the variables "
            "added_mass(omega, radiating_dof, influenced_dof), radiation_damping (the same) and "
            "infinite_added_mass(radiating_dof, influenced_dof) as Capytaine names them: add "
            "them, or simulate with radiation 'constant'"
        ) from error
    inside = np.isfinite(omega) & (omega > 0)
    data = {name: values[inside] for name, values in found.items()}
    stored: dict[str, Complex] = {}
    if set(VARIABLES) <= set(file):
        stored = {name: file[name][0] + 1j * file[name][1] for name in VARIABLES}
    return {"omega": omega[inside], **data, "infinite": infinite}, stored


@lru_cache(maxsize=16)
def _memory(path: Path) -> tuple[Memory, tuple[PairFit, ...]]:
    """Checked memory of a file, and how well it fits."""
    data, stored = read_radiation(path)
    arguments = data["omega"], data["added_mass"], data["radiation_damping"]
    if not stored:
        memory = fit_memory(*arguments, data["infinite"])
        return memory, memory.fits(*arguments)
    band = read_attributes(path, (), of="memory_poles").get("band")
    if band is not None:
        inside = (data["omega"] >= band[0] * (1 - 1e-9)) & (data["omega"] <= band[1] * (1 + 1e-9))
        omega, A, B = arguments
        arguments = omega[inside], A[inside], B[inside]
    infinite = 0.5 * (data["infinite"] + data["infinite"].T)
    memory = Memory(infinite, stored["memory_poles"], stored["memory_residues"])
    try:
        memory.check()
        return memory, memory.check_fit(*arguments)
    except ModelError as error:
        raise ModelError(
            f"the radiation memory stored in {path.name} does not belong to its data: {error}; "
            f"store it again: python -m marine_mj.hydrodynamics.fit_database {path}"
        ) from error


def forget() -> None:
    """Read files again when they are next needed."""
    read_radiation.cache_clear()
    _memory.cache_clear()


def has_memory_data(name: str) -> bool:
    """Whether a wave database has A, B and A(inf), which a radiation memory needs.

    Raises:
        ModelError: the database does not exist.
    """
    path = database_path(name)
    try:
        read_radiation(path)
    except ModelError:
        return False
    return True


def database_memory(name: str) -> Memory:
    """Radiation memory of a wave database, fitted where none is stored in it; read once.

    Args:
        name: wave database, see `raos.database_path`; A(inf) and residues are those in the density
            of the water that it carries (`wave_file.WaveDatabase`).

    Raises:
        ModelError: the database does not exist or lacks A, B or A(inf); the stored or fitted
            model is not stable, not passive or does not fit.
    """
    path = database_path(name)
    return _memory(path)[0].scaled(density_ratio(name, path))


def memory_report(name: str) -> tuple[PairFit, ...]:
    """How well the radiation memory of a wave database fits its data, by coupled pair.

    Raises:
        ModelError: see `database_memory`.
    """
    return _memory(database_path(name))[1]
