"""Which law lets the waves act on a body, and the data of the one for long waves.

A floating body with a restoring matrix and neither force RAOs nor hull panels rides on the waves
as on long ones: `kernels.long_wave` has the equations.
"""

from collections.abc import Collection
from dataclasses import dataclass

import mujoco
import numpy as np

from marine_mj.environment import Environment, WaveField
from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.body_settings import BodySettings, motion_of
from marine_mj.hydrodynamics.coefficients import BodyCoefficients
from marine_mj.hydrodynamics.inertia import subtree_inertia
from marine_mj.hydrodynamics.panels import uses_panels
from marine_mj.hydrodynamics.table_builder import TableBuilder

#: What `excitation_of` answers, and what it means.
EXCITATIONS = {
    "prescribed": "the body's motion is given, no wave moves it",
    "database": "force RAOs of the wave database",
    "panels": "pressure of the undisturbed wave on the wetted panels",
    "database and panels": "pressure on the wetted panels, diffraction from the wave database",
    "long waves": "elevation and slope of the surface and motion of the water, means over the hull",
    "submerged": "motion of the water at the displaced volume",
    "none": "at most the drag of moving water",
}


@dataclass(frozen=True)
class EquivalentBox:
    """The box with the waterplane area, radii of inertia and displaced mass of a floating body.

    Attributes:
        length, breadth, draught: m.
        center_of_buoyancy: (3,) FLU from the body origin, m.
        waterplane_center: (3,) centroid of the waterplane, FLU from the body origin, m.
        waterplane_stiffness: (6, 3) force and moment of the pressure on the waterplane for a
            surface lifted at the origin [m], rolled and pitched [rad].
        mass: displaced mass, kg.
    """

    length: float
    breadth: float
    draught: float
    center_of_buoyancy: Array
    waterplane_center: Array
    waterplane_stiffness: Array
    mass: float


def _carries(body: BodyCoefficients) -> bool:
    """Whether the body has a restoring matrix with a waterplane."""
    return body.restoring is not None and bool(body.restoring[2, 2] > 0)


def excitation_of(body: BodyCoefficients, settings: BodySettings) -> str:
    """By what waves act on a body, one of `EXCITATIONS`.

    Raises:
        ModelError: `settings.excitation` asks for what the body cannot have.
    """
    motion, panels = motion_of(body, settings), uses_panels(body, settings)
    if motion in ("rao", "fixed"):
        found = "prescribed"
    elif motion == "dynamic":
        found = "database and panels" if panels else "database"
    elif panels:
        found = "panels" if settings.froude_krylov else "none"
    elif body.displaced_volume or body.buoyancy:
        found = "submerged"
    elif _carries(body) and settings.excitation != "none":
        found = "long waves"
    else:
        found = "none"
    if settings.excitation is not None and found not in ("long waves", "none"):
        raise ModelError(
            f"excitation {settings.excitation!r} of {body.name!r}, on which waves act by "
            f"{found!r} ({EXCITATIONS[found]}); allowed is to leave it out, or the motion 'free' "
            "and linear hydrostatics with a restoring matrix"
        )
    if settings.excitation == "long_wave" and found == "none":
        raise ModelError(
            f"excitation 'long_wave' of {body.name!r} needs a floating body: a restoring matrix "
            f'with G33 > 0; add <numeric name="{body.name}.restoring_frd" .../> or leave it out'
        )
    if found == "long waves" and settings.sheltered_by is not None:
        raise ModelError(
            f"{body.name!r} floats in long waves and has sheltered_by = "
            f"{settings.sheltered_by!r}, allowed is one of them: a shelter database tells the "
            "water's motion below the surface, not the surface; leave out sheltered_by or set "
            "excitation 'none'"
        )
    return found


