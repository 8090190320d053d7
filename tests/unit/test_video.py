"""Videos: right frames in the right order, and plain words where OpenGL is missing."""

import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import mujoco
import numpy as np
import pytest
from picture_scenes import SIZE, dataset, run, scene, sea

from marine_mj import rendering, video
from marine_mj.cameras import CAMERAS, camera_poses
from marine_mj.errors import LogError, RenderError
from marine_mj.overlay import describe_sea, log_overlay, write_lines
from marine_mj.rendering import SceneRenderer, look_at
from marine_mj.replay import States, interpolate, place, slerp, states_from_log
from marine_mj.time_map import time_map
from marine_mj.video import encode, gl_status, render_frames, render_video
from marine_mj.water import components, elevation


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    return scene()


@pytest.fixture
def gl() -> None:
    status = gl_status()
    if not status:
        pytest.skip(status.reason)


# States between the samples of a log


def test_interpolation_hits_samples_and_middles(model):
    states = run()
    again = interpolate(model, states, states.time)
    np.testing.assert_allclose(again.qpos, states.qpos, atol=1e-12)
    middle = interpolate(model, states, [0.15])
    np.testing.assert_allclose(middle.qpos[0, 7:10], states.qpos[1:3, 7:10].mean(axis=0))


def test_interpolation_turns_along_the_great_arc(model):
    qpos = np.zeros((2, 14))
    qpos[:, [3, 10]] = 1
    # 120 degrees about z, written with the other sign of the quaternion.
    qpos[1, 3:7] = -np.array([np.cos(np.pi / 3), 0, 0, np.sin(np.pi / 3)])
    states = States(np.array([0.0, 1.0]), qpos, np.zeros((2, 0)), np.array([[0.0], [1.0]]))
    found = interpolate(model, states, [0.25])
    expected = [np.cos(np.pi / 12), 0, 0, np.sin(np.pi / 12)]
    np.testing.assert_allclose(found.qpos[0, 3:7], expected, atol=1e-12)
    assert found.eq_active[0, 0] == 0


def test_slerp_of_equal_quaternions():
    q = np.array([[0.6, 0.8, 0, 0]])
    np.testing.assert_allclose(slerp(q, q, [0.3]), q)


def test_times_outside_the_run_hold_its_ends(model):
    states = run()
    ends = interpolate(model, states, [-5.0, 99.0])
    np.testing.assert_allclose(ends.qpos, states.qpos[[0, -1]])


def test_log_of_another_scene_is_refused(model):
    states = States(np.zeros(1), np.zeros((1, 3)), np.zeros((1, 0)), np.zeros((1, 0)))
    with pytest.raises(RenderError, match=r"3 positions .* the model 14"):
        interpolate(model, states, [0.0])


def test_log_without_positions_is_refused():
    with pytest.raises(RenderError, match="has no 'qpos'"):
        states_from_log(dataset().drop_vars("qpos"))


def test_frame_times_do_not_depend_on_the_rate_of_the_log():
    assert len(time_map(np.array([0.0, 7.0, 10.0])).frame_times(25)) == 251
    times = time_map(np.linspace(0, 10, 11), 2.0, 4.0).frame_times(25)
    assert times[0] == 4.0 and times[1] == pytest.approx(4.08) and times[-1] <= 10
    with pytest.raises(RenderError, match=r"asked for was 20\.0 to None"):
        time_map(np.array([0.0, 10.0]), 1.0, 20.0)


# Cameras


@pytest.mark.parametrize("camera", [*CAMERAS, "usv/deck"])
def test_cameras_point_at_the_vehicles_and_stay_off_the_surface(model, camera):
    states, waves = run(), sea()
    poses = camera_poses(model, states, waves, camera)
    assert len(poses) == len(states)
    for pose, time in zip(poses, states.time, strict=True):
        np.testing.assert_allclose(np.linalg.norm([pose.forward, pose.up], axis=1), 1)
        above = pose.position[2] - elevation(waves, *pose.position[:2], time)
        if camera in ("chase", "side"):
            assert above > 0.3
        elif camera in ("dock", "close"):
            assert above < -0.3
        elif camera == "split":
            assert abs(above) < 0.2
        if camera != "usv/deck":
            # Both vehicles are within 3 m of the origin.
            direction = -pose.position / np.linalg.norm(pose.position)
            assert direction @ pose.forward > 0.8


