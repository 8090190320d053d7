"""What every marine task offers beyond dm_control's: signals for the log and a summary."""

from dataclasses import dataclass
from typing import Any

import dm_env
import numpy as np
from dm_control.suite import base

from marine_mj.frames import Array
from marine_mj.tasks.physics import MarinePhysics


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


class MarineTask(base.Task):
    """Base of all tasks.

    Attributes:
        signal_specs: description of what `signals` returns.
    """

    signal_specs: dict[str, Signal] = {}  # noqa: RUF012

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
