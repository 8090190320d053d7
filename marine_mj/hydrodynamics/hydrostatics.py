"""Hydrostatics of a floating or submerged hull from the triangles of its wetted surface.

Worked out from the displaced volume, in NumPy; the simulation integrates pressure natively
(`kernels.panels`).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from marine_mj.frames import Array

#: A surface whose opening is a smaller share of its area is closed: no waterplane.
_CLOSED = 1e-9


@dataclass(frozen=True)
class Hydrostatics:
    """What still water does to a hull; lengths from the waterline frame (z = 0 is the surface).

    Attributes:
        volume: displaced volume, m3.
        center_of_buoyancy: (3,) m (zeros when nothing is wet).
        wetted_surface: m2.
        waterplane_area: m2, 0 for a submerged body.
        waterplane_center: (2,) x and y of the centre of flotation, m (NaN without waterplane).
        waterplane_moments: (3,) second moments about the origin: int x^2, int y^2, int x y, m4.
        draught: depth of the lowest point, m (0 when nothing is wet).
        length, breadth: of the wetted part, m.
    """

    volume: float
    center_of_buoyancy: Array
    wetted_surface: float
    waterplane_area: float
    waterplane_center: Array
    waterplane_moments: Array
    draught: float
    length: float
    breadth: float

    def metacentric_heights(self, center_of_mass: Array) -> tuple[float, float]:
        """GM_T and GM_L, m: `I / V + z_B - z_G`, I about the centre of flotation."""
        if self.waterplane_area == 0.0:
            height = float(self.center_of_buoyancy[2] - center_of_mass[2])
            return height, height
        x, y = self.waterplane_center
        over = float(self.center_of_buoyancy[2] - center_of_mass[2])
        across = self.waterplane_moments[1] - self.waterplane_area * y**2
        along = self.waterplane_moments[0] - self.waterplane_area * x**2
        return float(across / self.volume + over), float(along / self.volume + over)

    def stiffness(
        self, density: float, gravity: float, mass: float, center_of_mass: Array, origin: Array
    ) -> Array:
        """Hydrostatic stiffness (6, 6) about `origin`, weight included: N/m, N, N m.

        Rows are forces, columns motions. With lengths from the origin:

            C33 = rho g A        C34 = rho g int y dA       C35 = -rho g int x dA
            C44 = rho g (int y^2 dA + V z_B) - m g z_G      C45 = -rho g int x y dA
            C55 = rho g (int x^2 dA + V z_B) - m g z_G
            C46 = -rho g V x_B + m g x_G                    C56 = -rho g V y_B + m g y_G

        (Newman, Marine Hydrodynamics, sec. 6.16.) C64 and C65 are 0: nothing turns about a
        vertical axis in still water.

        Args:
            density: kg/m3.
            gravity: m/s2.
            mass: kg.
            center_of_mass: (3,) m, waterline frame.
            origin: (3,) m, waterline frame.
        """
        spring, weight = density * gravity, mass * gravity
        B, G = self.center_of_buoyancy - origin, center_of_mass - origin
        lift = spring * self.volume
        C = np.zeros((6, 6))
        if self.waterplane_area > 0.0:
            area = self.waterplane_area
            sx, sy = area * self.waterplane_center
            xx, yy, xy = self.waterplane_moments
            ox, oy = origin[:2]
            C[2, 2] = spring * area
            C[2, 3] = C[3, 2] = spring * (sy - oy * area)
            C[2, 4] = C[4, 2] = -spring * (sx - ox * area)
            C[3, 3] = spring * (yy - 2 * oy * sy + oy**2 * area)
            C[4, 4] = spring * (xx - 2 * ox * sx + ox**2 * area)
            C[3, 4] = C[4, 3] = -spring * (xy - ox * sy - oy * sx + ox * oy * area)
        righting = lift * B[2] - weight * G[2]
        C[3, 3] += righting
        C[4, 4] += righting
        C[3, 5] = -lift * B[0] + weight * G[0]
        C[4, 5] = -lift * B[1] + weight * G[1]
        return C


def hydrostatics(points: Array, faces: NDArray) -> Hydrostatics:
    """Hydrostatics of a wetted surface: below z = 0, open at the waterplane if it reaches it.

    Volume and waterplane integrals by the divergence theorem on the wetted faces alone:
    `V = int z n_z dS`, `V x_B = int x z n_z dS`, `V z_B = int z^2 / 2 n_z dS`,
    `int_wp f(x, y) dA = -int f n_z dS`; all integrands are quadratic and integrated exactly.

    Args:
        points: (n, 3) m, waterline frame.
        faces: (m, 3), normals outwards; none: a dry hull.
    """
    corners = points[faces]
    a, b, c = np.moveaxis(corners, 1, 0)
    normal = 0.5 * np.cross(b - a, c - a)  # times area
    # the mean over the middles of the edges is exact for quadratics (Strang & Fix 1973)
    middles = 0.5 * (corners + np.roll(corners, -1, axis=1))

    def integral(values: Array) -> float:
        return float((values.mean(axis=1) * normal[:, 2]).sum())

    x, y, z = np.moveaxis(middles, -1, 0)
    volume = integral(z)
    center = np.zeros(3)
    if volume > 0:
        center = np.array([integral(x * z), integral(y * z), integral(z**2) / 2]) / volume
    area = -integral(np.ones_like(x))
    plane, moments = np.full(2, np.nan), np.zeros(3)
    if area > _CLOSED * np.abs(normal).sum():
        plane = np.array([-integral(x), -integral(y)]) / area
        moments = np.array([-integral(x * x), -integral(y * y), -integral(x * y)])
    else:
        area = 0.0
    size = np.ptp(points, axis=0) if len(points) else np.zeros(3)
    return Hydrostatics(
        volume,
        center,
        float(np.linalg.norm(normal, axis=1).sum()),
        area,
        plane,
        moments,
        float(-points[:, 2].min()) if len(points) else 0.0,
        float(size[0]),
        float(size[1]),
    )
