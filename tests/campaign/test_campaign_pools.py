"""Real workers: processes, Dask, dead workers, killed campaigns. The results never differ."""

import multiprocessing
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from campaign_helpers import CALM, DRAWN, Inline, die_at_run_2, draw, plan, read, report_of

from marine_mj.campaign import run_campaign
from marine_mj.campaign.folder import CampaignFolder
from marine_mj.campaign.pools import open_pool
from marine_mj.campaign.report import report
from marine_mj.campaign.worker import WORKER_DIED
from marine_mj.errors import CampaignError


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """Folder of the campaign, done in this process without any disturbance."""
    folder = tmp_path_factory.mktemp("campaign") / "undisturbed"
    run_campaign(plan(), folder, executor=Inline())
    report(folder)
    return folder


def assert_same(folder, other):
    """Same rows and same trajectories, bit for bit."""
    assert read(folder).equals(read(other))
    names = [file.name for file in CampaignFolder(other).chunk_files()]
    assert [file.name for file in CampaignFolder(folder).chunk_files()] == names
    for name in names:
        file = Path("trajectories") / name.replace(".parquet", ".nc")
        with xr.open_dataset(folder / file) as a, xr.open_dataset(other / file) as b:
            assert a.identical(b) and np.isfinite(a.eta_ned).all()


def test_one_and_two_processes_one_of_which_is_killed(undisturbed, tmp_path):
    killed = []

    def kill_one(progress):
        if not killed:
            victim = multiprocessing.active_children()[0]
            os.kill(victim.pid, signal.SIGKILL)
            killed.append(victim.pid)

    done = run_campaign(plan(), tmp_path / "two", workers=2, progress=kill_one)
    assert killed and done.errors == 0
    assert_same(tmp_path / "two", undisturbed)
    run_campaign(plan(), tmp_path / "one", workers=1)
    assert_same(tmp_path / "one", undisturbed)


def test_dask_on_this_machine(undisturbed, tmp_path):
    pytest.importorskip("distributed")
    run_campaign(plan(), tmp_path / "dask", workers=2, cluster="local")
    assert_same(tmp_path / "dask", undisturbed)


def test_dask_scheduler_and_two_workers_as_processes(undisturbed, tmp_path):
    pytest.importorskip("distributed")
    file = tmp_path / "scheduler.json"
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "cwd": tmp_path}
    here = str(Path(__file__).parent)
    environment = {**os.environ, "PYTHONPATH": here, "OMP_NUM_THREADS": "1"}
    module = [sys.executable, "-m", "distributed.cli"]
    scheduler = [module[0], "-m", "distributed.cli.dask_scheduler", "--host", "127.0.0.1"]
    scheduler += ["--port", "0", "--no-dashboard", "--scheduler-file", str(file)]
    worker = [module[0], "-m", "distributed.cli.dask_worker", "--scheduler-file", str(file)]
    worker += ["--nthreads", "1", "--no-dashboard", "--no-nanny", "--host", "127.0.0.1"]
    started = [subprocess.Popen(c, env=environment, **quiet) for c in (scheduler, worker, worker)]
    try:
        from distributed import Client

        with Client(scheduler_file=str(file), timeout=60) as client:
            client.wait_for_workers(2, timeout=60)
            address = client.scheduler.address
        run_campaign(plan(), tmp_path / "cluster", cluster=address)
    finally:
        for process in started:
            process.kill()
            process.wait()
    assert_same(tmp_path / "cluster", undisturbed)


def test_a_scheduler_that_is_not_there(monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr("marine_mj.campaign.pools._CONNECT", 0.5)
    with (
        pytest.raises(CampaignError, match=r"no Dask scheduler answers at 'tcp://127.0.0.1:9'"),
        open_pool(cluster="tcp://127.0.0.1:9"),
    ):
        pass


def kill_and_resume(folder, file, kills, rng):
    """Kill the campaign's command again and again, then let it finish."""
    seen: dict[str, int] = {}
    for i in range(kills + 1):
        command = "resume" if (folder / "manifest.json").is_file() else "run"
        arguments = ["campaign", command, str(file), "--out", str(folder), "--workers", "1"]
        process = subprocess.Popen(
            [sys.executable, "-m", "marine_mj.cli", *arguments],
            stderr=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
        )
        if i < kills:
            wait_until_killed(process, folder, len(seen), rng)
        else:
            assert process.wait(timeout=120) == 0, process.stderr.read().decode()
        now = {f.name: f.stat().st_mtime_ns for f in CampaignFolder(folder).chunk_files()}
        # Nothing that was finished is lost or written a second time.
        assert seen.items() <= now.items()
        seen = now


def wait_until_killed(process, folder, before, rng):
    """Kill at a random moment: anywhere from the start, or shortly after a chunk is finished."""
    soon = rng.random() < 0.3
    end = time.monotonic() + (rng.uniform(0.0, 4.0) if soon else 60.0)
    while time.monotonic() < end and process.poll() is None:
        if not soon and len(CampaignFolder(folder).chunk_files()) > before:
            break
        time.sleep(0.01)
    time.sleep(rng.uniform(0.0, 0.3))
    workers = Path(f"/proc/{process.pid}/task/{process.pid}/children")
    children = workers.read_text().split() if workers.exists() else []
    process.kill()
    process.wait()
    end = time.monotonic() + 20.0
    while any(alive(child) for child in children):
        assert time.monotonic() < end, "workers outlive the campaign that was killed"
        time.sleep(0.02)


def alive(pid):
    """Whether a process runs (a zombie does not)."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def killed_and_undisturbed(tmp_path, kills, seed):
    """Compare a campaign that is killed with one that is not."""
    file = tmp_path / "calm.toml"
    # Two cells, chunks of one run: more chunks than the kills let finish.
    file.write_text(
        CALM.replace("chunk = 3", "chunk = 1").replace("runs = 4", f"runs = {3 + kills}")
    )
    run_campaign(plan(file.read_text()), tmp_path / "b", executor=Inline())
    kill_and_resume(tmp_path / "a", file, kills, np.random.default_rng(seed))
    assert_same(tmp_path / "a", tmp_path / "b")
    report(tmp_path / "a")
    report(tmp_path / "b")
    assert report_of(tmp_path / "a") == report_of(tmp_path / "b")


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="needs /proc")
def test_a_killed_campaign_loses_nothing(tmp_path):
    killed_and_undisturbed(tmp_path, 1, 1)


@pytest.mark.validation
def test_a_campaign_killed_ten_times_loses_nothing(tmp_path):
    killed_and_undisturbed(tmp_path, 10, 2)


@pytest.mark.validation
@pytest.mark.parametrize("cluster", [None, "local"])
def test_the_run_that_kills_its_worker_is_a_row(tmp_path, cluster):
    made = plan(DRAWN)
    run_campaign(made, tmp_path / "a", workers=2, cluster=cluster, do=die_at_run_2)
    run_campaign(made, tmp_path / "b", executor=Inline(), do=draw)
    found, expected = read(tmp_path / "a"), read(tmp_path / "b")
    assert found.error[2] == WORKER_DIED and not found.success[2]
    assert found.drop(index=2).equals(expected.drop(index=2))
