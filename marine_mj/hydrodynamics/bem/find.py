"""Which hull mesh a name means: a file, or the one a vehicle names."""

from pathlib import Path

import mujoco

from marine_mj.errors import ModelError
from marine_mj.hydrodynamics.coefficients import BodyCoefficients, read_coefficients
from marine_mj.hydrodynamics.mesh import SUFFIXES, find_mesh
from marine_mj.library import find_model


def find_hull(name: str) -> tuple[Path, BodyCoefficients | None]:
    """Mesh file of a hull, and the body it belongs to (None for a plain mesh).

    Args:
        name: a mesh file (see `find_mesh`), or a vehicle whose MJCF has
            `<text name="BODY.hull_mesh" data="FILE"/>`; FILE is looked up among the vehicle's
            assets, then as `find_mesh` does.

    Raises:
        ModelError: there is no such file or vehicle, or the vehicle does not name one hull mesh.
    """
    if Path(name).suffix.lower() in SUFFIXES:
        return find_mesh(name), None
    xml = find_model(name)
    bodies = [b for b in read_coefficients(mujoco.MjSpec.from_file(str(xml))) if b.hull_mesh]
    if len(bodies) != 1:
        raise ModelError(
            f"vehicle {name!r} names {len(bodies)} hull meshes, needed is 1: write "
            '<text name="BODY.hull_mesh" data="FILE"/> into <custom>, or give a mesh file'
        )
    return find_mesh(str(bodies[0].hull_mesh)), bodies[0]
