"""The campaigns of a reproduction: sea states upwards, until one is not finished in time."""

import json
import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from marine_mj.analysis.docking import Entries
from marine_mj.campaign import Campaign, Plan, run_together
from marine_mj.campaign.folder import CampaignFolder
from marine_mj.campaign.pools import open_pool
from marine_mj.environment.sea_states import SEA_STATES
from marine_mj.errors import AnalysisError, CampaignError
from marine_mj.reproduce.docking import CONFIGURATIONS, SCENARIO, TABLES, Configuration, Row
from marine_mj.simulation.batch import BLOCK

#: Of all campaigns: run i has the same phases and noise in every configuration.
_SEED = 712
#: Runs of a configuration that cannot be parted; a batch holds many of them.
_CHUNK = 60
#: Sea states of a campaign. More of them make larger batches, of which a control period costs 2 to
#: 3 ms however few runs are left; but those above one with an unfinished run are for nothing.
_BLOCKS = ((0,), (1, 2, 3, 4, 5, 6), (7, 8, 9), (10, 11, 12))
#: How often the progress is told, s.
_LOOK = 0.5
#: Sea states of configurations by campaign, upwards.
Blocks = dict[str, list[tuple[int, ...]]]


@dataclass(frozen=True)
class Cells:
    """Results of a configuration.

    Attributes:
        entries: by sea state, up to the first one with a run that did not enter in time.
        errors: runs that ended with an error (diverged), by sea state; only those with some.
        duration: time a run had, s.
    """

    entries: dict[int, Entries]
    errors: dict[int, int]
    duration: float

    def __add__(self, higher: "Cells") -> "Cells":
        """With the results of higher sea states."""
        return Cells(self.entries | higher.entries, self.errors | higher.errors, self.duration)


