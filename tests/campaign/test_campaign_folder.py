"""Folders: what is written, going on, refusals, stopping, faults; runs in this process."""

import errno
import json
import os
import subprocess
import sys
import tracemalloc
from concurrent.futures import Future, ThreadPoolExecutor

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from campaign_helpers import CALM, DRAWN, Inline, campaign, draw, plan, read
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from marine_mj.campaign import Campaign, Plan, evaluate, load_plan, run_campaign, run_together
from marine_mj.campaign.dispatch import dispatch
from marine_mj.campaign.folder import CampaignFolder
from marine_mj.campaign.pools import open_pool
from marine_mj.campaign.replay import find_run, replay
from marine_mj.campaign.status import status
from marine_mj.campaign.stopping import StoppingMonitor
from marine_mj.campaign.worker import WORKER_DIED, Done, Work, do
from marine_mj.errors import CampaignError
from marine_mj.scenario import Scenario
from marine_mj.simulation import run


def drawn(folder, text=DRAWN, resume=False, extend=False, **values):
    """Run a campaign whose outcomes are drawn."""
    return run_campaign(
        plan(text, **values), folder, executor=Inline(), do=draw, resume=resume, extend=extend
    )


@pytest.fixture(scope="module")
def calm(tmp_path_factory):
    """Folder of a real campaign."""
    folder = tmp_path_factory.mktemp("campaign") / "calm"
    with ThreadPoolExecutor(1) as executor:
        run_campaign(plan(), folder, executor=executor)
    return folder


def test_rows_are_those_of_the_single_runner(calm):
    rows = pd.read_parquet(calm / "runs")
    made = plan()
    assert list(rows.run) == list(range(8)) and list(rows.cell) == [0, 1] * 4
    for number in (0, 7):
        row, log = rows.iloc[number], run(made.scenario(number))
        assert row.seed == log.seed == made.run(number).seed
        assert Scenario.from_toml(row.scenario) == made.scenario(number)
        summary = json.loads(row.summary)
        assert summary["simulated_time"] == log.summary["simulated_time"] == row.simulated_time
        assert row.force == log.summary["peak_contact_force"]
        assert json.loads(row.versions)["mujoco"] == log.summary["versions"]["mujoco"]
    assert rows.success.all() and rows.error.isna().all() and rows.pitch_deg.isna().all()
    assert rows.success.dtype == bool and rows.north.dtype == float


def test_trajectories_are_those_of_the_single_runner(calm):
    made = plan()
    files = sorted((calm / "trajectories").glob("*.nc"))
    assert len(files) == 3
    with xr.open_mfdataset(files, engine="h5netcdf", combine="nested", concat_dim="run") as data:
        assert list(data.run) == list(range(8))
        log = run(made.scenario(4))
        assert np.array_equal(data.eta_ned.sel(run=4).values, log.data.eta_ned.values)


def test_pandas_polars_and_duckdb_read_the_folder(calm):
    rows = pd.read_parquet(calm / "runs")
    polars = pytest.importorskip("polars")
    for source in (calm / "runs", calm / "runs" / "*.parquet"):
        table = polars.read_parquet(source)
        assert table["north"].to_list() == rows.north.to_list()
    duckdb = pytest.importorskip("duckdb")
    query = f"select cell, count(*), avg(north) from '{calm}/runs/*.parquet' group by cell"
    found = sorted(duckdb.sql(query).fetchall())
    assert [n for _, n, _ in found] == [4, 4]
    means = rows.groupby("cell").north.mean()
    assert [m for *_, m in found] == pytest.approx(list(means), rel=1e-14)


def test_resuming_a_complete_campaign_computes_nothing(calm):
    before = {f.name: f.stat().st_mtime_ns for f in (calm / "runs").iterdir()}

    def never(work):
        raise AssertionError("nothing was missing")

    done = run_campaign(load_plan(calm), calm, resume=True, executor=Inline(), do=never)
    assert (done.done, done.total) == (8, 8)
    assert before == {f.name: f.stat().st_mtime_ns for f in (calm / "runs").iterdir()}
    assert status(calm).state == "complete"


