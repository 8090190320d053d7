"""Undocking: the latch opens, the vehicle leaves without touching what it must not."""

import numpy as np
import pytest

from marine_mj.scenario import Scenario
from marine_mj.simulation import run, run_batch
from marine_mj.tasks import build_environment
from marine_mj.tasks.docking_settings import GAIN_SETS

UNDOCK = Scenario.load("docking_undock")


def test_leaves_the_cradle_at_sea_state_4():
    plan = {"task.settings.plan.leave_depth": 1.0, "task.settings.hold": 0.5}
    summary = run_batch(UNDOCK, [plan]).rows[0]
    assert summary["docked"] and summary["undocked"] and not summary["latched"]
    # Released at the first look at or after 2 s.
    assert summary["latch_time"] == 0.0 and summary["undock_time"] == pytest.approx(2.0, abs=0.011)
    assert not summary["undock_forbidden_contact"] and not summary["forbidden_contact"]
    # measured: clear at 6.1 s, away at 13.7 s
    assert summary["clear_time"] < 15 and summary["away_time"] < 40
    # held at the seat 12 mm deep in the layer of two pads of 75 kN/m; measured 1.65 kN
    assert 1500 < summary["undock_contact_force"] < 1.05 * 2 * 75e3 * 0.012
    assert summary["simulated_time"] == pytest.approx(summary["away_time"] + 0.5, abs=0.02)
    assert summary["attempts"] == 0


def test_same_bits_alone_and_in_a_batch_for_every_controller():
    base = UNDOCK.with_values({"duration": 0.64})
    name = "task.settings."
    variations = [
        {name + "controller": c, name + "gains": sets[0], name + "undock_after": after, "seed": s}
        for c, sets in GAIN_SETS.items()
        for after, s in ((0.2, 1), (0.4, 2))
    ]
    result = run_batch(base, variations, record=("qpos", "latched", "phase"))
    for i, changes in enumerate(variations):
        assert result.rows[i]["error"] is None
        if i % 2:
            log = run(base.with_values(changes))
            for signal in ("qpos", "latched", "phase"):
                np.testing.assert_array_equal(log.data[signal], result.signals[signal][i])
    latched = result.signals["latched"].values
    assert (latched[:, 0] == 1).all() and (latched[:, -1] == 0).all()
    # each opened at its own time: 0.2 s and 0.4 s, in steps of the log
    times = 0.04 * latched.sum(axis=1)
    np.testing.assert_allclose(times[::2], 0.2, atol=0.041)
    np.testing.assert_allclose(times[1::2], 0.4, atol=0.041)


@pytest.mark.validation
def test_docks_and_leaves_again():
    changes = {"sea.spectrum": "none", "sea.sea_state": None, "sea.spreading": None}
    changes |= {"task.settings.undock_after": 1.0, "task.settings.hold": 0.0, "duration": 60.0}
    row = run_batch(Scenario.load("docking_demo"), [changes]).rows[0]
    assert row["docked"] and row["undocked"] and not row["forbidden_contact"]
    assert row["attempts"] == 1
    assert row["undock_time"] == pytest.approx(row["latch_time"] + 1.0, abs=0.011)
    assert row["latch_time"] < row["undock_time"] < row["clear_time"] < row["away_time"]


def test_opens_on_request():
    env = build_environment(UNDOCK.with_values({"task.settings.undock_after": None}), random=0)
    env.reset()
    action = np.zeros(env.action_spec().shape)
    for _ in range(30):
        env.step(action)
    assert env.physics.latched()
    env.task.undock(env.physics)
    env.step(action)
    assert not env.physics.latched()
    assert env.task.summary(env.physics)["undock_time"] == pytest.approx(0.31)
    env.reset()
    assert env.physics.latched()
    assert env.task.summary(env.physics)["undock_time"] is None


def test_request_without_a_closed_latch_does_nothing():
    env = build_environment(Scenario.load("docking_demo"), random=0)
    env.reset()
    env.task.undock(env.physics)
    env.step(np.zeros(env.action_spec().shape))
    assert env.task.summary(env.physics)["undock_time"] is None


def test_open_loop_starts_docked_and_is_released():
    chosen = UNDOCK.with_values({"task.name": "dock_open", "duration": 9.0})
    chosen = chosen.with_values({"task.settings.plan.leave_depth": 1.0})
    chosen = chosen.with_values({"task.settings.undock_after": 0.5, "task.settings.hold": 0.0})

    def down(step):
        return np.array([0.0, 0, 0, 0, -1, -1, 0, 0])

    summary = run(chosen, policy=down).summary
    assert summary["undocked"] and summary["clear_time"] == summary["away_time"]
    assert summary["undock_time"] == pytest.approx(0.5, abs=0.011)


def test_dock_that_turns_is_left_when_it_is_quiet():
    """Sea state 6: the latch waits for a quiet dock, and gives in after `patience`."""
    quiet = {"sea.sea_state": 6, "task.settings.plan.quiet_rate": 1e-3, "duration": 8.0}
    rows = run_batch(
        UNDOCK.with_values(quiet),
        [{"task.settings.plan.patience": p} for p in (0.01, 100.0)],
    ).rows
    assert 2.0 < rows[0]["undock_time"] < 7.0
    assert rows[1]["undock_time"] is None and rows[1]["latched"]


@pytest.mark.validation
def test_twenty_seas_without_forbidden_contact():
    variations = [{"sea.sea_state": s, "seed": 2000 + i} for s in (4, 6) for i in range(20)]
    rows = run_batch(UNDOCK, variations).rows
    assert all(row["undocked"] and not row["undock_forbidden_contact"] for row in rows)
