"""Hull meshes: where they come from, and what makes them unfit for hydrodynamics."""

from collections import deque
from pathlib import Path

import mujoco
import numpy as np
import trimesh
from numpy.typing import NDArray

import marine_mj.assets
from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.hydrodynamics.coefficients import BodyCoefficients, read_coefficients
from marine_mj.library import find_model

#: Mesh files that trimesh reads without further packages.
SUFFIXES = (".stl", ".obj", ".ply", ".off", ".glb", ".gltf")


def find_hull(name: str) -> tuple[Path, BodyCoefficients | None]:
    """Mesh file of a hull, and the body of the vehicle it belongs to (None for a plain mesh).

    Args:
        name: a mesh file (a path, or a name in the package's assets), or a vehicle whose MJCF has
            `<text name="BODY.hull_mesh" data="FILE"/>`; FILE is a path, or lies in the vehicle's
            `assets` or in those of the package.

    Raises:
        ModelError: there is no such file or vehicle, or the vehicle names no hull mesh.
    """
    assets = Path(marine_mj.assets.__file__).parent
    if Path(name).suffix.lower() in SUFFIXES:
        return _first([Path(name), assets / name], f"hull mesh {name!r}"), None
    xml = find_model(name)
    bodies = [b for b in read_coefficients(mujoco.MjSpec.from_file(str(xml))) if b.hull_mesh]
    if len(bodies) != 1:
        raise ModelError(
            f"vehicle {name!r} names {len(bodies)} hull meshes, needed is 1: write "
            '<text name="BODY.hull_mesh" data="FILE"/> into <custom>, or give a mesh file'
        )
    file = str(bodies[0].hull_mesh)
    places = [Path(file), xml.parent / "assets" / file, assets / file]
    return _first(places, f"hull mesh {file!r} of {name!r}"), bodies[0]


def _first(places: list[Path], what: str) -> Path:
    """The first file that exists."""
    for place in places:
        if place.is_file():
            return place.resolve()
    raise ModelError(f"{what} does not exist; looked for {', '.join(map(str, places))}")


def read_mesh(file: str | Path, scale: float = 1.0, repair: bool = False) -> trimesh.Trimesh:
    """Closed surface in m, normals outwards, of a mesh file that passes `check_mesh`.

    Args:
        file: STL, OBJ, PLY ...
        scale: metres per unit of the file (0.001 for mm).
        repair: turn inward and inconsistent faces, drop faces without area.

    Raises:
        ModelError: the file cannot be read, the scale is not above 0, or see `check_mesh`.
    """
    if not (np.isfinite(scale) and scale > 0):
        raise ModelError(f"scale is {scale:g}; allowed is a finite number above 0 (m per unit)")
    try:
        mesh = trimesh.load(file, force="mesh", process=False)
    except Exception as error:
        raise ModelError(
            f"{Path(file).name} cannot be read as a mesh ({error}); allowed are {SUFFIXES}"
        ) from error
    if not isinstance(mesh, trimesh.Trimesh) or len(mesh.faces) == 0:
        raise ModelError(f"{Path(file).name} has no faces; needed is a closed surface")
    mesh = trimesh.Trimesh(np.asarray(mesh.vertices) * scale, mesh.faces, process=False)
    mesh.merge_vertices()
    if repair:
        keep = _areas(mesh) > 0
        keep &= (np.diff(np.sort(mesh.faces, axis=1), axis=1) > 0).all(axis=1)
        mesh.update_faces(keep)
        mesh.faces = _aligned(np.asarray(mesh.faces))
        if mesh.volume < 0:
            mesh.faces = mesh.faces[:, ::-1]
    check_mesh(mesh, Path(file).name)
    return mesh


def check_mesh(mesh: trimesh.Trimesh, name: str) -> None:
    """Raise unless a mesh is a closed, consistently wound surface with normals outwards.

    Raises:
        ModelError: a vertex is not finite; faces have no area; edges are open or have more than
            two faces; neighbours are wound against each other; all normals point inwards. The
            message has the number and the place.
    """
    points = np.asarray(mesh.vertices)
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        raise ModelError(f"{name} has {len(bad)} vertices that are not finite: {points[bad[0]]}")
    flat = np.flatnonzero(_areas(mesh) <= 1e-12 * mesh.area)
    if len(flat):
        raise ModelError(
            f"{name} has {len(flat)} degenerate faces of {len(mesh.faces)} (no area), the first "
            f"{_at(mesh.triangles_center[flat[0]])}; remove them (--repair drops them)"
        )
    edges = np.sort(mesh.edges, axis=1)
    unique, where, count = np.unique(edges, axis=0, return_inverse=True, return_counts=True)
    middle = points[unique].mean(axis=1)
    if (count == 1).any():
        place = middle[count == 1]
        raise ModelError(
            f"{name} is not watertight: {len(place)} open edges of {len(unique)}, the first "
            f"{_at(place[0])}, all between {_at(place.min(axis=0))} and {_at(place.max(axis=0))} "
            "(m); close the surface, deck included"
        )
    if (count > 2).any():
        raise ModelError(
            f"{name} has {int((count > 2).sum())} edges with more than two faces, the first "
            f"{_at(middle[count > 2][0])}; remove inner walls and doubled faces"
        )
    forward = np.bincount(where.ravel(), mesh.edges[:, 0] < mesh.edges[:, 1], len(unique))
    if (forward != 1).any():
        raise ModelError(
            f"{name}: {int((forward != 1).sum())} of {len(unique)} edges have faces wound against "
            f"each other, the first {_at(middle[forward != 1][0])}; --repair turns them"
        )
    if mesh.volume < 0:
        raise ModelError(
            f"{name}: normals point inwards (enclosed volume {mesh.volume:.4g} m3, must be > 0); "
            "--repair turns them"
        )


def _areas(mesh: trimesh.Trimesh) -> Array:
    """Areas of the faces, m2."""
    a, b, c = np.moveaxis(np.asarray(mesh.vertices)[mesh.faces], 1, 0)
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


def _at(point: Array) -> str:
    """A place as text."""
    return "(" + ", ".join(f"{v:.3g}" for v in point) + ")"


def _aligned(faces: NDArray) -> NDArray:
    """Faces wound like the first one of their connected part."""
    faces = np.array(faces)
    owners: dict[tuple[int, int], list[int]] = {}
    for index, (a, b, c) in enumerate(faces.tolist()):
        for u, v in ((a, b), (b, c), (c, a)):
            owners.setdefault((min(u, v), max(u, v)), []).append(index)
    seen = np.zeros(len(faces), dtype=bool)
    for start in range(len(faces)):
        if seen[start]:
            continue
        seen[start] = True
        queue = deque([start])
        while queue:
            a, b, c = faces[queue[0]].tolist()
            queue.popleft()
            for u, v in ((a, b), (b, c), (c, a)):
                for other in owners[min(u, v), max(u, v)]:
                    if seen[other]:
                        continue
                    seen[other] = True
                    p, q, r = faces[other].tolist()
                    if (u, v) in ((p, q), (q, r), (r, p)):
                        faces[other] = faces[other, ::-1]
                    queue.append(other)
    return faces
