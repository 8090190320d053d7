"""One batch of runs on native threads, stepped together from its start to its last end."""

from collections.abc import Callable, Sequence
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
from marine_mj.simulation.recorder import COMMON, RAW
from marine_mj.simulation.runner import plain
from marine_mj.tasks.base import Flags, Mission
from marine_mj.tasks.reader import BodyReader

Ids = NDArray[np.intp]
#: Compiled scene and mission of one run.
Prepared = tuple[mujoco.MjModel, Mission]
#: Recorded signals of one run, each with `time` as its first dimension.
Signals = dict[str, xr.Variable]

_WARNINGS = [int(warning) for warning in STATE_WARNINGS]


def refuse_signal(name: str, known: Sequence[str]) -> None:
    """Raise because of a signal that does not exist.

    Raises:
        ScenarioError: always; the message lists the signals that do.
    """
    raise ScenarioError(f"signal {name!r} does not exist; available: {', '.join(known)}")


class Episode:
    """One batch from its start to the end of its last run.

    Args:
        scenarios: of the runs, by number.
        prepared: models and missions of the runs, by number.
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
        self._models = [prepared[i][0] for i in self._numbers]
        self._missions = [prepared[i][1] for i in self._numbers]
        first, scenario = self._models[0], self._scenarios[0]
        self._batch = batch.Batch(first, len(self._models), threads)
        self._batch.set_models(self._models)
        self._substeps = round(scenario.control_period / scenario.timestep)
        self._limit = scenario.duration / (scenario.timestep * self._substeps)
        self._stride = decimation * round(scenario.log_period / scenario.control_period)
        self._period = self._substeps * scenario.timestep
        self._sensor = int(first.sensor(t_.CONTACT_SENSOR).adr[0])
        self._contacts = np.zeros((len(self._models), self._substeps, first.nsensordata))
        self._qpos, self._qvel = self._batch.bind("qpos"), self._batch.bind("qvel")
        self._time, self._ctrl = self._batch.bind("time"), self._batch.bind("ctrl")
        self._closed = self._batch.bind("eq_active")
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
            mujoco.mj_forward(model, data)
            model.opt.disableflags = flags
            mujoco.mj_getState(model, data, self._batch.state[i], spec)

    def run(self, finished: Callable[[int], None]) -> list[tuple[int, dict[str, Any], Signals]]:
        """Number, row and signals of every run."""
        self._place()
        ids: Ids = np.arange(len(self._models))
        self._start = self._time.copy()
        mission = self._mission(ids)
        state = mission.initial(self._start, ids.shape)
        latched = self._latched(mission, ids)
        view = mission.view(self._qpos[ids], self._qvel[ids])
        rows: dict[int, dict[str, Any]] = {}
        self._sample(mission, state, view, latched, ids)
        steps = 0
        while ids.size:
            commands, state = mission.command(state, view, latched)
            reasons = self._bad_commands(ids, commands)
            self._ctrl[ids] = commands
            force, forbidden, failed = self._step(ids)
            reasons = failed | reasons
            steps += 1
            if reasons:
                keep = np.array([i not in reasons for i in ids])
                for place in np.flatnonzero(~keep):
                    i = int(ids[place])
                    closed = bool(latched[place])
                    rows[i] = self._row(i, trees.take(state, place), closed, steps, reasons[i])
                finished(int((~keep).sum()))
                ids, force, forbidden = ids[keep], force[keep], forbidden[keep]
                state, latched = trees.take(state, keep), latched[keep]
                mission = self._mission(ids)
                if not ids.size:
                    break
            view = mission.view(self._qpos[ids], self._qvel[ids])
            time = self._time[ids]
            state, closing = mission.observe(state, view, time, latched, force, forbidden)
            if closing.any():
                self._close(mission, view, ids, closing)
                latched = self._latched(mission, ids)
            over = mission.finished(state, time, latched)
            if steps >= self._limit:
                over = np.full(ids.shape, True)
            if steps % self._stride == 0:
                self._sample(mission, state, view, latched, ids)
            if over.any():
                for place in np.flatnonzero(over):
                    i = int(ids[place])
                    closed = bool(latched[place])
                    rows[i] = self._row(i, trees.take(state, place), closed, steps, None)
                finished(int(over.sum()))
                ids = ids[~over]
                state, latched = trees.take(state, ~over), latched[~over]
                mission = self._mission(ids)
                view = mission.view(self._qpos[ids], self._qvel[ids])
        return [(number, rows[i], self._signals(i)) for i, number in enumerate(self._numbers)]

    def _mission(self, ids: Ids) -> Mission:
        """One mission for the runs that still go on."""
        return trees.stack([self._missions[i] for i in ids]) if ids.size else self._missions[0]

    def _latched(self, mission: Mission, ids: Ids) -> Flags:
        """Where (n,) the first weld of the mission is closed."""
        if not mission.welds:
            return np.zeros(ids.shape, dtype=bool)
        return self._closed[ids, mission.welds[0]] > 0

    def _close(self, mission: Mission, view: Any, ids: Ids, closing: Flags) -> None:
        """Close the weld in the present pose."""
        weld, held = mission.welds[0], view.weld
        for place in np.flatnonzero(closing):
            self._models[ids[place]].eq_data[weld, :10] = held[place]
        self._closed[ids[closing], weld] = 1.0

    def _step(self, ids: Ids) -> tuple[Array, Flags, dict[int, str]]:
        """One control period: largest contact force (n,) in it, forbidden contact, failures."""
        reasons: dict[int, str] = {}
        out = {"sensordata": self._contacts[: len(ids)]}
        try:
            self._batch.rollout(self._substeps, record=("sensordata",), ids=ids, out=out)
        except batch.SimulationError as error:
            reasons |= {int(i): self._batch.error(int(i)) for i in error.ids}
        force = self._contacts[: len(ids), :, self._sensor].max(axis=1)
        warned = (self._batch.warning[ids][:, _WARNINGS, 1] > 0).any(axis=1)
        finite = np.isfinite(self._qpos[ids]).all(axis=1) & np.isfinite(self._qvel[ids]).all(axis=1)
        for i in ids[warned | ~finite]:
            reasons.setdefault(int(i), self._reason(int(i)))
        return force, self._contacts[: len(ids), -1, self._sensor + 1] > 0, reasons

    def _bad_commands(self, ids: Ids, commands: Array) -> dict[int, str]:
        """Why runs fail whose commands are not finite; they get zeros."""
        reasons: dict[int, str] = {}
        for place in np.flatnonzero(~np.isfinite(commands).all(axis=1)):
            i = int(ids[place])
            try:
                check_control(self._models[i], commands[place], self._time[i])
            except SimulationError as error:
                reasons[i] = str(error)
            commands[place] = 0.0
        return reasons

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

    def _row(
        self, i: int, state: Any, latched: bool, steps: int, error: str | None
    ) -> dict[str, Any]:
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

    def _sample(self, mission: Mission, state: Any, view: Any, latched: Flags, ids: Ids) -> None:
        """Keep the present signals of the runs that go on."""
        if not self._record:
            return
        values: dict[str, Array] = {}
        task = mission.signals(state, view, latched)
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
