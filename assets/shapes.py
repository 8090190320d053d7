"""Smooth visual meshes from a few numbers: surfaces of revolution, lofts, ducts, propellers.

Shared by the `make_<model>.py` scripts. Lengths in m, axes x forward, y port, z up.
"""

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import ArrayLike

MODELS = Path(__file__).resolve().parents[1] / "models"


def grid_surface(points: ArrayLike, close_ends: bool = True) -> trimesh.Trimesh:
    """Skin over rings `points` (rings, points per ring, 3), each ring closed on itself."""
    points = np.asarray(points, dtype=float)
    rings, count, _ = points.shape
    index = np.arange(rings * count).reshape(rings, count)
    after = np.roll(index, -1, axis=1)
    quads = np.stack([index[:-1], after[:-1], after[1:], index[1:]], axis=-1).reshape(-1, 4)
    faces = [quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]
    vertices = points.reshape(-1, 3)
    if close_ends:
        vertices = np.vstack([vertices, points[0].mean(axis=0), points[-1].mean(axis=0)])
        first, last = rings * count, rings * count + 1
        faces.append(np.stack([after[0], index[0], np.full(count, first)], axis=-1))
        faces.append(np.stack([index[-1], after[-1], np.full(count, last)], axis=-1))
    mesh = trimesh.Trimesh(vertices, np.vstack(faces), process=False)
    mesh.merge_vertices()
    mesh.update_faces(mesh.nondegenerate_faces())
    if close_ends and mesh.volume < 0:
        mesh.invert()
    return mesh


def revolve(profile: ArrayLike, segments: int = 48, close_ends: bool = True) -> trimesh.Trimesh:
    """Surface of revolution about x of `profile` (n, 2): x and radius."""
    x, radius = np.asarray(profile, dtype=float).T
    angle = np.linspace(0.0, 2 * np.pi, segments, endpoint=False)
    points = np.stack(
        [
            np.broadcast_to(x[:, None], (len(x), segments)),
            radius[:, None] * np.cos(angle),
            radius[:, None] * np.sin(angle),
        ],
        axis=-1,
    )
    return grid_surface(points, close_ends)


def duct(radius: float, length: float, thickness: float, segments: int = 40) -> trimesh.Trimesh:
    """Thruster nozzle along x: outer `radius`, rounded lip in front."""
    inner, half = radius - thickness, 0.5 * length
    profile = [
        (half, inner + 0.35 * thickness),
        (half - 0.15 * length, inner),
        (-half, inner),
        (-half, inner + 0.25 * thickness),
        (half - 0.3 * length, radius),
        (half - 0.08 * length, radius),
        (half, inner + 0.35 * thickness),
    ]
    return revolve(profile, segments, close_ends=False)


def propeller(radius: float, blades: int = 3, hub: float = 0.3, pitch: float = 0.9):
    """Propeller about x: ogival hub and twisted blades of `pitch` over diameter."""
    hub_radius = hub * radius
    s = np.linspace(0.0, 1.0, 7)
    nose = hub_radius * np.sqrt(1 - s[::-1] ** 2)
    x = np.concatenate([[-1.3 * hub_radius], np.linspace(-1.2, 0.4, 3) * hub_radius])
    profile = np.vstack(
        [
            np.column_stack([x, [0.01 * hub_radius, *(0.95 * hub_radius,) * 3]]),
            np.column_stack([hub_radius * (0.5 + 1.1 * s[:-1]), nose[::-1][:-1]]),
            [[hub_radius * 1.6, 0.001 * hub_radius]],
        ]
    )
    parts = [revolve(profile, 20)]
    sections = []
    for fraction in np.linspace(hub * 0.8, 1.0, 6):
        r = fraction * radius
        angle = np.arctan2(pitch * 2 * radius, 2 * np.pi * r)
        chord = radius * (0.55 - 0.15 * fraction) * (1.0 if fraction < 0.99 else 0.5)
        thick = radius * 0.05 * (1.2 - fraction)
        along = np.array([-0.5, 0.0, 0.5, 0.0]) * chord
        across = np.array([0.0, 0.5, 0.0, -0.5]) * thick
        axial = along * np.sin(angle) + across * np.cos(angle)
        tangential = along * np.cos(angle) - across * np.sin(angle)
        theta = tangential / r
        sections.append(np.column_stack([axial, r * np.sin(theta), r * np.cos(theta)]))
    blade = grid_surface(sections)
    for i in range(blades):
        turn = trimesh.transformations.rotation_matrix(2 * np.pi * i / blades, [1, 0, 0])
        parts.append(blade.copy().apply_transform(turn))
    return join(*parts)


def foil(chord: float, span: float, thickness: float, taper: float = 1.0) -> trimesh.Trimesh:
    """Symmetric foil: chord along x (leading edge at +chord/2), span along y from 0, z thick."""
    s = 0.5 * (1 - np.cos(np.linspace(0.0, np.pi, 13)))
    half = 2.6 * (0.2969 * np.sqrt(s) - 0.126 * s - 0.3516 * s**2 + 0.2843 * s**3 - 0.1015 * s**4)
    half *= 0.5 * thickness / half.max()
    x = np.concatenate([0.5 - s, (0.5 - s)[-2:0:-1]])
    z = np.concatenate([half, -half[-2:0:-1]])
    rings = [
        np.column_stack([chord * scale * x, np.full(len(x), span * f), scale * z])
        for f, scale in ((0.0, 1.0), (0.94, taper), (0.985, 0.97 * taper), (1.0, 0.88 * taper))
    ]
    return grid_surface(rings)


