"""What a body needs to know about the surface: over what height it gets wet, and how deep it is.

A floating body stands on four columns of water whose stiffness is its restoring matrix: each has a
quarter of G33, and their places along the principal axes of the rotation give G34, G35, G44, G45
and G55. That is a calibration of ours: the matrix says how the lift changes about the floating
condition and not where it ends; the columns end where the lift of a wall-sided hull does, at its
keel (draught `weight / G33`) and its deck. They have a potential, so no motion through the surface
gains energy.
"""

from functools import lru_cache

import mujoco
import numpy as np

from marine_mj.environment import Environment, WaveField
from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.body_settings import BodySettings, Motion
from marine_mj.hydrodynamics.coefficients import BodyCoefficients
from marine_mj.hydrodynamics.floating import Pose, afloat, equilibrium
from marine_mj.hydrodynamics.inertia import subtree_inertia
from marine_mj.hydrodynamics.mesh import HullMesh, read_mesh
from marine_mj.hydrodynamics.panels import uses_panels
from marine_mj.hydrodynamics.table_builder import TableBuilder

#: Depth of a hull over its draught where nothing says it: a freeboard of two draughts (ours, a
#: small craft's; it limits the lift of a hull pushed under water to three times its weight).
DEPTH_RATIO = 3.0


def half_height(body: BodyCoefficients, volume: float) -> float:
    """Half height [m] over which a submerged body leaves the water; 0: it never does.

    Given, or the radius of its strips, or (ours) that of a sphere of its volume [m3].
    """
    if body.submergence_height or not volume:
        return body.submergence_height
    if body.strips is not None:
        return body.strips.radius
    return float((3 * volume / (4 * np.pi)) ** (1 / 3))


def hull_depth(body: BodyCoefficients, weight: float, lift: float) -> float:
    """Height [m] of a wall-sided hull with the waterplane of a floating body, keel to deck.

    Args:
        body: with a restoring matrix, G33 > 0.
        weight: that it carries, N.
        lift: rho g, N/m3.

    Raises:
        ModelError: the given depth is less than the draught weight / G33.
    """
    assert body.restoring is not None
    stiffness = float(body.restoring[2, 2])
    draught = weight / stiffness
    given = body.hull_depth or 2 * body.submergence_height
    if given:
        if given < draught:
            name = "hull_depth" if body.hull_depth else "twice the submergence_height"
            raise ModelError(
                f"{name} of {body.name!r} is {given:g} m, allowed is at least its draught, weight "
                f"/ G33 = {weight:g} N / {stiffness:g} N/m = {draught:g} m: check it, the mass and "
                "the restoring matrix"
            )
        return given
    if body.hull_mesh:
        return max(lift * read_mesh(body.hull_mesh).volume / stiffness, draught)
    return DEPTH_RATIO * draught


def columns(G: Array) -> tuple[Array, Array]:
    """Columns with the stiffness of a restoring matrix.

    Args:
        G: (6, 6) with G33 > 0.

    Returns:
        Rise of every column (COLUMNS, 2) over roll and pitch, m/rad, and what they lack of G's
        columns heave, roll and pitch (6, 3): everything in other rows, a negative stiffness.
    """
    spring = G[2, 2]
    coupling = 0.5 * (G[2, 3:5] + G[3:5, 2])
    rotation = 0.5 * (G[3:5, 3:5] + G[3:5, 3:5].T) - np.outer(coupling, coupling) / spring
    values, vectors = np.linalg.eigh(rotation)
    first, second = (np.sqrt(np.maximum(values, 0.0) / spring) * vectors).T
    signs = ((1, 1), (1, -1), (-1, 1), (-1, -1))
    arms = np.array([coupling / spring + a * first + b * second for a, b in signs])
    rows = np.column_stack([np.ones(t_.COLUMNS), arms])
    rest = np.array(G[:, 2:5])
    rest[2:5] -= 0.25 * spring * rows.T @ rows
    rest[np.abs(rest) < 1e-12 * np.abs(G).max()] = 0.0
    return arms, rest


