"""The pole dock catches a Scout that comes from behind too high or too low."""

from itertools import product

import numpy as np
import pytest
from pushing import push_in, scene_with

PUSH = 25.0  # N, forward: 0.4 m/s against the drag
DEPTH = 1.1  # of the seat, m


@pytest.fixture(scope="module")
def model():
    return scene_with("pole")


def dock(model, y, z, pitch_deg=0.0, roll_deg=0.0, duration=9.0):
    """From 2 m behind the seat, y to port and z above it in m; pitch bow down."""
    angles = np.radians([roll_deg, pitch_deg, 0.0])
    return push_in(model, [-2.0, y, z - DEPTH], [PUSH, 0.0, 0.0], duration, angles)


@pytest.mark.parametrize(
    "y, z, pitch_deg, roll_deg",
    [*product((0.04,), (-0.2, 0.0, 0.2), (-5, 5), (0,)), (0.0, 0.1, 0, -5), (0.0, -0.1, 0, 5)],
)
def test_a_vehicle_too_high_or_too_low_ends_at_the_pole(model, y, z, pitch_deg, roll_deg):
    end = dock(model, y, z, pitch_deg, roll_deg)
    assert not end.forbidden
    assert end.distance < 0.05  # worst 4.4 mm
    assert end.angle < np.radians(3.0)  # worst 1.8 deg
    assert end.peak < 6000.0  # worst 1.0 kN


def test_a_vehicle_above_the_ramps_touches_a_tip(model):
    end = dock(model, 0.1, 0.42, duration=4.0)
    assert any("forbidden_tip_upper" in name for name in end.forbidden)