def test_unknown_camera_and_body_name_what_exists(model):
    with pytest.raises(RenderError, match=r"camera is 'nose', available are chase.*usv/deck"):
        camera_poses(model, run(), sea(), "nose")
    with pytest.raises(RenderError, match=r"follow is 'ship', vehicles are usv/hull, auv/hull"):
        camera_poses(model, run(), sea(), "chase", "ship")


# Text


def test_overlay_tells_time_sea_distance_and_phase():
    lines = log_overlay(dataset(), components(sea()))
    assert lines(0.52)[0] == "t =   0.5 s"
    assert "H_s = 1.10 m" in lines(0.0)[1]
    assert lines(1.5)[-1] == "under" and lines(3.9)[-1] == "latched"
    assert describe_sea(components(sea(count=0))) == "calm"
    assert "wave H = 1.10" not in describe_sea(components(sea()))


def test_text_changes_only_its_corner():
    frame = np.full((180, 320, 3), 90, np.uint8)
    write_lines(frame, ["t = 1 s"])
    assert np.any(frame != 90)
    assert np.all(frame[60:] == 90) and np.all(frame[:, 200:] == 90)
    frame[:] = 90
    write_lines(frame, ["x0.2"], scale=1.8, right=True)
    assert np.any(frame != 90)
    assert np.all(frame[60:] == 90) and np.all(frame[:, :200] == 90)


# Without OpenGL


def test_a_wrong_platform_is_named(monkeypatch):
    monkeypatch.setenv("MUJOCO_GL", "vulkan")
    status = gl_status()
    assert not status and "MUJOCO_GL is 'vulkan'" in status.reason and "egl" in status.reason
    with pytest.raises(RenderError, match="MUJOCO_GL is 'vulkan'"):
        list(render_frames(None, run(), sea()))


def test_a_missing_library_names_the_packages():
    # ctypes finds no shared library in this process or its children: no EGL.
    code = """
import os, subprocess, sys
from marine_mj import rendering
hide = "import ctypes.util\\nctypes.util.find_library = lambda name: None\\n"
hide += "import ctypes\\nold = ctypes.CDLL.__init__\\n"
hide += "def new(self, name, *a, **k):\\n"
hide += "    if name and 'EGL' in str(name): raise OSError('cannot open libEGL.so.1')\\n"
hide += "    old(self, name, *a, **k)\\nctypes.CDLL.__init__ = new\\n"
rendering._PROBE = hide + rendering._PROBE
status = rendering.gl_status()
print(status.ok, status.reason)
"""
    result = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True
    )
    assert result.stdout.startswith("False")
    assert "apt-get install libegl1 libegl-mesa0 libgl1-mesa-dri" in result.stdout


def test_a_probe_that_dies_kills_only_itself(monkeypatch):
    monkeypatch.setattr(rendering, "_PROBE", "import os; os.abort()")
    rendering._probe.cache_clear()
    try:
        status = gl_status()
        assert not status and "ended with code -6" in status.reason
        with pytest.raises(RenderError, match="libgl1-mesa-dri"):
            video.still(None, 0.0)
    finally:
        rendering._probe.cache_clear()


# Settings


def test_bad_settings_are_refused_before_anything_else():
    with pytest.raises(RenderError, match="allowed are even numbers"):
        render_video(None, "x.mp4", size=(161, 90))
    with pytest.raises(RenderError, match="both must be positive"):
        render_video(None, "x.mp4", fps=0)
    with pytest.raises(LogError, match="got int"):
        video.open_log(3)


# Pictures


