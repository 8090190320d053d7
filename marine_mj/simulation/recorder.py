"""Collecting the log of an episode."""

import importlib.metadata
import json
import platform
from typing import Any

import numpy as np
import xarray as xr
from dm_control.rl import control

from marine_mj import __version__, wrenches
from marine_mj.frames import Array
from marine_mj.scenario import Scenario
from marine_mj.simulation.log import Log
from marine_mj.tasks.base import MarineTask, Signal
from marine_mj.tasks.physics import MarinePhysics

DOFS = ["surge", "sway", "heave", "roll", "pitch", "yaw"]

#: Raw state, for replay.
RAW = {
    "qpos": Signal(("q",), "m, -", "MuJoCo", "generalised positions"),
    "qvel": Signal(("v",), "m/s, rad/s", "MuJoCo", "generalised velocities"),
    "act": Signal(("a",), "actuator", "", "actuator activations"),
    "ctrl": Signal(("u",), "actuator", "", "actuator commands"),
    "eq_active": Signal(("eq",), "1", "", "active equality constraints (latches)"),
}
#: Signals of every vehicle.
VEHICLE = {
    "eta_ned": Signal(("vehicle", "dof"), "m, rad", "NED", "pose, zyx Euler angles"),
    "nu_frd": Signal(("vehicle", "dof"), "m/s, rad/s", "body FRD", "velocity"),
    "wrench": Signal(
        ("vehicle", "cause", "dof"), "N, N m", "body FLU", "wrench at the body origin by cause"
    ),
    "elevation": Signal(("vehicle",), "m", "", "water surface above the mean level, up"),
}
#: Signals that every batch can record, beside those of its task.
COMMON = {**RAW, "eta_ned": VEHICLE["eta_ned"], "nu_frd": VEHICLE["nu_frd"]}


class Recorder:
    """Keeps samples and turns them into a `Log`.

    Args:
        scenario: what is run.
        environment: dm_control environment of it.
        waves: wave field of the run, for the elevation at the vehicles.
    """

    def __init__(self, scenario: Scenario, environment: control.Environment, waves: Any) -> None:
        self._scenario, self._waves = scenario, waves
        self._physics: MarinePhysics = environment.physics
        self._task: MarineTask = environment.task
        self._samples: dict[str, list[Array]] = {}
        self._causes: list[str] = []

    def sample(self, time: float) -> None:
        """Record the present state at `time` s."""
        physics = self._physics
        row: dict[str, Any] = {name: getattr(physics.data, name) for name in RAW}
        row["time"] = time
        vehicles = physics.vehicles
        row["eta_ned"] = np.array([physics.eta_ned(v) for v in vehicles])
        row["nu_frd"] = np.array([physics.nu_frd(v) for v in vehicles])
        row["wrench"] = self._wrenches()
        row["elevation"] = self._waves.elevation(
            row["eta_ned"][:, 0], -row["eta_ned"][:, 1], physics.data.time
        )
        for name, value in (row | self._task.signals(physics)).items():
            self._samples.setdefault(name, []).append(np.array(value, dtype=float))

    def _wrenches(self) -> Array:
        """Wrenches (vehicle, cause, 6) on the main bodies."""
        physics = self._physics
        model = physics.model.ptr
        by_body = wrenches(model, physics.data.ptr)
        if not self._causes:
            self._causes = list(next(iter(by_body.values()), {}))
        found = np.zeros((len(physics.vehicles), len(self._causes), 6))
        for i, vehicle in enumerate(physics.vehicles):
            causes = by_body.get(model.body(physics.main_body(vehicle)).name, {})
            for j, cause in enumerate(self._causes):
                if cause in causes:
                    found[i, j] = causes[cause]
        return found

    def log(self, summary: dict[str, Any]) -> Log:
        """The log so far, with a summary of the run."""
        described = RAW | VEHICLE | self._task.signal_specs
        variables = {}
        for name, values in self._samples.items():
            if name == "time":
                continue
            signal = described.get(name, Signal())
            attributes = {"units": signal.units, "long_name": signal.about or name}
            if signal.frame:
                attributes["frame"] = signal.frame
            variables[name] = (("time", *signal.dims), np.array(values), attributes)
        coordinates: dict[str, Any] = {
            "time": ("time", np.array(self._samples.get("time", [])), {"units": "s"}),
            "vehicle": list(self._physics.vehicles),
            "dof": DOFS,
        }
        if self._causes:
            coordinates["cause"] = self._causes
        about: dict[str, Any] = {
            "title": self._scenario.name,
            "scenario": self._scenario.to_toml(),
            "seed": self._scenario.seed,
            "versions": json.dumps(versions()),
            "summary": json.dumps(summary),
        }
        return Log(xr.Dataset(variables, coordinates, about))


def versions() -> dict[str, str]:
    """Versions of what decides the numbers of a run."""
    packages = ("mujoco", "dm_control", "numba", "numpy")
    found = {name: importlib.metadata.version(name) for name in packages}
    return {"marine_mj": __version__, **found, "python": platform.python_version()}
