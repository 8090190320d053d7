"""Hulls afloat on panels: choice of hydrostatics, poses, equilibrium, preparation of meshes."""

import numpy as np
import pytest
import trimesh
from conftest import model_error, one_body

import marine_mj
from marine_mj.hydrodynamics import HullMesh, check_model, prepare_hull
from marine_mj.hydrodynamics.floating import (
    Pose,
    afloat,
    equilibrium,
    floating_height,
    righting_arms,
)
from marine_mj.scenario import Scenario
from marine_mj.scene import compile_scene

BOX = trimesh.creation.box((2.0, 1.0, 0.6))
X, TRIANGLES = np.asarray(BOX.vertices), np.asarray(BOX.faces, dtype=np.int64)


def floating(file, numerics="", settings=None, **options):
    """Model of a body with a hull mesh."""
    xml = one_body(
        added_mass=np.ones(6),
        numerics=f'<text name="a.hull_mesh" data="{file}"/>{numerics}',
        mass=600.0,
        inertia="60 200 250",
        **options,
    )
    return marine_mj.load_xml(xml, settings=settings)


def test_file_is_found_beside_the_vehicle(tmp_path, monkeypatch):
    """Like meshes: in the folder that the MJCF names."""
    folder = tmp_path / "boat"
    (folder / "assets").mkdir(parents=True)
    BOX.export(folder / "assets" / "box.obj")
    xml = one_body(
        added_mass=np.ones(6),
        numerics='<text name="a.hull_mesh" data="box.obj"/>',
        mass=600.0,
        inertia="60 200 250",
        center="0 0 -0.05",
        pos="0 0 0",
    ).replace("<mujoco>", '<mujoco model="boat"><compiler meshdir="assets"/>')
    (folder / "boat.xml").write_text(xml)
    monkeypatch.chdir(tmp_path)
    rows = {r.quantity: r for r in check_model(str(folder))}
    assert rows["panels of the hull mesh"].value == 12
    draught = 600 / 1025 / 2.0
    assert rows["draught, panels"].value == pytest.approx(draught, rel=1e-9)
    # closed form of a box: KB + BM - KG
    GM = draught / 2 + 1 / 12 / draught - 0.25
    assert rows["GM_T, panels"].value == pytest.approx(GM, rel=1e-9)
    assert rows["step with panels in 100 waves, measured"].value > 0
    assert [name for name, r in rows.items() if r.ok is False] == []


def test_scenario_chooses_the_hydrostatics():
    scenario = Scenario.load("docking_demo")
    assert scenario.vehicles["usv"].hydrostatics is None
    linear = compile_scene(scenario, visual=False).model
    changed = scenario.with_values({"vehicles.usv.hydrostatics": "panels"})
    panels = compile_scene(changed, visual=False).model
    # the mesh stands in the table: 250 vertices and 496 triangles
    assert panels.nnumericdata > linear.nnumericdata + 496 * 6


# Refusals


def test_missing_file():
    with model_error("hull mesh 'no_such.obj' does not exist", "vehicle's assets"):
        floating("no_such.obj")


def test_unreadable_file(tmp_path):
    path = tmp_path / "broken.stl"
    path.write_bytes(b"not a mesh")
    with model_error("hull mesh 'broken.stl'"):
        floating(path)


def test_mesh_of_an_unknown_body():
    xml = one_body(added_mass=np.ones(6), numerics='<text name="b.hull_mesh" data="x.obj"/>')
    with model_error("'b.hull_mesh'", "['a']"):
        marine_mj.load_xml(xml)


def test_too_many_triangles_for_panels(tmp_path):
    trimesh.creation.icosphere(4).export(tmp_path / "fine.obj")
    with model_error("5120 triangles and 2562 vertices", "2048 and 1024", "prepare_hull"):
        floating(tmp_path / "fine.obj")


def test_panels_without_a_mesh():
    with model_error("hydrostatics 'panels' of 'a' needs a hull mesh", "a.hull_mesh"):
        marine_mj.load_xml(
            one_body(added_mass=np.ones(6)), settings={"a": {"hydrostatics": "panels"}}
        )


def test_unknown_hydrostatics():
    with model_error("hydrostatics is 'nonlinear', allowed are linear, panels"):
        marine_mj.load_xml(
            one_body(added_mass=np.ones(6)), settings={"a": {"hydrostatics": "nonlinear"}}
        )


def test_panels_with_constant_buoyancy(tmp_path):
    BOX.export(tmp_path / "box.obj")
    settings = {"a": {"hydrostatics": "panels", "constant_buoyancy": True}}
    with model_error("constant_buoyancy is True", "leave out one"):
        floating(tmp_path / "box.obj", settings=settings)


def test_hull_that_sinks(tmp_path):
    hull = HullMesh(X, TRIANGLES)
    with model_error("is to displace 1.95122 m3 but encloses 1.2 m3", "check the mass"):
        equilibrium(hull, 2000.0, (0, 0, 0), 1025.0)
    with model_error("is to displace 0 m3"):
        floating_height(hull, 0.0)


# Hydrostatics in NumPy


