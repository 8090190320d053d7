"""What a scenario leaves open and the scene decides: its integrator, and how waves act."""

from functools import lru_cache
from pathlib import Path
from typing import Any

import mujoco

from marine_mj.hydrodynamics.body_settings import BodySettings
from marine_mj.hydrodynamics.coefficients import read_coefficients
from marine_mj.hydrodynamics.excitation import excitation_of
from marine_mj.library import find_model
from marine_mj.scenario import Scenario, Vehicle

#: Settings of a vehicle that decide by what waves act on it.
_ASKED = ("motion", "hydrostatics", "froude_krylov", "excitation")


def choose_integrator(scenario: Scenario) -> str:
    """The integrator of a scene; what `Scenario.integrator` says, or for "auto" by this rule.

    1. Nothing can touch anything (`contact = false`): "RK4". Such a scene is a study of the
       trajectory, and `implicitfast` errs in it by the first power of the time step.
    2. One vehicle alone with joints between bodies in the water: "RK4". Its parts exchange
       energy over the joints, and the first-order error feeds it.
    3. Everything else: "implicitfast". Contact forces are not smooth, so the higher order of RK4
       is lost in them, and it costs three to four times as much.
    """
    if scenario.integrator != "auto":
        return scenario.integrator
    if not scenario.contact:
        return "RK4"
    alone = len(scenario.vehicles) == 1
    return (
        "RK4"
        if alone and any(_articulated(v) for v in scenario.vehicles.values())
        else ("implicitfast")
    )


def excitations(scenario: Scenario) -> dict[str, str]:
    """By what waves act on the root body of each vehicle: one of `excitation.EXCITATIONS`.

    Raises:
        ModelError: a model does not exist, or its settings do not fit.
    """
    return {name: _excitation(vehicle) for name, vehicle in scenario.vehicles.items()}


def _articulated(vehicle: Vehicle) -> bool:
    """Whether a vehicle has several bodies in the water."""
    path = find_model(vehicle.model)
    return _bodies(path, path.stat().st_mtime_ns) > 1


def _excitation(vehicle: Vehicle) -> str:
    """By what waves act on one vehicle."""
    path = find_model(vehicle.model)
    asked = tuple(getattr(vehicle, name) for name in _ASKED)
    return _kind(path, path.stat().st_mtime_ns, asked)


@lru_cache(maxsize=64)
def _bodies(path: Path, changed: int) -> int:
    """Number of hydrodynamic bodies of a vehicle file."""
    return len(read_coefficients(mujoco.MjSpec.from_file(str(path))))


@lru_cache(maxsize=64)
def _kind(path: Path, changed: int, asked: tuple[Any, ...]) -> str:
    """By what waves act on the root body of a vehicle file with some settings."""
    spec = mujoco.MjSpec.from_file(str(path))
    root = spec.worldbody.first_body()
    settings = BodySettings(**dict(zip(_ASKED, asked, strict=True)))
    found = [b for b in read_coefficients(spec) if root is not None and b.name == root.name]
    return excitation_of(found[0], settings) if found else "none"
