"""Guidance laws on kinematic vehicles in a current: `x' = U [cos psi, sin psi] + c`."""

import numpy as np
import pytest
from marine_mj.controllers import guidance_laws as laws

from marine_mj.errors import ScenarioError
from marine_mj.frames import ssa

DOCK, AXIS, U, STEP = np.array([3.0, -1.0]), 0.4, 1.2, 0.01
DIRECTION = np.array([np.cos(AXIS), np.sin(AXIS)])
LEFT = np.array([-np.sin(AXIS), np.cos(AXIS)])
CURRENT = 0.3 * LEFT
START = DOCK - 50.0 * DIRECTION + 3.0 * LEFT


def sail(law, current=CURRENT, start=START, seconds=120.0):
    """Cross-track error and angle to the axis when the plane of the dock is crossed, or NaN."""
    position, memory, heading = start.copy(), 0.0, 0.0
    before = laws.track_errors(position, DOCK, AXIS)[1]
    for _ in range(round(seconds / STEP)):
        togo, error = laws.track_errors(position, DOCK, AXIS)
        if togo <= 0:
            return float(error), float(ssa(heading - AXIS))
        heading, speed, memory = law(position, togo, error, (error - before) / STEP, memory)
        before = error
        way = np.array([np.cos(heading), np.sin(heading)])
        position = position + STEP * (speed * way + current)
    return np.nan, np.nan


def line_of_sight(position, togo, error, rate, memory):
    return laws.line_of_sight(position, DOCK), U, memory


def pure_pursuit(position, togo, error, rate, memory):
    return laws.pure_pursuit(position, DOCK, AXIS, 3.0), U, memory


def crab(position, togo, error, rate, memory):
    course = laws.pure_pursuit(position, DOCK, AXIS, 3.0)
    return laws.crab_angle(course, U, CURRENT), U, memory


def cross_track(position, togo, error, rate, memory):
    return laws.cross_track(error, memory, rate, AXIS), U, memory + STEP * error


def touchdown(position, togo, error, rate, memory):
    crab = laws.crab_angle(AXIS - np.arctan(error / 3.0), U, CURRENT)
    heading = crab if togo > 3.0 else AXIS + CRAB  # from there on without looking at the error
    return laws.touchdown_alignment(heading, AXIS, togo, 3.0), U, memory


def side_slip(position, togo, error, rate, memory):
    return laws.side_slip(position, DOCK, AXIS, U, CURRENT, 4.0), U, memory


def integral_sight(position, togo, error, rate, memory):
    heading, change = laws.integral_line_of_sight(error, memory, AXIS, 2.0, 0.5)
    return heading, U, memory + STEP * change


def sliding_path(position, togo, error, rate, memory):
    heading, speed, change = laws.sliding_path(
        position, DOCK, AXIS, memory, U, 0.7 * CURRENT, 35.0, 0.5, 2.0
    )
    return heading, speed, memory + STEP * change


CRAB = -np.arcsin(0.3 / U)  # heading of a vehicle that holds the line, relative to the axis


@pytest.mark.parametrize(
    ("law", "error", "angle", "within"),
    [
        (pure_pursuit, 0.0, None, 0.01),  # 0.005, but across the axis at the end
        (crab, 0.0, CRAB, 1e-6),  # 8e-11 m, 1.5e-7 rad
        (cross_track, 0.0, CRAB, 0.03),  # 0.018
        (side_slip, 0.0, 0.0, 0.005),  # 0.001: in the dock and along its axis at once
        (integral_sight, 0.0, CRAB, 1e-3),  # 1.5e-5
        (sliding_path, 0.0, None, 0.05),  # 0.024
    ],
)
def test_reaches_the_dock_in_a_cross_current(law, error, angle, within):
    found = sail(law)
    assert found[0] == pytest.approx(error, abs=within)
    if angle is not None:
        assert found[1] == pytest.approx(angle, abs=within)


