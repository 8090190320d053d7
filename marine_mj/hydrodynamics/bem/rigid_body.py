"""Mass, centre of gravity and inertia of a hull, given or assumed."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import trimesh

from marine_mj.errors import ModelError
from marine_mj.frames import Array, skew
from marine_mj.hydrodynamics.mesh import HullMesh

#: Largest difference of mass and displaced mass that a hull at rest may have.
IMBALANCE = 0.05


@dataclass(frozen=True)
class RigidBody:
    """Mass [kg], centre of gravity (3,) [m] and inertia about it (3, 3) [kg m2].

    `assumptions` lists, in words, what was not given.
    """

    mass: float
    center_of_mass: Array
    inertia: Array
    assumptions: tuple[str, ...] = field(default=())

    def matrix(self, origin: Array) -> Array:
        """Rigid-body inertia M_RB (6, 6) about `origin`, body axes FLU."""
        S = skew(self.center_of_mass - origin)
        coupling = self.mass * S
        return np.block(
            [[self.mass * np.eye(3), -coupling], [coupling, self.inertia - coupling @ S]]
        )


def rigid_body(
    mesh: HullMesh,
    displaced_mass: float,
    center_of_buoyancy: Array,
    *,
    mass: float | None = None,
    center_of_mass: Sequence[float] | None = None,
    inertia: Sequence[float] | None = None,
    gyration: Sequence[float] | None = None,
) -> RigidBody:
    """Rigid body of a floating or submerged hull; what is not given is assumed and said so.

    Defaults: the displaced mass; the centroid of the closed mesh moved over the centre of
    buoyancy; the inertia of the closed mesh with uniform density.

    Args:
        mesh: closed hull, topsides included, waterline frame, m.
        displaced_mass: kg.
        center_of_buoyancy: (3,) m.
        mass: kg.
        center_of_mass: (3,) m, waterline frame.
        inertia: (3,) diagonal about the centre of mass, kg m2.
        gyration: (3,) radii of gyration about the centre of mass, m, instead of `inertia`.

    Raises:
        ModelError: mass, inertia or radii are not above 0, both inertia and radii are given, or
            the mass differs by more than 5 % from the displaced mass.
    """
    if inertia is not None and gyration is not None:
        raise ModelError("both inertia and radii of gyration are given, allowed is one of them")
    for name, values in (("inertia", inertia), ("radii of gyration", gyration)):
        if values is not None and not (len(values) == 3 and min(values) > 0):
            raise ModelError(f"{name} = {list(values)}; allowed are 3 numbers above 0 (x y z)")
    solid = trimesh.Trimesh(mesh.vertices, mesh.triangles, process=False)
    assumed = []
    if mass is None:
        mass = displaced_mass
        assumed.append(f"mass: the displaced {mass:.6g} kg")
    if not mass > 0 or abs(mass - displaced_mass) > IMBALANCE * displaced_mass:
        raise ModelError(
            f"mass is {mass:g} kg, but the hull displaces {displaced_mass:g} kg; allowed are "
            f"{100 * IMBALANCE:g} %: change the mass or the waterline"
        )
    if center_of_mass is None:
        center = np.append(center_of_buoyancy[:2], solid.center_mass[2])
        assumed.append("centre of gravity: height of the mesh's centroid, over the buoyancy")
    else:
        center = np.asarray(center_of_mass, dtype=float)
        if center.shape != (3,) or not np.isfinite(center).all():
            raise ModelError(f"centre of gravity is {center}; allowed are 3 finite numbers (m)")
    if inertia is not None:
        matrix = np.diag(np.asarray(inertia, dtype=float))
    elif gyration is not None:
        matrix = mass * np.diag(np.asarray(gyration, dtype=float) ** 2)
    else:
        matrix = np.asarray(solid.moment_inertia) * mass / solid.volume
        assumed.append("inertia: the closed mesh with uniform density")
    return RigidBody(float(mass), center, matrix, tuple(assumed))
