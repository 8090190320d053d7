"""Discrete PID on arrays: one controller object serves one vehicle or a thousand.

The law is the one of the docking reference (digest 6.1): backward difference without filter,
integral term clamped to half the output limits, output clipped. No frame of its own: it acts on
whatever axes the error has.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np

from marine_mj.errors import ScenarioError
from marine_mj.frames import Array

T = TypeVar("T")


def hold_positive(settings: object, title: str, *names: str) -> None:
    """Keep fields of a frozen dataclass as float arrays that are positive.

    Raises:
        ScenarioError: one is not; the message names `title`, the field and its value.
    """
    for name in names:
        value = np.asarray(getattr(settings, name), dtype=float)
        if not np.all(value > 0):
            raise ScenarioError(f"{title}: {name} must be > 0, got {value}")
        object.__setattr__(settings, name, value)


@dataclass(frozen=True)
class Limits:
    """Lower and upper bound per axis, (n,) or (..., n), in the unit of the output."""

    low: Array
    high: Array

    def __post_init__(self) -> None:
        """Raise ScenarioError unless `low <= high` on every axis."""
        low, high = np.asarray(self.low, dtype=float), np.asarray(self.high, dtype=float)
        object.__setattr__(self, "low", low)
        object.__setattr__(self, "high", high)
        if not np.all(low <= high):
            raise ScenarioError(f"limits must have low <= high, got low {low}, high {high}")

    def clip(self, value: Array) -> Array:
        """Value limited to [low, high]."""
        return np.minimum(np.maximum(value, self.low), self.high)


@dataclass(frozen=True)
class PidGains:
    """Proportional, integral and derivative gain per axis, (n,) or (..., n), not negative."""

    P: Array | Sequence[float]
    I: Array | Sequence[float]  # noqa: E741
    D: Array | Sequence[float]

    def __post_init__(self) -> None:
        """Raise ScenarioError for a gain that is negative or not finite."""
        for name in ("P", "I", "D"):
            value = np.asarray(getattr(self, name), dtype=float)
            if not np.all(np.isfinite(value)) or np.any(value < 0):
                raise ScenarioError(f"PID gain {name} must be finite and >= 0, got {value}")
            object.__setattr__(self, name, value)


def named_gains(sets: Mapping[str, T], name: str, controller: str) -> T:
    """Gain set of a controller by its name.

    Raises:
        ScenarioError: the controller has no such set; the message lists those it has.
    """
    if name not in sets:
        raise ScenarioError(
            f"gains = {name!r} does not exist for {controller}; available: {', '.join(sets)}"
        )
    return sets[name]


@dataclass(frozen=True)
class PidState:
    """Memory of a PID.

    Attributes:
        integral: (..., n) integral term `I sum(e dt)`, in the unit of the output.
        previous: (..., n) differentiated error of the previous call; NaN before the first one.
    """

    integral: Array
    previous: Array

    def reset(self, mask: Array) -> "PidState":
        """State with the entries of boolean `mask` (...,) as before the first call."""
        mask = np.asarray(mask)[..., None]
        return PidState(np.where(mask, 0.0, self.integral), np.where(mask, np.nan, self.previous))


@dataclass(frozen=True)
class Pid:
    """`u = P e + I sum(e dt) + D (e - e_previous)/dt + feed-forward`, clipped to the limits.

    Attributes:
        gains: gains per axis.
        limits: limits of the output; the integral term is clamped to half of them.
        period: time between two updates, s.
    """

    gains: PidGains
    limits: Limits
    period: float
    axes: int = field(init=False)

    def __post_init__(self) -> None:
        """Raise ScenarioError for a period that is not positive."""
        if not self.period > 0:
            raise ScenarioError(f"control period must be > 0 s, got {self.period}")
        object.__setattr__(self, "axes", np.shape(self.gains.P)[-1])

    def initial(self, shape: tuple[int, ...] = ()) -> PidState:
        """State before the first update, for a leading shape."""
        return PidState(np.zeros((*shape, self.axes)), np.full((*shape, self.axes), np.nan))

    def update(
        self,
        state: PidState,
        error: Array,
        feed_forward: Array | float = 0.0,
        differentiated: Array | None = None,
    ) -> tuple[Array, PidState]:
        """Output (..., n) and the next state.

        Args:
            state: state after the previous update.
            error: (..., n) target minus measurement.
            feed_forward: (..., n) added before the output is clipped.
            differentiated: (..., n) error that the derivative acts on, default `error`.
        """
        error = np.asarray(error, dtype=float)
        slope = error if differentiated is None else np.asarray(differentiated, dtype=float)
        half = Limits(0.5 * self.limits.low, 0.5 * self.limits.high)
        integral = half.clip(state.integral + self.gains.I * error * self.period)
        # No previous error at the first call: no derivative then.
        difference = np.where(np.isnan(state.previous), 0.0, slope - state.previous)
        output = self.gains.P * error + integral + self.gains.D * difference / self.period
        return self.limits.clip(output + feed_forward), PidState(integral, slope)
