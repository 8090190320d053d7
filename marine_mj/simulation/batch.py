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
from mujoco import batch
from numpy.typing import NDArray

from marine_mj import frames, hydrodynamics, trees
from marine_mj.errors import MarineMjError, ModelError, ScenarioError, SimulationError
from marine_mj.frames import Array
from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.wrenches import STATE_WARNINGS, check_control, check_state
from marine_mj.scenario import Scenario
from marine_mj.scene import body_settings, build_scene, compile_scene, main_bodies
from marine_mj.simulation.recorder import COMMON, RAW, versions
from marine_mj.simulation.runner import plain, run
from marine_mj.tasks import DOMAINS
from marine_mj.tasks.base import Flags, Mission
from marine_mj.tasks.reader import BodyReader
from marine_mj.weather import environment_of

Ids = NDArray[np.intp]
#: Compiled scene and mission of one run.
Prepared = tuple[mujoco.MjModel, Mission]
#: Recorded signals of one run, each with `time` as its first dimension.
Signals = dict[str, xr.Variable]
#: Called with the number of finished runs and of all runs.
BatchProgress = Callable[[int, int], None]

#: Most simulations at once: more gain nothing, and memory grows with them.
BLOCK = 500
#: What may differ between runs that share a compiled model: all of it is in the packed table.
_WEATHER = ("name", "description", "seed", "sea", "current", "wind")
_WARNINGS = [int(warning) for warning in STATE_WARNINGS]


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
    however runs are put together. Runs that differ in weather, seed and numbers of the controller
    are stepped together; others in groups of their own. Finished runs cost nothing any more.

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
    scenarios = _variations(base, variations, n)
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
    """Indices of the runs that can be stepped together: alike but for their numbers."""
    groups: dict[str, list[int]] = {}
    for i, scenario in enumerate(scenarios):
        values = {k: v for k, v in scenario.model_dump().items() if k not in _WEATHER}
        groups.setdefault(json.dumps(_shape(values), sort_keys=True), []).append(i)
    return list(groups.values())


def _key(scenario: Scenario) -> str:
    """What a compiled scene depends on, but for the weather in its table."""
    values = {k: v for k, v in scenario.model_dump().items() if k not in _WEATHER}
    return json.dumps(values, sort_keys=True)


def _shape(value: Any) -> Any:
    """A value with its floats left out; times that a whole batch shares are kept."""
    if isinstance(value, dict):
        shared = ("timestep", "control_period", "log_period", "duration", "water_density")
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
        _refuse_signal(missing[0], [str(name) for name in log.data])
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


def _refuse_signal(name: str, known: Sequence[str]) -> None:
    """Raise because of a signal that does not exist."""
    raise ScenarioError(f"signal {name!r} does not exist; available: {', '.join(known)}")


