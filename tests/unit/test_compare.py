"""Comparisons: which runs are made, what they are called, and the table of limit sea states."""

import pytest

from marine_mj import demo
from marine_mj.campaign.pools import Here
from marine_mj.cli import main
from marine_mj.compare import Variant, variants, variants_at_limit
from marine_mj.compare_command import varied_values
from marine_mj.errors import AnalysisError, ScenarioError
from marine_mj.limits import LimitTable, measure_limits
from marine_mj.scenario import Scenario

KEY = "task.settings.controller"


def table(**success: str) -> LimitTable:
    """Table of two seeds and sea states 4 to 6 from "11 10": runs at 4, runs at 5."""
    runs = {
        name: tuple(tuple(digit == "1" for digit in state) for state in text.split())
        for name, text in success.items()
    }
    return LimitTable(
        scenario="docking_demo", duration=90, seeds=(7, 8), sea_states=(4, 5, 6), success=runs
    )


def test_values_of_the_command_line():
    assert varied_values(f"{KEY}=cpv, mpc") == (KEY, ["cpv", "mpc"])
    assert varied_values("sea.sea_state=4,5") == ("sea.sea_state", [4, 5])
    assert varied_values("plan.corridor=[[0.3, 0.2], [0.4, 0.3]]")[1] == [[0.3, 0.2], [0.4, 0.3]]
    for text in ("cpv,mpc", "=cpv", "key="):
        with pytest.raises(ScenarioError, match=r"is not KEY=VALUE,VALUE,..., such as"):
            varied_values(text)


def test_all_combinations_with_a_dense_log_and_a_name():
    base = Scenario.load("docking_demo")
    found = variants(base, {KEY: ["cpv", "mpc"], "sea.sea_state": [4, 5]})
    assert [variant.title for variant in found] == ["cpv, 4", "cpv, 5", "mpc, 4", "mpc, 5"]
    assert found[2].scenario.task.settings["controller"] == "mpc"
    assert [variant.scenario.sea.sea_state for variant in found] == [4, 5, 4, 5]
    assert all(v.scenario.log_period == v.scenario.control_period == 0.01 for v in found)
    assert all(variant.scenario.seed == base.seed for variant in found)
    assert Variant.of(base, {KEY: "lqr"}).title == "lqr, sea state 4"
    with pytest.raises(ScenarioError, match="nothing is compared: give values, such as --vary"):
        variants(base, {})


def test_limits_end_at_the_first_failure():
    found = table(cpv="11 11 11", mpc="11 10", lqr="10 11 11")
    assert [found.limit(name) for name in ("cpv", "mpc", "lqr")] == [6, 4, None]
    assert found.count("mpc", 5) == 1
    assert found.seed(["cpv", "mpc"], 5) == 7
    with pytest.raises(AnalysisError, match=r"'mpc' was not measured at sea state 6, only at 4, 5"):
        found.count("mpc", 6)
    with pytest.raises(AnalysisError, match=r"'pid' is not in the table of limits; it has cpv"):
        found.limit("pid")
    other = table(cpv="10", mpc="01")
    with pytest.raises(AnalysisError, match="with no seed of 7, 8 all of cpv, mpc dock at sea"):
        other.seed(["cpv", "mpc"], 4)


def test_runs_at_the_limits():
    found = table(cpv="11 11 11", mpc="11 11 01", lqr="11 00", pose_pid="00")
    same = variants_at_limit(found, shared=True)
    assert [v.title for v in same] == [f"{n}, sea state 4" for n in ("cpv", "mpc", "lqr")]
    assert {(v.scenario.sea, v.scenario.seed) for v in same} == {(same[0].scenario.sea, 7)}
    own = variants_at_limit(found, shared=False)
    assert [(v.scenario.sea.sea_state, v.scenario.seed) for v in own] == [(6, 7), (5, 7), (4, 7)]
    assert own[0].scenario.duration == 90
    with pytest.raises(ScenarioError, match="no controller of cpv docks at sea state 4"):
        variants_at_limit(table(cpv="00"), shared=True)


def test_the_packaged_table_is_of_the_demonstration():
    found = LimitTable.load()
    assert found.scenario == "docking_demo" and len(found.seeds) == 10
    assert set(found.success) == {"pose_pid", "cpv", "cpva", "lqr", "sliding", "mpc"}
    for name, runs in found.success.items():
        # Measured to the end: every controller has failed somewhere.
        assert sum(runs[-1]) < 9, name
        assert found.limit(name) == found.sea_states[len(runs) - 2]
    # There is a sea for all of them.
    lowest = min(found.limit(name) for name in found.success)
    assert found.seed(list(found.success), lowest) in found.seeds


def test_a_bad_table_is_refused(tmp_path):
    with pytest.raises(AnalysisError, match=r"cannot be read: .*marine-mj limits"):
        LimitTable.load(tmp_path / "none.json")
    file = tmp_path / "bad.json"
    file.write_text('{"scenario": "docking_demo"}')
    with pytest.raises(ScenarioError, match=r"(?s)table of limits bad.json: .*seeds is missing"):
        LimitTable.load(file)


def test_measuring_stops_at_the_first_sea_state_that_is_too_much(monkeypatch):
    """Here the vehicle docks up to sea state 5, but for one crash of seed 1 at sea state 4."""
    flown = []

    class Result:
        def __init__(self, changes):
            flown.extend(changes)
            self.rows = [
                {
                    "docked": change["sea.sea_state"] <= 5,
                    "forbidden_contact": (change["sea.sea_state"], change["seed"]) == (4, 1),
                    "error": None,
                }
                for change in changes
            ]

    monkeypatch.setattr("marine_mj.simulation.run_batch", lambda _, changes, **__: Result(changes))
    told = []
    found = measure_limits(
        *("docking_demo", ["cpv"], [7, 4, 5, 6], range(10)),
        executor=Here(),
        progress=lambda *a: told.append(a),
    )
    assert [found.count("cpv", state) for state in (4, 5, 6)] == [9, 10, 0]
    assert found.limit("cpv") == 5 and len(flown) == 30 and told == [(1, 1)]


def test_the_command_runs_and_films(tmp_path, monkeypatch, capsys):
    filmed = {}

    def video(logs, path, progress, **options):
        filmed.update(logs=logs, path=path, **options)

    monkeypatch.setattr(demo, "video", video)
    monkeypatch.setattr("marine_mj.video.require_gl", lambda: None)
    arguments = ["compare", "docking_demo", "--vary", f"{KEY}=cpv,pose_pid", "--sea-state", "5"]
    more = ["--set", "duration=0.05", "--seed", "4", "-o", str(tmp_path / "a.mp4")]
    with pytest.raises(SystemExit) as end:
        main([*arguments, *more, "--logs", str(tmp_path / "logs"), "--contact-speed", "0.1"])
    assert end.value.code == 0
    assert filmed["titles"] == ["cpv, sea state 5", "pose_pid, sea state 5"]
    assert filmed["contact_speed"] == 0.1 and filmed["path"] == tmp_path / "a.mp4"
    first, second = filmed["logs"]
    assert first.seed == second.seed == 4 and len(first.data.time) == 6
    assert first.scenario.sea == second.scenario.sea
    names = sorted(path.name for path in (tmp_path / "logs").iterdir())
    assert names == ["cpv_sea_state_5.nc", "pose_pid_sea_state_5.nc"]
    assert "latch, s" in capsys.readouterr().out
