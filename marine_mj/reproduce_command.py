"""The command `marine-mj reproduce`: a published study done again."""

import contextlib
import os
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from marine_mj.errors import AnalysisError
from marine_mj.toml import assignments

if TYPE_CHECKING:
    from marine_mj.reproduce.docking import Row

console = Console()
errors = Console(stderr=True)
#: Runs per sea state: of the study, and of `--full`.
_RUNS, _FULL = 60, 1000
# Processor time of a configuration per run and sea state, all sea states of its table, s: measured
# with implicitfast (1.0), times what RK4 costs these batches (2.2).
_COST = 2.2


def reproduce_command(
    system: Annotated[str, typer.Argument(help="The study: docking.")] = "docking",
    full: Annotated[
        bool, typer.Option("--full", help=f"{_FULL} runs per sea state, whole grids of gains.")
    ] = False,
    runs: Annotated[
        int | None, typer.Option(help=f"Per sea state; default {_RUNS}, as in the study.")
    ] = None,
    tables: Annotated[
        str | None,
        typer.Option(help="Tables by number and figures by name: 7.12,8.9,raos; default: all."),
    ] = None,
    sets: Annotated[
        list[str] | None,
        typer.Option("--set", help="KEY=VALUE of the scenario, for all runs; needs an --out."),
    ] = None,
    highest: Annotated[
        int | None, typer.Option(help="Last sea state; default: that of the tables.")
    ] = None,
    workers: Annotated[
        int | None, typer.Option(help="Processes; default: one per processor.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", help="Folder; default results/reproduce/SYSTEM.")
    ] = None,
) -> None:
    """Do a published study again: its tables beside ours. Give it again to go on after a stop."""
    from marine_mj.reproduce import (
        choose,
        rows_of,
        run_configurations,
        run_sections,
        write_report,
    )

    if system != "docking":
        raise AnalysisError(f"cannot reproduce {system!r}; available: docking")
    if full and runs is not None:
        raise AnalysisError(f"--full means {_FULL} runs: leave out --runs {runs}, or --full")
    if sets and out is None:
        raise AnalysisError(
            "--set changes what the tables are made of: give it an --out of its own"
        )
    folder = out or Path("results") / "reproduce" / system
    numbers, names = choose(None if tables is None else tables.split(","))
    rows = rows_of(numbers) if numbers else []
    count = _FULL if full else _RUNS if runs is None else runs
    begin = time.monotonic()
    if rows:
        flown, share = _share(rows, highest)
        duration = _duration(_COST * share * count / (workers or os.cpu_count() or 1))
        errors.print(
            f"{flown} configurations, {count} runs per sea state: their campaigns take about "
            f"{duration} from the beginning; after a stop the same command goes on",
            soft_wrap=True,
            highlight=False,
        )
    try:
        with _progress("campaigns") as tell:
            cells = run_configurations(
                rows,
                folder,
                count,
                highest=highest,
                changes=assignments(sets or []),
                workers=workers,
                progress=tell,
            )
        with _progress("sections") as tell:
            sections = run_sections(
                names, folder, count, full=full, highest=highest, workers=workers, progress=tell
            )
    except KeyboardInterrupt:
        errors.print(
            f"interrupted; what is finished is in {folder}: give the same command again",
            soft_wrap=True,
        )
        raise typer.Exit(1) from None
    judged = write_report(rows, cells, folder, highest, sections=sections, workers=workers)
    found = [f for section in sections for f in section.outcome.findings]
    verdicts = Counter([*(j.verdict for j in judged), *(f.verdict for f in found)])
    total = len(judged) + len(found)
    shown = ", ".join(f"{verdict} {n}" for verdict, n in sorted(verdicts.items()))
    console.print(
        f"{total} numbers ({shown}) in {_duration(time.monotonic() - begin)}; "
        f"wrote {folder / 'report.md'} and report.json",
        soft_wrap=True,
        highlight=False,
    )


def _share(rows: "Sequence[Row]", highest: int | None) -> tuple[int, float]:
    """Number of configurations, and of those a whole run of all their sea states would be."""
    shares = {}
    for row in rows:
        last = row.last if highest is None else min(row.last, highest)
        shares[row.configuration] = max(last - row.first + 1, 0) / (row.last - row.first + 1)
    return len(shares), sum(shares.values())


def _duration(seconds: float) -> str:
    """A time in the unit that suits it."""
    for unit, size in (("h", 3600), ("min", 60)):
        if seconds >= size:
            return f"{seconds / size:.1f} {unit}"
    return f"{seconds:.0f} s"


@contextlib.contextmanager
def _progress(what: str) -> Iterator[Callable[[int, int], None]]:
    """A function that shows how many campaigns or sections are settled."""
    columns = (TextColumn(what), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=errors, transient=True, disable=not errors.is_terminal) as bar:
        task = bar.add_task(what, total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)
