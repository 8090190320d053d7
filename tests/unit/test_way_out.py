"""The way out of a dock on scripted motions."""

import numpy as np
import pytest
from marine_mj.controllers import DockingGuidance, DockingPlan, Phase, RigidState
from marine_mj.controllers.undocking import end_of_way, way_out

from marine_mj import trees
from marine_mj.errors import ScenarioError
from marine_mj.tasks.docking_settings import DockingSettings

LEVEL = np.array([1.0, 0, 0, 0])
PERIOD = 0.01


def at(*position, velocity=(0.0,) * 6):
    return RigidState(np.array(position, dtype=float), LEVEL, np.array(velocity))


CARRIER = at(10, 0, 0)
APERTURE, SEAT = CARRIER.attached([0, 0, -1.0]), CARRIER.attached([0, 0, -0.5])


def update(guidance, state, vehicle, latched):
    return guidance.update(state, vehicle, CARRIER, APERTURE, SEAT, np.asarray(latched), PERIOD)


def test_phases_from_the_seat_to_waypoint_1():
    guidance = DockingGuidance(DockingPlan(leave_speed=0.25, leave_depth=2.0))
    state = guidance.initial()
    for _ in range(3):
        command, state = update(guidance, state, at(10, 0, -0.6), True)
    assert state.phase == Phase.LATCHED
    np.testing.assert_array_equal(command.scale, 0.0)
    # The way out begins where the vehicle is, not at the seat, and keeps its speed.
    heights = []
    for _ in range(200):
        command, state = update(guidance, state, at(10, 0, -0.6), False)
        heights.append(command.target.position[2])
    assert state.phase == Phase.LEAVE
    assert heights[0] == pytest.approx(-0.6, abs=1e-12)
    np.testing.assert_allclose(np.diff(heights), -0.25 * PERIOD, rtol=1e-9)
    np.testing.assert_allclose(command.target.velocity, [0, 0, -0.25, 0, 0, 0], atol=1e-12)
    for _ in range(1000):
        command, state = update(guidance, state, at(10, 0, -2.6), False)
    # It stops 2 m below the aperture and waits there for the vehicle.
    np.testing.assert_allclose(command.target.position, [10, 0, -3.0], atol=1e-9)
    np.testing.assert_allclose(command.target.velocity, 0, atol=1e-12)
    assert state.phase == Phase.LEAVE
    command, state = update(guidance, state, at(10, 0, -2.75), False)
    assert state.phase == Phase.RETURN
    np.testing.assert_allclose(command.target.position, [9, 0, -4.0])
    _, state = update(guidance, state, at(9.1, 0, -4.0), False)
    command, state = update(guidance, state, at(9.1, 0, -4.0), False)
    assert state.phase == Phase.AWAY
    # Back at the aperture later on, it neither enters nor latches again.
    for z in (-1.2, -0.9):
        command, state = update(guidance, state, at(10, 0, z), False)
    assert state.phase == Phase.AWAY and not command.entered


def test_way_out_moves_with_a_dock_that_turns_and_moves():
    """Position and velocity of a point that slides out of a turning dock, by finite differences."""
    spin, speed = np.array([0.2, 0.1, -0.3, 0.05, 0.3, -0.1]), 0.3

    def dock(t):
        turn = spin[3:] * t
        angle = np.linalg.norm(turn)
        half = np.sin(0.5 * angle) * turn / angle if angle else np.zeros(3)
        quaternion = np.concatenate([[np.cos(0.5 * angle)], half])
        body = RigidState(np.zeros(3), quaternion, np.zeros(6))
        # velocity constant in world axes, spin about its own axis
        carrier = RigidState(
            spin[:3] * t,
            quaternion,
            np.concatenate([body.rotation.T @ spin[:3], body.rotation.T @ spin[3:]]),
        )
        return carrier.attached([0.1, 0, -1.0]), carrier.attached([0.1, 0, -0.5])

    def target(t):
        return way_out(*dock(t), 2, np.asarray(0.4 - speed * t / 0.5), speed, 1.0)

    h = 1e-4
    numeric = (target(1 + h).position - target(1 - h).position) / (2 * h)
    # measured 3e-10 m/s
    np.testing.assert_allclose(target(1.0).linear_velocity, numeric, atol=1e-7)


def test_end_of_way_is_that_distance_before_the_aperture():
    assert end_of_way(0.5, 2.0) * 0.5 == -2.0


def test_batch_is_row_by_row():
    guidance = DockingGuidance()
    rng = np.random.default_rng(0)
    positions = np.array([10, 0, -0.5]) + rng.normal(size=(60, 4, 3)) * [0.3, 0.1, 1.0]
    latched = np.arange(60)[:, None] < [5, 20, 60, 0]
    many, single = guidance.initial((4,)), [guidance.initial() for _ in range(4)]

    def spread(body):
        return RigidState(np.tile(body.position, (4, 1)), np.tile(LEVEL, (4, 1)), np.zeros((4, 6)))

    frames = [spread(b) for b in (CARRIER, APERTURE, SEAT)]
    for step, closed in zip(positions, latched, strict=True):
        command, many = guidance.update(many, spread(at(0, 0, 0)), *frames, closed, PERIOD)
        vehicles = RigidState(step, np.tile(LEVEL, (4, 1)), np.zeros((4, 6)))
        command, many = guidance.update(many, vehicles, *frames, closed, PERIOD)
        for i in range(4):
            _, single[i] = update(guidance, single[i], at(0, 0, 0), closed[i])
            one, single[i] = update(guidance, single[i], at(*step[i]), closed[i])
            assert (one.target.position == command.target.position[i]).all()
            assert single[i].phase == many.phase[i] and single[i].progress == many.progress[i]


def test_trees_where_takes_whole_rows():
    fresh = RigidState(np.zeros((2, 3)), np.zeros((2, 4)), np.zeros((2, 6)))
    old = RigidState(np.ones((2, 3)), np.ones((2, 4)), np.ones((2, 6)))
    mixed = trees.where(np.array([True, False]), fresh, old)
    np.testing.assert_array_equal(mixed.position, [[0] * 3, [1] * 3])
    np.testing.assert_array_equal(mixed.velocity[:, 0], [0, 1])
    alone = trees.where(np.array(True), at(1, 2, 3), at(4, 5, 6))
    np.testing.assert_array_equal(alone.position, [1, 2, 3])


def test_refusals():
    for name in ("leave_speed", "leave_depth"):
        with pytest.raises(ScenarioError, match=f"{name} must be > 0, got 0"):
            DockingPlan(**{name: 0.0})
    for other in ({"end_at_capture": True}, {"station": 1.0}):
        with pytest.raises(ScenarioError, match=r"undock_after = 5\.0 needs a latch that closes"):
            DockingSettings.parse({"undock_after": 5.0, **other})
