"""Tasks by domain and name, in the manner of `dm_control.suite`."""

from typing import Any

from dm_control.rl import control

from marine_mj.tasks import DOMAINS


def _tasks(tag: str | None) -> tuple[tuple[str, str], ...]:
    """(domain, task) pairs, optionally only those with a tag."""
    pairs = []
    for domain, module in sorted(DOMAINS.items()):
        names = list(module.SUITE if tag is None else module.SUITE.tagged(tag))
        names += [name for name, (task, _) in _variants(domain).items() if task in names]
        pairs += [(domain, name) for name in names]
    return tuple(pairs)


def _variants(domain: str) -> dict[str, tuple[str, dict[str, Any]]]:
    """Names that stand for a task of the domain with keywords."""
    return getattr(DOMAINS[domain], "VARIANTS", {})


#: All (domain, task) pairs, variants as `dock_cpva_ss4` among them.
ALL_TASKS = _tasks(None)
#: Only the tasks that the variants stand for.
BASE_TASKS = tuple((d, name) for d, module in sorted(DOMAINS.items()) for name in module.SUITE)
#: Tasks with rewards in [0, 1] and actions in [-1, 1].
BENCHMARKING = _tasks("benchmarking")
#: Tasks with an attached controller.
CLOSED_LOOP = _tasks("closed_loop")
#: Tasks whose action is the raw actuator command.
OPEN_LOOP = _tasks("open_loop")
#: Task names by domain.
TASKS_BY_DOMAIN = {
    domain: tuple(name for d, name in ALL_TASKS if d == domain) for domain in sorted(DOMAINS)
}


def load(
    domain_name: str,
    task_name: str,
    task_kwargs: dict[str, Any] | None = None,
    environment_kwargs: dict[str, Any] | None = None,
    visualize_reward: bool = False,
) -> control.Environment:
    """Environment of a task, as `dm_control.suite.load`.

    Args:
        domain_name: a key of `TASKS_BY_DOMAIN`.
        task_name: a task of this domain.
        task_kwargs: keyword arguments of the task, such as `controller`, `sea_state`; they
            come before those of a variant.
        environment_kwargs: keyword arguments of `dm_control.rl.control.Environment`.
        visualize_reward: for compatibility; marine scenes have no reward colours.

    Raises:
        ValueError: the domain or the task does not exist; the message lists what does.
        ScenarioError: a task keyword is not valid.
    """
    if domain_name not in DOMAINS:
        raise ValueError(f"domain {domain_name!r} does not exist; available: {', '.join(DOMAINS)}")
    suite, variants = DOMAINS[domain_name].SUITE, _variants(domain_name)
    if task_name not in suite and task_name not in variants:
        raise ValueError(
            f"task {task_name!r} does not exist in domain {domain_name!r}; "
            f"available: {', '.join(suite)}{_outline(variants)}"
        )
    if visualize_reward:
        raise ValueError("visualize_reward is not available: marine scenes have no reward colours")
    task, keywords = variants.get(task_name, (task_name, {}))
    kwargs = keywords | dict(task_kwargs or {})
    if environment_kwargs is not None:
        kwargs["environment_kwargs"] = environment_kwargs
    return suite[task](**kwargs)


def _outline(variants: dict[str, Any]) -> str:
    """First and last of many names, for a message."""
    names = list(variants)
    return f", and {len(names)} variants from {names[0]} to {names[-1]}" if names else ""
