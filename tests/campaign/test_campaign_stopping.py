"""Stopping rules: where a campaign ends, whatever the order of its chunks."""

import json
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from campaign_helpers import CALM, DRAWN, campaign, draw, drawn, plan, read
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from marine_mj.campaign import run_campaign, run_together
from marine_mj.campaign.folder import CampaignFolder
from marine_mj.campaign.status import status
from marine_mj.campaign.stopping import StoppingMonitor
from marine_mj.errors import CampaignError


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


def test_campaigns_with_a_stopping_rule_or_signals_do_not_go_together(tmp_path):
    with pytest.raises(CampaignError, match=r"rare, stopping or record\.signals.*run_campaign"):
        run_together({tmp_path / "a": plan(CALM)})
    assert not (tmp_path / "a").exists()
