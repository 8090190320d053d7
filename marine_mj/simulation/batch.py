"""Many runs of one scenario at once, on native threads: `mujoco.batch` and vectorised missions."""

import copy
import json
import time as clock
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import mujoco
import numpy as np
import xarray as xr

from marine_mj import hydrodynamics, trees
from marine_mj.errors import MarineMjError, ModelError, ScenarioError, SimulationError
from marine_mj.scenario import Scenario
from marine_mj.scene import body_settings, build_scene, compile_scene
from marine_mj.simulation.episode import Episode, Prepared, Signals, refuse_signal
from marine_mj.simulation.recorder import versions
from marine_mj.simulation.runner import run
from marine_mj.tasks import DOMAINS
from marine_mj.tasks.base import Mission
from marine_mj.weather import environment_of

#: Called with the number of finished runs and of all runs.
BatchProgress = Callable[[int, int], None]

#: Most simulations at once: memory grows with them, a control period's own cost does not.
BLOCK = 1200
#: What may differ between runs that share a compiled model: all of it is in the packed table.
_WEATHER = ("name", "description", "seed", "sea", "current", "wind")
#: What a scene does not know.
_RUN = (*_WEATHER, "duration", "task")


@dataclass(frozen=True)
class BatchResult:
    """Results of a batch.

    Attributes:
        rows: one per run, in order: the summary of the task as `Log.summary` has it, with
            `simulated_time` (s), `wall_time` (s, share of the block it ran in) and `error` (None,
            or why the run ended early).
        signals: recorded signals with the dimensions (run, time, ...), NaN after the end of a run;
            None when nothing was to be recorded.
    """

    rows: list[dict[str, Any]]
    signals: xr.Dataset | None


def run_batch(
    scenario: Scenario | str,
    variations: Sequence[Mapping[str, Any]] | None = None,
    n: int | None = None,
    *,
    threads: int = 1,
    record: Sequence[str] = (),
    decimation: int = 1,
    progress: BatchProgress | None = None,
) -> BatchResult:
    """Results of many variations of one scenario.

    The same bits as `simulation.run` gives for each variation, whatever the number of threads and
    however runs are put together. Runs that differ in weather, seed, duration and numbers of the
    task (gains, thresholds, noise) are stepped together; others in groups of their own. Finished
    runs cost nothing any more.

    Args:
        scenario: base scenario, or its name or path.
        variations: changes of each run by dotted keys, e.g. `{"seed": 7, "sea.sea_state": 4}`; see
            `Scenario.with_values`.
        n: without variations, number of runs with the seeds `scenario.seed + 0 ... n - 1`.
        threads: native threads that step the physics.
        record: names of signals to keep: qpos, qvel, act, ctrl, eq_active, eta_ned, nu_frd and
            those of the task.
        decimation: keep every how many-th entry of the scenario's `log_period`.
        progress: called when runs have finished.

    Raises:
        ScenarioError: a variation is not valid (the message names the run), neither variations nor
            n are given, or a signal does not exist.
    """
    base = scenario if isinstance(scenario, Scenario) else Scenario.load(scenario)
    return run_scenarios(
        _variations(base, variations, n),
        threads=threads,
        record=record,
        decimation=decimation,
        progress=progress,
    )


def run_scenarios(
    scenarios: Sequence[Scenario],
    *,
    threads: int = 1,
    record: Sequence[str] = (),
    decimation: int = 1,
    progress: BatchProgress | None = None,
) -> BatchResult:
    """Results of any scenarios, in their order; `run_batch` says more.

    Args:
        scenarios: one per run.
        threads, record, decimation, progress: as in `run_batch`.

    Raises:
        ScenarioError: a signal does not exist, or `threads` or `decimation` is below 1.
    """
    if threads < 1 or decimation < 1:
        raise ScenarioError(
            f"threads = {threads} and decimation = {decimation}: allowed are whole numbers >= 1"
        )
    rows: list[dict[str, Any]] = [{} for _ in scenarios]
    recorded: list[Signals] = [{} for _ in scenarios]
    done = 0

    def finished(count: int) -> None:
        nonlocal done
        done += count
        if progress is not None:
            progress(done, len(scenarios))

    for members in _groups(scenarios):
        if hasattr(DOMAINS.get(scenarios[members[0]].task.domain), "mission"):
            for first in range(0, len(members), BLOCK):
                chosen = members[first : first + BLOCK]
                block = _Block([scenarios[i] for i in chosen], threads, record, decimation)
                for i, row, signals in zip(chosen, *block.run(finished), strict=True):
                    rows[i], recorded[i] = row, signals
        else:
            for i in members:
                rows[i], recorded[i] = _single(scenarios[i], record, decimation)
                finished(1)
    return BatchResult(rows, _dataset(recorded) if record else None)


