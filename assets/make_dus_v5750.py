"""Visual meshes of the survey USV: `python assets/make_dus_v5750.py`.

A hard-chine displacement hull with a flat bottom at 0.3 m draft and 1.5 m beam, like the published
box from the transom to x = 1.6 m; the flared bow overhangs the box (5.75 m over all). Everything
above the water line is free design.
"""

import numpy as np
import trimesh
from scipy.interpolate import PchipInterpolator
from shapes import (
    box,
    duct,
    foil,
    grid_surface,
    join,
    lettering,
    mirror,
    path,
    place,
    propeller,
    revolve,
    tube,
    write,
)

DRAFT, HALF_BEAM = 0.3, 0.75  # m
STERN, BOW = -2.5, 3.25  # m


def fair(x, points) -> float:
    """Smooth curve through `points` (x, value) by monotone cubics."""
    knots = np.array(points)
    return float(PchipInterpolator(knots[:, 0], knots[:, 1])(x))


def keel(x):
    return fair(x, [(-2.5, -DRAFT), (1.2, -DRAFT), (1.7, -0.28), (2.5, -0.10), (3.0, 0.32),
                    (BOW, 0.86)])  # fmt: skip


def chine(x):
    """Half breadth and height of the chine."""
    y = fair(x, [(-2.5, 0.68), (0.5, 0.70), (1.5, 0.60), (2.3, 0.34), (3.0, 0.08), (BOW, 0.006)])
    z = fair(x, [(-2.5, -0.24), (1.0, -0.24), (1.8, -0.14), (2.6, 0.14), (3.0, 0.42), (BOW, 0.87)])
    return y, z


def sheer(x):
    """Half breadth and height of the sheer."""
    y = fair(x, [(-2.5, 0.72), (-1.0, 0.75), (1.0, 0.75), (2.0, 0.62), (2.8, 0.32), (BOW, 0.02)])
    z = fair(x, [(-2.5, 0.52), (0.0, 0.54), (1.5, 0.66), (2.5, 0.82), (BOW, 0.96)])
    return y, z


def section(x) -> np.ndarray:
    """Ring of one frame: keel, chine, sheer, bulwark, deck; starboard mirrored."""
    (y_c, z_c), (y_s, z_s) = chine(x), sheer(x)
    side = np.linspace(0.0, 1.0, 9)[:, None]
    bottom = np.array([[0.0, keel(x)]]) + np.linspace(0, 1, 5)[:, None] * [y_c, z_c - keel(x)]
    lean = np.array([y_c, z_c]) + side[1:] * [y_s - y_c, z_s - z_c]
    flare = -0.04 * np.sin(np.pi * side[1:, 0]) * (x > 1.0) * min(1.0, (x - 1.0) / 1.0)
    lean[:, 0] = np.maximum(lean[:, 0] + flare, 0.004)
    thick = min(0.05, 0.5 * y_s)
    deck_height = z_s - 0.13
    inside = [[y_s - thick, z_s], [y_s - thick, deck_height], [0.0, deck_height + 0.01]]
    half = np.vstack([bottom, lean, inside])
    other = half[1:-1][::-1] * [-1, 1]
    ring = np.vstack([half, other])
    return np.column_stack([np.full(len(ring), x), ring])


def deckhouse(inset: float = 0.0, low: float = 0.38, high: float = 1.12):
    """Superstructure: raked front, tumblehome; `inset` shrinks it (negative: proud)."""
    rings = []
    for s in np.linspace(0.0, 1.0, 5):
        z = low + s * (high - low)
        rise = (z - 0.38) / (1.12 - 0.38)
        aft, fore = -0.95 + 0.10 * rise + inset, 1.25 - 0.55 * rise - inset
        half = 0.50 - 0.09 * rise - inset
        corner = 0.16
        ring = []
        for cx, cy, start in (
            (fore - corner, half - corner, 0),
            (aft + corner, half - corner, 90),
            (aft + corner, -half + corner, 180),
            (fore - corner, -half + corner, 270),
        ):
            for a in np.radians(np.linspace(start, start + 90, 7)):
                ring.append((cx + corner * np.cos(a), cy + corner * np.sin(a), z))
        rings.append(ring)
    return grid_surface(rings)


def cut(mesh: trimesh.Trimesh, low: float, high: float) -> trimesh.Trimesh:
    """The part of the surface between two heights."""
    vertices, faces = mesh.vertices, mesh.faces
    for height, sign in ((low, 1.0), (high, -1.0)):
        vertices, faces, _ = trimesh.intersections.slice_faces_plane(
            vertices, faces, plane_normal=[0, 0, sign], plane_origin=[0, 0, height]
        )
    return trimesh.Trimesh(vertices, faces)


def mast():
    """Arch over the deckhouse roof with crossbars and the pole."""
    legs = [path([(-0.75, s * 0.38, 1.08), (-0.62, s * 0.30, 1.75), (-0.60, s * 0.2, 1.86)], 0.025)
            for s in (1, -1)]  # fmt: skip
    return join(
        *legs,
        tube((-0.60, -0.2, 1.86), (-0.60, 0.2, 1.86), 0.025),
        tube((-0.66, -0.33, 1.52), (-0.66, 0.33, 1.52), 0.018),
        tube((-0.60, 0.0, 1.86), (-0.60, 0.0, 2.45), 0.018),
        tube((-0.60, -0.22, 2.12), (-0.60, 0.22, 2.12), 0.010),
    )


