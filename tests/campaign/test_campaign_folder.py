"""Folders: what is written, going on, refusals; runs in this process."""

import json
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from campaign_helpers import DRAWN, Inline, drawn, plan, read

from marine_mj.campaign import Campaign, Plan, load_plan, run_campaign
from marine_mj.campaign.folder import CampaignFolder
from marine_mj.campaign.replay import find_run
from marine_mj.campaign.status import status
from marine_mj.errors import CampaignError
from marine_mj.scenario import Scenario
from marine_mj.simulation import run


@pytest.fixture(scope="module")
def calm(tmp_path_factory):
    """Folder of a real campaign."""
    folder = tmp_path_factory.mktemp("campaign") / "calm"
    with ThreadPoolExecutor(1) as executor:
        run_campaign(plan(), folder, executor=executor)
    return folder


def test_status_of_a_campaign_that_has_finished_nothing_yet(calm, tmp_path):
    folder = shutil.copytree(calm, tmp_path / "begun")
    for file in (folder / "runs").glob("*.parquet"):
        file.unlink()
    (folder / "state.json").unlink(missing_ok=True)
    found = status(folder)
    assert found.progress.done == 0 and found.interval == (0.0, 1.0)


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


def test_plan_in_a_folder_is_the_plan_it_was_started_with(tmp_path):
    drawn(tmp_path)
    made = load_plan(tmp_path)
    assert made.base == plan(DRAWN).base and made.run(3) == plan(DRAWN).run(3)
    assert Plan(Campaign.load(tmp_path / "campaign.toml")).run(3) == made.run(3)