@pytest.mark.usefixtures("gl")
def test_looks_above_below_and_between(model):
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    waves = sea(0.05)
    with SceneRenderer(model, waves, SIZE) as renderer:
        above = renderer.render(data, look_at((0, -9, 2.5), (0, 0, 0.3)), 0.0)
        below = renderer.render(data, look_at((0, -6, -2.5), (0, 0, -1)), 0.0)
        split = renderer.render(data, look_at((0, -6, 0), (0, 0, 0)), 0.0)
    assert above.shape == below.shape == split.shape == (*SIZE[::-1], 3)
    sky, deep = above[:10].mean(axis=(0, 1)), below[-10:].mean(axis=(0, 1))
    assert sky.min() > 110
    # Under water there is little red and no sky.
    assert deep[0] < 70 and deep[2] > deep[0] + 20 and below.mean() < above.mean()
    assert split[:20].mean() > split[-20:].mean() + 30
    # The orange hull is in the picture from above.
    assert np.any((above[..., 0] > 150) & (above[..., 2] < 90))


@pytest.mark.usefixtures("gl")
def test_the_horizon_has_no_edge(model):
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    with SceneRenderer(model, sea(), SIZE) as renderer:
        for azimuth in np.deg2rad([0, 100, 225]):
            eye = np.array([0, 0, 4.0])
            pose = look_at(eye, (np.cos(azimuth), np.sin(azimuth), 4.0), fovy=10)
            picture = renderer.render(data, pose, 0.0).astype(float)
            rows = picture[SIZE[1] // 2 - 4 : SIZE[1] // 2 + 3].mean(axis=1)
            assert np.abs(np.diff(rows, axis=0)).max() < 25


@pytest.mark.usefixtures("gl")
def test_frames_move_and_are_reproducible(model):
    states = interpolate(model, run(), [0.0, 0.5, 1.0])
    frames = list(render_frames(model, states, sea(), size=SIZE))
    assert [frame.shape for frame in frames] == [(90, 160, 3)] * 3
    assert np.abs(frames[0].astype(int) - frames[2]).mean() > 1
    again = list(render_frames(model, states, sea(), size=SIZE))
    np.testing.assert_array_equal(frames[2], again[2])


@pytest.mark.usefixtures("gl")
def test_workers_give_the_same_frames(model):
    states = interpolate(model, run(), np.linspace(0, 2, 5))
    here = list(render_frames(model, states, sea(), size=SIZE))
    there = list(render_frames(model, states, sea(), size=SIZE, workers=2))
    assert len(there) == 5
    for a, b in zip(here, there, strict=True):
        # Threads of the matrix product may round a texel the other way.
        assert np.mean(a != b) < 0.01


@pytest.mark.usefixtures("gl")
def test_a_worker_that_fails_says_why(model):
    states = interpolate(model, run(), [0.0, 1.0])
    job = video.make_job(model, states, sea(), ("side",), SIZE)
    broken = video.replace(job, size=(4000, 90))
    with pytest.raises(RenderError, match="give add_scenery the size"):
        list(video.job_frames(broken, 2))


@pytest.mark.usefixtures("gl")
def test_video_of_a_log(model, tmp_path, monkeypatch):
    log = SimpleNamespace(data=dataset())
    environment = SimpleNamespace(waves=sea())
    monkeypatch.setattr(
        video, "_scene", lambda *_: SimpleNamespace(model=model, environment=environment)
    )
    done = []
    path = render_video(
        log, tmp_path / "run.mp4", size=SIZE, fps=5, stop=1.0, progress=lambda *a: done.append(a)
    )
    assert done == [(i + 1, 6) for i in range(6)]
    assert list(tmp_path.iterdir()) == [path]
    import imageio_ffmpeg

    reader = imageio_ffmpeg.read_frames(str(path))
    described = next(reader)
    assert described["size"] == SIZE and described["codec"] == "h264"
    assert "yuv420p" in described["pix_fmt"] and len(list(reader)) == 6


def test_a_failed_video_leaves_nothing(tmp_path):
    def frames():
        yield np.zeros((90, 160, 3), np.uint8)
        raise RenderError("driver lost")

    with pytest.raises(RenderError, match="driver lost"):
        encode(frames(), Path(tmp_path) / "run.mp4", 5, 2)
    assert not list(tmp_path.iterdir())


@pytest.mark.usefixtures("gl")
def test_placing_a_state_moves_cameras_with_their_body(model):
    data = mujoco.MjData(model)
    states = run()
    place(model, data, states, 0)
    before = data.cam_xpos[0, 2]
    place(model, data, states, 15)
    assert data.cam_xpos[0, 2] - before == pytest.approx(states.qpos[15, 2] - states.qpos[0, 2])