def test_missing_and_damaged_chunks_are_computed_again_and_only_these(tmp_path):
    drawn(tmp_path / "a")
    before, files = read(tmp_path / "a"), CampaignFolder(tmp_path / "a").chunk_files()
    kept = files[1].stat().st_mtime_ns
    files[0].unlink()
    files[2].write_bytes(files[2].read_bytes()[:-40])
    (tmp_path / "a" / ".part" / "left behind").write_text("half a file")
    (tmp_path / "a" / "state.json").unlink()
    with pytest.raises(CampaignError, match=r"cannot be read \(damaged\?\): .*computes it again"):
        status(tmp_path / "a")
    drawn(tmp_path / "a", resume=True)
    assert read(tmp_path / "a").equals(before)
    assert files[1].stat().st_mtime_ns == kept
    assert not list((tmp_path / "a" / ".part").iterdir())


def test_extending_adds_runs_and_keeps_the_old_ones(tmp_path):
    drawn(tmp_path / "a", runs=4)
    old = {f.name: f.stat().st_mtime_ns for f in (tmp_path / "a" / "runs").iterdir()}
    with pytest.raises(CampaignError, match=r"campaign.runs: 4 -> 7 since .* give --extend"):
        drawn(tmp_path / "a", runs=7, resume=True)
    drawn(tmp_path / "a", runs=7, resume=True, extend=True)
    drawn(tmp_path / "a", runs=7, resume=True)
    drawn(tmp_path / "b", runs=7)
    assert read(tmp_path / "a").equals(read(tmp_path / "b"))
    now = {f.name: f.stat().st_mtime_ns for f in (tmp_path / "a" / "runs").iterdir()}
    assert old.items() <= now.items()
    with pytest.raises(CampaignError, match=r"campaign.runs: 7 -> 5"):
        drawn(tmp_path / "a", runs=5, resume=True, extend=True)


def test_changes_are_named_and_refused(tmp_path):
    drawn(tmp_path / "a")
    cases = [
        ({"seed": 6}, r"campaign.seed: 5 -> 6"),
        ({"chunk": 4}, r"campaign.chunk: 3 -> 4"),
        ({"set": {"duration": 0.3}}, r"scenario.duration: 0.2 -> 60"),
        ({"success": []}, r"campaign.success: \['docked == true'\] -> \[\]"),
        ({"metrics": {}}, r"campaign.metrics.force.key: 'force' -> nothing"),
    ]
    for values, message in cases:
        if "set" in values:
            message = r"scenario.duration: 0.2 -> 0.3"
        with pytest.raises(CampaignError, match=message + r".*start with a new --out"):
            drawn(tmp_path / "a", resume=True, extend=True, **values)
    manifest = json.loads((tmp_path / "a" / "manifest.json").read_text())
    manifest["versions"]["mujoco"], manifest["code"] = "3.1.0", "0" * 64
    (tmp_path / "a" / "manifest.json").write_text(json.dumps(manifest))
    with pytest.raises(CampaignError, match=r"code: mujoco 3\.1\.0 -> 3.*\(000000000000 -> "):
        drawn(tmp_path / "a", resume=True)
    assert len(read(tmp_path / "a")) == 8


def test_a_latin_hypercube_cannot_be_extended(tmp_path):
    text = DRAWN.replace("std = 0.2 }", 'std = 0.2 }\nsampling = "latin_hypercube"')
    drawn(tmp_path / "a", text)
    with pytest.raises(CampaignError, match="a Latin hypercube is drawn for a number of runs"):
        drawn(tmp_path / "a", text, resume=True, extend=True, runs=5)


def test_refusals_of_folders(tmp_path):
    with pytest.raises(CampaignError, match=r"no campaign in .*start it with `marine-mj campaign"):
        drawn(tmp_path / "none", resume=True)
    drawn(tmp_path / "a")
    with pytest.raises(CampaignError, match="holds a campaign already: go on with it by"):
        drawn(tmp_path / "a")
    (tmp_path / "file").write_text("")
    with pytest.raises(CampaignError, match=r"cannot write .*Not a directory"):
        drawn(tmp_path / "file" / "b")
    with pytest.raises(CampaignError, match=r"run 99 is not among the 8 finished runs"):
        find_run(tmp_path / "a", 99)
    (tmp_path / "a" / "manifest.json").write_text('{"format": 7}')
    with pytest.raises(CampaignError, match="has format 7; this version reads format 1"):
        status(tmp_path / "a")
    (tmp_path / "a" / "manifest.json").write_text("{")
    with pytest.raises(CampaignError, match=r"manifest.json' cannot be read"):
        status(tmp_path / "a")