def _variations(
    base: Scenario, variations: Sequence[Mapping[str, Any]] | None, n: int | None
) -> list[Scenario]:
    """The scenario of every run."""
    if variations is None:
        if n is None or n < 1:
            raise ScenarioError(f"run_batch needs variations, or n >= 1 runs; got n = {n}")
        variations = [{"seed": base.seed + i} for i in range(n)]
    elif n is not None and n != len(variations):
        raise ScenarioError(f"n = {n} but there are {len(variations)} variations: leave out n")
    found = []
    for number, changes in enumerate(variations):
        try:
            found.append(base.with_values(dict(changes)))
        except ScenarioError as error:
            raise ScenarioError(f"run {number} with {dict(changes)}: {error}") from None
    return found


def _groups(scenarios: Sequence[Scenario]) -> list[list[int]]:
    """Indices of the runs of one task whose scenes are alike but for their numbers."""
    groups: dict[str, list[int]] = {}
    for i, scenario in enumerate(scenarios):
        task = (scenario.task.domain, scenario.task.name)
        bed = scenario.sea.depth is not None  # a geom more
        shape = json.dumps([*task, bed, _shape(_values(scenario, _RUN))], sort_keys=True)
        groups.setdefault(shape, []).append(i)
    return list(groups.values())


def _key(scenario: Scenario, without: Sequence[str]) -> str:
    """A scenario without some of its keys, as text."""
    return json.dumps(_values(scenario, without), sort_keys=True)


def _values(scenario: Scenario, without: Sequence[str]) -> dict[str, Any]:
    return {k: v for k, v in scenario.model_dump().items() if k not in without}


def _shape(value: Any) -> Any:
    """A value with its floats left out; times that a whole batch shares are kept."""
    if isinstance(value, dict):
        shared = ("timestep", "control_period", "log_period", "water_density")
        return {k: v if k in shared else _shape(v) for k, v in value.items()}
    if isinstance(value, tuple | list):
        return [_shape(item) for item in value]
    return "number" if isinstance(value, float) else value


def _single(
    scenario: Scenario, record: Sequence[str], decimation: int
) -> tuple[dict[str, Any], Signals]:
    """Row and signals of a run by the dm_control runner, for tasks that are not vectorised."""
    try:
        log = run(scenario)
    except SimulationError as error:
        if error.log is None:
            return _failed(scenario, str(error)), {}
        log = error.log
    except MarineMjError as error:
        return _failed(scenario, str(error)), {}
    missing = [name for name in record if name not in log.data]
    if missing:
        refuse_signal(missing[0], [str(name) for name in log.data])
    period = decimation * scenario.log_period
    grid = np.isclose(np.remainder(log.data["time"].values + 0.5 * period, period), 0.5 * period)
    signals = {name: log.data[name].variable[grid] for name in ("time", *record)}
    row = {k: v for k, v in log.summary.items() if k not in ("real_time_factor", "versions")}
    return row, signals


def _failed(scenario: Scenario, reason: str) -> dict[str, Any]:
    """Row of a run that never started."""
    return {
        "scenario": scenario.name,
        "seed": scenario.seed,
        "simulated_time": 0.0,
        "wall_time": 0.0,
        "error": reason,
    }


@dataclass
class _Prototype:
    """A compiled scene that runs with other weather are copied from."""

    model: mujoco.MjModel
    bodies: list[hydrodynamics.BodyCoefficients]
    settings: dict[str, dict[str, Any]]


