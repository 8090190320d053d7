"""Batch runner: the same bits as the dm_control runner, failures as rows."""

import numpy as np
import pytest

from marine_mj.errors import ScenarioError
from marine_mj.scenario import Scenario
from marine_mj.scene import compile_scene
from marine_mj.simulation import run, run_batch
from marine_mj.simulation.episode import Episode

SHORT = Scenario.load("docking_demo").with_values({"duration": 1.0})
TIMES = ("wall_time", "real_time_factor", "versions")


def row_of(log):
    return {key: value for key, value in log.summary.items() if key not in TIMES}


def without_time(row):
    return {key: value for key, value in row.items() if key not in TIMES}


#: From waypoint 1 in small waves, with a wide latch: docked within 14 s.
QUICK = Scenario.load("docking_demo").with_values(
    {
        "sea.sea_state": 1,
        "duration": 20.0,
        "vehicles.auv.position_ned": [9.0, 0.0, 3.8],
        "vehicles.auv.heading_deg": 0.0,
        "task.settings.hold": 0.5,
        "task.settings.latch": {"position": 0.1, "speed": 0.3, "dwell": 0.2},
        "task.settings.plan.wait_depth": 0.5,
    }
)


@pytest.fixture(scope="module")
def docking():
    """Dockings with contact, latch and different ends, in one batch."""
    variations = [
        {"seed": 1, "current.speed": 0.05},
        {"seed": 3, "task.settings.plan.push": 60.0, "sea.sea_state": 2},
        {"seed": 5},
    ]
    record = ("qpos", "qvel", "act", "ctrl", "eq_active", "eta_ned", "dock_error", "contact_force")
    return variations, record, run_batch(QUICK, variations, record=record)


def test_batch_gives_the_bits_of_the_dm_control_runner(docking):
    variations, record, result = docking
    assert all(row["docked"] for row in result.rows)
    assert len({row["simulated_time"] for row in result.rows}) == 3
    assert max(row["peak_contact_force"] for row in result.rows) > 100
    for number, changes in enumerate(variations):
        log = run(QUICK.with_values(changes))
        assert without_time(result.rows[number]) == row_of(log)
        on_grid = np.isin(np.round(log.data["time"], 6), np.round(result.signals["time"], 6))
        for name in record:
            single = log.data[name].values[on_grid]
            together = result.signals[name].values[number]
            np.testing.assert_array_equal(single, together[: len(single)], err_msg=name)
            assert np.isnan(together[len(single) :]).all(), name


def test_threads_and_grouping_do_not_change_a_bit(docking, monkeypatch):
    variations, record, result = docking
    monkeypatch.setattr("marine_mj.simulation.batch.BLOCK", 2)
    other = run_batch(QUICK, variations, record=record, threads=2)
    assert [*map(without_time, other.rows)] == [*map(without_time, result.rows)]
    assert other.signals.equals(result.signals)


@pytest.mark.parametrize(
    "changes",
    [
        {"task.settings.controller": "pose_pid", "task.settings.gains": "extended"},
        {"task.settings.gains": "reference"},
        {"task.name": "dock_open"},
        {"task.settings.random_start_time": True, "task.settings.start_spread": 0.3},
        {"vehicles.usv.motion": "rao", "vehicles.auv.planar": True, "sea.spreading": None},
        {"integrator": "RK4"},
        {"task.settings.navigation": {"kind": "inertial", "usbl": {"period": 0.2, "delay": 0.1}}},
        {
            "task.settings.navigation": {"kind": "thesis", "fix_period": 0.05},
            "vehicles.auv.planar": True,
            "sea.spreading": None,
        },
    ],
)
def test_every_controller_and_mode_gives_the_same_bits(changes):
    base = SHORT.with_values({"duration": 0.4, **changes})
    result = run_batch(base, n=2, record=("qpos", "qvel"))
    for number in range(2):
        log = run(base.with_values({"seed": base.seed + number}))
        np.testing.assert_array_equal(log.data["qpos"], result.signals["qpos"][number])
        np.testing.assert_array_equal(log.data["qvel"], result.signals["qvel"][number])
        assert without_time(result.rows[number]) == row_of(log)


@pytest.mark.parametrize("name", sorted(n for n in Scenario.packaged() if "docking" in n))
def test_runs_of_every_scenario_share_a_model_and_give_the_same_bits(name):
    """Seeds and seas differ: fields of the one model that a run changes must be its own."""
    base = Scenario.load(name).with_values({"duration": 0.6})
    others = {"seed": base.seed + 7, "sea.sea_state": 5}
    result = run_batch(base, [{}, others], record=("qpos", "qvel"))
    log = run(base.with_values(others))
    np.testing.assert_array_equal(log.data["qpos"], result.signals["qpos"][1])
    np.testing.assert_array_equal(log.data["qvel"], result.signals["qvel"][1])
    assert without_time(result.rows[1]) == row_of(log)
    assert not np.array_equal(*result.signals["qvel"].values[:, -1])


