"""The docking study done again: its numbers as data, the judgement, and a tiny reproduction."""

import json
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from contextlib import nullcontext
from dataclasses import replace
from typing import get_args

import numpy as np
import pytest

from marine_mj import cli
from marine_mj.analysis.docking import Entries
from marine_mj.campaign import worker
from marine_mj.campaign.pools import Here
from marine_mj.errors import AnalysisError, CampaignError
from marine_mj.reproduce import (
    CONFIGURATIONS,
    TABLES,
    Cells,
    judge,
    reasons,
    rows_of,
    run_configurations,
    runner,
    write_report,
)
from marine_mj.reproduce.judgement import TOLERANCE
from marine_mj.reproduce.runner import block_plan
from marine_mj.simulation.batch import run_scenarios

KEYS = {"quantity", "published", "ours", "interval", "unit", "verdict", "note"}


def line(number):
    return next(row for row in rows_of() if row.line == number)


def entries(state, runs=60, surge=0.05, energy=1.0, missing=0):
    """Runs whose spread grows with the sea state."""
    rng = np.random.default_rng(state)
    metrics = [surge * state * rng.normal(size=runs), 0.02 * rng.normal(size=runs)]
    values = np.array([*metrics, energy * rng.gamma(4.0, 1.0, size=runs)])
    values[:, :missing] = np.nan
    return Entries(*values)


def cells(last, **changes):
    return Cells({s: entries(s, **changes) for s in range(1, last + 1)}, {}, 120.0)


@pytest.mark.parametrize(
    ("number", "table", "label", "values"),
    [
        (2573, "7.12", "manual pose", (2, 5, 4, 2, 14.8)),
        (2576, "7.12", "CPVA", (7, 8, 6, 6, 82.7)),
        (2594, "7.13", "kinematic 2.0 s", (5, 6, 7, 5, 59.4)),
        (2615, "7.14", "polynomial, second order", (7, 8, 6, 6, 82.7)),
        (2633, "7.15", "1.0 m/s", (8, 6, 6, 6, 82.7)),
        (2649, "7.16", "0.7 m/s", (7, 7, 7, 7, 93.6)),
        (2662, "7.17", "0.5 m/s", (6, 6, 6, 6, 82.7)),
        (3164, "8.9", "t_z 2.0 s", (None, 0, 0, None, 0.0)),
        (3169, "8.9", "t_z 0.04 s", (5, 8, 6, 5, 59.4)),
        (3189, "8.10", "t_z 0.04 s", (8, 8, 8, 8, 98.3)),
        (3218, "8.12", "pose and velocity worst", (None, None, 2, None, 0.0)),
        (3234, "8.13", "pose and velocity best", (7, 7, 7, 7, 93.6)),
        (3265, "8.15", "acceleration worst", (2, 8, 5, 2, 14.8)),
        (3283, "8.16", "acceleration worst", (0, 7, 6, 0, 0.0)),
    ],
)
def test_lines_are_those_of_the_study(number, table, label, values):
    row = line(number)
    columns = ("surge", "pitch", "energy", "total", "uptime")
    assert (row.table, row.label) == (table, label)
    assert tuple(row.published(name) for name in columns) == values


def test_totals_are_the_least_of_their_columns_after_the_errata():
    for row in rows_of():
        parts = [-1 if v is None else v for v in (row.surge, row.pitch, row.energy)]
        total = -1 if row.total is None else row.total
        assert total == min(parts), row
    assert {row.line for row in rows_of() if row.printed} == {2630, 3262}
    assert line(3262).printed == {"total": 5.0, "uptime": 59.4}


def test_tables_and_their_configurations():
    assert {name: len(rows) for name, rows in TABLES.items()} == {
        **{"7.12": 4, "7.13": 4, "7.14": 3, "7.15": 4, "7.16": 4, "7.17": 4},
        **{"8.9": 7, "8.10": 6, "8.12": 4, "8.13": 4, "8.15": 4, "8.16": 4},
    }
    assert {row.configuration for row in rows_of()} == set(CONFIGURATIONS)


