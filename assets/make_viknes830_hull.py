"""Hull of the 8.3 m USV (Viknes 830): `python assets/make_viknes830_hull.py`.

Writes `assets/viknes830_hull.stl`, a watertight surface in m: x forward, y port, z up, origin on
the design water line above the centre of gravity (= centre of buoyancy, 2.837 m before the aft
perpendicular). Made from the main dimensions of the Viknes study (stations of its section 3.9); no
lines plan is published. Sections are a hard chine over a V bottom that ends in a keel wedge: the
chine sets the height of the volume's centre, the wedge gives the full draught.

                                   study     mesh
    length over all        m       8.300    8.300
    length, water line     m       7.200    7.200
    breadth                m       2.573    2.573
    draught                m       0.760    0.760
    volume                 m3      4.881    4.881
    waterplane area        m2     14.543   14.567
    LCB before AP          m       2.837    2.840
    LCF before AP          m       2.899    2.899   (the study's stations)
    KB                     m       0.562    0.562
    GM_T, VCG 1.012        m       0.971    0.973
    GM_L                   m       8.623    8.637
    C_b                            0.347    0.347

The wetted surface is 20.4 m2; the study's 22.4 m2 is an estimate, `B (L + 2 T)`. The wave database:

    marine-mj hydro viknes830_hull.stl -o assets/viknes830.nc --mass 5002.6 --panel 0.2 \\
        --center-of-gravity "0 0 0.252" --gyration "0.89 1.96 1.96" --roll-damping 0.07 \\
        --directions "$(seq -s ' ' 0 7.5 180)"
"""

from pathlib import Path

import numpy as np
import shapes
import trimesh
from scipy.interpolate import PchipInterpolator

from marine_mj.hydrodynamics.floating import afloat
from marine_mj.hydrodynamics.mesh import HullMesh

LENGTH, HALF_BEAM, DRAUGHT = 7.2, 1.2865, 0.76  # m, between perpendiculars, on the water line
ORIGIN = 2.837  # m before the aft perpendicular
KEEL_TO_MASS = 1.012  # m
#: Half breadth on the water line and draught over their largest, every tenth of the length.
STATIONS = np.linspace(0.0, 1.0, 11)
BREADTH = PchipInterpolator(STATIONS, (1, 1, 1, 1, 1, 1, 0.92, 0.74, 0.48, 0.21, 0.0))
DEPTH = PchipInterpolator(
    STATIONS, (0.98, 0.98, 0.98, 0.98, 0.97, 0.96, 0.96, 0.93, 0.88, 0.78, 0.63)
)
#: Chine: depth over local draught and breadth there; keel wedge: half breadth and depth.
CHINE, CHINE_BREADTH, WEDGE, WEDGE_DEPTH = 0.2115, 0.93, 0.08, 0.6762
FREEBOARD_AFT, FREEBOARD_BOW = 1.0, 1.4  # m
RAKE_BOW, RAKE_TRANSOM = 0.85, 0.25  # m, to 8.3 m over all


def section(s: float) -> np.ndarray:
    """Port half (n, 3) of the station at a share s of the length, keel first."""
    b, d = HALF_BEAM * float(BREADTH(s)), DRAUGHT * float(DEPTH(s)) / 0.98
    deck = FREEBOARD_AFT + (FREEBOARD_BOW - FREEBOARD_AFT) * s**2
    flare = 0.2 * min(s, 0.6) + 0.25 * (1 - s**6) * max(s - 0.6, 0.0)
    top = b + flare * (1 - s**8)
    knots = [
        (0.0, -d),
        (WEDGE * b, -WEDGE_DEPTH * d),
        (CHINE_BREADTH * b, -CHINE * d),
        (b, 0.0),
        (0.5 * (b + top), 0.45 * deck),
        (top, deck),
        (0.0, deck + 0.04 * top),
    ]
    counts = (2, 6, 2, 2, 2, 3)
    half = [knots[0]]
    for (y0, z0), (y1, z1), n in zip(knots[:-1], knots[1:], counts, strict=True):
        half += [(y0 + t * (y1 - y0), z0 + t * (z1 - z0)) for t in np.linspace(0, 1, n + 1)[1:]]
    points = np.array(half)
    above = np.clip(points[:, 1] / deck, 0.0, 1.0)
    bow = RAKE_BOW * above * s**6
    aft = RAKE_TRANSOM * np.minimum(2 * above, 1.0) * (1 - s) ** 12
    return np.column_stack([LENGTH * s - ORIGIN + bow - aft, points])


def hull() -> trimesh.Trimesh:
    """Closed hull, normals outwards: a port half with its part of the transom, mirrored."""
    s = np.unique(np.concatenate([np.linspace(0, 0.5, 6), np.linspace(0.5, 1.0, 16)]))
    half = np.array([section(v) for v in s])
    middle = np.array([half[0, :, 0].max(), 0.0, 0.0])
    fan = [(i + 1, i, half.shape[1]) for i in range(half.shape[1] - 1)]
    transom = trimesh.Trimesh(np.vstack([half[0], middle]), fan, process=False)
    port = shapes.join(shapes.grid_surface(half, close_ends=False), transom)
    # Rings are closed over the centre plane, where no wall belongs; the stem closes by itself.
    port.update_faces((np.abs(port.vertices[port.faces, 1]) > 1e-9).any(axis=1))
    mesh = shapes.join(port, shapes.mirror(port))
    mesh.merge_vertices()
    mesh.update_faces(mesh.nondegenerate_faces())
    mesh.remove_unreferenced_vertices()
    if mesh.volume < 0:
        mesh.invert()
    return mesh


def main() -> None:
    mesh = hull()
    still = afloat(HullMesh(mesh.vertices, mesh.faces, "viknes830_hull"))
    path = Path(__file__).with_name("viknes830_hull.stl")
    path.write_bytes(mesh.export(file_type="stl"))
    center = np.array([0.0, 0.0, KEEL_TO_MASS - DRAUGHT])
    over = still.metacentric_heights(center)
    area, B = still.waterplane_area, still.center_of_buoyancy
    print(f"{path.name}: {len(mesh.faces)} faces, {path.stat().st_size / 1e3:.0f} kB")
    for name, target, got in (
        ("length over all", 8.3, np.ptp(mesh.vertices[:, 0])),
        ("length on the water line", 7.2, still.length),
        ("breadth", 2.573, still.breadth),
        ("draught", 0.76, still.draught),
        ("volume", 4.8806, still.volume),
        ("waterplane area", 14.543, area),
        ("LCB before AP", 2.837, B[0] + ORIGIN),
        ("KB", 0.562, B[2] + DRAUGHT),
        ("LCF before AP", 2.899, still.waterplane_center[0] + ORIGIN),
        ("GM_T", 0.971, over[0]),
        ("GM_L", 8.623, over[1]),
        ("C_b", 0.347, still.volume / (7.2 * 2.573 * 0.76)),
    ):
        print(f"    {name:<26}{target:>9.3f}{got:>9.3f}{100 * (got / target - 1):>8.1f} %")


if __name__ == "__main__":
    main()