def test_line_of_sight_arrives_against_the_current_and_not_along_the_axis():
    _, angle = sail(line_of_sight)
    assert angle < CRAB - 0.1
    assert abs(sail(line_of_sight, 0 * CURRENT)[1] - np.arctan2(-3, 50)) < 1e-6  # straight


def test_touchdown_alignment_is_aligned_and_pays_with_the_drift():
    error, angle = sail(touchdown)
    assert abs(angle) < 0.01
    # cosine blend over 3 m: half of v_cross * 3 m / U is not made up
    assert error == pytest.approx(0.5 * 0.3 * 3.0 / U, rel=0.05)


def test_side_slip_needs_its_offset():
    """Without the upstream line the same vehicle misses by the whole drift."""
    upstream = laws.side_slip_line(AXIS, U, CURRENT, 4.0)
    assert upstream == pytest.approx(-0.3 * 4.0 / U)
    no_current = sail(lambda p, *a: (laws.side_slip(p, DOCK, AXIS, U, 0 * CURRENT, 4.0), U, 0.0))
    assert no_current[0] > 0.9  # 1.0 of drift


def test_proportional_navigation_hits_a_moving_target():
    target, velocity = np.array([20.0, 5.0]), np.array([0.0, 0.4])
    position, heading, closest = np.zeros(2), 0.0, np.inf
    for _ in range(4000):
        way = U * np.array([np.cos(heading), np.sin(heading)])
        heading += STEP * laws.proportional_navigation(position, way, target, velocity)
        position, target = position + STEP * way, target + STEP * velocity
        closest = min(closest, np.linalg.norm(target - position))
    assert closest < 0.02  # measured 0.005: half a step
    # On a collision course the bearing rests and so does the heading.
    assert laws.proportional_navigation(np.zeros(2), np.array([1.0, 0]), np.array([5.0, 0])) == 0


def test_crab_angle_cancels_what_it_can():
    course = np.linspace(-3, 3, 7)
    current = np.array([0.3, -0.5])
    heading = laws.crab_angle(course, U, current)
    ground = U * np.stack([np.cos(heading), np.sin(heading)], -1) + current
    np.testing.assert_allclose(ssa(np.arctan2(ground[:, 1], ground[:, 0]) - course), 0, atol=1e-12)
    assert laws.crab_angle(0.0, 0.4, np.array([0.0, 0.5])) == pytest.approx(-np.pi / 2)


def test_laws_are_vectorised():
    rng = np.random.default_rng(0)
    position, axis = rng.normal(size=(6, 2)), rng.normal(size=6)
    current = 0.2 * rng.normal(size=(6, 2))
    calls = [
        lambda p, a, c: laws.line_of_sight(p, DOCK),
        lambda p, a, c: laws.pure_pursuit(p, DOCK, a, 2.0),
        lambda p, a, c: laws.proportional_navigation(p, c, DOCK),
        lambda p, a, c: laws.side_slip(p, DOCK, a, U, c, 3.0),
        lambda p, a, c: laws.sliding_path(p, DOCK, a, 0.1, U, c, 5.0, 0.5, 1.0)[0],
        lambda p, a, c: laws.touchdown_alignment(0.3, a, p[..., 0], 2.0),
    ]
    for call in calls:
        many = call(position, axis, current)
        assert many.shape == (6,)
        for i in range(6):
            np.testing.assert_allclose(call(position[i], axis[i], current[i]), many[i], rtol=1e-12)


def test_speed_regulation():
    np.testing.assert_allclose(
        laws.regulated_speed(np.array([0, 1.0, -2.0, 9.0]), 1.0, 0.4, 2.0), [1.0, 0.7, 0.4, 0.4]
    )
    with pytest.raises(ScenarioError, match="threshold must be > 0 m, got 0"):
        laws.regulated_speed(0.0, 1.0, 0.4, 0.0)
