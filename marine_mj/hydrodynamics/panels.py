"""Hull panels of a body: whether it has them, what the table holds, its linear restoring."""

import mujoco
import numpy as np

from marine_mj.environment import Environment, WaveField
from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.body_settings import BodySettings
from marine_mj.hydrodynamics.coefficients import ZERO, BodyCoefficients
from marine_mj.hydrodynamics.expansion import expansion
from marine_mj.hydrodynamics.floating import floating_restoring
from marine_mj.hydrodynamics.inertia import subtree_inertia
from marine_mj.hydrodynamics.mesh import HullMesh, read_mesh
from marine_mj.hydrodynamics.table_builder import TableBuilder


def uses_panels(body: BodyCoefficients, settings: BodySettings) -> bool:
    """Whether the hydrostatics of a body come from its hull mesh; see `BodySettings`.

    Raises:
        ModelError: panels are asked for and the body names no hull mesh.
    """
    other = body.restoring is not None or body.displaced_volume or body.buoyancy
    chosen = settings.hydrostatics or ("panels" if body.hull_mesh and not other else "linear")
    if chosen == "panels" and body.hull_mesh is None:
        raise ModelError(
            f"hydrostatics 'panels' of {body.name!r} needs a hull mesh; allowed is 'linear', or a "
            f'mesh: <text name="{body.name}.hull_mesh" data="FILE.obj"/>'
        )
    return chosen == "panels"


def panel_parameters(
    table: TableBuilder, body: BodyCoefficients, waves: WaveField, settings: BodySettings
) -> Array:
    """Parameters (P_SIZE,) of the panels of a body; vertices and triangles go into the table.

    Raises:
        ModelError: the hull mesh does not exist, cannot be read, is refused or too large.
    """
    hull = read_mesh(str(body.hull_mesh))
    _check_size(hull)
    x = hull.vertices
    place = table.add(x.T, x)
    rows = table.add(np.column_stack([hull.triangles, hull.areas]))
    head = [len(x), len(hull.triangles), place, rows, settings.froude_krylov]
    return np.concatenate([head, expansion(waves, hull.extent, len(x))])


def _check_size(hull: HullMesh) -> None:
    """Refuse a mesh that is too large for the kernel."""
    counts = len(hull.triangles), len(hull.vertices)
    if counts[0] > t_.MAX_HULL_TRIANGLES or counts[1] > t_.MAX_HULL_VERTICES:
        raise ModelError(
            f"hull mesh {hull.name!r} has {counts[0]} triangles and {counts[1]} vertices, allowed "
            f"on panels are {t_.MAX_HULL_TRIANGLES} and {t_.MAX_HULL_VERTICES} at most: coarsen it "
            "with marine_mj.hydrodynamics.prepare_hull (500 triangles are usually enough)"
        )


def restoring_of(
    model: mujoco.MjModel,
    body: BodyCoefficients,
    settings: BodySettings,
    environment: Environment,
) -> Array:
    """Linear restoring matrix (6, 6) of a floating body, FLU: given, or from its hull mesh.

    The mesh is taken at its equilibrium; zeros for a body that is under water there.

    Raises:
        ModelError: the hull floats but finds no equilibrium.
    """
    if body.restoring is not None:
        return body.restoring
    if not uses_panels(body, settings):
        return ZERO
    mass, center, _ = subtree_inertia(model, model.body(body.name).id)
    hull = read_mesh(str(body.hull_mesh))
    if mass >= environment.water_density * hull.volume:
        return ZERO
    return floating_restoring(hull, mass, center, environment.water_density, environment.gravity)
