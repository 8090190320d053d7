"""Hull meshes: closed surfaces of triangles, read from files and checked."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.hydrodynamics.repair import repaired, turned_outwards
from marine_mj.library import find_asset

#: Mesh files that trimesh reads without further packages.
SUFFIXES = (".stl", ".obj", ".ply", ".off", ".glb", ".gltf")
#: A triangle whose area is a smaller share of the hull's is degenerate.
_SLIVER = 1e-12


@dataclass(frozen=True, eq=False)
class HullMesh:
    """A closed surface of triangles with its normals outwards, m; checked when it is made.

    Attributes:
        vertices: (n, 3) m.
        triangles: (m, 3) vertex numbers, counter-clockwise from outside.
        name: for messages.

    Raises:
        ModelError: see `check_mesh`.
    """

    vertices: Array
    triangles: NDArray[np.int64]
    name: str = "hull"

    def __post_init__(self) -> None:
        """Check: see `check_mesh`."""
        check_mesh(self)

    @property
    def areas(self) -> Array:
        """Area times outward unit normal (m, 3) of every triangle, m2."""
        a, b, c = (self.vertices[self.triangles[:, i]] for i in range(3))
        return 0.5 * np.cross(b - a, c - a)

    @property
    def volume(self) -> float:
        """Enclosed volume, m3."""
        return float(np.sum(self.vertices[self.triangles[:, 0]] * self.areas) / 3)

    @property
    def extent(self) -> Array:
        """Lengths (3,) along the axes, m."""
        return np.ptp(self.vertices, axis=0)

    def moved(self, shift: Array) -> "HullMesh":
        """The same mesh moved by `shift` (3,), m."""
        return HullMesh(self.vertices + shift, self.triangles, self.name)


def check_mesh(mesh: HullMesh) -> None:
    """Raise unless a mesh is a closed, consistently wound surface with normals outwards.

    Raises:
        ModelError: there are no triangles; a vertex is not finite; triangles have no area; edges
            are open or have more than two triangles; neighbours are wound against each other; the
            normals point inwards. The message has the number and the place.
    """
    name, points, triangles = f"hull mesh {mesh.name!r}", mesh.vertices, mesh.triangles
    if len(triangles) == 0:
        raise ModelError(f"{name} has 0 triangles; needed is a closed surface of triangles")
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        raise ModelError(
            f"{name} has {len(bad)} vertices that are not finite, the first {points[bad[0]]}; "
            "correct the file"
        )
    areas = np.linalg.norm(mesh.areas, axis=1)
    flat = np.flatnonzero(areas <= _SLIVER * areas.sum())
    if len(flat):
        raise ModelError(
            f"{name} has {len(flat)} triangles of {len(triangles)} without area, the first "
            f"{_at(points[triangles[flat[0]]].mean(axis=0))}; remove them (--repair and "
            "prepare_hull do)"
        )
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    unique, where, count = np.unique(
        np.sort(edges, axis=1), axis=0, return_inverse=True, return_counts=True
    )
    middle = points[unique].mean(axis=1)
    if (count == 1).any():
        place = middle[count == 1]
        raise ModelError(
            f"{name} is not closed: {len(place)} open edges of {len(unique)}, the first "
            f"{_at(place[0])}, all between {_at(place.min(axis=0))} and {_at(place.max(axis=0))} "
            "(m); close the surface, deck included (prepare_hull does)"
        )
    if (count > 2).any():
        raise ModelError(
            f"{name} has {int((count > 2).sum())} edges with more than two triangles, the first "
            f"{_at(middle[count > 2][0])}; remove inner walls and doubled triangles"
        )
    forward = np.bincount(where.ravel(), edges[:, 0] < edges[:, 1], len(unique))
    if (forward != 1).any():
        raise ModelError(
            f"{name}: {int((forward != 1).sum())} of {len(unique)} edges have triangles wound "
            f"against each other, the first {_at(middle[forward != 1][0])}; turn them (--repair "
            "and prepare_hull do)"
        )
    if mesh.volume <= 0:
        raise ModelError(
            f"{name}: normals point inwards (enclosed volume {mesh.volume:.4g} m3, must be > 0); "
            "reverse the order of the corners (--repair and prepare_hull do)"
        )


def _at(point: Sequence[float] | Array) -> str:
    """A place as text."""
    return "(" + ", ".join(f"{v:.3g}" for v in point) + ")"


def find_mesh(name: str | Path) -> Path:
    """File of a hull mesh: a path, or a name in the package's assets.

    Raises:
        ModelError: there is no such file.
    """
    path = find_asset(name)
    if path is None:
        raise ModelError(
            f"hull mesh {str(name)!r} does not exist; it is looked up as a path, among the "
            "vehicle's assets and in marine_mj.assets"
        )
    return path


def read_mesh(name: str | Path, scale: float = 1.0, repair: bool = False) -> HullMesh:
    """Hull mesh of a file: STL, OBJ, PLY, ... as trimesh reads them.

    Vertices at the same place are merged.

    Args:
        name: see `find_mesh`.
        scale: metres per unit of the file (0.001 for mm).
        repair: turn inward and inconsistent triangles, drop those without area and doubled ones.

    Raises:
        ModelError: there is no such file, it cannot be read, the scale is not above 0, or see
            `check_mesh`.
    """
    if not (np.isfinite(scale) and scale > 0):
        raise ModelError(f"scale is {scale:g}; allowed is a finite number above 0 (m per unit)")
    path = find_mesh(name)
    return _read(path, path.stat().st_mtime_ns, float(scale), repair)


@lru_cache(maxsize=16)
def _read(path: Path, changed: int, scale: float, repair: bool) -> HullMesh:
    """Hull mesh of a file as it was at the time `changed`."""
    import trimesh  # here: slow to import

    try:
        loaded: Any = trimesh.load(path, force="mesh", process=False)
        mesh = trimesh.Trimesh(np.asarray(loaded.vertices) * scale, loaded.faces, process=False)
        mesh.merge_vertices()
    except Exception as error:  # whatever the reader of the format stumbles over
        raise ModelError(
            f"hull mesh {path.name!r} cannot be read as a triangle mesh ({error}); allowed are "
            f"{', '.join(SUFFIXES)}"
        ) from error
    vertices: Array = np.asarray(mesh.vertices, dtype=float)
    triangles = np.asarray(mesh.faces, dtype=np.int64)
    if repair:
        vertices, triangles = repaired(vertices, triangles)
        triangles = turned_outwards(vertices, triangles)
    return HullMesh(vertices, triangles, path.name)
