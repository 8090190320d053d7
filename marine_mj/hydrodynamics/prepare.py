"""Making a hull mesh that the panels can use: closed, turned outwards, coarse."""

import heapq
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.hydrodynamics.mesh import HullMesh
from marine_mj.hydrodynamics.repair import repaired, turned_outwards

#: Weight of the distance to the old vertices beside that to the old planes: without it flat parts
#: would become a few huge triangles, too coarse for waves.
_SPREAD = 3e-3


def prepare_hull(
    vertices: ArrayLike, triangles: ArrayLike, count: int = 500, name: str = "hull"
) -> HullMesh:
    """Closed hull of at most `count` triangles with the volume of the given mesh.

    Vertices at the same place are merged, degenerate and double triangles left out, open borders
    (a missing deck) closed by a fan from their middle, exact for plane borders, normals turned
    outwards. Edges are then collapsed in the order of the quadric error (Garland & Heckbert 1997),
    and the result is scaled about its centre to keep the volume.

    Args:
        vertices: (n, 3) m, body axes FLU.
        triangles: (m, 3) vertex numbers.
        count: largest number of triangles.
        name: for messages.

    Raises:
        ModelError: the mesh has no triangles, cannot be closed (more than two triangles at an
            edge), or cannot be made as coarse as asked for.
    """
    x, faces = _closed(np.asarray(vertices, dtype=float), np.asarray(triangles), name)
    fine = HullMesh(x, faces, name)
    if len(faces) > count:
        x, faces = _collapse(x, faces, count)
        if len(faces) > count:
            raise ModelError(
                f"hull mesh {name!r} cannot be made coarser than {len(faces)} triangles without "
                f"changing its topology, asked for are {count}: allow more"
            )
    coarse = HullMesh(x, faces, name)
    center = x.mean(axis=0)
    return HullMesh(center + (x - center) * np.cbrt(fine.volume / coarse.volume), faces, name)


def _closed(x: Array, triangles: NDArray, name: str) -> tuple[Array, NDArray[np.int64]]:
    """Merged, consistently turned and closed mesh."""
    x, faces = repaired(x, triangles)
    if len(faces) == 0:
        raise ModelError(f"hull mesh {name!r} has no triangles with an area; needed is a surface")
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    _, place, uses = np.unique(
        np.sort(edges, axis=1), axis=0, return_inverse=True, return_counts=True
    )
    open_edges = edges[uses[place.ravel()] == 1]
    if len(open_edges):
        following = {int(a): int(b) for a, b in open_edges}
        caps: list[tuple[int, int, int]] = []
        middles: list[Array] = []
        while following:
            loop = [next(iter(following))]
            while loop[-1] in following:
                loop.append(following.pop(loop[-1]))
            border = np.array(loop[:-1])
            middle = len(x) + len(middles)
            middles.append(x[border].mean(axis=0))
            caps += [(b, a, middle) for a, b in pairwise(loop)]
        x, faces = np.vstack([x, middles]), np.vstack([faces, caps])
    return x, turned_outwards(x, faces)


def _quadrics(x: Array, faces: NDArray) -> Array:
    """Error (n, 4, 4) of moving each vertex: from the planes of its triangles, and from itself."""
    a, b, c = (x[faces[:, i]] for i in range(3))
    normal = np.cross(b - a, c - a)
    area = np.linalg.norm(normal, axis=1)
    normal /= np.maximum(area, 1e-300)[:, None]
    plane = np.column_stack([normal, -np.sum(normal * a, axis=1)])
    Q = np.zeros((len(x), 4, 4))
    weight = np.zeros(len(x))
    for corner in faces.T:
        np.add.at(Q, corner, area[:, None, None] * plane[:, :, None] * plane[:, None, :])
        np.add.at(weight, corner, _SPREAD * area)
    Q[:, [0, 1, 2], [0, 1, 2]] += weight[:, None]
    Q[:, :3, 3] -= weight[:, None] * x
    Q[:, 3, :3] -= weight[:, None] * x
    Q[:, 3, 3] += weight * np.sum(x * x, axis=1)
    return Q


def _collapse(x: Array, faces: NDArray, count: int) -> tuple[Array, NDArray[np.int64]]:
    """Edges collapsed, cheapest first, until `count` triangles are left."""
    x, Q = x.copy(), _quadrics(x, faces)
    corners = [tuple(map(int, face)) for face in faces]
    around: list[set[int]] = [set() for _ in x]
    for number, face in enumerate(corners):
        for vertex in face:
            around[vertex].add(number)
    version = [0] * len(x)
    alive, queue = len(corners), list[tuple]()

    def neighbours(vertex: int) -> set[int]:
        return {v for number in around[vertex] for v in corners[number]} - {vertex}

    def offer(i: int, j: int) -> None:
        q = Q[i] + Q[j]
        place = np.linalg.solve(q[:3, :3], -q[:3, 3])
        error = float(place @ q[:3, :3] @ place + 2 * q[:3, 3] @ place + q[3, 3])
        heapq.heappush(queue, (error, i, j, version[i], version[j], tuple(place)))

    def turns_over(i: int, j: int, place: Array) -> bool:
        """Whether a triangle that stays would be turned over or flattened."""
        for number in around[i] ^ around[j]:
            old = [x[v] for v in corners[number]]
            new = [place if v in (i, j) else x[v] for v in corners[number]]
            before = np.cross(old[1] - old[0], old[2] - old[0])
            after = np.cross(new[1] - new[0], new[2] - new[0])
            if before @ after <= 0.2 * np.linalg.norm(before) * np.linalg.norm(after):
                return True
        return False

    for i in range(len(x)):
        for j in neighbours(i):
            if i < j:
                offer(i, j)
    while alive > count and queue:
        _, i, j, version_i, version_j, place = heapq.heappop(queue)
        if version[i] != version_i or version[j] != version_j:
            continue
        first, second = neighbours(i), neighbours(j)
        # only two common neighbours: otherwise the surface would touch itself; a third one that is
        # not common: a tetrahedron would become flat
        if len(first & second) != 2 or len(first | second) < 5:
            continue
        if turns_over(i, j, np.array(place)):
            continue
        for number in around[i] & around[j]:
            for vertex in corners[number]:
                around[vertex].discard(number)
            alive -= 1
        for number in around[j]:
            corners[number] = tuple(i if v == j else v for v in corners[number])
        around[i] |= around[j]
        around[j] = set()
        x[i], Q[i] = place, Q[i] + Q[j]
        version[i] += 1
        version[j] += 1
        for other in neighbours(i):
            offer(*sorted((i, other)))
    kept = sorted(set().union(*around))
    left = np.array([corners[number] for number in kept], dtype=np.int64)
    used, numbers = np.unique(left, return_inverse=True)
    return x[used], numbers.reshape(left.shape)