def test_waterplane_of_a_turned_box():
    hull = HullMesh(X + np.array([0.3, -0.1, 0.0]), TRIANGLES)
    state = afloat(hull)
    assert state.waterplane_area == pytest.approx(2.0, rel=1e-12)
    np.testing.assert_allclose(state.waterplane_center, [0.3, -0.1], atol=1e-12)
    expected = [2 * (1 / 3 + 0.09), 2 * (1 / 12 + 0.01), -0.06]
    np.testing.assert_allclose(state.waterplane_moments, expected, atol=1e-12)
    np.testing.assert_allclose(state.center_of_buoyancy, [0.3, -0.1, -0.15], atol=1e-12)
    assert state.volume == pytest.approx(0.6, rel=1e-12)
    assert state.wetted_surface == pytest.approx(2.0 + 6.0 * 0.3, rel=1e-12)


def test_poses_go_there_and_back():
    pose = Pose(0.2, 0.4, -0.3)
    np.testing.assert_allclose(pose.place(np.zeros(3)), [0, 0, 0.2], atol=1e-15)
    # positive roll lifts port, positive pitch lowers the bow
    assert Pose(0, 0.1, 0).place([0, 1, 0])[2] > 0 > Pose(0, 0, 0.1).place([1, 0, 0])[2]
    np.testing.assert_allclose(pose.body(pose.place(X)), X, atol=1e-15)  # 3e-16


def test_dry_and_drowned_hull():
    """Nothing wet: no forces; all wet: the whole volume and no waterplane."""
    hull = HullMesh(X, TRIANGLES)
    dry = afloat(hull, Pose(1.0, 0.3, 0.2))
    assert (dry.volume, dry.wetted_surface, dry.waterplane_area, dry.draught) == (0, 0, 0, 0)
    np.testing.assert_array_equal(dry.center_of_buoyancy, 0)
    deep = afloat(hull, Pose(-3.0, 0.3, 0.2))
    assert deep.volume == pytest.approx(1.2, rel=1e-12)
    assert deep.waterplane_area == 0 and np.isnan(deep.waterplane_center).all()
    np.testing.assert_allclose(deep.center_of_buoyancy, [0, 0, -3], atol=1e-12)


def test_unstable_hull_has_negative_righting_arms():
    hull = HullMesh(X, TRIANGLES)
    assert righting_arms(hull, 0.6, (0, 0, 0.6), [0.1])[0] < 0 < righting_arms(
        hull, 0.6, (0, 0, 0), [0.1]
    )[0]  # fmt: skip


def test_equilibrium_rolls_over_to_the_stable_side():
    """A CG a little off makes the unstable box find its angle of loll."""
    hull = HullMesh(X, TRIANGLES)
    pose = equilibrium(hull, 615.0, (0, 0.001, 0.35))
    assert abs(pose.roll) > 0.2
    arm = righting_arms(hull, 0.6, (0, 0.001, 0.35), [pose.roll - 0.02, pose.roll + 0.02])
    assert arm[0] < 0 < arm[1]


# Preparation


def test_coarse_ball_keeps_volume_and_shape():
    fine = trimesh.creation.icosphere(3, 1.0)
    hull = prepare_hull(fine.vertices, fine.faces, 400)
    assert len(hull.triangles) <= 400
    assert hull.volume == pytest.approx(fine.volume, rel=1e-12)
    half = afloat(hull)
    # measured 0.02 % of the volume, 1 mm, and 1.1 cm at the vertices
    assert half.volume == pytest.approx(fine.volume / 2, rel=0.005)
    np.testing.assert_allclose(half.center_of_buoyancy, [0, 0, -3 / 8], atol=0.005)
    np.testing.assert_allclose(np.linalg.norm(hull.vertices, axis=1), 1.0, atol=0.03)


def test_hull_without_deck_is_closed():
    """An open box of loose, inward triangles becomes the closed box."""
    lid = BOX.face_normals[:, 2] > 0.9
    loose = X[TRIANGLES[~lid][:, ::-1]].reshape(-1, 3)
    hull = prepare_hull(loose, np.arange(len(loose)).reshape(-1, 3))
    assert hull.volume == pytest.approx(1.2, rel=1e-12)
    assert afloat(hull).volume == pytest.approx(0.6, rel=1e-12)


def test_mixed_windings_are_turned():
    mixed = TRIANGLES.copy()
    mixed[:5] = mixed[:5, ::-1]
    assert prepare_hull(X, mixed).volume == pytest.approx(1.2, rel=1e-12)


def test_two_hulls():
    pair = trimesh.util.concatenate([BOX, BOX.copy().apply_translation([0, 3, 0])])
    pair.faces[12:] = pair.faces[12:, ::-1]
    hull = prepare_hull(pair.vertices, pair.faces)
    assert hull.volume == pytest.approx(2.4, rel=1e-12)


def test_what_cannot_be_prepared():
    with model_error("has no triangles with an area"):
        prepare_hull(np.zeros((3, 3)), [[0, 1, 2]])
    with model_error("cannot be made coarser than 4 triangles", "asked for are 2"):
        tetrahedron = trimesh.convex.convex_hull([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
        prepare_hull(tetrahedron.vertices, tetrahedron.faces, 2)