@dataclass
class _Block:
    """Runs that are stepped together."""

    scenarios: list[Scenario]
    threads: int
    record: Sequence[str]
    decimation: int
    prototypes: dict[str, _Prototype] = field(default_factory=dict)
    missions: dict[str, Mission] = field(default_factory=dict)

    def _prepare(self, scenario: Scenario) -> Prepared:
        """Compiled scene and mission of one run."""
        prototype = self.prototypes.get(key := _key(scenario, _RUN))
        environment = environment_of(scenario)
        if prototype is None:
            model = compile_scene(scenario, environment, visual=False).model
            spec = build_scene(scenario)
            prototype = _Prototype(
                model,
                hydrodynamics.read_coefficients(spec),
                body_settings(scenario, spec),
            )
            self.prototypes[key] = prototype
        original, mission = prototype.model, self._mission(scenario, prototype.model)
        model = copy.copy(original)
        try:
            hydrodynamics.write_environment(
                model, prototype.bodies, environment, prototype.settings
            )
        except ModelError:  # another number of wave components or gust knots
            return Prepared(compile_scene(scenario, environment, visual=False).model, mission)
        return Prepared(model, mission, original)

    def _mission(self, scenario: Scenario, model: mujoco.MjModel) -> Mission:
        """Mission of a run; scales of the vehicles' coefficients do not change it."""
        key = _key(scenario.nominal, _WEATHER)
        if key not in self.missions:
            self.missions[key] = DOMAINS[scenario.task.domain].mission(scenario, model)
        return self.missions[key]

    def run(self, finished: Callable[[int], None]) -> tuple[list[dict[str, Any]], list[Signals]]:
        """Rows and recorded signals of all runs."""
        begin = clock.perf_counter()
        count = len(self.scenarios)
        rows: list[dict[str, Any]] = [{} for _ in range(count)]
        prepared: dict[int, Prepared] = {}
        for i, scenario in enumerate(self.scenarios):
            try:
                prepared[i] = self._prepare(scenario)
            except MarineMjError as error:
                rows[i] = _failed(scenario, str(error))
        finished(count - len(prepared))
        signals: list[Signals] = [{} for _ in range(count)]
        for alike in _alike(prepared):
            episode = Episode(
                {i: self.scenarios[i] for i in alike},
                alike,
                self.threads,
                self.record,
                self.decimation,
            )
            for i, row, samples in episode.run(finished):
                rows[i], signals[i] = row, samples
        share = (clock.perf_counter() - begin) / count
        for row in rows:
            row["wall_time"] = share
        return rows, signals


def _alike(prepared: dict[int, Prepared]) -> list[dict[int, Prepared]]:
    """The runs in groups that one mission can steer."""
    groups: list[tuple[Mission, dict[int, Prepared]]] = []
    places: dict[int, dict[int, Prepared]] = {}
    for i, mission in ((i, needed.mission) for i, needed in prepared.items()):
        if id(mission) not in places:
            group = next((runs for first, runs in groups if _stackable(first, mission)), None)
            if group is None:
                group = {}
                groups.append((mission, group))
            places[id(mission)] = group
        places[id(mission)][i] = prepared[i]
    return [runs for _, runs in groups]


def _stackable(a: Mission, b: Mission) -> bool:
    """Whether one mission can steer the runs of both."""
    try:
        trees.stack([a, b])
    except trees.StructureError:
        return False
    return True


def _dataset(recorded: Sequence[Signals]) -> xr.Dataset:
    """Signals (run, time, ...) of all runs, NaN after the end of each."""
    longest: Signals = max(recorded, key=lambda signals: signals["time"].size if signals else 0)
    variables = {}
    for name, most in longest.items():
        if name == "time":
            continue
        values = np.full((len(recorded), *most.shape), np.nan)
        for i, signals in enumerate(recorded):
            if signals:
                values[i, : len(signals[name])] = signals[name].values
        variables[name] = (("run", *most.dims), values, most.attrs)
    coordinates = {"run": np.arange(len(recorded))}
    if longest:
        coordinates["time"] = longest["time"].values
    return xr.Dataset(variables, coordinates, {"versions": json.dumps(versions())})
