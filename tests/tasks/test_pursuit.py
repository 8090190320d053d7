"""Waypoints instead of a dock: closed forms of the target, and one run like a batch of them."""

import numpy as np
import pytest
from marine_mj.controllers import PursuitGuidance, RigidState

from marine_mj import frames
from marine_mj.errors import ScenarioError
from marine_mj.scenario import Scenario
from marine_mj.simulation import run, run_batch

BODY = RigidState(np.zeros(3), np.array([1.0, 0, 0, 0]), np.zeros(6))


def test_target_follows_its_parabolas():
    pose, rate, gain = (
        np.array([2.0, 5.0, 0.3]),
        np.array([1.0, 0.3, 0.5]),
        np.array([0.1, 0, -0.2]),
    )
    guidance = PursuitGuidance(0.01, pose, rate, gain)
    state = guidance.initial()
    for _ in range(251):
        command, state = guidance.update(state, BODY, BODY, BODY, BODY, np.array(False), 0.01)
    t = 2.5  # the first update is at 0
    target = command.target
    eta = frames.eta_ned(target.position, target.quaternion)
    expected = pose + rate * t + 0.5 * gain * t**2
    np.testing.assert_allclose(eta[[0, 2, 4]], expected, atol=1e-12)
    world = frames.flip(np.r_[target.linear_velocity, target.velocity[3:]])
    np.testing.assert_allclose(world[[0, 2, 4]], rate + gain * t, atol=1e-12)
    np.testing.assert_allclose(frames.flip(command.acceleration)[[0, 2, 4]], gain, atol=0)
    again = guidance.target(state, BODY, BODY, BODY)
    np.testing.assert_array_equal(again.position, target.position)


def waypoint(**values):
    return {
        "duration": 1.0,
        "task.settings.station": None,
        "task.settings.controller": "cpva",
        "task.settings.gains": "reference",
        "vehicles.usv.position_ned": [200.0, 0.0, 0.0],
        "task.settings.waypoint": values,
    }


def test_a_batch_has_the_bits_of_single_runs():
    base = Scenario.load("docking_tuning")
    changes = [
        waypoint(pose=[0.0, 3.0, 1.0]),
        waypoint(pose=[-1.0, 4.0, 0.0], rate=[0.5, 0.0, 0.0], acceleration=[0.1, 0.0, 0.0]),
    ]
    names = ("qpos", "target_error", "wrench_command")
    batch = run_batch(base, changes, record=names).signals
    for i, change in enumerate(changes):
        single = run(base.with_values(change)).data
        for name in names:
            np.testing.assert_array_equal(batch[name].values[i], single[name].values)


def test_station_and_waypoint_are_refused_together():
    change = waypoint(pose=[0.0, 3.0, 0.0]) | {"task.settings.station": 1.0}
    with pytest.raises(ScenarioError, match=r"station = 1 and a waypoint are two targets: leave"):
        run(Scenario.load("docking_tuning").with_values(change))
