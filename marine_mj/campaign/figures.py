"""Figures of a report."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from marine_mj.analysis.statistics import fit_gamma, fit_normal
from marine_mj.campaign.settings import Campaign

#: Cells that get a line of their own in the figures of metrics.
_LINES = 8
#: Coverages whose intervals draw a fitted distribution.
_COVERAGES = np.linspace(0.002, 0.998, 100)


def draw_figures(
    found: dict[str, Any], campaign: Campaign, data: pd.DataFrame, folder: Path
) -> list[str]:
    """Names of the pictures written into `folder`.

    Args:
        found: numbers of the report.
        campaign: settings.
        data: finished runs.
        folder: where the pictures go.
    """
    figures = {"success.png": _success(found), "convergence.png": _convergence(found)}
    if campaign.factors:
        figures["effects.png"] = _effects(found["effects"])
    for name in campaign.metrics:
        figures[f"metric_{name}.png"] = _metric(found, name, data)
    for file, figure in figures.items():
        FigureCanvasAgg(figure).print_png(str(folder / file))
    return list(figures)


def _success(found: dict[str, Any]) -> Figure:
    """Success probability of the cells with Wilson intervals."""
    cells = found["cells"]
    labels = [_label(c) for c in cells]
    width = 4 + 0.085 * max(map(len, labels))  # a letter of the font is 0.085 inches wide
    figure = Figure(figsize=(width, 1.2 + 0.3 * len(cells)), layout="constrained")
    axes = figure.subplots()
    p = np.array([c["probability"] for c in cells])
    ends = np.array([[c["low"], c["high"]] for c in cells])
    # Rounding may put an end of the interval a hair inside the estimate.
    error = np.clip(np.abs(ends.T - p), 0, None)
    axes.errorbar(p, np.arange(len(cells)), xerr=error, fmt="o", capsize=3)
    axes.set_yticks(range(len(cells)), labels)
    axes.set(xlim=(-0.02, 1.02), xlabel="success probability, 95 % Wilson interval")
    axes.set_ylim(len(cells) - 0.5, -0.5)
    axes.grid(axis="x", alpha=0.3)
    return figure


def _convergence(found: dict[str, Any]) -> Figure:
    """Estimate against the number of runs."""
    points = found["convergence"]
    n, p, low, high = ([x[k] for x in points] for k in ("n", "probability", "low", "high"))
    figure = Figure(figsize=(6, 3.5), layout="constrained")
    axes = figure.subplots()
    axes.fill_between(n, low, high, alpha=0.3, label="95 % Wilson interval")
    axes.plot(n, p, label="estimate")
    axes.set(xlabel="runs", ylabel="success probability", ylim=(-0.02, 1.02))
    axes.legend()
    axes.grid(alpha=0.3)
    return figure


def _metric(found: dict[str, Any], name: str, data: pd.DataFrame) -> Figure:
    """Distribution of a metric in each cell, with fitted distributions."""
    figure = Figure(figsize=(6, 4), layout="constrained")
    axes = figure.subplots()
    for i, cell in enumerate(found["cells"][:_LINES]):
        x = np.sort(data.loc[data["cell"] == cell["cell"], name].dropna().to_numpy(float))
        if not len(x):
            continue
        axes.step(x, np.arange(1, len(x) + 1) / len(x), "-", where="post", color=f"C{i}")
        axes.lines[-1].set_label(_label(cell))
        for kind, make, style in (("normal", fit_normal, "--"), ("gamma", fit_gamma, ":")):
            if kind in cell["metrics"][name]:
                fit: Any = make(x)
                ends = np.array([fit.interval(float(c)) for c in _COVERAGES])
                values = np.concatenate([ends[::-1, 0], ends[:, 1]])
                levels = np.concatenate([(1 - _COVERAGES[::-1]) / 2, (1 + _COVERAGES) / 2])
                axes.plot(values, levels, style, color=f"C{i}", lw=0.8)
    axes.set(xlabel=name, ylabel="share of runs below", ylim=(0, 1))
    axes.set_title("steps: runs, dashed: normal fit, dotted: gamma fit", fontsize="small")
    if axes.get_legend_handles_labels()[0]:
        axes.legend(fontsize="small")
    axes.grid(alpha=0.3)
    return figure


def _effects(effects: list[dict[str, Any]]) -> Figure:
    """How much each factor matters to each output."""
    labels, values, colors = [], [], []
    for entry in effects:
        labels.append(f"{entry['output']} ~ {entry['factor']}")
        if "share" in entry:
            values.append(entry["share"] or 0.0)
            colors.append("C0")
        else:
            values.append((entry["correlation"] or 0.0) ** 2)
            colors.append("C1")
    figure = Figure(figsize=(6, 1.2 + 0.3 * len(labels)), layout="constrained")
    axes = figure.subplots()
    axes.barh(labels, values, color=colors)
    kinds = "eta^2 (levels, blue), rho^2 of ranks (random factors, orange)"
    axes.set(xlim=(0, 1), xlabel=f"share of variance:\n{kinds}")
    axes.invert_yaxis()
    return figure


def _label(cell: dict[str, Any]) -> str:
    """A cell by its factors."""
    return ", ".join(f"{k} {v}" for k, v in cell["factors"].items()) or "all runs"
