"""The report of a campaign: tables as JSON and Markdown, figures as PNG."""

import contextlib
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
from scipy import stats

from marine_mj.analysis.statistics import fit_gamma, fit_normal, wilson_interval
from marine_mj.campaign.effects import effects
from marine_mj.campaign.figures import draw_figures
from marine_mj.campaign.folder import CampaignFolder
from marine_mj.campaign.markdown import markdown
from marine_mj.campaign.plan import Plan
from marine_mj.campaign.rare import COLUMNS
from marine_mj.campaign.rare_report import draw_levels, rare_markdown, rare_report
from marine_mj.campaign.runner import load_plan
from marine_mj.campaign.table import schema
from marine_mj.demo import write_json
from marine_mj.errors import AnalysisError, CampaignError

#: Fewest values that a distribution is fitted to.
_FIT = 5
#: Numbers of runs at which the convergence is tabulated, at most.
_POINTS = 50


def report(folder: str | Path) -> dict[str, Any]:
    """The numbers of a report, written with tables and figures into `folder`/report.

    Per cell: success probability with its Wilson interval, and of every metric mean with Student's
    interval, spread, quantiles and fitted distributions. Over all runs: convergence of the
    success probability and effects of the factors (`marine_mj.campaign.effects`). A search for
    rare events has a report of its own (`marine_mj.campaign.rare_report`).

    Args:
        folder: of the campaign; it may still be running.

    Raises:
        CampaignError: there is no campaign, or no run is finished.
    """
    plan, data = load_plan(folder), read_runs(folder)
    campaign, place = plan.campaign, CampaignFolder(folder)
    if campaign.rare is not None:
        rare = rare_report(plan, place, data)
        return _write(folder, rare, lambda out: draw_levels(plan, place, out), rare_markdown)
    found: dict[str, Any] = {
        "campaign": campaign.name,
        "scenario": plan.base.name,
        "runs": len(data),
        "planned": plan.total,
        "errors": int(data["error"].notna().sum()),
        "success": _proportion(data["success"]),
        "cells": [_cell(plan, int(str(cell)), part) for cell, part in data.groupby("cell")],
        "convergence": _convergence(data["success"].to_numpy()),
        "effects": effects(campaign, data),
        "failures": _failures(data),
    }
    return _write(folder, found, lambda out: draw_figures(found, campaign, data, out), markdown)


def _write(
    folder: str | Path,
    found: dict[str, Any],
    draw: Callable[[Path], list[str]],
    page: Callable[[dict[str, Any]], str],
) -> dict[str, Any]:
    """The numbers of a report, written with its figures and its page."""
    out = Path(folder) / "report"
    try:
        out.mkdir(exist_ok=True)
        found["figures"] = draw(out)
        write_json(out / "report.json", found)
        (out / "report.md").write_text(page(found), encoding="utf-8")
    except OSError as error:
        raise CampaignError(f"cannot write the report to {str(out)!r}: {error}") from None
    return found


def read_runs(folder: str | Path) -> pd.DataFrame:
    """Finished runs in order, without the long texts.

    Raises:
        CampaignError: there is no campaign, or no run is finished.
    """
    place = CampaignFolder(folder)
    place.manifest()
    files = place.chunk_files()
    if not files:
        raise CampaignError(f"no run of the campaign in {str(place.path)!r} is finished yet")
    long = ("summary", "scenario", "versions", "code", "git_revision")
    campaign = load_plan(folder).campaign
    columns = [name for name in schema(campaign).names if name not in long]
    columns += COLUMNS if campaign.rare is not None else ()
    tables = [place.read(file.stem, columns) for file in files]
    return pa.concat_tables(tables).to_pandas()


def finite(value: float) -> float | None:
    """The number for JSON, None if it is not finite."""
    return float(value) if math.isfinite(value) else None


def _proportion(success: pd.Series) -> dict[str, Any]:
    """Number, share and Wilson interval of successes."""
    n, successes = len(success), int(success.sum())
    low, high = wilson_interval(successes, n)
    return {
        "n": n,
        "successes": successes,
        "probability": successes / n,
        "low": low,
        "high": high,
    }


def _cell(plan: Plan, cell: int, data: pd.DataFrame) -> dict[str, Any]:
    """Results of one combination of the crossed factors."""
    return {
        "cell": cell,
        "factors": plan.cell_factors(cell),
        "errors": int(data["error"].notna().sum()),
        **_proportion(data["success"]),
        "metrics": {name: describe(data[name]) for name in plan.campaign.metrics},
    }


def describe(column: pd.Series) -> dict[str, Any]:
    """Numbers of a metric's distribution; those that do not exist are None."""
    x = column.dropna().to_numpy(float)
    if not len(x):
        return {"n": 0}
    found: dict[str, Any] = {"n": len(x), "mean": float(x.mean())}
    if len(x) > 1:
        std = float(x.std(ddof=1))
        half = float(stats.t.ppf(0.975, len(x) - 1)) * std / math.sqrt(len(x))
        found |= {"std": std, "mean_low": found["mean"] - half, "mean_high": found["mean"] + half}
    quantiles = np.quantile(x, (0, 0.05, 0.5, 0.95, 1))
    names = ("min", "q05", "median", "q95", "max")
    found |= dict(zip(names, map(float, quantiles), strict=True))
    for name, fit in fits(x).items():
        low, high = fit.interval(0.95)
        parameters = {k: finite(v) for k, v in vars(fit).items() if isinstance(v, int | float)}
        found[name] = {**parameters, "low": finite(low), "high": finite(high)}
    return found


def fits(x: np.ndarray) -> dict[str, Any]:
    """Fitted normal and gamma distribution, by name; one that cannot be fitted is left out.

    That is: both of values that are (nearly) the same, gamma of values that are not positive.
    """
    found: dict[str, Any] = {}
    if len(x) >= _FIT:
        for name, make in (("normal", fit_normal), ("gamma", fit_gamma)):
            with contextlib.suppress(AnalysisError):
                found[name] = make(x)
    return found


def _convergence(success: np.ndarray) -> list[dict[str, Any]]:
    """Estimate and interval after the first n runs, for n up to all of them."""
    total = len(success)
    points = np.unique(np.round(np.linspace(1, total, min(total, _POINTS))).astype(int))
    sums = np.cumsum(success.astype(int))
    found = []
    for n in points:
        low, high = wilson_interval(int(sums[n - 1]), int(n))
        found.append({"n": int(n), "probability": float(sums[n - 1] / n), "low": low, "high": high})
    return found


def _failures(data: pd.DataFrame) -> list[dict[str, Any]]:
    """Runs without success, the first fifty, with the reason."""
    bad = data[~data["success"]].head(50)
    return [
        {"run": int(run), "cell": int(cell), "reason": str(why)}
        for run, cell, why in zip(bad["run"], bad["cell"], bad["failure"], strict=True)
    ]
