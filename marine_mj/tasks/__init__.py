"""dm_control tasks: one module per domain, each with a `SUITE` and `build(scenario)`."""

from typing import Any

from dm_control.rl import control

from marine_mj.headless import tolerant_import

tolerant_import("dm_control._render")  # before anything of dm_control that renders

from marine_mj.errors import ScenarioError
from marine_mj.scenario import Scenario
from marine_mj.tasks import docking

#: Domains by name.
DOMAINS: dict[str, Any] = {"docking": docking}


def build_environment(
    scenario: Scenario, random: Any = None, environment_kwargs: dict[str, Any] | None = None
) -> control.Environment:
    """dm_control environment of a scenario.

    Raises:
        ScenarioError: the domain or task does not exist (the message lists what does), or a task
            setting is not valid.
    """
    choice = scenario.task
    if choice.domain not in DOMAINS:
        raise ScenarioError(
            f"task.domain = {choice.domain!r} does not exist; available: {', '.join(DOMAINS)}"
        )
    domain = DOMAINS[choice.domain]
    if choice.name not in domain.SUITE:
        raise ScenarioError(
            f"task.name = {choice.name!r} does not exist in domain {choice.domain!r}; "
            f"available: {', '.join(domain.SUITE)}"
        )
    return domain.build(scenario, random, environment_kwargs)


__all__ = ["DOMAINS", "build_environment"]
