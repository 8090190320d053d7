"""Limit sea states: up to which sea state each controller docks."""

import json
from collections.abc import Callable, Sequence
from importlib import resources
from pathlib import Path
from typing import Annotated

from pydantic import Field

from marine_mj.errors import AnalysisError
from marine_mj.scenario import Scenario
from marine_mj.settings import Settings

#: Share of the runs that must succeed at the limit and below.
NEEDED = 0.9
#: Called with runs done and runs in all.
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
    threads: int = 1,
    progress: Progress | None = None,
) -> LimitTable:
    """Limit sea states of controllers in a docking scenario: one run per sea state and seed.

    A controller is not flown beyond the first sea state that is too much for it.

    Args:
        scenario: its name or file; gain set, latch and all else stay as they stand there.
        controllers: values of `task.settings.controller`.
        sea_states: numbers of `marine_mj.environment.sea_state`.
        seeds: of the runs.
        duration: longest time of a run, s.
        threads: native threads.
        progress: called when runs have finished.

    Raises:
        ScenarioError: the scenario or a controller does not exist.
    """
    from marine_mj.simulation import run_batch

    base = Scenario.load(scenario).with_values({"duration": duration})
    states, done = sorted(set(sea_states)), 0
    table = LimitTable(
        scenario=scenario,
        duration=duration,
        seeds=tuple(seeds),
        sea_states=tuple(states),
        success={name: () for name in controllers},
    )
    total = len(controllers) * len(states) * len(seeds)
    for number, controller in enumerate(controllers):
        for state in states:
            values = {"task.settings.controller": controller, "sea.sea_state": state}
            rows = run_batch(
                base, [values | {"seed": seed} for seed in seeds], threads=threads
            ).rows
            docked = tuple(_succeeded(row) for row in rows)
            runs = (*table.success[controller], docked)
            table = table.changed(success=table.success | {controller: runs})
            done += len(seeds)
            if progress is not None:
                progress(done, total)
            if table.limit(controller) != state:
                break
        done = (number + 1) * len(states) * len(seeds)
    if progress is not None:
        progress(total, total)
    return table


def _succeeded(row: dict) -> bool:
    """Latched, without forbidden contact and without an error."""
    return bool(row.get("docked")) and not row.get("forbidden_contact") and not row.get("error")