def box(size: ArrayLike, position: ArrayLike = (0, 0, 0)) -> trimesh.Trimesh:
    """Box of full edge lengths `size`."""
    return trimesh.creation.box(
        size, trimesh.transformations.translation_matrix(np.asarray(position, dtype=float))
    )


def tube(start: ArrayLike, end: ArrayLike, radius: float, segments: int = 14) -> trimesh.Trimesh:
    """Round bar between two points."""
    return trimesh.creation.cylinder(radius=radius, segment=[start, end], sections=segments)


def path(points: ArrayLike, radius: float, segments: int = 8) -> trimesh.Trimesh:
    """Bent round bar through `points` (n, 3), with balls in the joints."""
    points = np.asarray(points, dtype=float)
    parts = [tube(a, b, radius, segments) for a, b in pairwise(points)]
    for point in points:
        ball = trimesh.creation.icosphere(subdivisions=int(segments > 6), radius=radius)
        parts.append(ball.apply_translation(point))
    return join(*parts)


def place(mesh: trimesh.Trimesh, position=(0, 0, 0), axis=None, angle_deg: float = 0.0):
    """Copy of `mesh`, turned about `axis` through the origin and then moved."""
    mesh = mesh.copy()
    if axis is not None:
        matrix = trimesh.transformations.rotation_matrix(np.radians(angle_deg), axis)
        mesh.apply_transform(matrix)
    return mesh.apply_translation(position)


def mirror(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """The other side: y -> -y, normals outwards."""
    mesh = mesh.copy()
    mesh.vertices[:, 1] *= -1
    mesh.invert()
    return mesh


def ball(position: ArrayLike, radius: float = 0.022) -> trimesh.Trimesh:
    """Lamp at a point."""
    return trimesh.creation.icosphere(subdivisions=2, radius=radius).apply_translation(position)


def both(build: Callable[[int], trimesh.Trimesh]) -> trimesh.Trimesh:
    """Port and starboard part of `build(side)`, side 1 and -1."""
    return join(build(1), build(-1))


def join(*meshes: trimesh.Trimesh) -> trimesh.Trimesh:
    """One mesh of all."""
    return trimesh.util.concatenate(meshes)


#: Strokes of the letters needed in names, on a 4 x 6 grid (width x height).
LETTERS = {
    "A": [[(0, 0), (2, 6), (4, 0)], [(0.8, 2.2), (3.2, 2.2)]],
    "B": [[(0, 0), (0, 6), (3, 6), (4, 5), (4, 4), (3, 3.2), (4, 2), (4, 1), (3, 0), (0, 0)]],
    "C": [[(4, 5), (3, 6), (1, 6), (0, 5), (0, 1), (1, 0), (3, 0), (4, 1)]],
    "D": [[(0, 0), (0, 6), (2.6, 6), (4, 4.6), (4, 1.4), (2.6, 0), (0, 0)]],
    "E": [[(4, 6), (0, 6), (0, 0), (4, 0)], [(0, 3), (3, 3)]],
    "L": [[(0, 6), (0, 0), (4, 0)]],
    "O": [[(1, 0), (0, 1), (0, 5), (1, 6), (3, 6), (4, 5), (4, 1), (3, 0), (1, 0)]],
    "R": [[(0, 0), (0, 6), (3, 6), (4, 5), (4, 4), (3, 3), (0, 3)], [(2, 3), (4, 0)]],
    "S": [[(4, 5), (3, 6), (1, 6), (0, 5), (0, 4), (4, 2), (4, 1), (3, 0), (1, 0), (0, 1)]],
    "T": [[(0, 6), (4, 6)], [(2, 6), (2, 0)]],
    "U": [[(0, 6), (0, 1), (1, 0), (3, 0), (4, 1), (4, 6)]],
    "V": [[(0, 6), (2, 0), (4, 6)]],
    "0": [[(1, 0), (0, 1), (0, 5), (1, 6), (3, 6), (4, 5), (4, 1), (3, 0), (1, 0)]],
    "2": [[(0, 5), (1, 6), (3, 6), (4, 5), (4, 4), (0, 0), (4, 0)]],
    "5": [[(4, 6), (0, 6), (0, 3.5), (3, 3.5), (4, 2.6), (4, 1), (3, 0), (0, 0)]],
    "7": [[(0, 6), (4, 6), (1.4, 0)]],
}


def lettering(text: str, height: float, weight: float = 0.14) -> trimesh.Trimesh:
    """Raised letters in the x-z plane, reading along -x when seen from port (+y), centred."""
    scale = height / 6
    parts, cursor = [], 0.0
    for character in text:
        for stroke in LETTERS.get(character, []):
            points = [(-(cursor + a) * scale, 0.0, b * scale) for a, b in stroke]
            parts.append(path(points, 0.5 * weight * height, 4))
        cursor += 5.4 if character != " " else 3.0
    mesh = join(*parts)
    return mesh.apply_translation(-mesh.bounds.mean(axis=0))


def write(model: str, **meshes: trimesh.Trimesh) -> None:
    """Save each mesh as `models/<model>/assets/<name>.obj`."""
    folder = MODELS / model / "assets"
    folder.mkdir(parents=True, exist_ok=True)
    for name, mesh in meshes.items():
        text = trimesh.exchange.obj.export_obj(
            mesh, include_normals=False, include_color=False, include_texture=False, digits=4
        )
        (folder / f"{name}.obj").write_text(text + "\n")
        print(f"{model}/{name}.obj: {len(mesh.faces)} faces, {len(text) / 1e3:.0f} kB")
