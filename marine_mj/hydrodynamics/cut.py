"""Cutting a surface at a plane: the part below the water, the half on one side of a mirror."""

import numpy as np
from numpy.typing import NDArray

from marine_mj.frames import Array


def cut(
    points: Array, faces: NDArray, axis: int, sign: int, snap: float = 0.0
) -> tuple[Array, NDArray[np.int64]]:
    """Part of a triangulated surface where `sign * points[:, axis] >= 0`, open at the plane.

    Faces that lie in the plane are dropped (the waterplane is no wetted surface). Triangles stay
    connected across cut edges.

    Args:
        points: (n, 3) m.
        faces: (m, 3) indices.
        axis: 0, 1 or 2, the plane's normal.
        sign: +1 or -1, the side that is kept.
        snap: vertices closer to the plane than this share of the extent are moved onto it, so that
            no slivers remain.
    """
    points = np.array(points, dtype=float)
    if snap > 0:
        extent = float(np.ptp(points, axis=0).max())
        points[np.abs(points[:, axis]) < snap * extent, axis] = 0.0
    side = sign * points[:, axis]
    inside, beyond = side >= 0, side > 0
    whole = inside[faces].all(axis=1) & beyond[faces].any(axis=1)
    crossing = faces[beyond[faces].any(axis=1) & ~inside[faces].all(axis=1)]
    # corner, then crossing of the edge that starts there, around every face that is cut
    a, b = crossing, np.roll(crossing, -1, axis=1)
    is_cut = (beyond[a] & ~inside[b]) | (beyond[b] & ~inside[a])
    ends = np.sort(np.stack([a[is_cut], b[is_cut]], axis=1), axis=1)
    new, number = _numbered(ends)
    crossings = np.zeros_like(crossing)
    crossings[is_cut] = len(points) + number
    low, high = new.T
    share = (side[low] / (side[low] - side[high]))[:, None]
    between = points[low] + share * (points[high] - points[low])
    between[:, axis] = 0.0
    ring = np.stack([a, crossings], axis=2).reshape(-1, 6)
    kept = np.stack([inside[a], is_cut], axis=2).reshape(-1, 6)
    order = np.argsort(~kept, axis=1, kind="stable")
    ring = np.take_along_axis(ring, order, axis=1)
    fan = np.stack([ring[:, [0, 1, 2]], ring[:, [0, 2, 3]]], axis=1)
    exists = np.stack([np.ones(len(ring), dtype=bool), kept.sum(axis=1) == 4], axis=1)
    found = np.concatenate([faces[whole], fan[exists]]).astype(np.int64)
    used, index = np.unique(found, return_inverse=True)
    return np.concatenate([points, between])[used], index.reshape(-1, 3)


def _numbered(pairs: NDArray) -> tuple[NDArray, NDArray]:
    """Different pairs (k, 2) in the order in which they first come, and which one each is."""
    unique, first, which = np.unique(pairs, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty(len(order), dtype=np.int64)
    rank[order] = np.arange(len(order))
    return unique[order], rank[which.ravel()]
