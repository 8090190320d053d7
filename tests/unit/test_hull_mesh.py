"""Hull meshes: refusals, cutting, hydrostatics against closed forms, remeshing, panels."""

import mujoco
import numpy as np
import pytest
import trimesh

from marine_mj.errors import ModelError
from marine_mj.hydrodynamics.bem.convergence import Convergence, richardson
from marine_mj.hydrodynamics.bem.find import find_hull
from marine_mj.hydrodynamics.bem.panels import from_triangles, is_mirrored, lid, rectangle
from marine_mj.hydrodynamics.bem.remesh import remesh
from marine_mj.hydrodynamics.bem.rigid_body import rigid_body
from marine_mj.hydrodynamics.bem.settings import Settings
from marine_mj.hydrodynamics.bem.study import read_hull
from marine_mj.hydrodynamics.coefficients import read_coefficients
from marine_mj.hydrodynamics.cut import cut
from marine_mj.hydrodynamics.hydrostatics import hydrostatics
from marine_mj.hydrodynamics.mesh import HullMesh, read_mesh

LENGTH, BEAM, DRAUGHT = 5.0, 1.5, 0.3


def box(size=(LENGTH, BEAM, 1.3), center=(0.0, 0.0, 0.35)):
    return trimesh.creation.box(size, trimesh.transformations.translation_matrix(center))


def saved(mesh, path):
    mesh.export(path)
    return str(path)


@pytest.fixture
def box_file(tmp_path):
    return saved(box(), tmp_path / "box.stl")


def refused(vertices, faces, message):
    """Expect that a mesh is refused with a message that fits."""
    with pytest.raises(ModelError, match=message):
        HullMesh(np.asarray(vertices), np.asarray(faces))


def test_formats_give_the_same_hull(tmp_path):
    for kind in ("obj", "stl", "ply"):
        hull = read_mesh(saved(box(), tmp_path / f"box.{kind}"))
        assert len(hull.vertices) == 8
        # STL keeps single precision
        assert hull.volume == pytest.approx(LENGTH * BEAM * 1.3, rel=1e-6)


def test_open_edges_are_counted_and_placed():
    message = r"hull mesh 'hull' is not closed: 3 open edges of 18, .*deck included"
    refused(box().vertices, box().faces[1:], message)


def test_wall_inside_is_refused():
    faces = np.vstack([box().faces, box().faces[:1]])
    refused(box().vertices, faces, "3 edges with more than two triangles")


def test_degenerate_triangles_are_refused():
    faces = np.vstack([box().faces, [[0, 0, 1]]])
    refused(box().vertices, faces, r"1 triangles of 13 without area, .*--repair and prepare_hull")
    refused(0 * box().vertices, box().faces, "12 triangles of 12 without area")


def test_empty_and_not_finite():
    refused(box().vertices, box().faces[:0], "has 0 triangles; needed is a closed surface")
    vertices = np.array(box().vertices)
    vertices[3, 1] = np.nan
    refused(vertices, box().faces, "1 vertices that are not finite, the first .* nan")


def test_neighbours_that_face_opposite_sides():
    refused(box().vertices, turned(box(), 1).faces, "3 of 18 edges have triangles wound against")


def turned(mesh, count):
    """The mesh with the first faces wound the other way."""
    faces = np.array(mesh.faces)
    faces[:count] = faces[:count, ::-1]
    return trimesh.Trimesh(mesh.vertices, faces, process=False)


def test_winding_is_repaired_only_when_asked(tmp_path):
    inward = saved(turned(box(), 12), tmp_path / "inward.ply")
    with pytest.raises(ModelError, match=r"normals point inwards \(enclosed volume -9.75 m3"):
        read_mesh(inward)
    mixed = saved(turned(box(), 5), tmp_path / "mixed.ply")
    with pytest.raises(ModelError, match=r"of 18 edges have triangles wound against each other"):
        read_mesh(mixed)
    doubled = box()
    doubled.faces = np.vstack([doubled.faces, doubled.faces[:2], [[0, 0, 1]]])
    many = saved(doubled, tmp_path / "doubled.ply")
    with pytest.raises(ModelError, match="1 triangles of 15 without area"):
        read_mesh(many)
    for file in (inward, mixed, many):
        assert read_mesh(file, repair=True).volume == pytest.approx(LENGTH * BEAM * 1.3)


