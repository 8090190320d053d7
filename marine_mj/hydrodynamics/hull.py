"""Hull meshes: closed triangle meshes in body axes, read from files and checked."""

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import marine_mj.assets
from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.hydrodynamics import table as t_

#: A triangle whose area is a smaller share of the hull's is degenerate.
_SLIVER = 1e-12


@dataclass(frozen=True, eq=False)
class Hull:
    """A closed hull of triangles in body axes FLU about the body origin.

    Attributes:
        vertices: (n, 3) m.
        triangles: (m, 3) vertex numbers, counter-clockwise from outside.
        name: for messages.
    """

    vertices: Array
    triangles: NDArray[np.int64]
    name: str = "hull"

    def __post_init__(self) -> None:
        """Check: see `check_hull`."""
        check_hull(self)

    @classmethod
    def unlimited(cls, vertices: Array, triangles: NDArray[np.int64], name: str) -> "Hull":
        """A closed hull of any number of triangles, for all but the simulation.

        Raises:
            ModelError: see `check_hull`.
        """
        hull = cls.__new__(cls)
        values = {"vertices": vertices, "triangles": triangles, "name": name}
        for field, value in values.items():
            object.__setattr__(hull, field, value)
        check_hull(hull, limits=False)
        return hull

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
        """Lengths (3,) along the body axes, m."""
        return np.ptp(self.vertices, axis=0)


def check_hull(hull: Hull, limits: bool = True) -> None:
    """Raise unless the hull is closed, turned outwards and small enough for the kernel.

    Args:
        hull: what is checked.
        limits: False: of any size.

    Raises:
        ModelError: a vertex is not finite; a triangle has no area; an edge does not belong to
            two triangles; two neighbours face opposite sides; the normals point inwards; there are
            more than `MAX_HULL_TRIANGLES` triangles or `MAX_HULL_VERTICES` vertices.
    """
    name, triangles = f"hull mesh {hull.name!r}", hull.triangles
    if len(triangles) == 0 or not np.isfinite(hull.vertices).all():
        raise ModelError(
            f"{name} has {len(triangles)} triangles and "
            f"{int((~np.isfinite(hull.vertices)).sum())} coordinates that are not finite; needed "
            "is a closed surface of triangles"
        )
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    _, uses = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)
    wrong = int((uses != 2).sum())
    if wrong:
        raise ModelError(
            f"{name} is not closed: {wrong} of its {len(uses)} edges do not belong to exactly two "
            "triangles; close it, deck included (marine_mj.hydrodynamics.prepare_hull does)"
        )
    repeated = len(edges) - len(np.unique(edges, axis=0))
    if repeated:
        raise ModelError(
            f"{name} has {repeated} edges whose two triangles face opposite sides; turn the "
            "triangles so that all normals point outwards (prepare_hull does)"
        )
    areas = np.linalg.norm(hull.areas, axis=1)
    flat = int((areas <= _SLIVER * areas.sum()).sum())
    if flat:
        raise ModelError(f"{name} has {flat} triangles without area; remove them, or prepare_hull")
    if hull.volume <= 0:
        raise ModelError(
            f"{name} encloses a volume of {hull.volume:g} m3, allowed is > 0: its normals point "
            "inwards; reverse the order of the corners (prepare_hull does)"
        )
    counts = (len(triangles), len(hull.vertices))
    if limits and (counts[0] > t_.MAX_HULL_TRIANGLES or counts[1] > t_.MAX_HULL_VERTICES):
        raise ModelError(
            f"{name} has {counts[0]} triangles and {counts[1]} vertices, allowed are "
            f"{t_.MAX_HULL_TRIANGLES} and {t_.MAX_HULL_VERTICES} at most: coarsen it with "
            "marine_mj.hydrodynamics.prepare_hull (500 triangles are usually enough)"
        )


def hull_path(name: str) -> Path:
    """File of a hull mesh: a path, or a name in the package's assets.

    Raises:
        ModelError: there is no such file.
    """
    assets = Path(marine_mj.assets.__file__).parent
    for path in (Path(name), assets / name):
        if path.is_file():
            return path.resolve()
    raise ModelError(
        f"hull mesh {name!r} does not exist; it is looked up as a path, among the vehicle's assets "
        "and in marine_mj.assets"
    )


def read_hull(name: str) -> Hull:
    """Hull of a mesh file (OBJ, STL, PLY, ... as trimesh reads them), m, body axes FLU.

    Vertices at the same place are merged, triangles without corners of their own left out.

    Raises:
        ModelError: no such file, not a triangle mesh, or see `check_hull`.
    """
    path = hull_path(name)
    return _read(path, path.stat().st_mtime_ns)


@lru_cache(maxsize=16)
def _read(path: Path, changed: int) -> Hull:
    """Hull of a file as it was at the time `changed`."""
    import trimesh  # here: slow to import

    try:
        mesh: Any = trimesh.load(path, force="mesh", process=False)
        mesh.merge_vertices(merge_tex=True, merge_norm=True)
        triangles = np.asarray(mesh.faces, dtype=np.int64)
        vertices: Array = np.asarray(mesh.vertices, dtype=float)
    except Exception as error:  # whatever the reader of the format stumbles over
        raise ModelError(
            f"hull mesh {path.name!r} cannot be read as a triangle mesh ({error}); use OBJ, STL or "
            "PLY"
        ) from error
    return Hull(vertices, triangles, path.name)
