"""How a hull mesh lies in still water: poses, equilibrium, restoring matrix, righting arms.

Attitudes are zyx Euler angles in MuJoCo's axes (NWU, FLU): positive roll lifts port, positive pitch
lowers the bow. "Level axes" are those of the world, the origin on the water line above or below
that of the body.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from marine_mj.errors import ModelError
from marine_mj.frames import Array, quaternion_from_euler, rotation_from_quaternion
from marine_mj.hydrodynamics.cut import cut
from marine_mj.hydrodynamics.hydrostatics import Hydrostatics, hydrostatics
from marine_mj.hydrodynamics.mesh import HullMesh

_ITERATIONS = 200
#: Largest turn of one step towards the equilibrium, rad.
_STEP = 0.2


@dataclass(frozen=True)
class Pose:
    """How a hull lies: height of its origin above still water [m], roll and pitch [rad], NWU."""

    height: float = 0.0
    roll: float = 0.0
    pitch: float = 0.0

    @property
    def rotation(self) -> Array:
        """Body axes to level axes (3, 3)."""
        return rotation_from_quaternion(quaternion_from_euler([self.roll, self.pitch, 0.0]))

    @property
    def origin(self) -> Array:
        """The body origin (3,) in level axes, m."""
        return np.array([0.0, 0.0, self.height])

    def place(self, points: ArrayLike) -> Array:
        """Points (..., 3) of the body [m, FLU] in level axes."""
        return np.asarray(points, dtype=float) @ self.rotation.T + self.origin

    def body(self, points: ArrayLike) -> Array:
        """Points (..., 3) in level axes [m] in body axes FLU."""
        return (np.asarray(points, dtype=float) - self.origin) @ self.rotation


def afloat(mesh: HullMesh, pose: Pose | None = None) -> Hydrostatics:
    """Hydrostatics of a hull in a pose: level axes, origin on the water line above the body's.

    Args:
        mesh: closed hull, body axes FLU.
        pose: default: level, origin on the water line.
    """
    points = (pose or Pose()).place(mesh.vertices)
    return hydrostatics(*cut(points, mesh.triangles, 2, -1))


def floating_height(mesh: HullMesh, volume: float, roll: float = 0.0, pitch: float = 0.0) -> float:
    """Height [m] of the body origin at which a hull displaces a volume [m3] at fixed angles.

    Raises:
        ModelError: the volume is not between zero and that of the hull.
    """
    if not 0 < volume < mesh.volume:
        raise ModelError(
            f"hull mesh {mesh.name!r} is to displace {volume:.6g} m3 but encloses "
            f"{mesh.volume:.6g} m3: allowed is more than 0 and less than that; check the mass and "
            "the units of the mesh (m)"
        )
    from scipy.optimize import brentq  # here: slow to import

    z = mesh.vertices @ Pose(0.0, roll, pitch).rotation[2]

    def missing(height: float) -> float:
        return afloat(mesh, Pose(height, roll, pitch)).volume - volume

    return float(brentq(missing, -z.max(), -z.min(), xtol=1e-13, rtol=1e-14))


def _turned(R: Array) -> tuple[float, float]:
    """Roll and pitch of an attitude, whatever its yaw."""
    return float(np.arctan2(R[2, 1], R[2, 2])), float(-np.arcsin(np.clip(R[2, 0], -1.0, 1.0)))


def equilibrium(
    mesh: HullMesh, mass: float, center_of_gravity: ArrayLike, water_density: float = 1025.0
) -> Pose:
    """Pose in which a hull floats at rest: heave, roll and pitch without net force and moment.

    Newton's method on the restoring matrix from the level pose, downhill in the potential energy;
    a hull that stands upright on the edge (negative GM) stays there.

    Args:
        mesh: closed hull.
        mass: kg.
        center_of_gravity: (3,) body axes FLU from the body origin, m.
        water_density: kg/m3.

    Raises:
        ModelError: the hull sinks, or no equilibrium is found.
    """
    center = np.asarray(center_of_gravity, dtype=float)
    length = float(mesh.extent.max())
    pose = Pose(floating_height(mesh, mass / water_density))
    scale = np.array([1.0, length, length])
    worst = np.inf
    for _ in range(_ITERATIONS):
        state = afloat(mesh, pose)
        lift, gravity = water_density * state.volume, pose.place(center)
        arm = lift * state.center_of_buoyancy - mass * gravity
        residual = np.array([lift - mass, arm[1], -arm[0]]) / scale / mass
        worst = float(np.abs(residual).max())
        if worst < 1e-12:
            break
        G = state.stiffness(water_density, 1.0, mass, gravity, pose.origin)[2:5, 2:5] / mass
        values, vectors = np.linalg.eigh(G / np.outer(scale, scale))
        values = np.maximum(np.abs(values), 1e-9 * np.abs(values).max())
        step = vectors @ ((vectors.T @ residual) / values) / scale
        largest = max(abs(step[0]) / length, *np.abs(step[1:]))
        step *= min(1.0, _STEP / max(largest, 1e-300))
        turn = np.array([1.0, 0.5 * step[1], 0.5 * step[2], 0.0])
        roll, pitch = _turned(rotation_from_quaternion(turn / np.linalg.norm(turn)) @ pose.rotation)
        pose = Pose(pose.height + float(step[0]), roll, pitch)
    if worst > 1e-9:
        raise ModelError(
            f"hull mesh {mesh.name!r} with {mass:g} kg at {center} m finds no equilibrium (a "
            f"{worst:.1e} of its weight is left): check the mass and the centre of gravity"
        )
    return pose


def floating_restoring(
    mesh: HullMesh,
    mass: float,
    center_of_gravity: ArrayLike,
    water_density: float = 1025.0,
    gravity: float = 9.81,
) -> Array:
    """Restoring matrix G (6, 6) about the body origin at the equilibrium, level axes.

    Args as `equilibrium`, and gravity in m/s2.

    Raises:
        ModelError: see `equilibrium`.
    """
    pose = equilibrium(mesh, mass, center_of_gravity, water_density)
    center = pose.place(center_of_gravity)
    return afloat(mesh, pose).stiffness(water_density, gravity, mass, center, pose.origin)


def righting_arms(
    mesh: HullMesh, volume: float, center_of_gravity: ArrayLike, heel: ArrayLike, pitch: float = 0.0
) -> Array:
    """GZ (n,) [m] at the heel angles (n,) [rad], at constant displacement and fixed pitch.

    `GZ = y_G - y_B` in level axes: positive where the moment turns the hull back upright.

    Args:
        mesh: closed hull.
        volume: displaced volume, m3.
        center_of_gravity: (3,) body axes FLU from the body origin, m.
        heel: roll angles, rad.
        pitch: rad.

    Raises:
        ModelError: the volume is not between zero and that of the hull.
    """
    center = np.asarray(center_of_gravity, dtype=float)
    arms = []
    for roll in np.atleast_1d(np.asarray(heel, dtype=float)):
        pose = Pose(floating_height(mesh, volume, roll, pitch), float(roll), pitch)
        arms.append(pose.place(center)[1] - afloat(mesh, pose).center_of_buoyancy[1])
    return np.array(arms)
