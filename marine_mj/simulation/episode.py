"""One batch of runs on native threads, stepped together from its start to its last end."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
import xarray as xr
from mujoco import batch
from numpy.typing import NDArray

from marine_mj import frames, trees
from marine_mj.errors import ScenarioError, SimulationError
from marine_mj.frames import Array
from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.wrenches import STATE_WARNINGS, check_control, check_state
from marine_mj.scenario import Scenario
from marine_mj.scene import main_bodies
from marine_mj.scene_choices import choose_integrator, excitations
from marine_mj.simulation.recorder import COMMON, RAW
from marine_mj.simulation.runner import plain
from marine_mj.tasks.base import Flags, Mission
from marine_mj.tasks.reader import BodyReader

Ids = NDArray[np.intp]
#: Recorded signals of one run, each with `time` as its first dimension.
Signals = dict[str, xr.Variable]

# In what copies of a compiled scene differ: the environment's table and what follows from the added
# mass in it, and how welds hold.
_OWN = ("numeric_data", "body_invweight0", "dof_invweight0", "eq_data")
# What contact parts have by the wet masses that meet; large, so only where it is not the same.
_CONTACT = ("pair_solref", "pair_solreffriction", "pair_solimp")
# Numbers of a table (64 KB) that is too large to be copied in every period.
_LARGE = 8192
_WARNINGS = [int(warning) for warning in STATE_WARNINGS]


def _differ(models: Sequence[mujoco.MjModel], field: str) -> bool:
    """Whether a field of some models is not that of the first."""
    first = getattr(models[0], field)
    return any(not np.array_equal(getattr(model, field), first) for model in models[1:])


def refuse_signal(name: str, known: Sequence[str]) -> None:
    """Raise because of a signal that does not exist.

    Raises:
        ScenarioError: always; the message lists the signals that do.
    """
    raise ScenarioError(f"signal {name!r} does not exist; available: {', '.join(known)}")


@dataclass(frozen=True)
class Prepared:
    """What a run needs.

    Attributes:
        model: compiled scene.
        mission: steers and judges.
        original: scene that `model` is a copy of, with another environment; None: of no other.
    """

    model: mujoco.MjModel
    mission: Mission
    original: mujoco.MjModel | None = None


@dataclass
class _Running:
    """Runs of an episode that still go on: numbers (n,), mission, its state, closed latches."""

    ids: Ids
    mission: Mission
    state: Any
    latched: Flags


class Episode:
    """One batch from its start to the end of its last run.

    Args:
        scenarios: of the runs, by number.
        prepared: what the runs need, by number.
        threads, record, decimation: as in `run_batch`.

    Raises:
        ScenarioError: a signal to record does not exist.
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
        runs = [prepared[i] for i in self._numbers]
        self._models = [run.model for run in runs]
        self._missions = [run.mission for run in runs]
        first, scenario = self._models[0], self._scenarios[0]
        self._batch = batch.Batch(first, len(self._models), threads)
        # One model with fields for each run stays in the processor's cache, many models do not; but
        # these fields are copied in every period, which takes longer for a large table of waves.
        original = runs[0].original
        shared = original is not None and all(run.original is original for run in runs)
        shared = shared and first.nnumericdata <= _LARGE
        own = (*_OWN, *(name for name in _CONTACT if _differ(self._models, name)))
        self._fields = {name: self._batch.expand(name) for name in own} if shared else {}
        self._eq_data: Sequence[Array] = [model.eq_data for model in self._models]
        if shared:
            self._eq_data = self._fields["eq_data"]
        else:
            self._batch.set_models(self._models)
        self._substeps = round(scenario.control_period / scenario.timestep)
        self._limit = np.array([s.duration for s in self._scenarios])
        self._limit /= scenario.timestep * self._substeps
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
                refuse_signal(name, list(self._known))
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
            for name, values in self._fields.items():
                values[i] = getattr(model, name)

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
            on.state, closed = on.mission.observe(on.state, view, time, on.latched, contacts)
            if (closed != on.latched).any():
                self._switch(view, closed)
            if steps % self._stride == 0:
                self._sample(view)
            over = on.mission.finished(on.state, time, on.latched) | (steps >= self._limit[on.ids])
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
        missions = [self._missions[i] for i in ids]
        distinct = list({id(mission): mission for mission in missions}.values())
        places = {id(mission): place for place, mission in enumerate(distinct)}
        rows = np.array([places[id(mission)] for mission in missions], dtype=np.intp)
        return trees.stack(distinct, rows) if distinct else self._missions[0]

    def _latched(self, mission: Mission, ids: Ids) -> Flags:
        """Where (n,) the first weld of the mission is closed."""
        if not mission.welds:
            return np.zeros(ids.shape, dtype=bool)
        return self._closed[ids, mission.welds[0]] > 0

    def _switch(self, view: Any, closed: Flags) -> None:
        """Close welds (n,), in the present pose, and open the others."""
        on = self._on
        weld, closing = on.mission.welds[0], closed & ~on.latched
        if closing.any():
            held = view.weld
            for place in np.flatnonzero(closing):
                self._eq_data[on.ids[place]][weld, :10] = held[place]
        self._closed[on.ids, weld] = closed
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
                "integrator": choose_integrator(scenario),
                "excitation": excitations(scenario),
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
