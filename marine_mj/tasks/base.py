"""What every marine task offers beyond dm_control's: signals for the log and a summary."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any

import dm_env
import mujoco
import numpy as np
from dm_control.rl import control
from numpy.typing import ArrayLike, NDArray

from marine_mj.frames import Array
from marine_mj.scenario import Scenario
from marine_mj.tasks.physics import MarinePhysics

Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class Signal:
    """Description of a logged signal.

    Attributes:
        dims: dimensions after `time`.
        units: SI unit.
        frame: frame of the values, "" for scalars.
        about: one line.
    """

    dims: tuple[str, ...] = ()
    units: str = "1"
    frame: str = ""
    about: str = ""


class Mission(ABC):
    """The heart of a task on arrays of any leading shape: () for one simulation, (n,) for a batch.

    The dm_control task and the batch runner drive the same mission, so both give the same bits.
    A mission holds what does not change; its memory is an explicit state, a frozen dataclass of
    arrays with that leading shape. Parameters (gains, limits, distances) may be arrays (n, ...)
    themselves: `marine_mj.trees.stack` makes one mission of many.

    Attributes:
        signal_specs: description of what `signals` returns.
    """

    signal_specs: dict[str, Signal] = {}  # noqa: RUF012

    @property
    def welds(self) -> tuple[int, ...]:
        """Equality constraints that the mission may close and open; see `observe`."""
        return ()

    @abstractmethod
    def place(
        self,
        scenario: Scenario,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        random: np.random.RandomState,
    ) -> None:
        """Write the start of one simulation into `data`, which has just been reset."""

    def noise_seed(self, random: np.random.RandomState) -> int:
        """Seed of a run's noise, drawn after `place`; 0 (nothing drawn) for a task without."""
        return 0

    @abstractmethod
    def initial(
        self, time: Array | float, shape: tuple[int, ...] = (), seeds: ArrayLike = 0
    ) -> Any:
        """State at the start, at `time` (...,) s, for a leading shape and noise seeds (...,)."""

    @abstractmethod
    def view(self, qpos: Array, qvel: Array) -> Any:
        """What the mission sees in generalised coordinates (..., nq) and velocities (..., nv)."""

    @abstractmethod
    def command(
        self, state: Any, view: Any, latched: Flags, action: Array | None = None
    ) -> tuple[Array, Any]:
        """Commands (..., nu) of all actuators, and the next state."""

    @abstractmethod
    def observe(
        self,
        state: Any,
        view: Any,
        time: Array | float,
        latched: Flags,
        contacts: Array,
    ) -> tuple[Any, Flags]:
        """Next state one control period later, and where (...,) the first weld is closed then.

        Where it was open and closes, its data become those of `view.weld`.

        `contacts` (..., steps, 4) is the scene's contact sensor at every physics step of the
        period; `hydrodynamics.table.CONTACT_SENSOR` lists its values.
        """

    @abstractmethod
    def finished(self, state: Any, time: Array | float, latched: Flags) -> Flags:
        """Where (...,) the mission is over before its time."""

    @abstractmethod
    def signals(self, state: Any, view: Any, latched: Flags) -> dict[str, Array]:
        """Signals (..., ...) for the log, by name."""

    @abstractmethod
    def summary(self, scenario: Scenario, state: Any, latched: bool) -> dict[str, Any]:
        """Results of one simulation (state of shape ()), as plain values for JSON."""


class MarineTask(control.Task):
    """Base of all tasks; `dm_control.suite.base.Task` would import the whole suite with it.

    Attributes:
        signal_specs: description of what `signals` returns.
        random: source of the random starts of the episodes.
    """

    signal_specs: dict[str, Signal] = {}  # noqa: RUF012

    def __init__(self, random: np.random.RandomState | int | None = None) -> None:
        if not isinstance(random, np.random.RandomState):
            random = np.random.RandomState(random)
        self.random = random

    def signals(self, physics: MarinePhysics) -> dict[str, Array | float]:
        """Signals of the task at this moment, for the log."""
        return {}

    def summary(self, physics: MarinePhysics) -> dict[str, Any]:
        """Results of the episode so far, as plain values for JSON."""
        return {}

    def default_action(self, physics: MarinePhysics) -> Array:
        """Action of a run without a policy: no thrust, or no change of the reference."""
        return np.zeros(self.action_spec(physics).shape)

    @property
    def control_period(self) -> float:
        """Time between two actions, s."""
        raise NotImplementedError


def symmetric_spec(size: int, name: str) -> dm_env.specs.BoundedArray:
    """Action spec (size,) with limits -1 and 1."""
    return dm_env.specs.BoundedArray((size,), float, minimum=-1.0, maximum=1.0, name=name)


def from_unit(action: Array, low: Array, high: Array) -> Array:
    """Commands of actions in [-1, 1]: 0 is 0, -1 is `low`, 1 is `high` (low <= 0 <= high)."""
    action = np.asarray(action, dtype=float)
    return np.where(action < 0, -action * low, action * high)