def run_configurations(
    rows: Iterable[Row],
    folder: str | Path,
    runs: int = 60,
    *,
    highest: int | None = None,
    changes: Mapping[str, Any] | None = None,
    workers: int | None = None,
    executor: Executor | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> dict[str, Cells]:
    """Results of all configurations that table rows need, by name.

    A configuration's sea states run upwards, one to six of them as a campaign in
    `folder`/campaigns; what is finished there is not done again, and more `runs` only add to it.
    They end with the first one in which a run did not enter the dock in time, the termination rule
    of the study (digest 7.0). Configurations that differ in numbers only share their batches; the
    results depend neither on that nor on the workers.

    Args:
        rows: of the tables.
        folder: of the reproduction.
        runs: per configuration and sea state.
        highest: last sea state; None: that of the tables.
        changes: of the scenario by dotted key, for all runs: what if the study did otherwise?
        workers, executor: see `open_pool`.
        progress: called with the number of campaigns that are settled and of all campaigns.

    Raises:
        AnalysisError: fewer than 2 runs, or `highest` is below the first sea state of a table.
        CampaignError: a campaign there has other settings or code, or a worker was killed.
    """
    if runs < 2:
        raise AnalysisError(
            f"runs = {runs} per sea state: allowed are 2 or more (the study has 60)"
        )
    blocks = _blocks(rows, highest)
    total = sum(map(len, blocks.values()))
    base = Path(folder) / "campaigns"
    found: dict[str, Cells] = {}
    running: dict[Future, list[str]] = {}
    with open_pool(workers, executor=executor) as pool:
        while waiting := set(blocks) - {n for n, c in found.items() if _over(c, blocks[n])}:
            idle = waiting - {name for names in running.values() for name in names}
            while idle and len(running) < pool.slots:
                names = _next(idle, blocks, found, pool.slots, runs)
                tasks = [(name, blocks[name][_done(found, blocks, name)]) for name in names]
                running[pool.submit(_together, tasks, base, runs, changes or {})] = names
                idle -= set(names)
            for future in wait(running, timeout=_LOOK, return_when=FIRST_COMPLETED).done:
                names = running.pop(future)
                try:
                    for name, cells in future.result().items():
                        found[name] = found[name] + cells if name in found else cells
                except pool.died:
                    raise CampaignError(
                        f"a worker was killed while it ran {', '.join(names)} in {str(base)!r} or "
                        "beside it (out of memory?): give the same command again, it goes on with "
                        "what is missing"
                    ) from None
            if progress is not None:
                progress(sum(_settled(found, blocks, name) for name in blocks), total)
    return {name: found[name] for name in blocks}


def block_plan(
    configuration: Configuration,
    states: Sequence[int],
    runs: int,
    changes: Mapping[str, Any] | None = None,
) -> Plan:
    """The campaign of a configuration in some sea states: common seeds, entries as metrics."""
    settings: dict[str, Any] = {
        "name": f"{configuration.name}.sea_states_{'-'.join(map(str, states))}",
        "scenario": SCENARIO,
        "set": {**configuration.changes, **(changes or {})},
        "runs": runs,
        "seed": _SEED,
        "common_seeds": True,
        "chunk": _CHUNK,
        "factors": {"sea_state": {"key": "sea.sea_state", "grid": list(states)}},
        "metrics": {
            "surge_error": "capture.surge_error",
            "pitch_error": "capture.pitch_error",
            "kinetic_energy": "capture.relative_kinetic_energy",
            "capture_time": "capture_time",
        },
        "success": ["capture_time > 0"],
    }
    return Plan(Campaign.parse(settings, f"campaign {settings['name']}"))


def _blocks(rows: Iterable[Row], highest: int | None) -> Blocks:
    """Sea states of each configuration, upwards, as they run together.

    They cover all tables with the configuration, chosen or not, so that a later choice of tables
    finds the same campaigns.
    """
    top = max(SEA_STATES[-1].ss_bft if highest is None else highest, -1)
    found: Blocks = {}
    for row in rows:
        if top < row.first:
            raise AnalysisError(
                f"highest sea state {highest} is below {row.first}, the first one of table "
                f"{row.table}: give {row.first} or more"
            )
        users = [r for rs in TABLES.values() for r in rs if r.configuration == row.configuration]
        first, last = min(r.first for r in users), min(top, max(r.last for r in users))
        parts = (tuple(s for s in block if first <= s <= last) for block in _BLOCKS)
        found[row.configuration] = [part for part in parts if part]
    return found


def _done(found: Mapping[str, Cells], blocks: Blocks, name: str) -> int:
    """Number of blocks of a configuration that are finished."""
    cells = found.get(name)
    return 0 if cells is None else sum(block[0] in cells.entries for block in blocks[name])


def _settled(found: Mapping[str, Cells], blocks: Blocks, name: str) -> int:
    """Number of its blocks that are finished or not needed."""
    over = name in found and _over(found[name], blocks[name])
    return len(blocks[name]) if over else _done(found, blocks, name)


def _over(cells: Cells, blocks: Sequence[tuple[int, ...]]) -> bool:
    """Whether a configuration is at its end."""
    return blocks[-1][-1] in cells.entries or not all(e.complete for e in cells.entries.values())


def _next(
    idle: Collection[str], blocks: Blocks, found: Mapping[str, Cells], slots: int, runs: int
) -> list[str]:
    """Configurations to run together next: those with the most work left, up to a full batch.

    Work is the time that the remaining runs may take; a worker gets no more than its share.
    """
    left = {
        name: CONFIGURATIONS[name].changes["duration"]
        * sum(map(len, blocks[name][_done(found, blocks, name) :]))
        for name in sorted(idle)
    }
    groups: dict[str, list[str]] = {}
    for name in left:
        groups.setdefault(CONFIGURATIONS[name].structure, []).append(name)
    names = max(groups.values(), key=lambda group: sum(left[name] for name in group))
    states = max(len(blocks[name][_done(found, blocks, name)]) for name in names)
    return names[: min(math.ceil(len(idle) / slots), max(1, BLOCK // (runs * states)))]


def _together(
    tasks: Sequence[tuple[str, tuple[int, ...]]],
    base: Path,
    runs: int,
    changes: Mapping[str, Any],
) -> dict[str, Cells]:
    """Results of configurations in some sea states each; the work of a worker."""
    plans = {
        _folder(base, name, states): block_plan(CONFIGURATIONS[name], states, runs, changes)
        for name, states in tasks
    }
    run_together(plans, extend=True)
    return {name: _read(base, name, states) for name, states in tasks}


def _read(base: Path, name: str, states: Sequence[int]) -> Cells:
    """Results of a campaign, up to the first sea state with a run that did not enter in time."""
    entries: dict[int, Entries] = {}
    errors: dict[int, int] = {}
    there = CampaignFolder(_folder(base, name, states))
    columns = ["sea_state", "summary", "error"]
    rows = [row for f in there.chunk_files() for row in there.read(f.stem, columns).to_pylist()]
    for state in states:
        mine = [row for row in rows if row["sea_state"] == state]
        entries[state] = Entries.of([json.loads(row["summary"]) for row in mine])
        if failed := sum(row["error"] is not None for row in mine):
            errors[state] = failed
        if not entries[state].complete:
            break
    return Cells(entries, errors, float(CONFIGURATIONS[name].changes["duration"]))


def _folder(base: Path, name: str, states: Sequence[int]) -> Path:
    return base / name / f"sea_states_{'-'.join(f'{s:02d}' for s in states)}"
