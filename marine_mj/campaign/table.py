"""Rows of results as a table: one row per run, columns of fixed type."""

import json
from collections.abc import Mapping, Sequence
from typing import Any

import pyarrow as pa

from marine_mj.campaign.code import all_versions, code_digest, git_revision
from marine_mj.campaign.conditions import look_up, transformed
from marine_mj.campaign.plan import Plan, Run
from marine_mj.campaign.settings import Campaign
from marine_mj.scenario import Scenario

#: Not part of a run's results: different each time, or a column of its own.
_APART = ("wall_time", "real_time_factor", "versions", "error", "scenario")


def schema(campaign: Campaign) -> pa.Schema:
    """Names and types of the columns."""
    return pa.schema(
        [
            *((name, pa.int64()) for name in ("run", "cell", "replicate", "seed")),
            *((name, _type(factor.examples)) for name, factor in campaign.factors.items()),
            *((name, pa.float64()) for name in campaign.metrics),
            ("success", pa.bool_()),
            ("failure", pa.string()),
            ("error", pa.string()),
            ("simulated_time", pa.float64()),
            ("wall_time", pa.float64()),
            *((name, pa.string()) for name in ("summary", "scenario")),
            *((name, pa.string()) for name in ("versions", "code", "git_revision")),
        ]
    )


def table(
    plan: Plan,
    runs: Sequence[Run],
    scenarios: Sequence[Scenario | Exception],
    rows: Sequence[Mapping[str, Any]],
) -> pa.Table:
    """Table of finished runs.

    Raises:
        CampaignError: a metric or a condition asks for what the results do not have, or a metric
            is no number.
    """
    shape = schema(plan.campaign)
    code = {
        "versions": json.dumps(all_versions()),
        "code": code_digest()[:16],
        "git_revision": git_revision(),
    }
    records = [
        _record(plan.campaign, run, scenario, row) | code
        for run, scenario, row in zip(runs, scenarios, rows, strict=True)
    ]
    for record in records:
        for name in plan.campaign.factors:
            if pa.types.is_string(shape.field(name).type) and not isinstance(record[name], str):
                record[name] = json.dumps(record[name])
    return pa.Table.from_pylist(records, shape)


def _record(
    campaign: Campaign, run: Run, scenario: Scenario | Exception, row: Mapping[str, Any]
) -> dict[str, Any]:
    """One row by column."""
    results = {key: value for key, value in row.items() if key not in _APART}
    error = row["error"]
    metrics = {} if error else evaluate_metrics(campaign, results)
    failure = error or _failure(campaign, results, metrics)
    return {
        "run": run.number,
        "cell": run.cell,
        "replicate": run.replicate,
        "seed": run.seed,
        **run.factors,
        **metrics,
        "success": failure is None,
        "failure": failure,
        "error": error,
        "simulated_time": row["simulated_time"],
        "wall_time": row["wall_time"],
        "summary": json.dumps(results),
        "scenario": scenario.to_toml() if isinstance(scenario, Scenario) else None,
    }


def evaluate_metrics(campaign: Campaign, results: Mapping[str, Any]) -> dict[str, float | None]:
    """All metrics of a run that ended without an error; None where it has none.

    Raises:
        CampaignError: the results have no such key, or it is no number.
    """
    found = {}
    for name, metric in campaign.metrics.items():
        what = f"metric {name!r}"
        found[name] = transformed(look_up(results, metric.key, what), metric.transform, what)
    return found


def _failure(
    campaign: Campaign, results: Mapping[str, Any], metrics: Mapping[str, Any]
) -> str | None:
    """The first condition of success that does not hold, with the value found."""
    for condition in campaign.conditions:
        key = condition.key
        if key in metrics and (campaign.metrics[key].transform or key not in results):
            value = metrics[key]
        else:
            value = look_up(results, key, f"condition {str(condition)!r}")
        if not condition.holds(value):
            return f"{condition} (was {json.dumps(value)})"
    return None


def _type(examples: Sequence[Any]) -> pa.DataType:
    """Type of a factor's column; what is no number or truth value is text."""
    if all(isinstance(value, bool) for value in examples):
        return pa.bool_()
    if any(isinstance(value, bool) or not isinstance(value, int | float) for value in examples):
        return pa.string()
    return pa.int64() if all(isinstance(value, int) for value in examples) else pa.float64()