def rails():
    """Bow pulpit and side rails."""
    top = []
    for x in np.linspace(1.3, 3.05, 8):
        y, z = sheer(x)
        top.append((x, max(y - 0.06, 0.03), z + 0.26))
    port = join(
        path(top, 0.014),
        *(tube((x, y, z - 0.27), (x, y, z), 0.011) for x, y, z in top[::2]),
    )
    aft = []
    for x in np.linspace(-2.44, -1.15, 4):
        y, z = sheer(x)
        aft.append((x, y - 0.05, z + 0.26))
    side = join(path(aft, 0.014), *(tube((x, y, z - 0.27), (x, y, z), 0.011) for x, y, z in aft))
    stern = tube((-2.44, -0.67, 0.78), (-2.44, 0.67, 0.78), 0.014)
    front = tube(top[-1], (top[-1][0], -top[-1][1], top[-1][2]), 0.014)
    return join(port, mirror(port), side, mirror(side), stern, front)


def fittings():
    """Hatches, winch, bollards, air intakes, thruster pods' struts: the dark parts."""
    parts = [
        box((0.55, 0.60, 0.10), (-1.75, 0, 0.45)),
        tube((-2.15, -0.28, 0.60), (-2.15, 0.28, 0.60), 0.12),
        box((0.05, 0.04, 0.34), (-2.15, 0.32, 0.55)),
        box((0.05, 0.04, 0.34), (-2.15, -0.32, 0.55)),
        box((0.45, 0.42, 0.06), (1.75, 0, 0.60)),
        box((0.20, 0.14, 0.22), (-0.2, 0.22, 1.20)),
        box((0.20, 0.14, 0.22), (-0.2, -0.22, 1.20)),
    ]
    for x, y in ((2.55, 0.25), (-2.3, 0.58), (0.2, 0.66)):
        for side in (1, -1):
            foot = (x, side * y, sheer(x)[1] - 0.02)
            parts.append(tube(foot, np.add(foot, (0, 0, 0.09)), 0.025))
    fender = [(x, sheer(x)[0] + 0.012, sheer(x)[1] - 0.045) for x in np.linspace(-2.5, 3.15, 15)]
    strip = path(fender, 0.03, 8)
    return join(*parts, strip, mirror(strip))


def propulsion():
    """Two azimuthing pods under the transom and a skeg between them."""
    parts = []
    for side in (1, -1):
        y = side * 0.42
        pod = revolve(
            [(-0.14, 0.01), (-0.10, 0.035), (0.0, 0.05), (0.10, 0.045), (0.16, 0.005)], 24
        )
        parts += [
            place(pod, (-2.18, y, -0.47)),
            tube((-2.16, y, -0.47), (-2.16, y, -0.25), 0.03),
            place(duct(0.11, 0.10, 0.014), (-2.31, y, -0.47)),
        ]
    skeg = place(foil(0.9, 0.20, 0.05, taper=0.6), (-1.7, 0, -0.29), (1, 0, 0), -90)
    return join(*parts, skeg)


def main() -> None:
    x = np.concatenate([np.linspace(STERN, 1.0, 15), np.linspace(1.0, BOW, 28)[1:]])
    hull = grid_surface([section(xi) for xi in x])
    name = lettering("DUS V5750", 0.16)
    port = place(name, (-1.5, 0.735, 0.30))
    starboard = place(place(name, (0, 0, 0), (0, 0, 1), 180), (-1.5, -0.735, 0.30))
    window = deckhouse(-0.004, 0.78, 1.0)
    radar = revolve([(-0.05, 0.02), (-0.05, 0.16), (0.03, 0.17), (0.09, 0.12), (0.105, 0.001)], 28)
    dome = revolve([(-0.06, 0.07), (0.02, 0.075), (0.07, 0.05), (0.09, 0.001)], 24)
    whips = [((-0.60, 0.2, 2.12), 0.9), ((-0.60, -0.2, 2.12), 0.7), ((-0.85, 0.34, 1.08), 1.5)]
    propellers = [place(propeller(0.092, 4), (-2.31, s * 0.42, -0.47)) for s in (1, -1)]
    write(
        "dus_v5750",
        bottom=cut(hull, -1.0, 0.04),
        stripe=cut(hull, 0.04, 0.10),
        topsides=cut(hull, 0.10, 2.0),
        deckhouse=deckhouse(),
        windows=window,
        mast=join(mast(), rails()),
        radar=join(
            place(radar, (-0.35, 0, 1.62), (0, 1, 0), -90),
            place(dome, (0.15, 0.0, 1.18), (0, 1, 0), -90),
            place(dome, (-0.66, 0.33, 1.62), (0, 1, 0), -90),
            tube((-0.35, 0, 1.1), (-0.35, 0, 1.6), 0.03),
            tube((-0.60, -0.28, 2.30), (-0.60, 0.28, 2.30), 0.035),
        ),
        antennas=join(*(tube(p, np.add(p, (0, 0, h)), 0.007, 8) for p, h in whips)),
        fittings=fittings(),
        propulsion=propulsion(),
        propellers=join(*propellers),
        name=join(port, starboard),
    )


if __name__ == "__main__":
    main()
