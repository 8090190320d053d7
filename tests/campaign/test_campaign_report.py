"""Reports: numbers against scipy and closed forms, files; commands and their messages."""

import numpy as np
import pandas as pd
import pytest
from campaign_helpers import CALM, DRAWN, Inline, draw, plan, report_of
from scipy import stats

from marine_mj import cli
from marine_mj.campaign import run_campaign
from marine_mj.campaign.folder import CampaignFolder
from marine_mj.campaign.report import describe, report
from marine_mj.errors import CampaignError


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Folder of a campaign with drawn outcomes and its report."""
    path = tmp_path_factory.mktemp("report") / "drawn"
    run_campaign(plan(DRAWN, runs=60), path, executor=Inline(), do=draw)
    report(path)
    return path


def test_success_and_convergence_are_scipys(folder):
    rows, found = pd.read_parquet(folder / "runs"), report_of(folder)
    assert found["runs"] == found["planned"] == 120 and found["errors"] == 0
    assert len(found["cells"]) == 2 and [c["factors"]["depth"] for c in found["cells"]] == [3, 4]
    for cell in [*found["cells"], found["success"]]:
        part = rows if "cell" not in cell else rows[rows.cell == cell["cell"]]
        ends = stats.binomtest(int(part.success.sum()), len(part)).proportion_ci(method="wilson")
        assert (cell["n"], cell["successes"]) == (len(part), part.success.sum())
        assert cell["low"] == pytest.approx(ends.low, abs=1e-12)  # measured 2e-16
        assert cell["high"] == pytest.approx(ends.high, abs=1e-12)  # measured 1e-16
    for point in found["convergence"]:
        assert point["probability"] == pytest.approx(
            rows.success.head(point["n"]).mean(), abs=1e-15
        )
    assert found["convergence"][-1]["n"] == 120


def test_metrics_and_fits_are_scipys(folder):
    rows, found = pd.read_parquet(folder / "runs"), report_of(folder)
    for cell in found["cells"]:
        x, metric = rows[rows.cell == cell["cell"]].force, cell["metrics"]["force"]
        low, high = stats.t.interval(0.95, len(x) - 1, x.mean(), stats.sem(x))
        expected = {"mean": x.mean(), "std": x.std(), "mean_low": low, "mean_high": high}
        expected |= {"min": x.min(), "median": x.median(), "q95": x.quantile(0.95), "max": x.max()}
        for name, value in expected.items():
            assert metric[name] == pytest.approx(value, rel=1e-12), name  # measured 4e-16
        normal = stats.norm.interval(0.95, x.mean(), x.std())
        assert (metric["normal"]["low"], metric["normal"]["high"]) == pytest.approx(
            normal, rel=1e-9
        )
        shape, _, scale = stats.gamma.fit(x, floc=0)
        gamma = stats.gamma.interval(0.95, shape, scale=scale)
        # Maximum likelihood to the accuracy of the optimiser.
        assert (metric["gamma"]["low"], metric["gamma"]["high"]) == pytest.approx(gamma, rel=1e-4)
    pitch = found["cells"][0]["metrics"]["pitch_deg"]
    assert 0 <= pitch["min"] < pitch["max"] < 20


def test_effects_are_those_of_the_closed_forms(folder):
    rows, found = pd.read_parquet(folder / "runs"), report_of(folder)
    effects = {(e["factor"], e["output"]): e for e in found["effects"]}
    depth = effects["depth", "force"]
    means = rows.groupby("depth").force.mean()
    # Two equal groups: the effects are half the difference of the means, with both signs.
    half = (means[4.0] - means[3.0]) / 2
    assert [e["effect"] for e in depth["levels"]] == pytest.approx([-half, half], rel=1e-12)
    # Two groups: eta^2 is the squared correlation with the group's number.
    r = np.corrcoef(rows.cell, rows.force)[0, 1]
    assert depth["share"] == pytest.approx(r**2, rel=1e-12)  # measured 3e-15
    rank = effects["north", "force"]
    expected = stats.spearmanr(rows.north, rows.force)
    assert rank["correlation"] == pytest.approx(expected.statistic, abs=1e-14)
    assert rank["p_value"] == pytest.approx(expected.pvalue, abs=1e-14)


def test_report_files_exist_and_the_page_shows_the_table(folder):
    found = report_of(folder)
    names = {"success.png", "convergence.png", "effects.png", "metric_force.png"}
    assert names < set(found["figures"])
    for name in found["figures"]:
        assert (folder / "report" / name).read_bytes().startswith(b"\x89PNG")
        assert (folder / "report" / name).stat().st_size > 5000
    page = (folder / "report" / "report.md").read_text()
    cell = found["cells"][1]
    shown = f"| 1 | 4 | 60 | {cell['successes']} | {cell['probability']:.4g} | {cell['low']:.4g} |"
    assert shown in page and "## Runs without success" in page


def test_report_of_constant_and_missing_metrics(tmp_path):
    run_campaign(plan(runs=3), tmp_path, executor=Inline())
    found = report(tmp_path)
    metrics = found["cells"][0]["metrics"]
    assert metrics["pitch_deg"] == {"n": 0} and metrics["force"]["std"] == 0
    assert "normal" not in metrics["force"]
    assert all(e.get("share") is None for e in found["effects"])


def test_metric_that_hardly_varies_has_no_gamma_fit_but_a_report():
    """Energies at a dock in calm water: the same to a millionth."""
    close = 0.5 * (1 + 1e-7 * np.arange(60))
    found = describe(pd.Series(close))
    assert "gamma" not in found and found["normal"]["std"] == pytest.approx(np.std(close, ddof=1))
    assert describe(pd.Series(np.ones(60))).keys().isdisjoint({"normal", "gamma"})
    assert {"normal", "gamma"} < describe(pd.Series(0.5 * (1 + 1e-4 * np.arange(60)))).keys()


def test_report_refusals(tmp_path):
    with pytest.raises(CampaignError, match="no campaign in"):
        report(tmp_path)

    def interrupted(work):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_campaign(plan(DRAWN), tmp_path / "a", executor=Inline(), do=interrupted)
    with pytest.raises(CampaignError, match=r"no run of the campaign in .* is finished yet"):
        report(tmp_path / "a")
    run_campaign(plan(DRAWN), tmp_path / "a", executor=Inline(), do=draw, resume=True)
    (tmp_path / "a" / "report").write_text("in the way")
    with pytest.raises(CampaignError, match="cannot write the report to"):
        report(tmp_path / "a")


def code_of(capsys, *arguments):
    """Exit code, output and errors of a command."""
    with pytest.raises(SystemExit) as stop:
        cli.main(list(map(str, arguments)))
    out = capsys.readouterr()
    return stop.value.code, " ".join(out.out.split()), out.err


def test_commands_on_a_finished_campaign(folder, capsys):
    code, out, _ = code_of(capsys, "campaign", "status", folder)
    assert code == 0 and "complete" in out and "120 of 120 runs" in out
    code, out, _ = code_of(capsys, "campaign", "report", folder)
    assert code == 0 and "depth 3.0" in out
    code, out, _ = code_of(capsys, "campaign", "resume", folder)
    assert code == 0 and "120 of 120 runs" in out
    code, out, _ = code_of(capsys, "list")
    assert "campaign docking_sea_states" in out


def test_replay_command_says_whether_the_run_is_the_same(tmp_path, capsys):
    run_campaign(plan(runs=1), tmp_path, executor=Inline())
    code, out, _ = code_of(capsys, "replay", tmp_path, 1)
    assert code == 0 and "the same results as in the campaign" in out
    assert (tmp_path / "replays" / "run-00000001" / "log.nc").is_file()
    assert (tmp_path / "replays" / "run-00000001" / "summary.json").is_file()
    made = plan(CALM, runs=1, metrics={})
    run_campaign(made, tmp_path / "b", executor=Inline(), do=draw)
    code, _, err = code_of(capsys, "replay", tmp_path / "b", 1)
    assert code == 0 and "differs from the campaign in: " in err and "docked" not in err.split()[0]


def test_command_refusals(tmp_path, capsys):
    for arguments, message in (
        (["run", "nothing"], "neither a file nor a packaged campaign"),
        (["status", "docking_sea_states", "--out", tmp_path], "no campaign in"),
        (["resume", "docking_sea_states", "--out", tmp_path], "no campaign in"),
        (["report", "docking_sea_states", "--out", tmp_path], "no campaign in"),
        (["run", "docking_sea_states", "--workers", "5000"], "--workers 5000: this machine has"),
    ):
        code, _, err = code_of(capsys, "campaign", *arguments)
        assert code == 1 and err.startswith("error: ") and message in err
    assert not CampaignFolder(tmp_path).exists
