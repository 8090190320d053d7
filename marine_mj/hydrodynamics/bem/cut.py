"""Cutting a surface: the part below the water, the half on one side of a mirror plane."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from marine_mj.frames import Array


def cut(points: Array, faces: NDArray, axis: int, sign: int) -> tuple[Array, NDArray]:
    """Part of a triangulated surface where `sign * points[:, axis] >= 0`, open at the plane.

    Vertices closer to the plane than 1e-6 of the extent are moved onto it; faces that lie in it
    are dropped (the waterplane is no wetted surface). Triangles stay connected across cut edges.

    Args:
        points: (n, 3) m.
        faces: (m, 3) indices.
        axis: 0, 1 or 2, the plane's normal.
        sign: +1 or -1, the side that is kept.
    """
    points = np.array(points, dtype=float)
    extent = float(np.ptp(points, axis=0).max())
    points[np.abs(points[:, axis]) < 1e-6 * extent, axis] = 0.0
    side = sign * points[:, axis]
    inside = side[faces] >= 0
    whole = inside.all(axis=1) & (side[faces] > 0).any(axis=1)
    crossing = (side[faces] > 0).any(axis=1) & ~inside.all(axis=1)
    vertices = list(points)
    kept = faces[whole].tolist()
    known: dict[tuple[int, int], int] = {}

    def between(a: int, b: int) -> int:
        """Vertex where an edge meets the plane."""
        if side[a] == 0:
            return a
        if side[b] == 0:
            return b
        key = (min(a, b), max(a, b))
        if key not in known:
            share = side[key[0]] / (side[key[0]] - side[key[1]])
            point = points[key[0]] + share * (points[key[1]] - points[key[0]])
            point[axis] = 0.0
            known[key] = len(vertices)
            vertices.append(point)
        return known[key]

    for face in faces[crossing].tolist():
        ring: list[int] = []
        for a, b in zip(face, face[1:] + face[:1], strict=True):
            if side[a] >= 0:
                ring.append(a)
            if side[a] * side[b] < 0:
                ring.append(between(a, b))
        kept += [[ring[0], ring[i], ring[i + 1]] for i in range(1, len(ring) - 1)]
    found = np.array(kept, dtype=int).reshape(-1, 3)
    used, index = np.unique(found, return_inverse=True)
    return np.array(vertices).reshape(-1, 3)[used], index.reshape(-1, 3)


def is_mirrored(points: Array, axis: int) -> bool:
    """Whether every vertex has its mirror image across the plane, to 1e-4 of the extent."""
    image = np.array(points, dtype=float)
    image[:, axis] *= -1
    tolerance = 1e-4 * float(np.ptp(points, axis=0).max())
    return bool(cKDTree(points).query(image)[0].max() <= tolerance)
