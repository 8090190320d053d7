"""Hull mesh of the DUS V5750 box for panel hydrostatics: `python assets/make_dus_v5750_hull.py`.

Closed box 5 x 1.5 x 1.3 m, its bottom 0.3 m below the origin (mid-box on the still water line),
496 triangles with edges of about 0.3 m lengthwise: waves down to 3 m length are resolved.
"""

import numpy as np
import trimesh
from shapes import write

LENGTH, BEAM = 5.0, 1.5  # m
STATIONS = np.linspace(-0.5 * LENGTH, 0.5 * LENGTH, 17)
BUTTOCKS = np.linspace(-0.5 * BEAM, 0.5 * BEAM, 5)
WATER_LINES = np.array([-0.3, 0.0, 0.3, 1.0])  # m


def side(axis: int, place: float, outwards: int) -> trimesh.Trimesh:
    """One face of the box: normal along `outwards` times `axis`."""
    grids = [STATIONS, BUTTOCKS, WATER_LINES]
    first, second = (axis + 1) % 3, (axis + 2) % 3
    a, b = np.meshgrid(grids[first], grids[second], indexing="ij")
    points = np.empty((*a.shape, 3))
    points[..., axis], points[..., first], points[..., second] = place, a, b
    index = np.arange(a.size).reshape(a.shape)
    quads = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1)
    # diagonals alternate, so that the panels favour no side
    odd = np.add.outer(*(np.arange(n - 1) for n in a.shape)) % 2 == 1
    quads[odd] = np.roll(quads[odd], 1, axis=-1)
    quads = quads.reshape(-1, 4)[:, ::outwards]
    faces = np.vstack([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    return trimesh.Trimesh(points.reshape(-1, 3), faces, process=False)


def hull() -> trimesh.Trimesh:
    """The closed box."""
    grids = [STATIONS, BUTTOCKS, WATER_LINES]
    sides = [side(axis, grids[axis][end], -(2 * end + 1)) for axis in range(3) for end in (0, -1)]
    mesh = trimesh.util.concatenate(sides)
    mesh.merge_vertices()
    return mesh


if __name__ == "__main__":
    write("dus_v5750", hull=hull())