def test_files_that_are_no_hull(tmp_path):
    (tmp_path / "text.stl").write_text("hello")
    with pytest.raises(ModelError, match=r"'text.stl' (cannot be read as a|has 0) triangle"):
        read_mesh(tmp_path / "text.stl")
    with pytest.raises(ModelError, match="scale is -1; allowed is a finite number above 0"):
        read_mesh(tmp_path / "text.stl", scale=-1)
    with pytest.raises(ModelError, match=r"hull mesh 'none.stl' does not exist; it is looked"):
        find_hull("none.stl")
    with pytest.raises(ModelError, match="unknown vehicle 'titanic'"):
        find_hull("titanic")
    with pytest.raises(ModelError, match=r"'scout' names 0 hull meshes, needed is 1: write <text"):
        find_hull("scout")


VEHICLE = """<mujoco><worldbody><body name="hull"><freejoint/>
<inertial pos="0.1 0 0.2" mass="2306" diaginertia="1040 5412 5237"/></body></worldbody>
<custom><numeric name="hull.added_mass_flu" data="1 1 1 1 1 1"/>
<numeric name="hull.equilibrium_height" data="0.1"/>
<numeric name="hull.restoring_flu" data="0 0 1 1 1 0"/>
<text name="hull.hull_mesh" data="{}"/></custom></mujoco>"""


def test_vehicle_names_its_hull(tmp_path):
    folder = tmp_path / "boat"
    (folder / "assets").mkdir(parents=True)
    saved(box(center=(0, 0, 0.25)), folder / "assets" / "boat_hull.stl")
    (folder / "boat.xml").write_text(VEHICLE.format("boat_hull.stl"))
    hull = read_hull(str(folder))
    assert hull.source == "boat_hull.stl" and hull.name == "boat"
    # The origin is 0.1 m above the water, the box 0.3 m deep.
    np.testing.assert_allclose(hull.origin, [0, 0, 0.1])
    assert hull.still.draught == pytest.approx(0.3)
    np.testing.assert_allclose(hull.body.center_of_mass, [0.1, 0, 0.3])
    np.testing.assert_allclose(
        hull.rigid[3:, 3:].diagonal(), [1040 + 2306 * 0.04, 5412 + 2306 * 0.05, 5237 + 2306 * 0.01]
    )
    assert not hull.notes
    (folder / "boat.xml").write_text(VEHICLE.format("other.stl"))
    with pytest.raises(ModelError, match=r"hull mesh 'other.stl' does not exist; it is looked"):
        read_hull(str(folder))


def test_hull_of_a_body_without_coefficients():
    text = VEHICLE.format("hull.stl").replace("hull.hull_mesh", "deck.hull_mesh")
    with pytest.raises(ModelError, match=r"text 'deck.hull_mesh' belongs to the body 'deck'"):
        read_coefficients(mujoco.MjSpec.from_string(text))


def test_settings_that_are_not_allowed(box_file):
    for values, message in (
        ({"waterline": 0.0, "draught": 0.3}, "both waterline and draught"),
        ({"draught": -0.3}, "draught is -0.3; allowed is a number above 0"),
        ({"viscous": (1.0, 2.0)}, "viscous has 2 values; allowed are 6 or 36"),
        ({"omega": (1.0, -2.0)}, "two or more different frequencies above 0"),
        ({"directions": (float("nan"),)}, "directions is .* finite numbers"),
        ({"depth": 0.2}, "the draught 0.3 m reaches the bottom at 0.2 m"),
        ({"mass": 5000.0}, "mass is 5000 kg, but the hull displaces 2306.25 kg"),
        ({"inertia": (1, 2, 3), "gyration": (1, 2, 3)}, "both inertia and radii"),
        ({"inertia": (1, -2, 3)}, r"inertia = \[1, -2, 3\]; allowed are 3 numbers above 0"),
        ({"center_of_mass": (0.0, 1.0)}, r"center_of_mass is \[0.0, 1.0\]; allowed are 3 finite"),
        ({"draught": 1e-7}, "box.stl encloses 0 m3, must be > 0: give a larger --draught"),
        ({"waterline": -2.0}, "lies above the water: its lowest point is 1.7 m above"),
    ):
        with pytest.raises(ModelError, match=message):
            read_hull(box_file, Settings(**values))