def test_configurations_are_what_the_study_flew():
    def settings(name):
        plan = block_plan(CONFIGURATIONS[name], [4], 2)
        return plan.base, plan.base.task.settings

    base, cpv = settings("cpv_wait_1.0_fix_worst")
    assert base.duration == 300.0 and base.vehicles["auv"].position_ned == (7.0, 0.0, 4.0)
    assert base.vehicles["usv"].position_ned[0] == 10.0
    assert (cpv["controller"], cpv["gains"]) == ("cpv", "reference")
    assert cpv["plan"]["wait_speed"] == 1.0 and cpv["end_at_capture"]
    assert cpv["navigation"]["scenario"] == "fix_worst"
    base, second = settings("polynomial_2")
    assert base.duration == 120.0
    expected = {"kind": "polynomial", "of": "both", "order": 2, "t_past": 0.04, "t_pred": 0.2}
    assert expected.items() <= second["prediction"].items()


def test_common_seeds_over_configurations():
    plans = [block_plan(CONFIGURATIONS[n], [4, 5], 3) for n in ("manual", "cpva_wait_0.5")]
    seeds = [[plan.run(i).seed for i in range(6)] for plan in plans]
    assert seeds[0] == seeds[1] and len(set(seeds[0])) == 3


def test_judgement_names_what_ends_the_sea_states():
    # Half width of the 99.7 % interval: 2.97 * 0.05 m per sea state, so sea state 3 is the last one
    # within 0.5 m (sample standard deviations: 0.42 m there, 0.59 m at 4).
    surge, pitch, energy, total, uptime = judge(line(2573), cells(5), resamples=50)
    assert (surge.ours, pitch.ours, energy.ours, total.ours) == (3, 5, 5, 3)
    assert [j.verdict for j in (surge, pitch, energy, total)] == ["agrees"] * 4
    assert surge.interval[0] <= 3 <= surge.interval[1]
    assert uptime.ours == pytest.approx(22.7, abs=0.01) and uptime.verdict == "agrees"
    far = judge(line(2576), cells(5), resamples=50)[0]
    assert far.published == 7 and far.ours == 3 and far.verdict == "differs"
    assert "at sea state 4 99.7 % of the runs have surge" in far.note and "limit 0.5" in far.note
    better = judge(line(2573), cells(5, surge=0.01), resamples=50)[0]
    assert better.ours == 5 and better.verdict == "differs"
    assert "ours still holds at sea state 3: 99.7 % of the runs have surge" in better.note


def test_termination_rule_and_none_at_all():
    found = cells(3, surge=0.01)
    found.entries[4] = entries(4, missing=2)
    total = judge(line(2576), found, resamples=20)[3]
    assert (
        total.ours == 3 and "2 of 60 runs did not enter in 120 s, which ends the line" in total.note
    )
    nothing = judge(line(2576), Cells({1: entries(1, surge=9.0)}, {}, 120.0), resamples=20)
    assert nothing[3].ours is None and nothing[3].interval == (0.0, 0.0)
    assert nothing[4].ours == 0.0 and nothing[4].note == "follows from the total"


def test_what_is_not_comparable():
    cut = judge(line(2576), cells(2), highest=2, resamples=20)[0]
    assert cut.verdict == "not comparable" and "above 2 were not run" in cut.note
    # An end below the cut is an end.
    assert judge(line(2573), cells(4), highest=4, resamples=20)[0].verdict == "agrees"
    diverged = replace(cells(5), errors={2: 3})
    far = judge(line(2576), diverged, resamples=20)[0]
    assert far.verdict == "not comparable" and "3 runs ended with an error" in far.note


def test_misprints_are_named():
    found = {j.column: j for j in judge(line(2630), cells(5), resamples=20)}
    assert found["total"].published == 6 and "the study prints 5" in found["total"].note


