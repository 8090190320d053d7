"""Markers: the right things at the right places of the rendered scene."""

import functools

import mujoco
import numpy as np
import pytest
import xarray as xr
from picture_scenes import dataset, scene, sea

from marine_mj.markers import AXES, TARGET, Marker, docking_markers, draw_markers
from marine_mj.rendering import SceneRenderer, look_at
from marine_mj.video import gl_status

DOF = ["surge", "sway", "heave", "roll", "pitch", "yaw"]


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    return scene()


def log(**changes: np.ndarray) -> xr.Dataset:
    """Four samples 1 s apart; the target jumps with the phase after the third."""
    target = np.array([[0, 0, 0], [2, 1, 4], [3, 1, 4], [9, 9, 9]], float)
    estimate = np.zeros((4, 6))
    estimate[:, :3] = [[np.nan] * 3, [1, 2, 3], [2, 2, 3], [3, 2, 3]]
    estimate[0] = np.nan
    # The shorter way from 170 to 190 degrees leads through 180.
    estimate[1:, 5] = np.deg2rad([170, -170, -170])
    values = {"target_ned": target, "estimated_eta_ned": estimate} | changes
    variables = {name: (("time", f"k{i}"), v) for i, (name, v) in enumerate(values.items())}
    variables["phase"] = (("time",), np.array([0.0, 0, 0, 1]))
    return xr.Dataset(variables, {"time": np.arange(4.0)})


def test_markers_stand_where_the_log_says(model):
    target, vehicle = docking_markers(model, log(), np.array([1.0, 1.5, 2.5, 3.0]))
    # NED to NWU: y and z change their signs. At 2.5 s the old target still holds.
    expected = [[2, -1, -4], [2.5, -1, -4], [3, -1, -4], [9, -9, -9]]
    np.testing.assert_array_equal(target.position, expected)
    np.testing.assert_array_equal(vehicle.position[1], [1.5, -2, -3])
    # 180 degrees: forward is -x, port is -y; 1e-16 of rounding.
    np.testing.assert_allclose(vehicle.rotation[1], np.diag([-1, -1, 1]), atol=1e-12)
    yaw = np.deg2rad(-170)
    np.testing.assert_allclose(vehicle.rotation[0, :2, 0], [np.cos(yaw), np.sin(yaw)], atol=1e-12)


def test_nothing_is_marked_before_the_first_look_and_without_signals(model):
    markers = docking_markers(model, log(), np.array([0.0, 0.5, 1.0]))
    for marker in markers:
        assert [len(marker.bars(i)) for i in range(3)] == [0, 0, 3]
    assert docking_markers(model, dataset(), np.array([1.0])) == ()


def test_a_cross_has_arms_along_the_world_and_axes_along_the_body():
    position = np.array([[1.0, 2.0, -3.0]])
    bars = Marker("target", position, size=0.3).bars(0)
    for i, (start, end, color) in enumerate(bars):
        np.testing.assert_allclose(end - start, 0.6 * np.eye(3)[i], atol=1e-15)
        np.testing.assert_allclose((start + end) / 2, position[0])
        assert color == TARGET
    turned = np.array([[[0, -1, 0], [1, 0, 0], [0, 0, 1]]], float)
    axes = Marker("vehicle", position, turned, 0.4).bars(0)
    np.testing.assert_allclose(axes[0][1] - position[0], [0, 0.4, 0])
    np.testing.assert_allclose(axes[1][1] - position[0], [-0.4, 0, 0])
    assert [color for *_, color in axes] == list(AXES)


def test_the_scene_gets_a_bright_capsule_per_bar(model):
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    view = mujoco.MjvScene(model, maxgeom=model.ngeom + 5)
    option, camera = mujoco.MjvOption(), mujoco.MjvCamera()
    everything = mujoco.mjtCatBit.mjCAT_ALL
    mujoco.mjv_updateScene(model, data, option, None, camera, everything, view)
    before = view.ngeom
    position = np.array([[1.0, 2.0, -3.0]])
    draw_markers(view, [Marker("target", position, size=0.3)], 0)
    assert view.ngeom == before + 3
    for i in range(3):
        geom = view.geoms[before + i]
        assert geom.type == mujoco.mjtGeom.mjGEOM_CAPSULE
        np.testing.assert_allclose(geom.pos, position[0], atol=1e-6)
        # A capsule lies along its own z; its half length is the arm. Single precision: 1e-8.
        np.testing.assert_allclose(np.abs(geom.mat[:, 2]), np.eye(3)[i], atol=1e-6)
        assert geom.size[2] == pytest.approx(0.3, abs=1e-6)
        np.testing.assert_allclose(geom.rgba, [*TARGET, 1], atol=1e-6)
        assert geom.emission > 0.5
    # A full scene takes no more, and does not fail.
    draw_markers(view, [Marker("target", position)] * 400, 0)
    assert view.ngeom == view.maxgeom


def test_a_marker_is_seen_where_it_projects_to(model):
    status = gl_status()
    if not status:
        pytest.skip(status.reason)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    point = np.array([0.9, -1.2, -3.1])
    size = (480, 270)
    pose = look_at((0, -6, -2.5), (0, 0, -2.5), fovy=50)
    draw = functools.partial(draw_markers, markers=[Marker("target", point[None])], i=0)
    with SceneRenderer(model, sea(), size) as renderer:
        plain = renderer.render(data, pose, 0.0).astype(int)
        marked = renderer.render(data, pose, 0.0, decor=draw).astype(int)
        again = renderer.render(data, pose, 0.0).astype(int)
    np.testing.assert_array_equal(plain, again)
    rows, columns = np.nonzero(np.abs(marked - plain).max(axis=2) > 20)
    assert len(rows) > 20
    way = point - pose.position
    scale = size[1] / 2 / np.tan(np.deg2rad(pose.fovy) / 2) / (way @ pose.forward)
    column = size[0] / 2 + scale * (way @ pose.right)
    row = size[1] / 2 - scale * (way @ pose.up)
    # The middle of the cross' outline: measured 0.2 and 0.3 pixels off.
    assert abs((rows.min() + rows.max() + 1) / 2 - row) < 1.5
    assert abs((columns.min() + columns.max() + 1) / 2 - column) < 1.5
