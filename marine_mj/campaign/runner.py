"""Running a campaign: what is missing is computed, written chunk by chunk, until it is enough."""

import contextlib
import datetime
import functools
import itertools
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

import pyarrow.compute as pc

from marine_mj.campaign import worker
from marine_mj.campaign.changes import check_unchanged
from marine_mj.campaign.chunks import Chunk, Progress, count, make_chunk
from marine_mj.campaign.code import all_versions, fingerprint, git_revision
from marine_mj.campaign.dispatch import dispatch
from marine_mj.campaign.folder import CampaignFolder
from marine_mj.campaign.plan import Plan
from marine_mj.campaign.pools import open_pool
from marine_mj.campaign.search import search
from marine_mj.campaign.settings import Campaign
from marine_mj.campaign.stopping import StoppingMonitor
from marine_mj.campaign.table import table
from marine_mj.campaign.worker import Done, Work
from marine_mj.errors import CampaignError
from marine_mj.scenario import Scenario


def run_campaign(
    plan: Plan,
    folder: str | Path,
    *,
    resume: bool = False,
    extend: bool = False,
    workers: int | None = None,
    cluster: str | None = None,
    executor: Executor | None = None,
    progress: Callable[[Progress], None] | None = None,
    do: Callable[[Work], Done] = worker.do,
) -> Progress:
    """State of a campaign after all its runs (or as many as its stopping rule asks for).

    Which runs there are, and their numbers, follow from the plan alone: not from workers, cluster,
    interruptions or timing.

    Args:
        plan: what to run.
        folder: gets manifest.json, campaign.toml, runs/*.parquet, trajectories/*.nc, state.json;
            with `rare` also levels/*.npz.
        resume: go on with a campaign that was started in this folder.
        extend: with `resume`, allow that `runs` grew.
        workers, cluster, executor: see `open_pool`.
        progress: called after every chunk.
        do: what a worker does.

    Raises:
        CampaignError: the folder is in use, cannot be written, holds another campaign (or, without
            `resume`, any), or a metric does not exist. What was finished stays intact.
        ScenarioError, ModelError: a level of a factor gives a scenario that cannot be built.
    """
    place = CampaignFolder(folder)
    pool = functools.partial(open_pool, workers, cluster, executor)
    with started(plan, place, resume, extend) as totals:
        if plan.campaign.rare is not None:
            with contextlib.ExitStack() as stack:
                return search(plan, place, lambda: stack.enter_context(pool()), progress, do)
        state = CampaignState(plan, place, totals, progress)
        jobs = state.missing()
        # No workers are started for a campaign that is complete.
        for job in itertools.islice(jobs, 1):
            with pool() as opened:
                for first, done in dispatch(itertools.chain([job], jobs), opened, do):
                    state.take(first, done)
                    if state.monitor.stopped_at is not None:
                        break
        return state.close()


def evaluate(
    scenario: Scenario,
    variations: Sequence[dict[str, Any]],
    *,
    workers: int | None = None,
    cluster: str | None = None,
    executor: Executor | None = None,
    chunk: int = 10,
) -> list[dict[str, Any]]:
    """Rows of runs (`BatchResult.rows`), in order, without a folder.

    For studies that choose their points as they go, such as subset simulation: `Plan.at` turns
    uniform numbers into variations. Dead workers are dealt with as in a campaign.

    Args:
        scenario: what all runs share.
        variations: changes by dotted key, one per run.
        workers, cluster, executor: see `open_pool`.
        chunk: runs that are done together.
    """
    text = scenario.to_toml()
    firsts = range(0, len(variations), chunk)
    jobs = ((first, Work(text, tuple(variations[first : first + chunk]))) for first in firsts)
    with open_pool(workers, cluster, executor) as pool:
        found = dict(dispatch(jobs, pool))
    return [row for first in firsts for row in found[first].rows]


@contextlib.contextmanager
def started(plan: Plan, place: CampaignFolder, resume: bool, extend: bool) -> Iterator[list[int]]:
    """Ends of a campaign and its extensions, whose folder is ready and locked meanwhile.

    Raises:
        CampaignError, ScenarioError, ModelError: see `run_campaign`.
    """
    _check_start(place, resume)
    plan.check()
    place.create()
    with place.lock():
        _check_start(place, resume)
        yield _open(plan, place, resume, extend)


def _check_start(place: CampaignFolder, resume: bool) -> None:
    """Refuse to start over a campaign, and to go on with none."""
    if resume:
        place.manifest()
    elif place.exists:
        raise CampaignError(
            f"{str(place.path)!r} holds a campaign already: go on with it by `marine-mj campaign "
            "resume`, or choose a new --out"
        )