def test_runs_that_cannot_share_a_batch_keep_their_order():
    variations = [
        {"seed": 1},
        {"seed": 2, "task.settings.controller": "pose_pid", "task.settings.gains": "extended"},
        {"seed": 3, "sea.components": 30},
        {"seed": 4, "vehicles.auv.actuation": "wrench"},
        {"seed": 5, "duration": 0.3},
    ]
    base = SHORT.with_values({"duration": 0.2})
    seen = []
    result = run_batch(base, variations, progress=lambda done, total: seen.append((done, total)))
    assert [row["seed"] for row in result.rows] == [1, 2, 3, 4, 5]
    assert [row["simulated_time"] for row in result.rows] == [0.2, 0.2, 0.2, 0.2, 0.3]
    assert result.rows[1]["controller"] == "pose_pid"
    assert seen[-1] == (5, 5)
    for row, changes in zip(result.rows, variations, strict=True):
        assert without_time(row) == row_of(run(base.with_values(changes)))


def test_calm_water_waves_and_a_sea_bed_in_one_call():
    """Scenes with another number of geoms or components are stepped apart, none is lost."""
    changes = [
        {"duration": 0.1, **more}
        for more in ({}, {"sea.sea_state": 0}, {"sea.depth": 20.0, "wind.speed": 10.0})
    ]
    rows = run_batch(SHORT, changes).rows
    for change, row in zip(changes, rows, strict=True):
        assert row["error"] is None
        assert without_time(row) == {**without_time(row), **row_of(run(SHORT.with_values(change)))}


def test_runs_that_differ_in_numbers_of_the_task_share_a_batch(monkeypatch):
    """Gain sets, waiting, prediction time, noise, fix period, duration: one episode, same bits."""
    base = Scenario.load("docking_thesis")
    thesis = {"task.settings.navigation.kind": "thesis"}
    ahead = {"kind": "kinematic", "t_pred": 0.4}
    groups = [
        [
            {"task.settings.gains": "manual", "duration": 0.3},
            {"task.settings.gains": "brute_force", "duration": 0.5},
            {"task.settings.plan.wait_speed": 0.7, "duration": 0.4, "seed": 3},
            {"task.settings.plan.goal_bias": [0.1, 0, 0, 0, 0.02, 0], "duration": 0.3, "seed": 3},
        ],
        [
            {**thesis, "task.settings.navigation.scenario": name, "duration": 0.5, "seed": seed}
            for seed, name in enumerate(("base", "period_0.04", "period_0.1", "fix_worst"))
        ],
        [
            {"task.settings.prediction": ahead, "duration": 0.3},
            {"task.settings.prediction": {**ahead, "t_pred": 1.0}, "duration": 0.3},
        ],
    ]
    names = ("qpos", "ctrl")
    single = [[run_batch(base, [v], record=names) for v in variations] for variations in groups]
    episodes = []
    start = Episode.__init__

    def counted(self, scenarios, *arguments):
        episodes.append(len(scenarios))
        start(self, scenarios, *arguments)

    monkeypatch.setattr(Episode, "__init__", counted)
    together = run_batch(base, [v for variations in groups for v in variations], record=names)
    assert sorted(episodes) == [2, 4, 4]
    alone = [result for results in single for result in results]
    for i, result in enumerate(alone):
        assert without_time(together.rows[i]) == without_time(result.rows[0])
        for name in names:
            part = result.signals[name].values[0]
            np.testing.assert_array_equal(together.signals[name].values[i][: len(part)], part)
    assert [r["simulated_time"] for r in together.rows[:4]] == [0.3, 0.5, 0.4, 0.3]


def test_without_contact_nothing_collides():
    forward = {"vehicles.auv.position_ned": [9.0, 0.0, 0.5], "duration": 2.0, "sea.sea_state": 0}
    base = Scenario.load("docking_thesis").with_values(forward)
    rows = run_batch(base, [{"contact": False}, {"contact": True}]).rows
    # The vehicle starts inside the cradle: measured 0 and 3e4 N.
    assert rows[0]["peak_contact_force"] == 0.0 and rows[1]["peak_contact_force"] > 100.0


def test_a_run_that_diverges_is_a_row_and_the_others_go_on():
    base = SHORT.with_values({"duration": 0.4, "sea.sea_state": 2})
    explosive = {"seed": 2, "vehicles.auv.velocity_frd": [1e12, 0, 0, 0, 0, 0]}
    result = run_batch(base, [{"seed": 1}, explosive, {"seed": 3}], record=("qpos",))
    assert [row["error"] is None for row in result.rows] == [True, False, True]
    assert "diverged at t =" in result.rows[1]["error"]
    assert result.rows[1]["simulated_time"] < 0.4
    np.testing.assert_array_equal(
        result.signals["qpos"][2], run(base.with_values({"seed": 3})).data["qpos"]
    )