def test_tiny_reproduction_report_and_resume(tmp_path, capsys):
    command = ["reproduce", "docking", "--tables", "7.13", "--runs", "2", "--highest", "2"]
    rows = [line(2591)]
    seen = []
    # In a process of its own, as the command does it; later in this one, which need not start.
    first = run_configurations(
        rows, tmp_path, 2, highest=2, workers=1, progress=lambda *now: seen.append(now)
    )
    assert seen[-1] == (2, 2)

    def run(runs):
        return run_configurations(rows, tmp_path, runs, highest=2, executor=Here())

    result = first["brute_force"].entries
    assert sorted(result) == [0, 1, 2] and all(e.complete for e in result.values())
    # Measured: surge 0.00 to 0.01 m, 3 to 8 J; calm water has no scatter at all.
    assert np.ptp(result[0].surge) == 0 and np.ptp(result[1].surge) > 0
    assert np.abs(result[2].surge).max() < 0.2 and result[2].energy.max() < 30

    files = {f: f.stat().st_mtime_ns for f in tmp_path.rglob("*.parquet")}
    again = run(2)
    assert {f: f.stat().st_mtime_ns for f in tmp_path.rglob("*.parquet")} == files and files
    np.testing.assert_array_equal(again["brute_force"].entries[2].surge, result[2].surge)
    more = run(3)
    kept = more["brute_force"].entries[2].surge[:2]
    np.testing.assert_array_equal(kept, result[2].surge)
    with pytest.raises(CampaignError, match=r"campaign\.runs: 3 -> 2"):
        run(2)

    write_report(rows, more, tmp_path, highest=2, resamples=20)
    report = json.loads((tmp_path / "report.json").read_text())
    assert len(report) == 5 and all(set(row) == KEYS for row in report)
    verdicts = {"agrees", "differs", "not comparable"}
    assert all(row["verdict"] in verdicts and len(row["interval"]) == 2 for row in report)
    assert report[0]["quantity"] == "table 7.13, kinematic 0.0 s: maximum sea state, surge"
    assert (report[0]["published"], report[0]["ours"]) == (6.0, 2.0)
    assert report[4]["unit"] == "%"
    page = (tmp_path / "report.md").read_text()
    assert "| kinematic 0.0 s | 6 -> 2 [2, 2] (not comparable) |" in page
    assert (tmp_path / "table_7.13.png").stat().st_size > 10_000

    with pytest.raises(SystemExit) as stop:
        cli.main([*command, "--full", "--out", str(tmp_path)])
    assert stop.value.code == 1 and "leave out --runs 2" in capsys.readouterr().err


def test_configurations_in_common_batches_are_those_alone(tmp_path):
    """Gain sets, waiting, durations: the same bits with company and without, drop-outs included."""
    rows = [line(2573), line(2574), line(2633)]
    short = {"duration": 9.0, "vehicles.auv.position_ned": [9.0, 0.0, 3.5]}
    calls = []

    def batch(scenarios, **options):
        calls.append(len(scenarios))
        return run_scenarios(scenarios, **options)

    def results(place, chosen):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(worker, "run_scenarios", batch)
            return run_configurations(chosen, place, 2, highest=2, changes=short, executor=Here())

    together = results(tmp_path / "together", rows)
    # Calm water (brute_force only; table 8.9 begins there), then twice two sea states and two runs
    # of all that are left.
    company, calls[:] = list(calls), []
    alone = [results(tmp_path / "alone", [row]) for row in rows]
    assert len(company) < len(calls) and sum(company) == sum(calls)
    for row, cells in zip(rows, alone, strict=True):
        mine, other = cells[row.configuration].entries, together[row.configuration].entries
        assert list(mine) == list(other)
        for state in mine:
            for metric in ("surge", "pitch", "energy"):
                np.testing.assert_array_equal(
                    getattr(mine[state], metric), getattr(other[state], metric)
                )
    # A folder of one arrangement serves in the other, and nothing is run again.
    calls.clear()
    results(tmp_path / "together", rows[:1])
    assert not calls
    with pytest.raises(CampaignError, match=r"scenario\.duration: 9\.0 -> "):
        run_configurations(rows[:1], tmp_path / "alone", 2, highest=2, executor=Here())


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["viknes"], "cannot reproduce 'viknes'; available: docking"),
        (["docking", "--tables", "7.12,9.1"], "table '9.1' is not among those"),
        (["docking", "--runs", "1"], "runs = 1 per sea state: allowed are 2 or more"),
        (["docking", "--highest", "0"], "highest sea state 0 is below 1, the first one of table"),
    ],
)
def test_refusals(capsys, tmp_path, arguments, message):
    with pytest.raises(SystemExit) as stop:
        cli.main(["reproduce", *arguments, "--out", str(tmp_path)])
    assert stop.value.code == 1 and message in capsys.readouterr().err.replace("\n", " ")


