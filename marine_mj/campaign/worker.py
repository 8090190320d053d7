"""What a worker does: the runs of one chunk."""

import contextlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import xarray as xr

from marine_mj.campaign.code import fingerprint
from marine_mj.errors import CampaignError, ScenarioError
from marine_mj.scenario import Scenario
from marine_mj.simulation.batch import BatchResult, run_batch, run_scenarios

#: Reason in the row of a run whose worker ended without an answer, again and again.
WORKER_DIED = "worker died: the process that computed this run was killed or crashed every time"


@dataclass(frozen=True)
class Work:
    """Runs to be done together.

    Attributes:
        scenario: base scenario, TOML text.
        variations: one mapping by dotted key per run.
        record: signals to keep.
        decimation: keep every so manyth log entry.
        fingerprint: of the code and models that the campaign was planned with; None: any.
    """

    scenario: str
    variations: tuple[Mapping[str, Any], ...]
    record: tuple[str, ...] = ()
    decimation: int = 1
    fingerprint: str | None = None

    def halves(self) -> tuple["Work", "Work"]:
        """The same runs in two parts."""
        middle = len(self.variations) // 2
        return (
            replace(self, variations=self.variations[:middle], fingerprint=None),
            replace(self, variations=self.variations[middle:], fingerprint=None),
        )


@dataclass(frozen=True)
class Done:
    """Results of runs.

    Attributes:
        rows: one per run, in order, as `BatchResult.rows`.
        signals: recorded signals by run (position in `rows`); None when there are none.
    """

    rows: list[dict[str, Any]]
    signals: xr.Dataset | None = None

    def __add__(self, other: "Done") -> "Done":
        """These runs followed by others."""
        return joined([self, other])


def joined(parts: Sequence[Done]) -> Done:
    """Results of several parts, one after the other."""
    rows: list[dict[str, Any]] = []
    signals = []
    for part in parts:
        if part.signals is not None:
            runs = part.signals["run"] + len(rows)
            signals.append(part.signals.assign_coords(run=runs))
        rows += part.rows
    return Done(rows, xr.concat(signals, "run", join="outer") if signals else None)


def varied(
    base: Scenario, variations: Sequence[Mapping[str, Any]]
) -> list[Scenario | ScenarioError]:
    """The scenario of each variation, or why it is none."""
    found: list[Scenario | ScenarioError] = []
    for variation in variations:
        try:
            found.append(base.with_values(dict(variation)))
        except ScenarioError as error:
            found.append(error)
    return found


def do(work: Work) -> Done:
    """Results of the runs; a run that raises is a row with its reason.

    Raises:
        CampaignError: this worker has other code or models than the campaign was planned with.
    """
    scenario = Scenario.from_toml(work.scenario, "base scenario")
    if work.fingerprint is not None:
        scenarios = varied(scenario, work.variations)
        here = fingerprint([s for s in scenarios if isinstance(s, Scenario)])
        if here != work.fingerprint:
            raise CampaignError(
                f"a worker has other code, package versions or models ({here[:12]}) than the "
                f"campaign was planned with ({work.fingerprint[:12]}): install the same there"
            )
    try:
        return _numbered(_batch(scenario, work.variations, work), range(len(work.variations)))
    # Whatever one run raises must not take the others with it.
    except Exception:
        return joined([_single(scenario, variation, work) for variation in work.variations])


def do_together(works: Sequence[Work]) -> list[Done]:
    """Results of several works without signals, each as `do` gives it, from one batch."""
    parts = [
        varied(Scenario.from_toml(work.scenario, "base scenario"), work.variations)
        for work in works
    ]
    scenarios = [s for part in parts for s in part if isinstance(s, Scenario)]
    if len(scenarios) == sum(map(len, parts)):
        # Whatever one run raises must not take the others with it.
        with contextlib.suppress(Exception):
            rows = iter(run_scenarios(scenarios).rows)
            return [Done([next(rows) for _ in part]) for part in parts]
    return [do(work) for work in works]


def _batch(scenario: Scenario, variations: Sequence[Mapping[str, Any]], work: Work) -> BatchResult:
    return run_batch(scenario, variations, record=work.record, decimation=work.decimation)


def _single(scenario: Scenario, variation: Mapping[str, Any], work: Work) -> Done:
    """Result of one run, or the row of its exception."""
    try:
        return _numbered(_batch(scenario, [variation], work), range(1))
    except Exception as error:
        return Done([failed(f"{type(error).__name__}: {error}")])


def failed(reason: str) -> dict[str, Any]:
    """Row of a run without results."""
    return {"simulated_time": 0.0, "wall_time": 0.0, "error": reason}


def _numbered(result: BatchResult, runs: range) -> Done:
    """A batch's results with a coordinate for its runs."""
    signals = result.signals
    if signals is not None:
        signals = signals.assign_coords(run=list(runs))
    return Done(list(result.rows), signals)
