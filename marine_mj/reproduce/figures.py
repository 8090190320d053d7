"""Stacked interval bars per sea state, as figures 7.18 to 7.23 and 8.8 to 8.13 of the study."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from marine_mj.analysis.docking import METRICS, CaptureLimits, interval
from marine_mj.reproduce.docking import Row
from marine_mj.reproduce.judgement import scaled
from marine_mj.reproduce.runner import Cells

#: Axis labels, and how far beyond the limits the panels reach (in limits): intervals grow wild.
_LABELS = {"surge": "surge error [m]", "pitch": "pitch error [deg]", "energy": "energy [J]"}
_REACH = 3.0


def draw_intervals(rows: Sequence[Row], cells: Mapping[str, Cells], folder: Path) -> str:
    """Name of the picture of one table, written into `folder`.

    Three panels (surge, pitch, energy): for each line of the table and each sea state in which all
    runs entered, the interval of 99.7 %; dashed are the capture limits.
    """
    figure = Figure(figsize=(8, 9), layout="constrained")
    panels = figure.subplots(len(METRICS), 1, sharex=True)
    limits, width = CaptureLimits(), 0.8 / len(rows)
    for axes, metric in zip(panels, METRICS, strict=True):
        limit = scaled(getattr(limits, metric), metric)
        for i, row in enumerate(rows):
            entries = {
                state: e
                for state, e in cells[row.configuration].entries.items()
                if e.complete and row.first <= state <= row.last
            }
            ends = [[scaled(x, metric) for x in interval(e, metric)] for e in entries.values()]
            axes.bar(
                [state - 0.4 + (i + 0.5) * width for state in entries],
                [high - low for low, high in ends],
                0.9 * width,
                [low for low, _ in ends],
                color=f"C{i}",
                label=row.label,
            )
        for end in (limit,) if metric == "energy" else (-limit, limit):
            axes.axhline(end, color="k", ls="--", lw=1)
        axes.set_ylim(0 if metric == "energy" else -_REACH * limit, _REACH * limit)
        axes.set_ylabel(_LABELS[metric])
        axes.grid(axis="y", alpha=0.3)
    panels[0].set_title(f"table {rows[0].table}: 99.7 % intervals, dashed: capture limits")
    panels[0].legend(fontsize="small", loc="upper left")
    panels[-1].set_xlabel("sea state")
    panels[-1].set_xticks(range(rows[0].first, rows[0].last + 1))
    name = f"table_{rows[0].table}.png"
    FigureCanvasAgg(figure).print_png(str(folder / name))
    return name