def test_command_says_how_long_it_takes_and_how_it_goes_on(capsys, tmp_path, monkeypatch):
    def stopped(*arguments, **settings):
        raise KeyboardInterrupt

    monkeypatch.setattr("marine_mj.reproduce.run_configurations", stopped)
    with pytest.raises(SystemExit) as stop:
        cli.main(["reproduce", "docking", "--full", "--workers", "2", "--out", str(tmp_path)])
    told = capsys.readouterr().err
    assert stop.value.code == 1 and "give the same command again" in told
    # 20 min times 2.2 with 60 runs on two processors (docs/reproduce.md).
    assert "40 configurations, 1000 runs per sea state" in told and "about 12.2 h from" in told
    with pytest.raises(SystemExit):
        cli.main(
            ["reproduce", "docking", "--full", "--tables", "7.12", "--highest", "1",
             "--workers", "2", "--out", str(tmp_path)]
        )  # fmt: skip
    assert "4 configurations" in (told := capsys.readouterr().err) and "about 6.1 min" in told


def test_changes_need_a_folder_of_their_own(capsys):
    with pytest.raises(SystemExit) as stop:
        cli.main(["reproduce", "docking", "--set", "sea.components=20"])
    assert stop.value.code == 1 and "give it an --out of its own" in capsys.readouterr().err


def test_an_empty_choice_is_refused():
    with pytest.raises(AnalysisError, match=r"there are 7\.12, 7\.13"):
        rows_of([])


def test_a_killed_worker_is_named(tmp_path, monkeypatch):
    class Dead:
        died = (BrokenProcessPool,)
        slots = 1

        def submit(self, *_):
            future = Future()
            future.set_exception(BrokenProcessPool())
            return future

    monkeypatch.setattr(runner, "open_pool", lambda *_, **__: nullcontext(Dead()))
    with pytest.raises(
        CampaignError, match=r"worker was killed while it ran manual in .*same command again"
    ):
        run_configurations([line(2573)], tmp_path)


def test_a_folder_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(CampaignError, match=r"cannot write the report to .*file.*runs are intact"):
        write_report([line(2573)], {"manual": cells(2)}, tmp_path / "file", resamples=5)


def test_reasons_belong_to_configurations():
    for name, columns, when, text in reasons.REASONS:
        assert any(c.startswith(name) for c in CONFIGURATIONS) and set(columns) <= set(TOLERANCE)
        assert when in get_args(reasons.When) and 40 < len(text) < 250
    assert "chatter" in reasons.reason("kinematic_2", "energy", -7, late=True)
    assert "2 %" in reasons.reason("brute_force_acceleration_worst", "surge", 4)
    assert "not published" in reasons.reason("cpva", "surge", 1)


def test_reasons_are_given_only_where_they_hold():
    # kinematic 1.0 s is told to chatter because runs come late: not where all of them enter
    assert "dock offset" in reasons.reason("kinematic_1", "total", -3, late=False)
    # the parabola explains why ours ends earlier, not why it might end later
    assert "parabola" in reasons.reason("polynomial_2", "surge", -4)
    assert "parabola" not in reasons.reason("polynomial_2", "surge", 2)
    assert "scatters less" not in reasons.reason("kinematic_0.4", "surge", -2)


def test_navigation_that_differs_in_surge_is_told_what_the_filters_know():
    base = next(r for r in TABLES["8.12"] if r.label == "base")
    assert base.noise == "base" and line(2573).noise is None
    calm = Cells({s: entries(s, surge=0.01) for s in range(9)}, {}, 120.0)
    surge, _, energy, *_ = judge(base, calm, resamples=20)
    assert surge.verdict == "differs" and "are within 0.31 m" in surge.note
    assert "filters alone" not in energy.note
