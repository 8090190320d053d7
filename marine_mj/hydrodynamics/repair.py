"""Mending triangle meshes: doubled and degenerate triangles, triangles wound the wrong way."""

from collections import deque

import numpy as np
from numpy.typing import NDArray

from marine_mj.frames import Array


def repaired(vertices: Array, triangles: NDArray) -> tuple[Array, NDArray[np.int64]]:
    """Vertices and triangles wound alike, vertices merged, without area or doubled left out.

    The triangles of a connected part turn as the first of them does; see `turned_outwards`.

    Args:
        vertices: (n, 3) m.
        triangles: (m, 3) vertex numbers.
    """
    import trimesh  # here: slow to import

    mesh = trimesh.Trimesh(vertices, triangles, process=False)
    mesh.merge_vertices()
    mesh.update_faces(mesh.nondegenerate_faces() & mesh.unique_faces())
    mesh.remove_unreferenced_vertices()
    faces, _ = _aligned(np.asarray(mesh.faces, dtype=np.int64))
    return np.asarray(mesh.vertices, dtype=float), faces


def turned_outwards(vertices: Array, triangles: NDArray[np.int64]) -> NDArray[np.int64]:
    """Triangles (m, 3) with all normals outwards, of one or more closed surfaces.

    Args:
        vertices: (n, 3) m.
        triangles: (m, 3) vertex numbers.
    """
    faces, part = _aligned(triangles)
    if len(faces) == 0:
        return faces
    a, b, c = (vertices[corner] for corner in faces.T)
    inwards = np.bincount(part, np.sum(a * np.cross(b, c), axis=1)) < 0
    faces[inwards[part]] = faces[inwards[part], ::-1]
    return faces


def _aligned(triangles: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Triangles wound like the first one of their connected part, and the numbers of the parts."""
    faces = np.array(triangles)
    owners: dict[tuple[int, int], list[int]] = {}
    for index, (a, b, c) in enumerate(faces.tolist()):
        for u, v in ((a, b), (b, c), (c, a)):
            owners.setdefault((min(u, v), max(u, v)), []).append(index)
    part = np.full(len(faces), -1)
    for start in range(len(faces)):
        if part[start] >= 0:
            continue
        part[start] = part.max() + 1
        queue = deque([start])
        while queue:
            current = queue.popleft()
            a, b, c = faces[current].tolist()
            for u, v in ((a, b), (b, c), (c, a)):
                for other in owners[min(u, v), max(u, v)]:
                    if part[other] >= 0:
                        continue
                    part[other] = part[current]
                    p, q, r = faces[other].tolist()
                    if (u, v) in ((p, q), (q, r), (r, p)):
                        faces[other] = faces[other, ::-1]
                    queue.append(other)
    return faces, part
