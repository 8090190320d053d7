"""Flat panels for the boundary element method: plain arrays, with mirror planes."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from marine_mj.frames import Array

#: Mirror planes by the axis that changes sign.
MIRRORS = {1: "xOz", 0: "yOz"}


@dataclass(frozen=True)
class Panels:
    """Quadrilaterals and triangles (their last corner twice), normals out of the body.

    Attributes:
        corners: (n, 4, 3) m.
        mirrors: axes (1 for y, 0 for x) across which the panels are to be mirrored.
    """

    corners: Array
    mirrors: tuple[int, ...] = ()

    def __add__(self, other: "Panels") -> "Panels":
        """Both together; the mirrors must be the same."""
        if self.mirrors != other.mirrors:
            raise ValueError(f"mirrors differ: {self.mirrors} and {other.mirrors}")
        return Panels(np.concatenate([self.corners, other.corners]), self.mirrors)

    def __len__(self) -> int:
        """Number of panels with the mirrored ones."""
        return len(self.corners) * 2 ** len(self.mirrors)

    def mirrored(self, *axes: int) -> "Panels":
        """The same panels as a half (or quarter) of a body."""
        return Panels(self.corners, axes)

    def whole(self) -> Array:
        """Corners (n, 4, 3) of all panels, mirrored ones written out."""
        corners = self.corners
        for axis in self.mirrors:
            sign = np.ones(3)
            sign[axis] = -1
            corners = np.concatenate([corners, (corners * sign)[:, [1, 0, 3, 2]]])
        return corners

    def triangles(self) -> tuple[Array, NDArray]:
        """Points (3 m, 3) and faces (m, 3) of the whole surface, each quadrilateral halved."""
        corners = self.whole()
        halves = np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]])
        cross = np.cross(halves[:, 1] - halves[:, 0], halves[:, 2] - halves[:, 0])
        size = np.linalg.norm(cross, axis=1)
        halves = halves[size > 1e-12 * size.max()]
        return halves.reshape(-1, 3), np.arange(3 * len(halves)).reshape(-1, 3)

    def radius(self) -> Array:
        """(n,) largest distance of a corner from the mean of the corners, m."""
        middle = self.corners.mean(axis=1, keepdims=True)
        return np.linalg.norm(self.corners - middle, axis=2).max(axis=1)


def surface(function: Callable[[Array, Array], Sequence[Array]], count_a: int, count_b: int):
    """Panels of `function(a, b) -> x, y, z` over the unit square; normals along d/da x d/db."""
    a, b = np.meshgrid(
        np.linspace(0, 1, count_a + 1), np.linspace(0, 1, count_b + 1), indexing="ij"
    )
    grid = np.stack(np.broadcast_arrays(*function(a, b)), axis=-1)
    corners = np.stack([grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]], axis=2)
    return Panels(corners.reshape(-1, 4, 3))


def rectangle(
    corner: ArrayLike, side_a: ArrayLike, side_b: ArrayLike, count_a: int, count_b: int
) -> Panels:
    """`count_a * count_b` equal panels with normal along `side_a x side_b`; lengths in m."""
    o, u, v = (np.asarray(value, dtype=float) for value in (corner, side_a, side_b))
    return surface(
        lambda a, b: np.moveaxis(o + a[..., None] * u + b[..., None] * v, -1, 0), count_a, count_b
    )


def from_triangles(points: Array, faces: NDArray, mirrors: tuple[int, ...] = ()) -> Panels:
    """Panels of a triangulated surface: points (n, 3) m and faces (m, 3)."""
    return Panels(points[faces][:, [0, 1, 2, 2]], mirrors)


def lid(hull: Panels, size: float) -> Panels | None:
    """Horizontal panels in the waterplane inside a hull, against irregular frequencies.

    Columns along x between the waterlines (any number of hulls and moonpools), about square and
    `size` m wide. None if the hull does not reach the surface.
    """
    edges = np.stack([hull.corners, np.roll(hull.corners, -1, axis=1)], axis=2).reshape(-1, 2, 3)
    scale = float(np.abs(hull.corners).max())
    edges = edges[(np.abs(edges[:, :, 2]) < 1e-7 * scale).all(axis=1)][:, :, :2]
    edges = edges[np.abs(edges[:, 0, 0] - edges[:, 1, 0]) > 1e-9 * scale]
    if len(edges) == 0:
        return None
    low, high = edges[..., 0].min(), edges[..., 0].max()
    borders = np.linspace(low, high, max(int(np.ceil((high - low) / size - 1e-9)), 1) + 1)

    def crossings(x: float) -> Array:
        """Waterline positions y at x, from starboard (or the mirror plane) to port."""
        first, last = edges[..., 0].min(axis=1), edges[..., 0].max(axis=1)
        hit = edges[(first <= x) & (x < last)]
        share = (x - hit[:, 0, 0]) / (hit[:, 1, 0] - hit[:, 0, 0])
        y = np.sort(hit[:, 0, 1] + share * (hit[:, 1, 1] - hit[:, 0, 1]))
        return np.concatenate([[0.0], y]) if 1 in hull.mirrors and len(y) % 2 else y

    cells = []
    margin = 1e-7 * (high - low)
    for x0, x1 in pairwise(borders.tolist()):
        aft, fore = crossings(x0 + margin), crossings(x1 - margin)
        if len(aft) != len(fore):
            continue  # a waterline begins inside this column
        for i in range(0, len(aft) - 1, 2):
            width = 0.5 * (aft[i + 1] - aft[i] + fore[i + 1] - fore[i])
            if width < 0.1 * size:
                continue
            count = max(int(np.ceil(width / size - 1e-9)), 1)
            y0 = np.linspace(aft[i], aft[i + 1], count + 1)
            y1 = np.linspace(fore[i], fore[i + 1], count + 1)
            cells += [
                [(x0, y0[j], 0), (x0, y0[j + 1], 0), (x1, y1[j + 1], 0), (x1, y1[j], 0)]
                for j in range(count)
            ]
    return Panels(np.array(cells, dtype=float), hull.mirrors) if cells else None


def is_mirrored(points: Array, axis: int) -> bool:
    """Whether every vertex has its mirror image across the plane, to 1e-4 of the extent."""
    from scipy.spatial import cKDTree  # here: slow to import

    image = np.array(points, dtype=float)
    image[:, axis] *= -1
    tolerance = 1e-4 * float(np.ptp(points, axis=0).max())
    return bool(cKDTree(points).query(image)[0].max() <= tolerance)