@lru_cache(maxsize=64)
def _mesh_columns(
    mesh: str, mass: float, center: tuple[float, ...], density: float, gravity: float
) -> tuple[Pose, float, float, float, Array]:
    """Pose afloat, stiffness of all columns, draught, depth and arms of a hull mesh."""
    hull = read_mesh(mesh)
    lift = density * gravity
    if mass >= density * hull.volume:
        return _sunk(hull, lift)
    pose = equilibrium(hull, mass, center, density)
    level = pose.place(center)
    G = afloat(hull, pose).stiffness(density, gravity, mass, level, pose.origin)
    draught, depth = mass * gravity / G[2, 2], lift * hull.volume / G[2, 2]
    return pose, float(G[2, 2]), float(draught), float(depth), columns(G)[0]


def _sunk(hull: HullMesh, lift: float) -> tuple[Pose, float, float, float, Array]:
    """The same of a hull that is heavier than its water: its bounding box, just under water."""
    height = float(hull.extent[2])
    low, high = hull.vertices.min(axis=0), hull.vertices.max(axis=0)
    x, y, _ = 0.5 * (low + high)
    along, across, _ = hull.extent / np.sqrt(12)
    arms = np.array([[y + b * across, -x - a * along] for a in (1, -1) for b in (1, -1)])
    return Pose(float(-high[2])), lift * hull.volume / height, height, height, arms


def _averaged(waves: WaveField, radius: float) -> Array:
    """Amplitudes (n,) averaged over a waterplane with that radius of gyration [m], `k r` small.

    The first terms of the average over any plane, as a Gaussian one has them.
    """
    return waves.amplitude * np.exp(-0.5 * (waves.wavenumber * radius) ** 2)


def surface_block(
    model: mujoco.MjModel,
    table: TableBuilder,
    body: BodyCoefficients,
    index: int,
    environment: Environment,
    settings: BodySettings,
    motion: Motion,
    afloat_bodies: set[int],
) -> int:
    """Offset of the surface block of a floating body, 0 for one that has none.

    None have submerged bodies, those with a prescribed motion or `constant_buoyancy`, and floating
    ones without stiffness in heave.

    Raises:
        ModelError: see `hull_depth`, or the hull mesh finds no equilibrium.
    """
    if settings.constant_buoyancy or motion in ("rao", "fixed"):
        return 0
    lift = environment.water_density * environment.gravity
    rest = np.zeros((6, 3))
    if uses_panels(body, settings):
        mass, center, _ = subtree_inertia(model, index, afloat_bodies)
        pose, stiffness, draught, depth, arms = _mesh_columns(
            *(str(body.hull_mesh), mass, tuple(center)),
            *(environment.water_density, environment.gravity),
        )
    elif body.restoring is not None and body.restoring[2, 2] > 0:
        mass, _, _ = subtree_inertia(model, index, afloat_bodies)
        pose, stiffness = Pose(body.equilibrium_height), float(body.restoring[2, 2])
        draught = mass * environment.gravity / stiffness
        depth = hull_depth(body, mass * environment.gravity, lift)
        arms, rest = columns(body.restoring)
    else:
        return 0
    radius = float(np.sqrt(np.max(np.var(arms, axis=0))))
    amplitudes = table.add(_averaged(environment.waves, radius))
    block = np.zeros(t_.SF_SIZE)
    block[t_.SF_HEIGHT], block[t_.SF_ROLL], block[t_.SF_PITCH] = pose.height, pose.roll, pose.pitch
    block[t_.SF_STIFFNESS] = stiffness / t_.COLUMNS
    block[t_.SF_DRAUGHT], block[t_.SF_DEPTH] = draught, depth
    block[t_.SF_ARMS : t_.SF_ARMS + 2 * t_.COLUMNS] = arms.ravel()
    block[t_.SF_AMPLITUDES] = amplitudes
    block[t_.SF_REST : t_.SF_REST + 18] = rest.ravel()
    block[t_.SF_FOLLOWS] = not uses_panels(body, settings)  # panels feel the surface where they are
    return table.add(block)
