"""The campaigns of a reproduction: sea states upwards, until one is not finished in time."""

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import FIRST_EXCEPTION, Executor, Future, wait
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from marine_mj.analysis.docking import Entries
from marine_mj.campaign import Campaign, Plan, run_campaign
from marine_mj.campaign.folder import CampaignFolder
from marine_mj.campaign.pools import open_pool
from marine_mj.environment.sea_states import SEA_STATES
from marine_mj.errors import AnalysisError, CampaignError
from marine_mj.reproduce.docking import CONFIGURATIONS, SCENARIO, TABLES, Configuration, Row

#: Of all campaigns: run i has the same phases and noise in every configuration.
_SEED = 712
#: Runs of a sea state that are stepped together.
_CHUNK = 60
#: Sea states whose runs share a batch, by longest run (s). A control period costs 0.8 ms,
#: however few runs are left in it, so sea states together are cheaper; but those above one with an
#: unfinished run are for nothing, and dear where runs may last 300 s.
_BLOCKS = {
    120.0: ((0,), (1, 2, 3), (4, 5, 6), (7, 8, 9), (10, 11, 12)),
    300.0: ((0,), (1, 2, 3), (4, 5), *((state,) for state in range(6, 13))),
}
#: How often the folders are counted for the progress, s.
_LOOK = 0.5


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


class Here(Executor):
    """Calls are done at once by the caller: a worker that runs whole campaigns needs no others."""

    def submit(self, function: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future:
        """Future that is done."""
        future: Future = Future()
        try:
            future.set_result(function(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future


def run_configurations(
    rows: Iterable[Row],
    folder: str | Path,
    runs: int = 60,
    *,
    highest: int | None = None,
    workers: int | None = None,
    executor: Executor | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> dict[str, Cells]:
    """Results of all configurations that table rows need, by name.

    A configuration's sea states run upwards, one to three of them as a campaign in
    `folder`/campaigns; what is finished there is not done again, and more `runs` only add to it.
    They end with the first one in which a run did not enter the dock in time, the termination rule
    of the study (digest 7.0). Workers take one configuration after the other, so the results do
    not depend on their number.

    Args:
        rows: of the tables.
        folder: of the reproduction.
        runs: per configuration and sea state.
        highest: last sea state; None: that of the tables.
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
    states = _blocks(rows, highest)
    # Long ones first, so that none is left over at the end.
    names = sorted(states, key=lambda name: -CONFIGURATIONS[name].changes["duration"])
    total = sum(len(s) for s in states.values())
    base = Path(folder) / "campaigns"
    found: dict[str, Cells] = {}
    with open_pool(workers, executor=executor) as pool:
        futures = {
            pool.submit(_configuration, CONFIGURATIONS[name], states[name], base, runs): name
            for name in names
        }
        waiting = set(futures)
        while waiting:
            done, waiting = wait(waiting, timeout=_LOOK, return_when=FIRST_EXCEPTION)
            for future in done:
                try:
                    found[futures[future]] = future.result()
                except pool.died:
                    raise CampaignError(
                        f"a worker was killed in {str(base / futures[future])!r} or beside it (out "
                        "of memory?): give the same command again, it goes on with what is missing"
                    ) from None
            if progress is not None:
                progress(_settled(base, runs, states, found), total)
    return {name: found[name] for name in states}


def block_plan(configuration: Configuration, states: Sequence[int], runs: int) -> Plan:
    """The campaign of a configuration in some sea states: common seeds, entries as metrics."""
    settings: dict[str, Any] = {
        "name": f"{configuration.name}.sea_states_{'-'.join(map(str, states))}",
        "scenario": SCENARIO,
        "set": configuration.changes,
        "runs": runs,
        "seed": _SEED,
        "common_seeds": True,
        "chunk": _CHUNK * len(states),
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


def _blocks(rows: Iterable[Row], highest: int | None) -> dict[str, list[tuple[int, ...]]]:
    """Sea states of each configuration, upwards, as they run together.

    They cover all tables with the configuration, chosen or not, so that a later choice of tables
    finds the same campaigns.
    """
    top = max(SEA_STATES[-1].ss_bft if highest is None else highest, -1)
    found: dict[str, list[tuple[int, ...]]] = {}
    for row in rows:
        if top < row.first:
            raise AnalysisError(
                f"highest sea state {highest} is below {row.first}, the first one of table "
                f"{row.table}: give {row.first} or more"
            )
        users = [r for rs in TABLES.values() for r in rs if r.configuration == row.configuration]
        first, last = min(r.first for r in users), min(top, max(r.last for r in users))
        blocks = _BLOCKS[CONFIGURATIONS[row.configuration].changes["duration"]]
        parts = (tuple(s for s in block if first <= s <= last) for block in blocks)
        found[row.configuration] = [part for part in parts if part]
    return found


def _configuration(
    configuration: Configuration, blocks: Sequence[tuple[int, ...]], base: Path, runs: int
) -> Cells:
    """Results of a configuration; the work of a worker."""
    entries: dict[int, Entries] = {}
    errors: dict[int, int] = {}
    duration = float(configuration.changes["duration"])
    for states in blocks:
        place = _folder(base, configuration.name, states)
        there = CampaignFolder(place)
        plan = block_plan(configuration, states, runs)
        run_campaign(plan, place, resume=there.exists, extend=True, executor=Here())
        columns = ["sea_state", "summary", "error"]
        rows = [row for f in there.chunk_files() for row in there.read(f.stem, columns).to_pylist()]
        for state in states:
            mine = [row for row in rows if row["sea_state"] == state]
            entries[state] = Entries.of([json.loads(row["summary"]) for row in mine])
            if failed := sum(row["error"] is not None for row in mine):
                errors[state] = failed
            if not entries[state].complete:
                return Cells(entries, errors, duration)
    return Cells(entries, errors, duration)


def _folder(base: Path, name: str, states: Sequence[int]) -> Path:
    return base / name / f"sea_states_{'-'.join(f'{s:02d}' for s in states)}"


def _settled(
    base: Path,
    runs: int,
    blocks: Mapping[str, list[tuple[int, ...]]],
    found: Mapping[str, Cells],
) -> int:
    """Campaigns that are done or will not be needed."""
    count = 0
    for name, parts in blocks.items():
        for states in parts:
            file = _folder(base, name, states) / "state.json"
            count += name in found or (file.is_file() and _runs(file) >= runs * len(states))
    return count


def _runs(file: Path) -> int:
    """Runs of a campaign that came to its end."""
    return int(json.loads(file.read_text(encoding="utf-8"))["runs"])