def _open(plan: Plan, place: CampaignFolder, resume: bool, extend: bool) -> list[int]:
    """Write or check the manifest; ends of the campaign so far and of its extensions."""
    levels = [plan.scenario(cell) for cell in plan.levels_one_at_a_time()]
    fresh: dict[str, Any] = {
        "format": 1,
        "campaign": plan.campaign.model_dump(mode="json"),
        "scenario": plan.base.to_toml(),
        "code": fingerprint(levels),
        "versions": all_versions(),
        "git_revision": git_revision(),
        "totals": [plan.total],
        "created": datetime.datetime.now().astimezone().isoformat(timespec="seconds"),
    }
    if not resume:
        place.write_text("campaign.toml", plan.campaign.to_toml())
        place.write_text("scenario.toml", plan.base.to_toml())
        place.write_json("manifest.json", fresh)
        return fresh["totals"]
    before = place.manifest()
    grown = check_unchanged(before, fresh, place.path, extend, plan.hypercube)
    if grown:
        before["totals"].append(plan.total)
        before["campaign"]["runs"] = plan.campaign.runs
        place.write_text("campaign.toml", plan.campaign.to_toml())
        place.write_json("manifest.json", before)
    return before["totals"]


class CampaignState:
    """Finished chunks of a campaign, counted as they come.

    Args:
        plan: what is run.
        place: its folder, locked.
        totals: see `started`.
        progress: called after every chunk.
    """

    def __init__(
        self,
        plan: Plan,
        place: CampaignFolder,
        totals: list[int],
        progress: Callable[[Progress], None] | None = None,
    ) -> None:
        self._plan, self._place, self._totals, self._progress = plan, place, totals, progress
        self.monitor = StoppingMonitor(plan.campaign, plan.cells)
        self._open: dict[int, Chunk] = {}
        self._done = self._successes = self._errors = 0

    def missing(self) -> Iterator[tuple[int, Work]]:
        """Work of the chunks without a file; those with one are counted on the way."""
        for first, end in self._plan.chunks(self._totals):
            if self.monitor.stopped_at is not None:
                return
            chunk = make_chunk(self._plan, [self._plan.run(n) for n in range(first, end)])
            if self._place.finished(chunk.name, end - first):
                self._count(chunk.name, first)
                continue
            self._open[first] = chunk
            yield first, chunk.work(self._plan)

    def take(self, first: int, done: Done) -> None:
        """Write a finished chunk."""
        chunk = self._open.pop(first)
        rows = table(self._plan, chunk.runs, chunk.scenarios, done.rows)
        chunk.write(self._place, rows, done.signals)
        self._count(chunk.name, first)

    def _count(self, name: str, first: int) -> None:
        """Count the runs of a finished chunk, from its file."""
        rule = self.monitor.rule
        metric = "success" if rule is None else rule.metric
        columns = list(dict.fromkeys(["cell", "success", "error", metric]))
        found = self._place.read(name, columns)
        values = [float("nan") if v is None else float(v) for v in found[metric].to_pylist()]
        self.monitor.add(first, zip(found["cell"].to_pylist(), values, strict=True))
        self._done += found.num_rows
        self._successes += pc.sum(found["success"]).as_py() or 0
        self._errors += found.num_rows - found["error"].null_count
        if self._progress is not None:
            self._progress(self._now())

    def _now(self) -> Progress:
        return Progress(self._done, self._plan.total, self._successes, self._errors)

    def close(self) -> Progress:
        """Leave exactly the runs before the stop, and say that the campaign is complete."""
        stop = self.monitor.stopped_at
        if stop is not None:
            self._place.remove_from(stop)
        counted = count(self._place, self._plan.total)
        about: dict[str, Any] = {"complete": True, "runs": counted.done, "stopped": None}
        if stop is not None and self.monitor.rule is not None:
            rule = self.monitor.rule
            about["stopped"] = {"metric": rule.metric, "width": self.monitor.width(), "runs": stop}
        self._place.write_json("state.json", about)
        return counted


def load_plan(folder: str | Path) -> Plan:
    """Plan of a campaign that was started in a folder, as it was then.

    Raises:
        CampaignError: there is none.
    """
    manifest = CampaignFolder(folder).manifest()
    base = Scenario.from_toml(manifest["scenario"], "scenario of the campaign")
    return Plan(Campaign.parse(manifest["campaign"], "campaign"), base)
