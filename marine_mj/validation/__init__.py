"""Validation: our numbers beside closed forms, independent solutions and the literature.

`marine-mj validate` runs it; docs/validation.md shows the table.
"""

import json
from collections.abc import Callable, Iterable
from pathlib import Path

from marine_mj.validation import (
    analysis,
    contact,
    control,
    databases,
    drift,
    estimates,
    geometry,
    goal,
    multibody,
    navigation,
    panels,
    physics,
    radiation,
    scout,
    vehicles,
    waves,
)
from marine_mj.validation.rows import Row

__all__ = ["CASES", "Row", "markdown", "run", "write"]

#: Functions that each give some rows, by part of the table.
CASES: dict[str, tuple[Callable[[], Iterable[Row]], ...]] = {
    "Rigid body and added mass": physics.CASES,
    "Waves": waves.CASES,
    "Radiation memory": radiation.CASES,
    "Wave databases": databases.CASES,
    "Wave drift": drift.CASES,
    "Vehicles": (*scout.CASES, *vehicles.CASES),
    "Hull panels": panels.CASES,
    "Contact": contact.CASES,
    "Coefficient estimates": estimates.CASES,
    "Hydrodynamics from geometry": (*geometry.CASES, *multibody.CASES),
    "Statistics": analysis.CASES,
    "Navigation": navigation.CASES,
    "Docking controllers": control.CASES,
    "Docking goal and operability": goal.CASES,
}


def run(progress: Callable[[int, int, str], None] | None = None) -> list[Row]:
    """All rows, in the order of the table.

    Args:
        progress: called with (cases done, cases in all, what is about to run).
    """
    cases = [case for part in CASES.values() for case in part]
    rows: list[Row] = []
    for done, case in enumerate(cases):
        if progress:
            progress(done, len(cases), (case.__doc__ or case.__name__).splitlines()[0])
        rows += case()
    if progress:
        progress(len(cases), len(cases), "done")
    return rows


def write(rows: Iterable[Row], folder: str | Path) -> Path:
    """Write `validation.json` into the folder (made if needed); returns its path."""
    path = Path(folder) / "validation.json"
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_suffix(".tmp")
    text = json.dumps([row.as_dict() for row in rows], indent=1, allow_nan=False)
    temporary.write_text(text + "\n", encoding="utf-8")
    temporary.replace(path)
    return path


def _cell(text: str) -> str:
    """Text that does not end its table cell."""
    return text.replace("|", "\\|")


def markdown(rows: Iterable[Row]) -> str:
    """The rows as the page docs/validation.md."""
    rows = list(rows)
    missed = [row.name for row in rows if not row.ok]
    verdict = f"{len(rows) - len(missed)} of {len(rows)} values are within their tolerance."
    lines = [
        "# Validation",
        "",
        "Made by `make validate`; do not edit. The tolerance is the largest allowed difference, in "
        "the same unit.",
        "",
        verdict + (f" Missed: {', '.join(missed)}." if missed else ""),
        "",
        "| case | measured | expected | tolerance | unit | source | ok |",
        "| --- | ---: | ---: | ---: | --- | --- | --- |",
    ]
    lines += [
        f"| {_cell(r.name)} | {r.measured:.6g} | {r.expected:.6g} | {r.tolerance:.2g} | {r.unit} | "
        f"{_cell(r.source)} | {'yes' if r.ok else '**no**'} |"
        for r in rows
    ]
    return "\n".join(lines) + "\n"
