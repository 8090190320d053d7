"""Ours beside the published: maximum sea states with their scatter, verdict and reason."""

from dataclasses import dataclass

import numpy as np
from scipy.stats import norm

from marine_mj.analysis.docking import (
    COVERAGE,
    METRICS,
    CaptureLimits,
    Entries,
    bootstrap_limits,
    interval,
    limits_of,
    operable,
    uptime,
)
from marine_mj.controllers.navigation.planar import planar_scenario
from marine_mj.reproduce.docking import Row
from marine_mj.reproduce.filter_theory import surge_error
from marine_mj.reproduce.reasons import reason
from marine_mj.reproduce.runner import Cells

#: Columns of the tables, in their order.
COLUMNS = (*METRICS, "total", "uptime")
#: Sea states by which ours may be off: what the study's own repeated configuration scatters by.
TOLERANCE = {"surge": 1, "pitch": 2, "energy": 1, "total": 1}
#: Coverage of the bootstrap intervals.
_COVERAGE = 0.95
_UNITS = {"surge": "m", "pitch": "deg", "energy": "J"}


@dataclass(frozen=True)
class Judged:
    """One number of a table.

    Attributes:
        row: line of the table.
        column: in `COLUMNS`.
        published: sea state or None ("-"), or uptime in %.
        ours: the same of our runs.
        interval: 95 % of the bootstrapped values; one below the first sea state stands for None.
        verdict: "agrees", "differs" or "not comparable".
        note: why it differs, and what the study misprints.
        gaps: ours when a sea state that fails may lie below one that holds; not for the uptime.
    """

    row: Row
    column: str
    published: float | None
    ours: float | None
    interval: tuple[float, float]
    verdict: str
    note: str
    gaps: float | None = None


def judge(row: Row, cells: Cells, highest: int | None = None, resamples: int = 200) -> list[Judged]:
    """All numbers of a table row beside ours.

    A metric holds at a sea state when 99.7 % of its fitted distribution lies within the capture
    limits; the maximum counts without gaps from the table's first sea state. "agrees" is within one
    sea state, for pitch within two; the uptime follows from the total and shares its verdict.

    Args:
        row: line of the table.
        cells: our results of its configuration.
        highest: where our sea states ended before the table's; None: they did not.
        resamples: of the bootstrap.
    """
    last = row.last if highest is None else min(row.last, highest)
    entries = {s: e for s, e in cells.entries.items() if row.first <= s <= last}
    ours, gaps = limits_of(entries), limits_of(entries, contiguous=False)
    drawn = bootstrap_limits(entries, resamples=resamples)
    bottom = row.first - 1
    found = []
    for column, tolerance in TOLERANCE.items():
        published = row.published(column)
        levels = [bottom if state is None else state for state in drawn[column]]
        ends = np.quantile(levels, [(1 - _COVERAGE) / 2, (1 + _COVERAGE) / 2], method="nearest")
        off = abs(_level(ours[column], bottom) - _level(published, bottom))
        verdict = "agrees" if off <= tolerance else "differs"
        cut = last < row.last and ours[column] == last
        reasons = []
        if cut:
            verdict = "not comparable"
            reasons.append(f"sea states above {last} were not run")
        elif verdict == "differs":
            reasons.append(_reason(row, cells, entries, column, ours[column], gaps[column], ends))
        failed = sum(cells.errors.get(s, 0) for s in entries)
        if failed and not cut:
            verdict = "not comparable" if verdict == "differs" else verdict
            reasons.append(f"{failed} runs ended with an error")
        if column in row.printed:
            reasons.append(f"the study prints {row.printed[column]:g}, against its own columns")
        span = (float(ends[0]), float(ends[1]))
        note = "; ".join(reasons)
        found.append(
            Judged(row, column, published, ours[column], span, verdict, note, gaps[column])
        )
    return [*found, _uptime(row, found[-1], bottom)]


def _uptime(row: Row, total: Judged, bottom: int) -> Judged:
    """The uptime, %, that a maximum sea state means."""

    def percent(state: float | None) -> float:
        return 100 * uptime(None if state is None or state <= bottom else int(state))

    reasons = [] if total.verdict == "agrees" else ["follows from the total"]
    if "uptime" in row.printed:
        reasons.append(f"the study prints {row.printed['uptime']:g}, against its own columns")
    return Judged(
        row,
        "uptime",
        row.uptime,
        percent(total.ours),
        (percent(total.interval[0]), percent(total.interval[1])),
        total.verdict,
        "; ".join(reasons),
    )


def scaled(value: float, metric: str) -> float:
    """A value of a metric in the units of the report: m, degrees, J."""
    return float(np.rad2deg(value)) if metric == "pitch" else value


def _level(state: float | None, bottom: int) -> float:
    return bottom if state is None else state


def _reason(
    row: Row,
    cells: Cells,
    entries: dict[int, Entries],
    column: str,
    ours: int | None,
    gaps: int | None,
    ends: np.ndarray,
) -> str:
    """What ends our sea states where they end, and whether chance would do for the difference."""
    parts = []
    bottom = row.first - 1
    published = _level(row.published(column), bottom)
    stop = int(_level(ours, bottom)) + 1
    beyond = int(published) + 1
    if stop - 1 > published and beyond in entries and column in METRICS:
        spread = _interval(entries[beyond], column)
        parts.append(f"ours still holds at sea state {beyond}: 99.7 % of the runs have {spread}")
    elif stop in entries:
        parts.append(_stop(entries[stop], stop, column, cells.duration))
    limit = TOLERANCE[column]
    if ends[0] - limit <= published <= ends[1] + limit:
        parts.append(f"the scatter of {len(next(iter(entries.values())))} runs reaches it")
    if row.noise is not None and column in ("surge", "total"):
        width = norm.ppf(0.5 + 0.5 * COVERAGE) * surge_error(planar_scenario(row.noise))
        parts.append(
            f"99.7 % of the errors in surge that the filters alone make, by linear theory in any "
            f"sea, are within {width:.2f} m"
        )
    if gaps != ours and abs(_level(gaps, bottom) - published) <= limit:
        parts.append(f"with gaps ours is {gaps}")
    late = stop in entries and not entries[stop].complete
    difference = _level(ours, bottom) - published
    parts.append(reason(row.configuration, column, difference, late))
    return "; ".join(parts)


def _stop(entries: Entries, state: int, column: str, duration: float) -> str:
    """Why a sea state fails."""
    if not entries.complete:
        missing = int((~np.isfinite(entries.surge)).sum())
        return (
            f"at sea state {state} {missing} of {len(entries)} runs did not enter in {duration:g} "
            f"s, which ends the line by the study's rule, whatever the other "
            f"{len(entries) - missing} do"
        )
    columns = METRICS if column == "total" else (column,)
    spreads = [_interval(entries, m) for m in columns if not operable(entries)[m]]
    return f"at sea state {state} 99.7 % of the runs have {', '.join(spreads)}"


def _interval(entries: Entries, metric: str) -> str:
    """Interval of a metric beside its limit."""
    low, high = (scaled(end, metric) for end in interval(entries, metric))
    limit = scaled(getattr(CaptureLimits(), metric), metric)
    return f"{metric} {low:.2f} to {high:.2f} {_UNITS[metric]} (limit {limit:g})"
