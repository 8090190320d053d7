"""Limit sea states: up to which sea state each controller docks."""

import json
from collections.abc import Callable, Sequence
from concurrent.futures import Executor, as_completed
from importlib import resources
from pathlib import Path
from typing import Annotated

from pydantic import Field

from marine_mj.campaign.pools import open_pool
from marine_mj.errors import AnalysisError, CampaignError
from marine_mj.scenario import Scenario
from marine_mj.settings import Settings

#: Share of the runs that must succeed at the limit and below.
NEEDED = 0.9
#: Called with how much is done and how much there is.
Progress = Callable[[int, int], None]


class LimitTable(Settings):
    """Which runs of a docking scenario succeeded: latched, and no forbidden contact.

    Attributes:
        scenario: name or file.
        duration: longest time of a run, s.
        seeds: of the runs at every sea state.
        sea_states: ascending.
        success: by controller: for the sea states up to the first one that is too much for it:
            for every seed, whether it docked.
    """

    scenario: str
    duration: Annotated[float, Field(gt=0)]
    seeds: tuple[int, ...]
    sea_states: tuple[int, ...]
    success: dict[str, tuple[tuple[bool, ...], ...]]

    @classmethod
    def load(cls, file: Path | None = None) -> "LimitTable":
        """The table in a file, or the packaged one of `docking_demo`.

        Raises:
            AnalysisError: the file cannot be read, or is not JSON.
            ScenarioError: it is no table of limits.
        """
        path = file or Path(
            str(resources.files("marine_mj") / "scenarios/docking_demo.limits.json")
        )
        try:
            values = json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise AnalysisError(
                f"table of limits {str(path)!r} cannot be read: {error}; "
                "marine-mj limits measure writes one"
            ) from None
        return cls.parse(values, f"table of limits {path.name}")

    def count(self, controller: str, sea_state: int) -> int:
        """How many runs of a controller succeeded at a sea state."""
        return sum(self._runs(controller, sea_state))

    def limit(self, controller: str) -> int | None:
        """Highest sea state at which, as at all lower ones, `NEEDED` of the runs succeeded.

        None where the lowest one of the table is too much; the last one of the table where none
        was too much.

        Raises:
            AnalysisError: the table does not have the controller.
        """
        found = None
        for sea_state, _ in zip(self.sea_states, self._of(controller), strict=False):
            if self.count(controller, sea_state) < NEEDED * len(self.seeds) - 1e-9:
                break
            found = sea_state
        return found

    def seed(self, controllers: Sequence[str], sea_state: int) -> int:
        """First seed with which all these controllers dock at a sea state.

        Raises:
            AnalysisError: there is none, or the table does not have a controller or sea state.
        """
        runs = [self._runs(controller, sea_state) for controller in controllers]
        for seed, *docked in zip(self.seeds, *runs, strict=True):
            if all(docked):
                return seed
        raise AnalysisError(
            f"with no seed of {', '.join(map(str, self.seeds))} all of {', '.join(controllers)} "
            f"dock at sea state {sea_state}: take fewer controllers or a lower sea state"
        )

    def _of(self, controller: str) -> tuple[tuple[bool, ...], ...]:
        """Results of a controller."""
        if controller not in self.success:
            raise AnalysisError(
                f"controller {controller!r} is not in the table of limits; it has "
                f"{', '.join(self.success)}"
            )
        return self.success[controller]

    def _runs(self, controller: str, sea_state: int) -> tuple[bool, ...]:
        """Results of a controller at a sea state."""
        measured = dict(zip(self.sea_states, self._of(controller), strict=False))
        if sea_state not in measured:
            raise AnalysisError(
                f"controller {controller!r} was not measured at sea state {sea_state}, only at "
                f"{', '.join(map(str, measured))}"
            )
        return measured[sea_state]


def measure_limits(
    scenario: str,
    controllers: Sequence[str],
    sea_states: Sequence[int],
    seeds: Sequence[int],
    *,
    duration: float = 90.0,
    workers: int | None = None,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> LimitTable:
    """Limit sea states of controllers in a docking scenario: one run per sea state and seed.

    A controller is not flown beyond the first sea state that is too much for it.

    Args:
        scenario: its name or file; gain set, latch and all else stay as they stand there.
        controllers: values of `task.settings.controller`; each is the work of one worker.
        sea_states: numbers of `marine_mj.environment.sea_state`.
        seeds: of the runs.
        duration: longest time of a run, s.
        workers, executor: see `marine_mj.campaign.pools.open_pool`.
        progress: called with the controllers that are measured and all of them.

    Raises:
        ScenarioError: the scenario or a controller does not exist.
        CampaignError: a worker was killed.
    """
    base = Scenario.load(scenario).with_values({"duration": duration})
    states = tuple(sorted(set(sea_states)))
    success: dict[str, tuple[tuple[bool, ...], ...]] = dict.fromkeys(controllers, ())
    table = LimitTable(
        scenario=scenario,
        duration=duration,
        seeds=tuple(seeds),
        sea_states=states,
        success=success,
    )
    with open_pool(workers, executor=executor) as pool:
        futures = {pool.submit(_climbed, table, base, name): name for name in success}
        for done, future in enumerate(as_completed(futures), start=1):
            name = futures[future]
            try:
                table = table.changed(success=table.success | {name: future.result()})
            except pool.died:
                raise CampaignError(
                    f"a worker was killed while it measured {name!r} or beside it (out of "
                    "memory?): give fewer workers or controllers"
                ) from None
            if progress is not None:
                progress(done, len(futures))
    return table


def _climbed(table: LimitTable, base: Scenario, controller: str) -> tuple[tuple[bool, ...], ...]:
    """Results of a controller up to the first sea state that is too much for it."""
    from marine_mj.simulation import run_batch

    for state in table.sea_states:
        values = {"task.settings.controller": controller, "sea.sea_state": state}
        rows = run_batch(base, [values | {"seed": seed} for seed in table.seeds]).rows
        runs = (*table.success[controller], tuple(_succeeded(row) for row in rows))
        table = table.changed(success=table.success | {controller: runs})
        if table.limit(controller) != state:
            break
    return table.success[controller]


def _succeeded(row: dict) -> bool:
    """Latched, without forbidden contact and without an error."""
    return bool(row.get("docked")) and not row.get("forbidden_contact") and not row.get("error")
