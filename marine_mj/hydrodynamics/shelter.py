"""The water motion near a floating hull: its shelter database in the packed table."""

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path

import mujoco

from marine_mj.environment import WaveField
from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.body_settings import Motion
from marine_mj.hydrodynamics.coefficients import BodyCoefficients
from marine_mj.hydrodynamics.element_pack import by_heading
from marine_mj.hydrodynamics.netcdf import read_variables
from marine_mj.hydrodynamics.raos import database_path
from marine_mj.hydrodynamics.table_builder import TableBuilder


@lru_cache(maxsize=4)
def read_field(path: Path) -> tuple[Array, Array, Array, Array]:
    """x (a,), y (b,), z (c,) [m] and modes (a, b, c, 3, m) of a shelter database.

    Raises:
        ModelError: the file is not a shelter database, or has too many modes for the kernels.
    """
    axes = {"x": ("x",), "y": ("y",), "z": ("z",), "field": ("x", "y", "z", "axis", "mode")}
    try:
        x, y, z, field = read_variables(path, axes, {}).values()
    except (OSError, KeyError, ValueError) as error:
        raise ModelError(
            f"{path.name} is not a shelter database ({error}); needed are the variables "
            "field(x, y, z, axis, mode) and shelter_strength, as "
            "marine_mj.hydrodynamics.bem.shelter writes them"
        ) from error
    if field.shape[-1] > t_.MAX_SHELTER_MODES:
        raise ModelError(
            f"{path.name} has {field.shape[-1]} modes, allowed are {t_.MAX_SHELTER_MODES}: make it "
            "with a larger residue"
        )
    return x, y, z, field


def shelter_block(
    model: mujoco.MjModel,
    table: TableBuilder,
    name: str,
    hull: str,
    motion: Motion,
    bodies: Sequence[BodyCoefficients],
    waves: WaveField,
) -> int:
    """Offset of the shelter block of a body, 0 without waves; see `kernels.shelter`.

    Args:
        model: compiled model.
        table: grows by the block.
        name: the sheltered body.
        hull: the floating body that shelters it.
        motion: of the sheltered body.
        bodies: all hydrodynamic bodies.
        waves: the sea.

    Raises:
        ModelError: the hull is not another hydrodynamic body with a shelter database, or the
            sheltered body takes its waves from RAOs.
    """
    databases = {b.name: b.shelter_database for b in bodies if b.name != name}
    database = databases.get(hull)
    if database is None:
        able = [other for other, file in databases.items() if file]
        raise ModelError(
            f"sheltered_by of {name!r} is {hull!r}; allowed is another body with a shelter "
            f'database (<text name="BODY.shelter_database" data="FILE.nc"/>): '
            f"{', '.join(able) or 'there is none'}"
        )
    if motion != "free":
        raise ModelError(
            f"{name!r} has motion {motion!r} and sheltered_by = {hull!r}; allowed is the motion "
            "'free': RAOs hold the water motion of undisturbed waves; leave out sheltered_by"
        )
    if not len(waves.omega):
        return 0
    x, y, z, field = read_field(database_path(database))
    headings, strengths, reference = by_heading(table, database, waves, "shelter")
    nodes = [len(x), len(y), len(z)]
    places, values = table.add(x, y, z), table.add(field)
    index = model.body(hull).id
    modes = field.shape[-1]
    return table.add([index, modes, headings, *nodes, places, strengths, values, reference])
