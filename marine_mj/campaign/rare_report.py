"""The report of a search for rare events: probabilities, levels and the runs that did it."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from marine_mj.campaign.folder import CampaignFolder
from marine_mj.campaign.levels import Search, at_most, pooled, read_searches
from marine_mj.campaign.markdown import shown, table
from marine_mj.campaign.plan import Plan

#: Runs that the report lists per cell.
_WORST = 10


def rare_report(plan: Plan, place: CampaignFolder, data: pd.DataFrame) -> dict[str, Any]:
    """Numbers of the report of a search.

    Per cell: probability of the event with coefficient of variation and 95 % interval over the
    repetitions, the number of runs that counting would take for the same accuracy,
    `(1 - p) / (p cov^2)`, and the worst runs, the design points: the highest scores, of equal
    ones those closest to the median run (`distance`, the norm of the standard normals).

    Args:
        plan: what is searched.
        place: folder of the campaign.
        data: its finished runs (`marine_mj.campaign.report.read_runs`).
    """
    rare, found = plan.campaign.rare, read_searches(plan, place)
    assert rare is not None
    return {
        "campaign": plan.campaign.name,
        "scenario": plan.base.name,
        "event": f"{rare.metric} {'>=' if rare.sign > 0 else '<='} {rare.threshold:g}",
        "runs": len(data),
        "errors": int(data["error"].notna().sum()),
        "cells": [
            _cell(plan, cell, [s for s in found if s.cell == cell], data[data["cell"] == cell])
            for cell in range(plan.cells)
        ],
        "searches": [_search(s) for s in found],
    }


def _cell(plan: Plan, cell: int, searches: list[Search], data: pd.DataFrame) -> dict[str, Any]:
    """Probability of the event in one combination of the crossed factors."""
    rare = plan.campaign.rare
    assert rare is not None
    estimate = pooled(searches) if len(searches) == rare.repetitions else None
    events = data[data["score"] >= rare.sign * rare.threshold]
    found: dict[str, Any] = {
        "cell": cell,
        "factors": plan.cell_factors(cell),
        "runs": len(data),
        "repetitions": len(searches),
        "events": len(events),
        "without_success": int((~events["success"]).sum()),
        "errors": int(events["error"].notna().sum()),
        "probability": None,
        "at_most": at_most(searches),
        "worst": _worst(plan, data),
    }
    if estimate is not None:
        p, cov = estimate.probability, estimate.cov
        low, high = estimate.interval()
        crude = (1 - p) / (p * cov**2) if p and cov else None
        found |= {"probability": p, "cov": cov, "low": low, "high": high, "crude_runs": crude}
    return found


def _worst(plan: Plan, data: pd.DataFrame) -> list[dict[str, Any]]:
    """The runs closest to the event or furthest in it."""
    rare = plan.campaign.rare
    assert rare is not None
    order = ["score", "distance", "run"]
    rows = data.sort_values(order, ascending=[False, True, True]).head(_WORST)
    random = [name for name, f in plan.campaign.factors.items() if not f.crossed]
    return [
        {
            "run": int(row["run"]),
            "repetition": int(row["replicate"]),
            "level": int(row["level"]),
            "metric": rare.sign * row["score"] if np.isfinite(row["score"]) else None,
            "failure": row["failure"],
            "distance": float(row["distance"]),
            "factors": {name: row[name] for name in random},
        }
        for row in rows.to_dict("records")
    ]


def _search(search: Search) -> dict[str, Any]:
    """Levels of one search."""
    estimate, state = search.estimate, search.state
    metrics = [float(m) if np.isfinite(m) else None for m in search.metrics]
    return {
        "cell": search.cell,
        "repetition": search.repetition,
        "evaluations": state.evaluations,
        "reached": state.finished,
        "probability": None if estimate is None else estimate.probability,
        "cov": None if estimate is None else estimate.cov,
        "levels": [
            {"metric": metric, "probability": float(p)}
            for metric, p in zip(metrics, search.probabilities, strict=True)
        ],
        "acceptance": [float(a) for a in state.acceptance],
    }


def draw_levels(plan: Plan, place: CampaignFolder, folder: Path) -> list[str]:
    """Names of the pictures written into `folder`: exceedance of the metric in every search.

    Steps are the runs of the last level; dots are the levels on the way.
    """
    rare = plan.campaign.rare
    assert rare is not None
    figure = Figure(figsize=(6, 4), layout="constrained")
    axes = figure.subplots()
    for search in read_searches(plan, place):
        color = f"C{search.cell % 10}"
        axes.plot(search.metrics, search.probabilities, "o", color=color, ms=4)
        state = search.state
        score = np.sort(state.score)[::-1]
        share = np.arange(1, len(score) + 1) / len(score) * np.prod(state.factors)
        finite = np.isfinite(score)
        axes.step(rare.sign * score[finite], share[finite], "-", color=color, lw=0.8)
        if search.repetition == 0:
            factors = plan.cell_factors(search.cell)
            axes.lines[-1].set_label(", ".join(f"{k} {v}" for k, v in factors.items()) or "all")
    axes.axvline(rare.threshold, color="k", ls="--", lw=0.8, label="threshold")
    axes.set(yscale="log", xlabel=rare.metric, ylabel="probability of a run beyond")
    axes.legend(fontsize="small")
    axes.grid(alpha=0.3)
    FigureCanvasAgg(figure).print_png(str(folder / "levels.png"))
    return ["levels.png"]


def rare_markdown(found: dict[str, Any]) -> str:
    """The page of the report."""
    names = list(found["cells"][0]["factors"])
    parts = [
        f"# Campaign {found['campaign']}",
        f"Scenario {found['scenario']}: probability of {found['event']} or no success, by subset "
        f"simulation with {found['runs']} runs, {found['errors']} of which ended with an error.",
        "## Probability by cell",
        table(
            [
                *("cell", *names, "probability", "cov", "95 % from", "to", "runs"),
                *("runs by counting", "events seen", "of these no success", "errors"),
            ],
            (
                [
                    *(c["cell"], *c["factors"].values(), _probability(c), c.get("cov")),
                    *(c.get("low"), c.get("high"), c["runs"], c.get("crude_runs")),
                    *(c["events"], c["without_success"], c["errors"]),
                ]
                for c in found["cells"]
            ),
        ),
        "## Levels",
        table(
            ["cell", "repetition", "level", "metric", "probability beyond", "accepted"],
            (
                [s["cell"], s["repetition"], i + 1, level["metric"], level["probability"], accepted]
                for s in found["searches"]
                for i, (level, accepted) in enumerate(
                    zip(s["levels"], [*s["acceptance"], None], strict=False)
                )
            ),
        ),
    ]
    for cell in found["cells"]:
        factors = list(cell["worst"][0]["factors"]) if cell["worst"] else []
        heads = ["run", "repetition", "level", "metric", "no success", "distance", *factors]
        rows = (
            [
                *(w["run"], w["repetition"], w["level"], w["metric"], w["failure"]),
                *(w["distance"], *w["factors"].values()),
            ]
            for w in cell["worst"]
        )
        parts += [f"## Worst runs of cell {cell['cell']}", table(heads, rows)]
    parts += [f"![{name}]({name})" for name in found["figures"]]
    return "\n\n".join(parts) + "\n"


def _probability(cell: dict[str, Any]) -> str:
    """The probability, or its bound as long as the event was not reached."""
    if cell["probability"] is None:
        return f"not reached, below about {shown(cell['at_most'])}"
    return shown(cell["probability"])
