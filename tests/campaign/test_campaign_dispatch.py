"""Dispatch of the work: faults of runs, workers, pools and disks; runs in this process."""

import errno
import os
import sys
import tracemalloc
from concurrent.futures import Future

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from campaign_helpers import CALM, DRAWN, Inline, draw, drawn, plan, read

from marine_mj.campaign import evaluate, run_campaign
from marine_mj.campaign.dispatch import dispatch
from marine_mj.campaign.folder import CampaignFolder
from marine_mj.campaign.pools import open_pool
from marine_mj.campaign.replay import replay
from marine_mj.campaign.status import status
from marine_mj.campaign.worker import WORKER_DIED, Done, Work, do
from marine_mj.errors import CampaignError


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
