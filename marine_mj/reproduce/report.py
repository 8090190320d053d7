"""The report of a reproduction: report.json, report.md and one figure per table."""

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from marine_mj.campaign.pools import Here, open_pool
from marine_mj.demo import write_json
from marine_mj.errors import CampaignError
from marine_mj.reproduce.docking import Row
from marine_mj.reproduce.figures import draw_intervals
from marine_mj.reproduce.judgement import COLUMNS, Judged, judge
from marine_mj.reproduce.runner import Cells
from marine_mj.reproduce.sections import Done

_INTRODUCTION = """\
Maximum operational sea states: published -> ours [95 % of {resamples} bootstrap resamples]. A
metric holds while 99.7 % of its fitted distribution lies within the capture limits (surge 0.5 m,
pitch 15 deg, energy 30 J); "-" means not even the lowest sea state. Ours agrees within one sea
state, pitch within two: the study's own base configuration, flown three times, scatters that much.
Runs per sea state: {runs}. Numbers: {counts}."""


def write_report(
    rows: Sequence[Row],
    cells: Mapping[str, Cells],
    folder: str | Path,
    highest: int | None = None,
    resamples: int = 200,
    sections: Sequence[Done] = (),
    workers: int | None = 1,
) -> list[Judged]:
    """All numbers of the tables beside ours, written to `folder`.

    Args:
        rows: of the tables.
        cells: our results by configuration (`run_configurations`).
        folder: gets report.json (docs/contracts.md), report.md and table_*.png.
        highest: last sea state that was run, where the tables go further.
        resamples: of the bootstrap.
        sections: what stands beside the tables of sea states (`run_sections`).
        workers: processes that judge and draw; 1: only this one, None: one per processor.

    Raises:
        CampaignError: the folder cannot be written, or a worker was killed.
    """
    place = Path(folder)
    tables: dict[str, list[Row]] = {}
    for row in rows:
        tables.setdefault(row.table, []).append(row)
    try:
        place.mkdir(parents=True, exist_ok=True)
        judged, figures = _judged(tables, cells, place, (highest, resamples), workers)
        rows_of_report = [as_dict(j) for j in judged]
        rows_of_report += [f.row(s.title) for s in sections for f in s.outcome.findings]
        write_json(place / "report.json", rows_of_report)
        (place / "report.md").write_text(
            _markdown(judged, cells, figures, resamples) + "".join(map(_section, sections)),
            encoding="utf-8",
        )
    except OSError as error:
        raise CampaignError(
            f"cannot write the report to {str(place)!r}: {error}. The runs are intact; make room "
            "or set the permissions, then give the same command again"
        ) from None
    return judged


def _judged(
    tables: Mapping[str, Sequence[Row]],
    cells: Mapping[str, Cells],
    folder: Path,
    settings: tuple[int | None, int],
    workers: int | None,
) -> tuple[list[Judged], dict[str, str]]:
    """All numbers, and the names of the pictures by table."""
    with open_pool(workers, executor=Here() if workers == 1 else None) as pool:
        drawn = {
            table: pool.submit(draw_intervals, lines, _of(lines, cells), folder)
            for table, lines in tables.items()
        }
        found = [
            pool.submit(judge, row, cells[row.configuration], *settings)
            for lines in tables.values()
            for row in lines
        ]
        try:
            judged = [number for future in found for number in future.result()]
            return judged, {table: future.result() for table, future in drawn.items()}
        except pool.died:
            raise CampaignError(
                f"a worker was killed while it wrote the report in {str(folder)!r} (out of "
                "memory?): the runs are intact, give the same command again"
            ) from None


def _of(rows: Sequence[Row], cells: Mapping[str, Cells]) -> dict[str, Cells]:
    """The results that rows need."""
    return {row.configuration: cells[row.configuration] for row in rows}


def as_dict(judged: Judged) -> dict[str, Any]:
    """A number as a row of report.json; "-" is not even the lowest sea state."""
    uptime = judged.column == "uptime"
    what = "uptime" if uptime else f"maximum sea state, {judged.column}"
    return {
        "quantity": f"table {judged.row.table}, {judged.row.label}: {what}",
        "published": _value(judged.published),
        "ours": _value(judged.ours),
        "interval": list(judged.interval),
        "unit": "%" if uptime else "sea state",
        "verdict": judged.verdict,
        "note": judged.note,
    }


def _value(value: float | None) -> float | str:
    return "-" if value is None else float(value)


def _markdown(
    judged: Sequence[Judged], cells: Mapping[str, Cells], figures: Mapping[str, str], resamples: int
) -> str:
    """The page."""
    if not judged:
        return "# Docking study reproduced\n"
    counts = Counter(j.verdict for j in judged)
    runs = {len(e) for c in cells.values() for e in c.entries.values()}
    text = ", ".join(f"{verdict} {n}" for verdict, n in sorted(counts.items()))
    parts = [
        "# Docking study reproduced",
        _INTRODUCTION.format(
            resamples=resamples, runs=", ".join(map(str, sorted(runs))), counts=text
        ),
    ]
    for table, figure in figures.items():
        lines = [j for j in judged if j.row.table == table]
        parts += [f"## Table {table}", _table(lines), f"![{figure}]({figure})"]
        parts += [_notes(lines)] if any(j.note for j in lines) else []
    return "\n\n".join(parts) + "\n"


def _table(judged: Sequence[Judged]) -> str:
    """One table: a line per row of the study, marked where ours differs or cannot be compared."""
    marks = {"agrees": "", "differs": " **differs**", "not comparable": " (not comparable)"}
    rows = [["line", *COLUMNS], ["---"] * (1 + len(COLUMNS))]
    for i in range(0, len(judged), len(COLUMNS)):
        line = judged[i : i + len(COLUMNS)]
        rows.append([line[0].row.label, *(f"{_shown(j)}{marks[j.verdict]}" for j in line)])
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def _shown(judged: Judged) -> str:
    """Published, ours and its interval."""
    bottom = judged.row.first - 1

    def text(value: float | None) -> str:
        if judged.column == "uptime":
            return f"{value:.1f}"
        return "-" if value is None or value <= bottom else f"{value:g}"

    low, high = judged.interval
    return f"{text(judged.published)} -> {text(judged.ours)} [{text(low)}, {text(high)}]"


def _notes(judged: Sequence[Judged]) -> str:
    return "\n".join(f"- {j.row.label}, {j.column}: {j.note}." for j in judged if j.note)


def _section(done: Done) -> str:
    """A section of the page: its numbers, notes and figures."""
    found = done.outcome
    parts = [f"\n## {done.title}", found.text]
    if found.findings:
        lines = ["| quantity | published | ours | unit | verdict | note |", "| --- " * 6 + "|"]
        for f in found.findings:
            span = ""
            if f.interval is not None:
                span = f" [{f.interval[0]:.3g}, {f.interval[1]:.3g}]"
            verdict = f"**{f.verdict}**" if f.verdict != "agrees" else f.verdict
            cells = (f.quantity, _number(f.published), f"{_number(f.ours)}{span}", f.unit, verdict)
            lines.append(f"| {' | '.join((*cells, f.note))} |")
        parts.append("\n".join(lines))
    parts += [f"![{name}](sections/{done.name}/{name})" for name in found.figures]
    return "\n\n".join(parts) + "\n"


def _number(value: float | str | None) -> str:
    """A value in the table."""
    if value is None:
        return "-"
    return value if isinstance(value, str) else f"{value:.4g}"