def test_a_chunk_of_other_inputs_is_not_overwritten(tmp_path):
    drawn(tmp_path / "a")
    file = CampaignFolder(tmp_path / "a").chunk_files()[0]
    file.rename(file.with_name("chunk-00000000-0123456789abcdef.parquet"))
    with pytest.raises(CampaignError, match="holds the same runs, computed with other inputs"):
        drawn(tmp_path / "a", resume=True)


def test_two_processes_do_not_share_a_folder_and_a_dead_ones_lock_is_taken_over(tmp_path):
    drawn(tmp_path)
    code = (
        "import sys\nfrom marine_mj.campaign.folder import CampaignFolder\n"
        "with CampaignFolder(sys.argv[1]).lock():\n    print('held', flush=True)\n    input()\n"
    )
    other = subprocess.Popen(
        [sys.executable, "-c", code, str(tmp_path)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        assert other.stdout.readline() == "held\n"
        with pytest.raises(CampaignError, match=f"in use by process {other.pid} on .*: wait for"):
            drawn(tmp_path, resume=True)
        assert status(tmp_path).state.startswith(f"running, process {other.pid} on")
    finally:
        other.kill()
        other.wait()
    assert str(other.pid) in (tmp_path / "lock").read_text()
    assert drawn(tmp_path, resume=True).done == 8


def test_a_full_disk_ends_the_campaign_and_leaves_what_is_finished(tmp_path, monkeypatch):
    made, sync, calls = plan(DRAWN), os.fsync, []

    def full(handle):
        calls.append(handle)
        if len(calls) > 10:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        sync(handle)

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(CampaignError, match=r"No space left on device. Finished chunks are intact"):
        run_campaign(made, tmp_path / "a", executor=Inline(), do=draw)
    monkeypatch.undo()
    finished = CampaignFolder(tmp_path / "a").chunk_files()
    assert len(finished) == 2
    assert "interrupted" in status(tmp_path / "a").state
    drawn(tmp_path / "a", resume=True)
    drawn(tmp_path / "b")
    assert read(tmp_path / "a").equals(read(tmp_path / "b"))


def test_metrics_and_conditions_that_do_not_exist_are_refused(tmp_path):
    for values, message in (
        ({"metrics": {"m": "forc"}}, "metric 'm' asks for 'forc'"),
        ({"success": ["forc < 1"]}, "condition 'forc < 1' asks for 'forc'"),
        ({"metrics": {"w": "wall_time"}}, "metric 'w' asks for 'wall_time'"),
    ):
        with pytest.raises(CampaignError, match=message):
            drawn(tmp_path / message[:9].replace("'", ""), **values)


def test_failure_names_the_condition_and_the_value(tmp_path):
    drawn(tmp_path, success=["docked == true", "force < 600"], runs=30)
    rows = pd.read_parquet(tmp_path / "runs")
    summaries = rows.summary.map(json.loads)
    docked, light = summaries.map(lambda s: s["docked"]), rows.force < 600
    assert (rows.success == (docked & light)).all()
    assert (rows.failure[~docked] == "docked == true (was false)").all()
    heavy = rows[docked & ~light]
    assert len(heavy) and all(
        f"force < 600 (was {f}" in t for f, t in zip(heavy.force, heavy.failure, strict=True)
    )


def test_a_diverging_and_an_impossible_run_are_rows_that_can_be_replayed(tmp_path):
    text = (
        CALM.replace("[3.0, 4.0]", "[0.0, 1e5]")
        .replace("position_ned[2]", "velocity_frd[0]")
        .replace("parameters = { mean = 3.0, std = 0.2 }", "parameters = { values = [50.0, -1.0] }")
        .replace('"normal"', '"choice"')
        .replace("vehicles.auv.position_ned[0]", "water_density")
        .replace("[record]", "[record]\ndecimation = 2")
    )
    made = plan(text, runs=2, seed=1)
    densities = [made.run(i).factors["north"] for i in range(4)]
    assert 50.0 in densities and -1.0 in densities
    run_campaign(made, tmp_path, executor=Inline())
    rows = pd.read_parquet(tmp_path / "runs").set_index("run")
    for number, density in enumerate(densities):
        row = rows.loc[number]
        if density < 0:
            assert "water_density = -1.0" in row.error and row.scenario is None
            with pytest.raises(CampaignError, match=f"run {number} has no scenario to replay"):
                replay(tmp_path, number)
        elif row.depth > 0:
            assert "diverged at t =" in row.error and not row.success and row.failure == row.error
            again = replay(tmp_path, number)
            assert again.error in row.error and not again.differences and again.log.is_file()
        else:
            assert row.error is None and row.success
            again = replay(tmp_path, number, tmp_path / "again")
            assert again.error is None and not again.differences
    assert status(tmp_path).progress.errors == (rows.error.notna()).sum() >= 2


class BreakingPool:
    """A pool of two workers in this process, in which one run kills everything that is running."""

    shared_fate, slots, retries = True, 2, 2

    class Died(Exception):
        """A worker is gone."""

    died = (Died,)

    def __init__(self, culprits):
        self.culprits, self.restarts, self.broken, self.calls = culprits, 0, False, 0

    def submit(self, function, work):
        """Future; a broken pool refuses until its restart."""
        if self.broken:
            raise self.Died
        self.calls += 1
        assert self.calls < 200
        future = Inline().submit(function, work)
        if any(v["seed"] in self.culprits for v in work.variations):
            self.broken = True
            future = Inline().submit(self._die)
        return future

    def _die(self):
        raise self.Died

    def restart(self):
        """Usable again."""
        self.restarts, self.broken = self.restarts + 1, False


def test_dispatch_finds_the_run_that_kills_its_worker():
    work = [
        Work("", tuple({"seed": s, "vehicles.auv.position_ned": [0, 0, 3]} for s in seeds))
        for seeds in ((0, 1, 2), (3, 4, 5, 6), (7, 8), (9,))
    ]
    pool = BreakingPool({5, 9})
    found = dict(dispatch(iter(enumerate(work)), pool, draw))
    assert sorted(found) == [0, 1, 2, 3]
    for name, item in enumerate(work):
        for variation, row in zip(item.variations, found[name].rows, strict=True):
            if variation["seed"] in (5, 9):
                assert row["error"] == WORKER_DIED
            else:
                again = draw(Work("", (variation,))).rows[0]
                assert row["docked"] == again["docked"] and row["force"] == again["force"]
    assert pool.restarts <= 14  # 3 beside others, then per halving 2; measured 14


class CancellingExecutor:
    """An executor that gives everything up, as Dask's does without its scheduler."""

    def submit(self, function, *arguments):
        """Cancelled future."""
        future = Future()
        future.cancel()
        future.set_running_or_notify_cancel()
        return future


def test_a_pool_that_gives_up_ends_the_campaign(tmp_path):
    with pytest.raises(
        CampaignError, match=r"the pool gave its work up.*Finished chunks are intac"
    ):
        run_campaign(plan(DRAWN), tmp_path, executor=CancellingExecutor(), do=draw)
    assert drawn(tmp_path, resume=True).done == 8


def test_a_worker_with_other_code_is_refused(tmp_path):
    work = Work(plan().base.to_toml(), (plan().run(0).variation,), fingerprint="0" * 64)
    with pytest.raises(CampaignError, match="a worker has other code, package versions or models"):
        do(work)


def test_signals_of_parts_keep_their_run_numbers():
    made = plan()
    variations = tuple(made.run(i).variation for i in range(3))
    whole = do(Work(made.base.to_toml(), variations, ("eta_ned",)))
    first, rest = Work(made.base.to_toml(), variations, ("eta_ned",)).halves()
    parts = do(first) + do(rest)
    assert whole.signals.equals(parts.signals)
    lost = Done([{"error": WORKER_DIED}]) + parts
    assert list(lost.signals.run) == [1, 2, 3]


@settings(max_examples=40, deadline=None)
@given(st.permutations(range(12)), st.sampled_from([0.25, 0.4, 0.6]))
def test_the_stopping_point_does_not_depend_on_the_order_of_chunks(order, width):
    values = [(i % 2, float(i % 5 != 0)) for i in range(120)]
    made = campaign(DRAWN, chunk=10, stopping={"width": width, "minimum": 5})
    monitor = StoppingMonitor(made, 2)
    for chunk in order:
        monitor.add(10 * chunk, values[10 * chunk : 10 * chunk + 10])
    assert monitor.stopped_at == expected_stop(values, 10, width, 5)


def expected_stop(values, every, width, minimum):
    """Where scipy's Wilson intervals of both cells become narrow."""
    for n in range(every, len(values) + 1, every):
        widths = []
        for cell in (0, 1):
            part = [v for c, v in values[:n] if c == cell]
            ends = stats.binomtest(int(sum(part)), len(part)).proportion_ci(method="wilson")
            widths.append(ends.high - ends.low if len(part) >= minimum else np.inf)
        if max(widths) <= width:
            return n
    return None


def test_stopping_on_success_leaves_the_same_runs_with_any_executor_or_interruption(tmp_path):
    values = {"runs": 60, "chunk": 6, "stopping": {"width": 0.35, "every": 12}}
    everything = {k: v for k, v in values.items() if k != "stopping"}
    drawn(tmp_path / "all", **everything)
    rows = read(tmp_path / "all")
    stop = expected_stop(
        list(zip(rows.cell, rows.success.astype(float), strict=True)), 12, 0.35, 10
    )
    assert 24 <= stop < 120
    done = drawn(tmp_path / "a", **values)
    assert done.done == stop and read(tmp_path / "a").equals(rows.head(stop))
    with ThreadPoolExecutor(4) as executor:
        run_campaign(plan(DRAWN, **values), tmp_path / "b", executor=executor, workers=4, do=draw)
    assert read(tmp_path / "b").equals(rows.head(stop))
    for file in CampaignFolder(tmp_path / "b").chunk_files()[1::2]:
        file.unlink()
    drawn(tmp_path / "b", resume=True, **values)
    assert read(tmp_path / "b").equals(rows.head(stop))
    assert status(tmp_path / "b").state.startswith("stopped by its rule: success known within 0.")


def test_stopping_on_the_mean_of_a_metric(tmp_path):
    values = {"runs": 100, "stopping": {"metric": "force", "width": 250.0, "every": 6}}
    done = drawn(tmp_path / "a", **values)
    rows = read(tmp_path / "a")

    def widest(n):
        parts = [rows.head(n).query(f"cell == {cell}").force for cell in (0, 1)]
        ends = [stats.t.interval(0.95, len(x) - 1, x.mean(), stats.sem(x)) for x in parts]
        return max(high - low for low, high in ends)

    assert widest(done.done) <= 250.0 < widest(done.done - 6)
    about = json.loads((tmp_path / "a" / "state.json").read_text())["stopped"]
    assert about["width"] == pytest.approx(widest(done.done), rel=1e-10)


def test_memory_does_not_grow_with_the_number_of_runs(tmp_path):
    def heavy(work):
        done = draw(work)
        n = len(done.rows)
        data = xr.Dataset({"x": (("run", "time"), np.zeros((n, 100_000)))}, {"run": np.arange(n)})
        return Done(done.rows, data)

    def peak(runs):
        tracemalloc.start()
        run_campaign(
            plan(DRAWN, runs=runs, chunk=4), tmp_path / str(runs), executor=Inline(), do=heavy
        )
        _, high = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        return high

    peak(2)
    # 3.2 MB of signals per chunk; measured 13.13 MB for 4 chunks, 13.06 MB for 20.
    assert peak(40) < 1.05 * peak(8)


def test_evaluate_gives_rows_in_order():
    made = plan()
    variations = [made.run(i).variation for i in range(3)]
    rows = evaluate(made.base, variations, executor=Inline(), chunk=2)
    for number, row in enumerate(rows):
        assert row["seed"] == made.run(number).seed and row["error"] is None


def test_refusals_of_pools(monkeypatch):
    for arguments, message in (
        ({"workers": 0}, "workers = 0 is not allowed: 1 or more"),
        ({"cluster": "here"}, "cluster = 'here' is not allowed: 'local', or the address"),
        ({"cluster": "tcp://a:1", "workers": 2}, "workers = 2 does not go with cluster = 'tcp"),
    ):
        with pytest.raises(CampaignError, match=message), open_pool(**arguments):
            pass
    monkeypatch.setitem(sys.modules, "distributed", None)
    with (
        pytest.raises(
            CampaignError, match=r"needs dask.distributed .*pip install 'marine-mj\[clus"
        ),
        open_pool(cluster="local"),
    ):
        pass


def test_plan_in_a_folder_is_the_plan_it_was_started_with(tmp_path):
    drawn(tmp_path)
    made = load_plan(tmp_path)
    assert made.base == plan(DRAWN).base and made.run(3) == plan(DRAWN).run(3)
    assert Plan(Campaign.load(tmp_path / "campaign.toml")).run(3) == made.run(3)


def test_campaigns_with_a_stopping_rule_or_signals_do_not_go_together(tmp_path):
    with pytest.raises(CampaignError, match=r"rare, stopping or record\.signals.*run_campaign"):
        run_together({tmp_path / "a": plan(CALM)})
    assert not (tmp_path / "a").exists()