def test_what_is_assumed_or_doubtful_is_said(box_file):
    notes = read_hull(box_file, Settings(center_of_mass=(0.3, 0, 0.2))).notes
    assert any("static trim of 2.6 deg is not in the mesh" in note for note in notes)
    notes = read_hull(box_file, Settings(center_of_mass=(0, 0, 0.6))).notes
    assert any("GM_T is -0.125 m: the hull is not stable" in note for note in notes)
    notes = read_hull(box_file, Settings(waterline=2.0)).notes
    assert any("1 m under water: taken as deeply submerged" in note for note in notes)


def test_box_hydrostatics_are_closed_forms(box_file):
    hull = read_hull(box_file, Settings(center_of_mass=(0, 0, 0.2)))
    still = hull.still
    volume = LENGTH * BEAM * DRAUGHT
    assert still.volume == pytest.approx(volume, rel=1e-6)  # STL has single precision
    assert still.waterplane_area == pytest.approx(LENGTH * BEAM, rel=1e-6)
    assert still.wetted_surface == pytest.approx(volume / DRAUGHT + 13 * DRAUGHT, rel=1e-6)
    np.testing.assert_allclose(still.center_of_buoyancy, [0, 0, -0.15], atol=1e-6)
    over = -0.15 - 0.2
    expected = BEAM**2 / 12 / DRAUGHT + over, LENGTH**2 / 12 / DRAUGHT + over
    np.testing.assert_allclose(still.metacentric_heights(np.array([0, 0, 0.2])), expected, 1e-5)
    weight = 1025 * 9.81 * volume
    wanted = [0, 0, weight / DRAUGHT, weight * expected[0], weight * expected[1], 0]
    np.testing.assert_allclose(np.diag(hull.stiffness), wanted, rtol=1e-5, atol=1e-3)
    assert hull.body.assumptions == (
        "mass: the displaced 2306.25 kg",
        "inertia: the closed mesh with uniform density",
    )


def test_stiffness_about_another_origin_is_that_of_the_moved_coordinates():
    """`C' = H^T C H` for the part that acts on displacements, weight included (trimmed box)."""
    mesh = box(center=(0.4, 0.1, 0.35))
    points, faces = cut(mesh.vertices, mesh.faces, 2, -1)
    still = hydrostatics(points, faces)
    # In equilibrium, so that no moment of net force is left.
    center = np.append(still.center_of_buoyancy[:2], 0.2)
    mass = 1025 * still.volume
    at = np.array([0.7, -0.3, 0.25])
    C, moved = (still.stiffness(1025, 9.81, mass, center, o) for o in (np.zeros(3), at))
    H = np.eye(6)
    x, y, z = at
    H[:3, 3:] = [[0, -z, y], [z, 0, -x], [-y, x, 0]]  # motion of the old origin
    np.testing.assert_allclose(moved, H.T @ C @ H, atol=1e-9 * C.max())


def test_cut_of_a_sphere_keeps_the_half_and_its_border_on_the_plane():
    mesh = trimesh.creation.icosphere(3)
    mesh.apply_translation([0, 0, 0.2])
    points, faces = cut(mesh.vertices, mesh.faces, 2, -1)
    half = trimesh.Trimesh(points, faces, process=False)
    edges = np.sort(half.edges, axis=1)
    unique, count = np.unique(edges, axis=0, return_counts=True)
    assert (count <= 2).all()
    assert np.abs(points[unique[count == 1]][..., 2]).max() == 0
    cap = np.pi * 0.8**2 * (1 - 0.8 / 3)
    assert hydrostatics(points, faces).volume == pytest.approx(cap, rel=0.02)  # 1.0 % of facets


def test_cut_snaps_only_what_is_close_and_only_if_asked():
    """Vertices 1 um above the plane: a sliver of its own, or part of the plane."""
    mesh = box(center=(0, 0, 1.3 / 2 + 1e-6))
    lowered = mesh.vertices - [0, 0, 2e-6]  # the bottom 1 um below
    assert hydrostatics(*cut(lowered, mesh.faces, 2, -1)).volume == pytest.approx(7.5e-6, rel=1e-6)
    assert len(cut(lowered, mesh.faces, 2, -1, snap=1e-6)[1]) == 0
    assert len(cut(mesh.vertices, mesh.faces, 2, 1, snap=1e-6)[1]) == 10  # no bottom


