"""Running one scenario from start to end."""

import time as clock
from collections.abc import Callable
from pathlib import Path
from typing import Any

import dm_env
import numpy as np

from marine_mj.errors import SimulationError
from marine_mj.frames import Array
from marine_mj.scenario import Scenario
from marine_mj.scene_choices import choose_integrator, excitations
from marine_mj.simulation.log import Log
from marine_mj.simulation.recorder import Recorder, versions
from marine_mj.tasks import build_environment
from marine_mj.weather import environment_of

Policy = Callable[[dm_env.TimeStep], Array]
#: Called with the simulated time and the duration, s.
Progress = Callable[[float, float], None]


def run(
    scenario: Scenario | str | Path,
    *,
    policy: Policy | None = None,
    progress: Progress | None = None,
) -> Log:
    """The log of one scenario.

    Args:
        scenario: a scenario, the path of a TOML file, or the name of a packaged scenario.
        policy: action of each control step from the time step; default: the task's own (no
            change of the reference for closed-loop tasks, no thrust for open ones).
        progress: called at every log entry.

    Raises:
        ScenarioError: the scenario is not valid.
        ModelError: a vehicle cannot be simulated as asked.
        SimulationError: the run diverged or a command was not finite. Its attribute `log` holds
            what was recorded until then.
    """
    if not isinstance(scenario, Scenario):
        scenario = Scenario.load(scenario)
    started = clock.perf_counter()
    environment = build_environment(scenario, random=scenario.seed)
    recorder = Recorder(scenario, environment, environment_of(scenario).waves)
    stride = round(scenario.log_period / scenario.control_period)
    physics, task = environment.physics, environment.task

    def summary(error: SimulationError | None = None) -> dict[str, Any]:
        now = clock.perf_counter()
        return plain(
            {
                "scenario": scenario.name,
                "seed": scenario.seed,
                **task.summary(physics),
                "integrator": choose_integrator(scenario),
                "excitation": excitations(scenario),
                "simulated_time": simulated,
                "wall_time": now - started,
                "real_time_factor": simulated / max(now - started, 1e-9),
                "error": None if error is None else str(error),
                "versions": versions(),
            }
        )

    simulated, start, steps = 0.0, 0.0, 0
    try:
        step = environment.reset()
        start = physics.data.time
        action = task.default_action(physics)
        recorder.sample(0.0)
        while not step.last():
            step = environment.step(action if policy is None else policy(step))
            steps += 1
            simulated = physics.data.time - start
            if steps % stride == 0 or step.last():
                recorder.sample(simulated)
                if progress is not None:
                    progress(simulated, scenario.duration)
    except SimulationError as error:
        simulated = max(float(physics.data.time) - start, 0.0)
        error.log = recorder.log(summary(error))
        raise
    return recorder.log(summary())


def plain(value: Any) -> Any:
    """Value with NumPy scalars as Python numbers and rounding noise kept out of JSON."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float):
        return None if not np.isfinite(value) else float(f"{value:.6g}")
    return value
