"""The cradle catches the Scout from anywhere within its capture limits (plain MuJoCo, no water)."""

from itertools import product

import mujoco
import numpy as np
import pytest
from pushing import push_in, scene_with

PUSH = 40.0  # N, upwards


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    return scene_with("cradle")


def dock(model, x, y, z=-1.45, pitch=0.0, yaw=0.0, speed=0.0, duration=25.0):
    """Pushed up from this place, with this pitch, yaw and upward speed."""
    up = np.array([0.0, 0.0, 1.0])
    return push_in(model, [x, y, z], PUSH * up, duration, (0.0, pitch, yaw), speed * up)


# Capture limits: surge 0.4 m, sway 0.3 m, pitch and yaw 10 deg; with yaw off, sway 0.15 m
# (models/cradle/README.md).
CASES = [
    *product((-0.4, 0.0, 0.4), (-0.3, 0.0, 0.3), (0,), (0,)),
    *product((-0.4, 0.4), (0.0, 0.3), (-10, 10), (0,)),
    *product((-0.4, 0.4), (0.15,), (-10, 0, 10), (-10, -5, 5, 10)),
    *product((0.0,), (0.0,), (-10, 10), (-10, 10)),
]


@pytest.mark.parametrize("x, y, pitch_deg, yaw_deg", CASES)
def test_every_start_within_the_capture_limits_ends_in_the_seat(model, x, y, pitch_deg, yaw_deg):
    end = dock(model, x, y, pitch=np.radians(pitch_deg), yaw=np.radians(yaw_deg))
    assert not end.forbidden
    assert end.distance < 0.05  # worst 0.016 m
    assert end.angle < np.radians(3.0)  # worst 0.7 deg
    assert end.deepest < 0.01  # worst 5.1 mm


@pytest.mark.parametrize("x, y, z", [(0.0, 0.0, -0.75), (0.35, 0.0, -1.0), (0.2, 0.25, -1.2)])
def test_half_a_metre_a_second_penetrates_less_than_a_centimetre(model, x, y, z):
    end = dock(model, x, y, z=z, speed=0.5)
    assert not end.forbidden
    # measured: 14.9 mm of the pads' layer left, 5.2 and 3.8 mm overlap on the bars
    assert -0.019 < end.deepest < 0.01
    assert end.distance < 0.05


def test_a_start_beside_the_mouth_touches_a_tip(model):
    end = dock(model, 0.0, 0.56, duration=8.0)
    assert any("forbidden_tip" in name for name in end.forbidden)


def test_seated_scout_clears_the_bottom_by_two_centimetres(model):
    data = mujoco.MjData(model)
    data.qpos[2] = -0.5
    mujoco.mj_forward(model, data)
    fin = data.geom("scout/top_fin")
    top = fin.xpos[2] + model.geom("scout/top_fin").size[2]
    bottom = data.geom("usv/forbidden_hull_bottom").xpos[2]
    bottom -= model.geom("usv/forbidden_hull_bottom").size[2]
    assert bottom - top == pytest.approx(0.02, abs=1e-6)