def test_mirror_planes_are_found():
    mesh = box(center=(1.0, 0.0, 0.0))
    assert is_mirrored(mesh.vertices, 1) and not is_mirrored(mesh.vertices, 0)


@pytest.mark.parametrize("size", [0.15, 0.4])
def test_remeshed_box_keeps_its_edges(size):
    points, faces = cut(*cut(box().vertices, box().faces, 2, -1), 1, 1)
    panels = from_triangles(*remesh(points, faces, size), (1,))
    still = hydrostatics(*panels.triangles())
    assert still.volume == pytest.approx(LENGTH * BEAM * DRAUGHT, rel=1e-9)
    assert still.wetted_surface == pytest.approx(LENGTH * BEAM + 13 * DRAUGHT, rel=1e-9)
    length = np.linalg.norm(panels.corners - np.roll(panels.corners, 1, axis=1), axis=2)
    assert length.max() < 1.6 * size  # 1.52: swapped diagonals
    assert np.median(length[length > 0]) == pytest.approx(size, rel=0.35)


def test_remesh_coarsens_a_fine_sphere_without_losing_its_shape():
    mesh = trimesh.creation.icosphere(4)  # 5120 faces
    points, faces = remesh(mesh.vertices, mesh.faces, 0.25)
    coarse = trimesh.Trimesh(points, faces, process=False)
    assert coarse.is_watertight and coarse.is_winding_consistent
    assert 350 < len(faces) < 700  # 474
    np.testing.assert_allclose(np.linalg.norm(points, axis=1), 1.0, atol=1e-9)
    assert coarse.volume == pytest.approx(mesh.volume, rel=0.03)  # 2.6 % of facets
    again = remesh(mesh.vertices, mesh.faces, 0.25)
    assert np.array_equal(points, again[0]) and np.array_equal(faces, again[1])


def test_lid_fills_the_waterplane_of_two_hulls_with_a_moonpool():
    """Catamaran: one box with a hole, another one beside it; only walls are needed."""

    def walls(x0, x1, y0, y1, outward):
        ring = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
        parts = []
        for (xa, ya), (xb, yb) in zip(ring, ring[1:] + ring[:1], strict=True):
            parts.append(rectangle((xa, ya, 0), (xb - xa, yb - ya, 0), (0, 0, -1), 4, 2))
        return parts

    parts = [*walls(-2, 2, 1, 2, 1), *walls(-0.5, 0.5, 1.25, 1.75, -1), *walls(-2, 2, -2, -1, 1)]
    hull = parts[0]
    for part in parts[1:]:
        hull = hull + part
    cover = lid(hull, 0.25)
    points, faces = cover.triangles()
    area = trimesh.Trimesh(points, faces, process=False)
    assert area.area == pytest.approx(4 + 4 - 0.5, rel=1e-6)
    assert (area.face_normals[:, 2] < 0).all()
    deep = rectangle((0, 0, -1), (1, 0, 0), (0, 1, 0), 2, 2)
    assert lid(deep, 0.25) is None


def test_uniform_box_is_its_own_assumed_inertia():
    mesh = HullMesh(box().vertices, box().faces)
    body = rigid_body(mesh, 2306.25, np.array([0, 0, -0.15]))
    expected = 2306.25 / 12 * np.array([1.5**2 + 1.3**2, 25 + 1.3**2, 25 + 1.5**2])
    np.testing.assert_allclose(np.diag(body.inertia), expected, rtol=1e-9)
    np.testing.assert_allclose(body.center_of_mass, [0, 0, 0.35], atol=1e-12)
    matrix = body.matrix(np.zeros(3))
    assert matrix[0, 4] == pytest.approx(2306.25 * 0.35)  # m z_G
    assert matrix[3, 3] == pytest.approx(expected[0] + 2306.25 * 0.35**2)


def test_richardson_finds_order_and_limit():
    sizes = np.array([0.4, 0.3, 0.2])
    order, limit = richardson(sizes, 7.0 + 2.0 * sizes**1.7)
    assert order == pytest.approx(1.7, rel=1e-9) and limit == pytest.approx(7.0, rel=1e-9)
    order, limit = richardson(sizes, np.array([1.0, 3.0, 2.0]))
    assert np.isnan(order) and limit == 2.0
    assert Convergence("A", sizes, np.array([1.0, 3.0, 2.0]), order, limit).uncertainty == 2.0
