"""Searching for rare events: levels of runs, each chosen by the results of the one before."""

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from marine_mj.analysis import SubsetState
from marine_mj.campaign.chunks import Chunk, Progress, count, make_chunk
from marine_mj.campaign.conditions import look_up, transformed
from marine_mj.campaign.dispatch import dispatch
from marine_mj.campaign.folder import CampaignFolder
from marine_mj.campaign.plan import Plan
from marine_mj.campaign.pools import Pool
from marine_mj.campaign.rare import Rare
from marine_mj.campaign.table import table
from marine_mj.campaign.worker import Done, Work
from marine_mj.errors import AnalysisError, CampaignError
from marine_mj.frames import Array


def search_name(cell: int, repetition: int) -> str:
    """Name of the state of a search, without the ending."""
    return f"repetition-{repetition:04d}-cell-{cell:04d}"


def searches(plan: Plan) -> Iterator[tuple[int, int]]:
    """Cell and repetition of every search, in the order in which they are done."""
    assert plan.campaign.rare is not None
    for repetition in range(plan.campaign.rare.repetitions):
        for cell in range(plan.cells):
            yield cell, repetition


def search(
    plan: Plan,
    place: CampaignFolder,
    open_pool: Callable[[], Pool],
    progress: Callable[[Progress], None] | None,
    do: Callable[[Work], Done],
) -> Progress:
    """State of the campaign after all its searches.

    Every call of the score is a few chunks of runs whose names follow from their inputs, as in
    other campaigns: what is on the disk is not computed again. After each level the state of the
    search is written, so that going on does not begin at the first level.

    Args:
        plan: what to search.
        place: folder of the campaign, locked.
        open_pool: gives the workers; called once, if anything is to be computed.
        progress: called after every chunk with the runs that are new.
        do: what a worker does.

    Raises:
        CampaignError: nothing can be written, the metric does not exist or does not distinguish
            the runs, or a run's factors give no valid scenario. Finished chunks are intact.
    """
    assert plan.campaign.rare is not None
    runs = _Runs(plan, place, open_pool, progress, do)
    for cell, repetition in searches(plan):
        try:
            _search(plan.campaign.rare, runs, cell, repetition)
        except AnalysisError as error:
            raise CampaignError(
                f"the search in cell {cell}, repetition {repetition} cannot go on: {error}"
            ) from None
    done = count(place, 0)
    place.write_json("state.json", {"complete": True, "runs": done.done, "stopped": None})
    return done


def _search(rare: Rare, runs: "_Runs", cell: int, repetition: int) -> None:
    """One search from its last finished level to its end."""
    name = search_name(cell, repetition)
    state = runs.place.read_state(name)
    runs.cell, runs.repetition = cell, repetition
    # With a chunk missing, all levels are gone through again: only that chunk is computed.
    if state is None or not runs.place.complete(runs.next, runs.next + state.evaluations):
        runs.level = 0
        state = SubsetState.start(
            runs.score,
            runs.plan.dimension(cell),
            rare.sign * rare.threshold,
            samples=rare.samples,
            p0=rare.p0,
            proposal=rare.proposal,
            seed=runs.plan.search_seed(repetition, cell),
        )
        runs.place.write_state(name, state)
    else:
        runs.next += state.evaluations
    while not state.finished and len(state.levels) < rare.most_levels:
        runs.level = len(state.levels) + 1
        state = state.advance(runs.score)
        runs.place.write_state(name, state)


@dataclass
class _Runs:
    """The score as runs: consecutive numbers, rows in chunks."""

    plan: Plan
    place: CampaignFolder
    open_pool: Callable[[], Pool]
    progress: Callable[[Progress], None] | None
    do: Callable[[Work], Done]
    now: Progress = field(default_factory=lambda: Progress(0, 0, 0, 0))
    pool: Pool | None = None
    next: int = 0
    cell: int = 0
    repetition: int = 0
    level: int = 0

    def score(self, u: Array) -> Array:
        """Scores (n,) of standard normals (n, d)."""
        chunks, found = [], {}
        for part in np.split(u, range(self.plan.campaign.chunk, len(u), self.plan.campaign.chunk)):
            chunks.append((self._chunk(part), part))
            self.next += len(part)
        missing = []
        for i, (chunk, _) in enumerate(chunks):
            if self.place.finished(chunk.name, len(chunk.runs)):
                found[i] = self.place.read(chunk.name, ["score"])["score"].to_numpy()
            else:
                missing.append((i, chunk.work(self.plan)))
        # No workers are started for what is there already.
        if missing:
            self.pool = self.pool or self.open_pool()
            for i, done in dispatch(iter(missing), self.pool, self.do):
                found[i] = self._write(*chunks[i], done)
        return np.concatenate([found[i] for i in range(len(chunks))])

    def _chunk(self, u: Array) -> Chunk:
        """The runs of a few standard normals (n, d)."""
        runs = [
            self.plan.at_normals(row, self.next + i, self.cell, self.repetition)
            for i, row in enumerate(u)
        ]
        chunk = make_chunk(self.plan, runs)
        for run, scenario in zip(runs, chunk.scenarios, strict=True):
            if isinstance(scenario, Exception):
                values = ", ".join(f"{k} = {v!r}" for k, v in run.factors.items())
                raise CampaignError(
                    f"the tail of the factors leads to a scenario that is not allowed ({values}): "
                    f"{scenario}. Give the factor a distribution with bounds"
                )
        return chunk

    def _write(self, chunk: Chunk, u: Array, done: Done) -> Array:
        """Scores (n,) of a finished chunk, which is written."""
        rows = table(self.plan, chunk.runs, chunk.scenarios, done.rows)
        scores = _scores(self.plan, rows)
        rows = rows.append_column("level", pa.array([self.level] * len(u), pa.int64()))
        rows = rows.append_column("score", pa.array(scores, pa.float64()))
        rows = rows.append_column("distance", pa.array(np.linalg.norm(u, axis=1), pa.float64()))
        chunk.write(self.place, rows, done.signals)
        errors = len(u) - rows["error"].null_count
        self.now = Progress(
            self.now.done + len(u),
            0,
            self.now.successes + (pc.sum(rows["success"]).as_py() or 0),
            self.now.errors + errors,
            f"cell {self.cell}, repetition {self.repetition}, level {self.level}",
        )
        if self.progress is not None:
            self.progress(self.now)
        return scores


def _scores(plan: Plan, rows: pa.Table) -> Array:
    """Score (n,) of each row."""
    rare, what = plan.campaign.rare, "rare.metric"
    assert rare is not None
    scores = []
    for row in rows.to_pylist():
        value = None
        if row["success"]:
            if rare.metric in plan.campaign.metrics:
                value = row[rare.metric]
            else:
                value = look_up(json.loads(row["summary"]), rare.metric, what)
                value = transformed(value, [], what)
        scores.append(rare.score(row["success"], value))
    return np.array(scores)
