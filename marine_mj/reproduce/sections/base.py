"""What a section of a reproduction is: numbers beside the published ones, and figures."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

Value = float | str | None


@dataclass(frozen=True)
class Finding:
    """One published number or statement beside ours.

    Attributes:
        quantity: what it is, without the number of the table.
        published: value of the study; None where it gives none.
        ours: our value.
        unit: "1" for ratios and statements.
        verdict: "agrees", "differs" or "not comparable".
        note: how far it may be off, and why it is.
        interval: scatter of ours, 95 %; None where there is none.
    """

    quantity: str
    published: Value
    ours: Value
    unit: str
    verdict: str
    note: str = ""
    interval: tuple[float, float] | None = None

    def row(self, title: str) -> dict[str, Any]:
        """Row of report.json."""
        found = asdict(self) | {"quantity": f"{title}: {self.quantity}"}
        return found | {"interval": None if self.interval is None else list(self.interval)}


def compare(
    quantity: str,
    published: float,
    ours: float,
    unit: str,
    within: float,
    note: str = "",
    interval: tuple[float, float] | None = None,
) -> Finding:
    """Finding that agrees when the values are at most `within` apart."""
    verdict = "agrees" if abs(ours - published) <= within else "differs"
    return Finding(quantity, published, float(ours), unit, verdict, note, interval)


@dataclass(frozen=True)
class Job:
    """What a section is to do.

    Attributes:
        folder: where its figures go; exists.
        runs: per sea state of campaigns.
        full: the whole grids of the study where the section takes less by default.
        campaigns: folder of the reproduction, whose campaigns the section may share.
        highest: last sea state of campaigns; None: that of the tables.
    """

    folder: Path
    runs: int = 60
    full: bool = False
    campaigns: Path | None = None
    highest: int | None = None

    def save(self, figure: Figure, name: str) -> str:
        """Name of the picture file of a figure, written to the folder."""
        FigureCanvasAgg(figure)
        figure.savefig(self.folder / f"{name}.png", dpi=110)
        return f"{name}.png"


@dataclass(frozen=True)
class Outcome:
    """Result of a section.

    Attributes:
        findings: numbers beside the published ones; may be empty for figures.
        figures: names of the pictures in its folder, in order.
        text: what a reader should know about them.
    """

    findings: Sequence[Finding]
    figures: Sequence[str]
    text: str


@dataclass(frozen=True)
class Section:
    """A table or figure of the study that is not a campaign of sea states.

    Attributes:
        name: by which it is chosen: the number of a table, or the name of a figure.
        title: in the report.
        run: does it.
        scaled: depends on the number of runs.
    """

    name: str
    title: str
    run: Callable[[Job], Outcome]
    scaled: bool = False


def panels(
    rows: int, columns: int, size: tuple[float, float], **changes: Any
) -> tuple[Figure, Any]:
    """Empty figure and its axes (rows, columns), with a light grid."""
    figure = Figure(figsize=size, layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, **changes)
    for ax in np.ravel(axes):
        ax.grid(alpha=0.3)
    return figure, axes