@dataclass
class _Prototype:
    """A compiled scene that runs with other weather are copied from."""

    model: mujoco.MjModel
    bodies: list[hydrodynamics.BodyCoefficients]
    settings: dict[str, dict[str, Any]]
    mission: Mission


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
        prototype = self.prototypes.get(key := _key(scenario))
        environment = environment_of(scenario)
        if prototype is None:
            model = compile_scene(scenario, environment, visual=False).model
            spec = build_scene(scenario)
            prototype = _Prototype(
                model,
                hydrodynamics.read_coefficients(spec),
                body_settings(scenario, spec),
                self._mission(scenario, model),
            )
            self.prototypes[key] = prototype
            return copy.copy(model), prototype.mission
        model = copy.copy(prototype.model)
        try:
            hydrodynamics.write_environment(
                model, prototype.bodies, environment, prototype.settings
            )
        except ModelError:  # another number of wave components or gust knots
            model = compile_scene(scenario, environment, visual=False).model
        return model, prototype.mission

    def _mission(self, scenario: Scenario, model: mujoco.MjModel) -> Mission:
        """Mission of a run; scales of the vehicles' coefficients do not change it."""
        key = _key(scenario.nominal)
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
            episode = _Episode(
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
    """The runs together if one mission can steer them all, else those with the same mission."""
    if not prepared:
        return []
    missions = {id(mission): mission for _, mission in prepared.values()}
    try:
        trees.stack(list(missions.values()))
    except trees.StructureError:
        return [{i: p for i, p in prepared.items() if id(p[1]) == key} for key in missions]
    return [prepared]


@dataclass
class _Running:
    """Runs of an episode that still go on: numbers (n,), mission, its state, closed latches."""

    ids: Ids
    mission: Mission
    state: Any
    latched: Flags


class _Episode:
    """One batch from its start to the end of its last run.

    Args:
        scenarios: of the runs, by number.
        prepared: models and missions of the runs.
        threads, record, decimation: as in `run_batch`.
    """

    def __init__(
        self,
        scenarios: dict[int, Scenario],
        prepared: dict[int, Prepared],
        threads: int,
        record: Sequence[str],
        decimation: int,
    ) -> None:
        self._numbers = list(prepared)
        self._scenarios = [scenarios[i] for i in self._numbers]
        self._models = [prepared[i][0] for i in self._numbers]
        self._missions = [prepared[i][1] for i in self._numbers]
        first, scenario = self._models[0], self._scenarios[0]
        self._batch = batch.Batch(first, len(self._models), threads)
        self._batch.set_models(self._models)
        self._substeps = round(scenario.control_period / scenario.timestep)
        self._limit = scenario.duration / (scenario.timestep * self._substeps)
        self._stride = decimation * round(scenario.log_period / scenario.control_period)
        self._period = self._substeps * scenario.timestep
        sensor = int(first.sensor(t_.CONTACT_SENSOR).adr[0])
        self._sensor = slice(sensor, sensor + t_.CONTACT_VALUES)
        self._contacts = np.zeros((len(self._models), self._substeps, first.nsensordata))
        self._qpos, self._qvel = self._batch.bind("qpos"), self._batch.bind("qvel")
        self._time, self._ctrl = self._batch.bind("time"), self._batch.bind("ctrl")
        self._closed = self._batch.bind("eq_active")
        self._seeds = np.zeros(len(self._models), dtype=np.uint64)
        self._readers = [BodyReader.of(first, body) for body in main_bodies(first).values()]
        self._record = list(record)
        self._known = {**COMMON, **self._missions[0].signal_specs}
        for name in self._record:
            if name not in self._known:
                _refuse_signal(name, list(self._known))
        self._samples: list[dict[str, list[Array]]] = [
            {name: [] for name in self._record} for _ in self._models
        ]

    def _place(self) -> None:
        """The start of every run, exactly as dm_control resets one."""
        disable = int(mujoco.mjtDisableBit.mjDSBL_ACTUATION)
        spec = int(mujoco.mjtState.mjSTATE_INTEGRATION)
        for i, (model, scenario) in enumerate(zip(self._models, self._scenarios, strict=True)):
            data = mujoco.MjData(model)
            flags = model.opt.disableflags
            model.opt.disableflags = flags | disable
            mujoco.mj_forward(model, data)
            random = np.random.RandomState(scenario.seed)
            self._missions[i].place(scenario, model, data, random)
            self._seeds[i] = self._missions[i].noise_seed(random)
            mujoco.mj_forward(model, data)
            model.opt.disableflags = flags
            mujoco.mj_getState(model, data, self._batch.state[i], spec)

    def run(self, finished: Callable[[int], None]) -> list[tuple[int, dict[str, Any], Signals]]:
        """Number, row and signals of every run."""
        self._place()
        self._finished = finished
        self._rows: dict[int, dict[str, Any]] = {}
        self._start = self._time.copy()
        ids: Ids = np.arange(len(self._models))
        mission = self._mission(ids)
        state = mission.initial(self._start, ids.shape, self._seeds)
        self._on = _Running(ids, mission, state, self._latched(mission, ids))
        view = self._view()
        self._sample(view)
        steps = 0
        while self._on.ids.size:
            on = self._on
            commands, on.state = on.mission.command(on.state, view, on.latched)
            sound = self._finite(commands)
            self._ctrl[self._on.ids] = commands[sound]
            contacts = self._step()
            steps += 1
            on = self._on
            if not on.ids.size:
                break
            view, time = self._view(), self._time[on.ids]
            on.state, closing = on.mission.observe(on.state, view, time, on.latched, contacts)
            if closing.any():
                self._close(view, closing)
            if steps % self._stride == 0:
                self._sample(view)
            over = on.mission.finished(on.state, time, on.latched)
            if steps >= self._limit:
                over = np.full(on.ids.shape, True)
            if over.any():
                self._leave(over)
                view = self._view()
        return [(n, self._rows[i], self._signals(i)) for i, n in enumerate(self._numbers)]

    def _view(self) -> Any:
        """What the mission sees of the runs that still go on."""
        return self._on.mission.view(self._qpos[self._on.ids], self._qvel[self._on.ids])

    def _leave(self, out: Flags, reasons: Mapping[int, str] | None = None) -> None:
        """Write the rows of runs (n,) that are over or failed and go on without them."""
        on = self._on
        for place in np.flatnonzero(out):
            i = int(on.ids[place])
            state = trees.take(on.state, place)
            reason = None if reasons is None else reasons[i]
            self._rows[i] = self._row(i, state, bool(on.latched[place]), reason)
        self._finished(int(out.sum()))
        ids, state, latched = on.ids[~out], trees.take(on.state, ~out), on.latched[~out]
        self._on = _Running(ids, self._mission(ids), state, latched)

    def _mission(self, ids: Ids) -> Mission:
        """One mission for the runs that still go on."""
        return trees.stack([self._missions[i] for i in ids]) if ids.size else self._missions[0]

    def _latched(self, mission: Mission, ids: Ids) -> Flags:
        """Where (n,) the first weld of the mission is closed."""
        if not mission.welds:
            return np.zeros(ids.shape, dtype=bool)
        return self._closed[ids, mission.welds[0]] > 0

    def _close(self, view: Any, closing: Flags) -> None:
        """Close the weld in the present pose."""
        on = self._on
        weld, held = on.mission.welds[0], view.weld
        for place in np.flatnonzero(closing):
            self._models[on.ids[place]].eq_data[weld, :10] = held[place]
        self._closed[on.ids[closing], weld] = 1.0
        on.latched = self._latched(on.mission, on.ids)

    def _finite(self, commands: Array) -> Flags:
        """Which runs (n,) have finite commands; the others leave."""
        sound = np.asarray(np.isfinite(commands).all(axis=1))
        reasons: dict[int, str] = {}
        for place in np.flatnonzero(~sound):
            i = int(self._on.ids[place])
            try:
                check_control(self._models[i], commands[place], self._time[i])
            except SimulationError as error:
                reasons[i] = str(error)
        if reasons:
            self._leave(~sound, reasons)
        return sound

    def _step(self) -> Array:
        """One control period: contact sensor (n, steps, 4) at every step, of the runs left."""
        ids = self._on.ids
        reasons: dict[int, str] = {}
        contacts = self._contacts[: len(ids)]
        out = {"sensordata": contacts}
        try:
            self._batch.rollout(self._substeps, record=("sensordata",), ids=ids, out=out)
        except batch.SimulationError as error:
            reasons |= {int(i): self._batch.error(int(i)) for i in error.ids}
        warned = (self._batch.warning[ids][:, _WARNINGS, 1] > 0).any(axis=1)
        finite = np.isfinite(self._qpos[ids]).all(axis=1) & np.isfinite(self._qvel[ids]).all(axis=1)
        for i in ids[warned | ~finite]:
            reasons.setdefault(int(i), self._reason(int(i)))
        failed = np.array([int(i) in reasons for i in ids], dtype=bool)
        if failed.any():
            self._leave(failed, reasons)
            contacts = contacts[~failed]
        return contacts[:, :, self._sensor]

    def _reason(self, i: int) -> str:
        """Why the state of a run is not valid."""
        model, data = self._models[i], mujoco.MjData(self._models[i])
        self._batch.get_data(i, data)
        for warning in STATE_WARNINGS:
            info, number = self._batch.warning[i, int(warning)]
            data.warning[warning].lastinfo, data.warning[warning].number = int(info), int(number)
        try:
            check_state(model, data)
        except SimulationError as error:
            return str(error)
        return f"the simulation failed at t = {data.time:.4f} s"

    def _row(self, i: int, state: Any, latched: bool, error: str | None) -> dict[str, Any]:
        """Results of one run."""
        scenario = self._scenarios[i]
        return plain(
            {
                "scenario": scenario.name,
                "seed": scenario.seed,
                **self._missions[i].summary(scenario, state, latched),
                "simulated_time": float(self._time[i] - self._start[i]),
                "error": error,
            }
        )

    def _sample(self, view: Any) -> None:
        """Keep the present signals of the runs that go on."""
        if not self._record:
            return
        mission, ids = self._on.mission, self._on.ids
        values: dict[str, Array] = {}
        task = mission.signals(self._on.state, view, self._on.latched)
        for name in self._record:
            if name in RAW:
                values[name] = self._batch.bind(name)[ids]
            elif name in COMMON:
                states = [r.state(self._qpos[ids], self._qvel[ids]) for r in self._readers]
                poses = [frames.eta_ned(s.position, s.quaternion) for s in states]
                twists = [frames.flip(s.velocity) for s in states]
                values[name] = np.stack(poses if name == "eta_ned" else twists, axis=1)
            else:
                values[name] = task[name]
        for place, i in enumerate(ids):
            for name, column in values.items():
                self._samples[i][name].append(np.array(column[place], dtype=float))

    def _signals(self, i: int) -> Signals:
        """Recorded signals of one run."""
        found: Signals = {}
        for name, values in self._samples[i].items():
            spec = self._known[name]
            about = {"units": spec.units, "long_name": spec.about or name}
            found[name] = xr.Variable(("time", *spec.dims), np.array(values), about)
        if found:
            count = len(next(iter(found.values())))
            time = self._stride * self._period * np.arange(count)
            found["time"] = xr.Variable(("time",), time, {"units": "s"})
        return found


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
