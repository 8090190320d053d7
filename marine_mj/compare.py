"""Runs of one scenario with other values, for pictures side by side."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

from marine_mj.errors import ScenarioError
from marine_mj.limits import LimitTable
from marine_mj.scenario import Scenario
from marine_mj.simulation import Log, run

#: Called with what is simulated, the simulated time and the duration, s.
Report = Callable[[str, float, float], None]


@dataclass(frozen=True)
class Variant:
    """A scenario to run, and what it is called in pictures."""

    title: str
    scenario: Scenario

    @classmethod
    def of(
        cls, scenario: Scenario, changes: Mapping[str, Any], title: str | None = None
    ) -> "Variant":
        """A scenario with values replaced.

        Its log has an entry per control period, so that slow motion is smooth and no touch is
        missed. The title defaults to the new values, and the number of the sea state.
        """
        changed = scenario.with_values({**changes, "log_period": scenario.control_period})
        names = [str(value) for value in changes.values()]
        if title is None and "sea.sea_state" not in changes and changed.sea.sea_state is not None:
            names.append(f"sea state {changed.sea.sea_state}")
        return cls(title or ", ".join(names), changed)

    def run(self, report: Report | None = None) -> Log:
        """The log of the run."""
        if report is None:
            return run(self.scenario)
        return run(self.scenario, progress=lambda time, end: report(self.title, time, end))


def variants(scenario: Scenario, varied: Mapping[str, Sequence[Any]]) -> list[Variant]:
    """A scenario with all combinations of the values given by dotted keys, in order.

    Raises:
        ScenarioError: nothing is varied, or a value is not allowed.
    """
    if not varied or not all(varied.values()):
        raise ScenarioError(
            "nothing is compared: give values, such as --vary task.settings.controller=cpv,mpc"
        )
    names = list(varied)
    return [
        Variant.of(scenario, dict(zip(names, values, strict=True)))
        for values in product(*varied.values())
    ]


def variants_at_limit(table: LimitTable, shared: bool) -> list[Variant]:
    """One docking per controller of a table, each in a sea in which it docked.

    Args:
        table: of limit sea states; controllers without a limit are left out.
        shared: all in the same sea, that of the lowest limit, with a seed with which all docked;
            otherwise each at its own limit.

    Raises:
        ScenarioError: no controller has a limit.
        AnalysisError: at the lowest limit there is no seed with which all docked.
    """
    limits = {name: table.limit(name) for name in table.success}
    reached = {name: limit for name, limit in limits.items() if limit is not None}
    if not reached:
        raise ScenarioError(
            f"no controller of {', '.join(limits)} docks at sea state {table.sea_states[0]}: "
            "measure limits from a lower one"
        )
    base = Scenario.load(table.scenario).with_values({"duration": table.duration})
    lowest = min(reached.values())
    together = table.seed(list(reached), lowest) if shared else 0
    found = []
    for name, limit in reached.items():
        sea_state = lowest if shared else limit
        changes = {
            "task.settings.controller": name,
            "sea.sea_state": sea_state,
            "seed": together if shared else table.seed([name], limit),
        }
        found.append(Variant.of(base, changes, f"{name}, sea state {sea_state}"))
    return found