def test_noise_does_not_care_which_runs_have_ended():
    base = SHORT.with_values({"duration": 0.4, "task.settings.navigation": {"kind": "inertial"}})
    explosive = {"seed": 2, "vehicles.auv.velocity_frd": [1e12, 0, 0, 0, 0, 0]}
    names = ("qpos", "estimated_eta_ned", "navigation_error", "relative_navigation_error")
    result = run_batch(base, [explosive, {"seed": 3}, {"seed": 4}], record=names)
    assert result.rows[0]["simulated_time"] < 0.4
    for number, seed in ((1, 3), (2, 4)):
        log = run(base.with_values({"seed": seed}))
        assert without_time(result.rows[number]) == row_of(log)
        for name in names:
            np.testing.assert_array_equal(log.data[name], result.signals[name][number])
    first, second = (row["navigation_rmse"]["vehicle"]["position"] for row in result.rows[1:])
    assert 0.05 < first != second


def test_a_run_that_cannot_start_is_a_row():
    steep = {"sea.sea_state": None, "sea.significant_wave_height": 9.0, "sea.peak_period": 3.0}
    result = run_batch(SHORT.with_values({"duration": 0.1}), [{"seed": 1}, steep])
    assert result.rows[0]["error"] is None
    assert "it would break" in result.rows[1]["error"]


def test_a_command_that_is_no_number_fails_its_run_only(monkeypatch):
    from marine_mj.tasks.docking_mission import DockingMission

    sound = DockingMission.command

    def broken(self, state, view, latched, action=None):
        commands, state = sound(self, state, view, latched, action)
        if len(latched) == 2:
            commands[1, 0] = np.nan
        return commands, state

    monkeypatch.setattr(DockingMission, "command", broken)
    result = run_batch(SHORT.with_values({"duration": 0.1}), n=2)
    assert result.rows[0]["error"] is None
    assert "actuator 'auv/thruster_1' is nan" in result.rows[1]["error"]


def test_refusals_name_the_run_and_what_there_is():
    with pytest.raises(ScenarioError, match=r"run 1 with .*sea_stat"):
        run_batch(SHORT, [{"seed": 1}, {"sea.sea_stat": 3}])
    with pytest.raises(ScenarioError, match="needs variations, or n >= 1"):
        run_batch(SHORT)
    with pytest.raises(ScenarioError, match="n = 3 but there are 1 variations"):
        run_batch(SHORT, [{}], 3)
    with pytest.raises(ScenarioError, match="threads = 0"):
        run_batch(SHORT, n=1, threads=0)
    with pytest.raises(ScenarioError, match="'speed' does not exist; available: qpos"):
        run_batch(SHORT, n=1, record=("speed",))


def test_a_model_with_other_coefficients_differs_run_by_run_and_the_controller_does_not_know():
    base = SHORT.with_values({"duration": 0.4, "sea.sea_state": 1})
    heavy = {"vehicles.auv.scale": {"mass": 1.1, "added_mass": 0.8, "displaced_volume": 1.01}}
    result = run_batch(base, [{"seed": 1}, {"seed": 1, **heavy}], record=("qpos", "wrench_command"))
    depth = result.signals["qpos"][:, -1, 9].values
    assert depth[1] < depth[0] - 1e-3  # 6 kg too heavy and not known to the controller: it sinks
    np.testing.assert_array_equal(*result.signals["wrench_command"][:, 0].values)
    log = run(base.with_values({"seed": 1, **heavy}))
    np.testing.assert_array_equal(log.data["qpos"], result.signals["qpos"][1])
    wrong = run_batch(base, [{"vehicles.auv.scale": {"weight": 1.1}}]).rows[0]
    assert "'weight'; 'scout' has mass, added_mass" in wrong["error"]


def test_contact_parts_of_runs_with_different_added_masses_that_share_a_model():
    """Constant radiation of the USV takes the added mass at the sea's peak."""
    base = Scenario.load("docking_demo").with_values(
        {
            "vehicles.usv.radiation": "constant",
            "vehicles.auv.position_ned": [10.0, 0.0, 0.53],
            "vehicles.auv.heading_deg": 0.0,
            "vehicles.auv.velocity_frd": [0.0, 0.0, -0.5, 0.0, 0.0, 0.0],
            "duration": 0.4,
        }
    )
    runs = [{"sea.sea_state": 3}, {"sea.sea_state": 6}]
    models = [compile_scene(base.with_values(changes), visual=False).model for changes in runs]
    assert not np.array_equal(models[0].pair_solref, models[1].pair_solref)
    together = run_batch(base, runs, record=["qpos"])
    for number, changes in enumerate(runs):
        alone = run_batch(base, [changes], record=["qpos"])
        assert together.rows[number]["peak_contact_force"] > 300
        np.testing.assert_array_equal(
            together.signals["qpos"].values[number], alone.signals["qpos"].values[0]
        )
