"""Hydrostatics of a hull mesh in still water: volume, centres, equilibrium, stability.

Worked out from the displaced volume, in NumPy; the simulation integrates pressure natively
(`kernels.panels`). Attitudes are zyx Euler angles in MuJoCo's axes (NWU, FLU): positive roll lifts
port, positive pitch lowers the bow. "Level axes" are those of the world through the body origin.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from marine_mj.errors import ModelError
from marine_mj.frames import Array, quaternion_from_euler, rotation_from_quaternion
from marine_mj.hydrodynamics.hull import Hull

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


@dataclass(frozen=True)
class Hydrostatics:
    """A hull in still water.

    Attributes:
        volume: displaced volume V, m3.
        center: centre of buoyancy (3,), body axes FLU, m (zeros when nothing is wet).
        center_level: the same in level axes, m.
        waterplane_area: m2.
        waterplane_moment: integrals (2,) of x and y over the waterplane, level axes, m3.
        waterplane_inertia: integrals (2, 2) of x x, x y, y y over it, level axes, m4.
        wetted_surface: m2.
        draught: depth of the lowest point, m.
    """

    volume: float
    center: Array
    center_level: Array
    waterplane_area: float
    waterplane_moment: Array
    waterplane_inertia: Array
    wetted_surface: float
    draught: float

    def restoring(
        self, mass: float, center_of_gravity: ArrayLike, water_density: float, gravity: float
    ) -> Array:
        """Restoring matrix G (6, 6) about the body origin, level axes (Newman 1977, sec. 6.16).

        `force = -G eta` for small heave, roll and pitch about this pose, with the weight.

        Args:
            mass: m, kg.
            center_of_gravity: (3,) in level axes from the body origin, m.
            water_density: rho, kg/m3.
            gravity: g, m/s2.
        """
        lift, weight = water_density * gravity * self.volume, mass * gravity
        x, y = self.waterplane_moment
        (xx, xy), (_, yy) = self.waterplane_inertia
        G = np.zeros((6, 6))
        G[2, 2:5] = self.waterplane_area, y, -x
        G[3, 3:5] = yy, -xy
        G[4, 4] = xx
        G = water_density * gravity * (G + np.triu(G, 1).T)
        first = lift * self.center_level - weight * np.asarray(center_of_gravity)
        G[3, 3] += first[2]
        G[4, 4] += first[2]
        G[3, 5], G[4, 5] = -first[0], -first[1]
        return G


def _wet_triangles(x: Array) -> Array:
    """Triangles (k, 3, 3) below z = 0 of triangles (m, 3, 3), cut at it, orientation kept."""
    below = x[:, :, 2] < 0
    count = below.sum(axis=1)
    parts = [x[count == 3]]
    for wet in (1, 2):
        chosen = x[count == wet]
        odd = (below[count == wet] if wet == 1 else ~below[count == wet]).argmax(axis=1)
        order = (odd[:, None] + np.arange(3)) % 3
        a, b, c = np.moveaxis(np.take_along_axis(chosen, order[:, :, None], axis=1), 1, 0)
        to_b = a + (a[:, 2] / (a[:, 2] - b[:, 2]))[:, None] * (b - a)
        to_c = a + (a[:, 2] / (a[:, 2] - c[:, 2]))[:, None] * (c - a)
        cut = [(a, to_b, to_c)] if wet == 1 else [(b, c, to_c), (b, to_c, to_b)]
        parts += [np.stack(corners, axis=1) for corners in cut]
    return np.concatenate(parts)


def hydrostatics(hull: Hull, pose: Pose | None = None) -> Hydrostatics:
    """Volume, centre of buoyancy and waterplane of a hull in still water.

    By Gauss's theorem over the wet surface S (n outwards): `V = int z n_z dS`,
    `V x_B = int x z n_z dS`, `V z_B = int z^2 / 2 n_z dS`, and over the waterplane
    `int f(x, y) dA = -int f n_z dS`; all integrands are quadratic and integrated exactly.

    Args:
        hull: closed hull.
        pose: default: level, origin on the water line.
    """
    pose = pose or Pose()
    R = pose.rotation
    x = hull.vertices @ R.T
    lift = np.array([0.0, 0.0, pose.height])
    wet = _wet_triangles(x[hull.triangles] + lift)
    areas = 0.5 * np.cross(wet[:, 1] - wet[:, 0], wet[:, 2] - wet[:, 0])
    # the mean over the middles of the edges is exact for quadratics (Strang & Fix 1973)
    middle = 0.5 * (wet + np.roll(wet, -1, axis=1))
    share = np.broadcast_to(areas[:, 2, None] / 3, middle.shape[:2])

    def integral(f: Array) -> float:
        return float(np.sum(share * f))

    X, Y, Z = np.moveaxis(middle, -1, 0)
    volume = integral(Z)
    moment = np.array([integral(X * Z), integral(Y * Z), integral(0.5 * Z * Z)])
    center = moment / volume - lift if volume > 0 else np.zeros(3)
    xy = integral(X * Y)
    return Hydrostatics(
        volume=volume,
        center=R.T @ center,
        center_level=center,
        waterplane_area=-integral(np.ones_like(X)) + 0.0,
        waterplane_moment=-np.array([integral(X), integral(Y)]),
        waterplane_inertia=-np.array([[integral(X * X), xy], [xy, integral(Y * Y)]]),
        wetted_surface=float(np.linalg.norm(areas, axis=1).sum()),
        draught=float(-(x[:, 2].min() + pose.height)),
    )


def floating_height(hull: Hull, volume: float, roll: float = 0.0, pitch: float = 0.0) -> float:
    """Height [m] of the body origin at which a hull displaces a volume [m3] at fixed angles.

    Raises:
        ModelError: the volume is not between zero and that of the hull.
    """
    if not 0 < volume < hull.volume:
        raise ModelError(
            f"hull mesh {hull.name!r} is to displace {volume:.6g} m3 but encloses "
            f"{hull.volume:.6g} m3: allowed is more than 0 and less than that; check the mass and "
            "the units of the mesh (m)"
        )
    from scipy.optimize import brentq  # here: slow to import

    z = hull.vertices @ Pose(0.0, roll, pitch).rotation[2]

    def missing(height: float) -> float:
        return hydrostatics(hull, Pose(height, roll, pitch)).volume - volume

    return float(brentq(missing, -z.max(), -z.min(), xtol=1e-13, rtol=1e-14))


def _turned(R: Array) -> tuple[float, float]:
    """Roll and pitch of an attitude, whatever its yaw."""
    return float(np.arctan2(R[2, 1], R[2, 2])), float(-np.arcsin(np.clip(R[2, 0], -1.0, 1.0)))


def equilibrium(
    hull: Hull, mass: float, center_of_gravity: ArrayLike, water_density: float = 1025.0
) -> Pose:
    """Pose in which a hull floats at rest: heave, roll and pitch without net force and moment.

    Newton's method on the restoring matrix from the level pose, downhill in the potential energy;
    a hull that stands upright on the edge (negative GM) stays there.

    Args:
        hull: closed hull.
        mass: kg.
        center_of_gravity: (3,) body axes FLU from the body origin, m.
        water_density: kg/m3.

    Raises:
        ModelError: the hull sinks, or no equilibrium is found.
    """
    center = np.asarray(center_of_gravity, dtype=float)
    length = float(hull.extent.max())
    pose = Pose(floating_height(hull, mass / water_density))
    scale = np.array([1.0, length, length])
    worst = np.inf
    for _ in range(_ITERATIONS):
        R = pose.rotation
        state = hydrostatics(hull, pose)
        lift, gravity = water_density * state.volume, R @ center
        arm = lift * state.center_level - mass * gravity
        residual = np.array([lift - mass, arm[1], -arm[0]]) / scale / mass
        worst = float(np.abs(residual).max())
        if worst < 1e-12:
            break
        G = state.restoring(mass, gravity, water_density, 1.0)[2:5, 2:5] / mass
        values, vectors = np.linalg.eigh(G / np.outer(scale, scale))
        values = np.maximum(np.abs(values), 1e-9 * np.abs(values).max())
        step = vectors @ ((vectors.T @ residual) / values) / scale
        largest = max(abs(step[0]) / length, *np.abs(step[1:]))
        step *= min(1.0, _STEP / max(largest, 1e-300))
        turn = np.array([1.0, 0.5 * step[1], 0.5 * step[2], 0.0])
        roll, pitch = _turned(rotation_from_quaternion(turn / np.linalg.norm(turn)) @ R)
        pose = Pose(pose.height + float(step[0]), roll, pitch)
    if worst > 1e-9:
        raise ModelError(
            f"hull mesh {hull.name!r} with {mass:g} kg at {center} m finds no equilibrium (a "
            f"{worst:.1e} of its weight is left): check the mass and the centre of gravity"
        )
    return pose


def floating_restoring(
    hull: Hull,
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
    pose = equilibrium(hull, mass, center_of_gravity, water_density)
    level = pose.rotation @ np.asarray(center_of_gravity, dtype=float)
    return hydrostatics(hull, pose).restoring(mass, level, water_density, gravity)


def righting_arms(
    hull: Hull, volume: float, center_of_gravity: ArrayLike, heel: ArrayLike, pitch: float = 0.0
) -> Array:
    """GZ (n,) [m] at the heel angles (n,) [rad], at constant displacement and fixed pitch.

    `GZ = y_G - y_B` in level axes: positive where the moment turns the hull back upright.

    Args:
        hull: closed hull.
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
        pose = Pose(floating_height(hull, volume, roll, pitch), float(roll), pitch)
        arms.append((pose.rotation @ center)[1] - hydrostatics(hull, pose).center_level[1])
    return np.array(arms)