def equivalent_box(
    body: BodyCoefficients, mass: float, center: Array, environment: Environment
) -> EquivalentBox:
    """The box for which a restoring matrix, a mass and a centre of gravity stand.

    `G33 = rho g A`, `G44 = G33 (k_y^2 + y_f^2) + W (z_B - z_G)` with the centroid (x_f, y_f) and
    the radii of inertia of the waterplane, likewise G55 (Fossen 2021, sec. 4.2); the breadth is
    that of the rectangle with this radius, `B^2 = 12 k_y^2`. The centre of buoyancy is taken at
    half the draught `m / (rho A)` below the water line, above or below the centre of gravity. That
    is ours: long waves do not feel it (its share of G44 and the arm of the force cancel).

    Args:
        body: with a restoring matrix whose G33 is above zero.
        mass: displaced mass, kg.
        center: (3,) centre of gravity, FLU from the body origin, m.
        environment: density and gravity.
    """
    G = np.asarray(body.restoring)
    weight, lift = mass * environment.gravity, G[2, 2]
    draught = weight / lift
    z_b = -body.equilibrium_height - 0.5 * draught
    C = G[:, 2:5].copy()
    C[[3, 4], [1, 2]] += weight * (center[2] - z_b)
    x, y = -C[2, 2] / lift, C[2, 1] / lift
    across, along = C[3, 1] / lift - y * y, C[4, 2] / lift - x * x
    length, breadth = np.sqrt(12 * np.maximum([along, across], 0.0))
    return EquivalentBox(
        length=float(length),
        breadth=float(breadth),
        draught=float(draught),
        center_of_buoyancy=np.array([center[0], center[1], z_b]),
        waterplane_center=np.array([x, y, -body.equilibrium_height]),
        waterplane_stiffness=C,
        mass=mass,
    )


def mean_speeds(waves: WaveField, draught: float) -> Array:
    """Horizontal and vertical orbital speed (2, N) of each component, mean over a draught, m/s.

    `a omega cosh k(z + h) / sinh kh` and the same with sinh, mean over -T < z < 0.
    """
    with np.errstate(over="ignore"):
        d = waves.wavenumber * min(0.5 * draught, 0.5 * waves.depth)
        u = waves.wavenumber * waves.depth
        mean = waves.amplitude * waves.omega * -np.expm1(-2 * d) / (2 * d * -np.expm1(-2 * u))
        lower = np.exp(-2 * (u - d))
    return np.stack([mean * (1 + lower), mean * (1 - lower)])


def long_wave_block(
    model: mujoco.MjModel,
    table: TableBuilder,
    body: BodyCoefficients,
    environment: Environment,
    settings: BodySettings,
    afloat: Collection[int],
) -> int:
    """Offset of the long-wave block of a body; 0 without waves or where another law acts.

    Args:
        model: compiled model.
        table: grows by the block.
        body: coefficients.
        environment: sea, density, gravity.
        settings: of the body; without `froude_krylov` the block holds the water's motion alone.
        afloat: bodies with buoyancy of their own, which nothing carries.

    Raises:
        ModelError: see `excitation_of`.
    """
    if excitation_of(body, settings) != "long waves" or len(environment.waves.omega) == 0:
        return 0
    mass, center, _ = subtree_inertia(model, model.body(body.name).id, afloat)
    box = equivalent_box(body, mass, center, environment)
    q = np.zeros(t_.LW_SIZE)
    q[t_.LW_PLACE : t_.LW_PLACE + 3] = box.waterplane_center
    q[t_.LW_HALF : t_.LW_HALF + 2] = 0.5 * box.length, 0.5 * box.breadth
    if settings.froude_krylov:
        q[: t_.LW_MASS] = box.waterplane_stiffness.ravel()
        q[t_.LW_MASS] = mass
        q[t_.LW_CENTER : t_.LW_CENTER + 3] = box.center_of_buoyancy
        across, along = mass * box.breadth**2 / 12, mass * box.length**2 / 12
        q[t_.LW_INERTIA : t_.LW_INERTIA + 3] = across, along, along - across
    q[t_.LW_SPEEDS] = table.add(mean_speeds(environment.waves, box.draught))
    return table.add(q)
