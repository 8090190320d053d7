"""When a latch closes: pose and relative speed inside limits for long enough, and not before."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from marine_mj.errors import ScenarioError
from marine_mj.frames import Array, length


@dataclass(frozen=True)
class LatchState:
    """Memory of a latch.

    Attributes:
        dwell: (...,) time for which all limits have been kept, s.
        closed: (...,) bool.
    """

    dwell: Array
    closed: Array


@dataclass(frozen=True)
class Latch:
    """Latch that closes after all limits were kept for `dwell` seconds (digest 7.8 defaults).

    Attributes:
        position: largest distance from the seat, m.
        attitude: largest angle to the seat, rad.
        speed: largest relative linear speed, m/s.
        rate: largest relative angular speed, rad/s.
        dwell: time the limits must be kept, s.
    """

    position: float = 0.05
    attitude: float = np.deg2rad(3.0)
    speed: float = 0.1
    rate: float = np.deg2rad(10.0)
    dwell: float = 1.0

    def __post_init__(self) -> None:
        """Raise ScenarioError for a limit that is not positive."""
        for name in ("position", "attitude", "speed", "rate"):
            if not np.all(np.asarray(getattr(self, name)) > 0):
                raise ScenarioError(f"latch {name} limit must be > 0, got {getattr(self, name)}")
        if not np.all(np.asarray(self.dwell) >= 0):
            raise ScenarioError(f"latch dwell must be >= 0 s, got {self.dwell}")

    def initial(self, shape: tuple[int, ...] = ()) -> LatchState:
        """Open latch, for a leading shape."""
        return LatchState(np.zeros(shape), np.zeros(shape, dtype=bool))

    def inside(self, error: Array, velocity: Array) -> NDArray[np.bool_]:
        """Whether (...,) pose error (..., 6) and relative velocity (..., 6) keep all limits."""
        return (
            (length(error[..., :3]) <= self.position)
            & (length(error[..., 3:]) <= self.attitude)
            & (length(velocity[..., :3]) <= self.speed)
            & (length(velocity[..., 3:]) <= self.rate)
        )

    def update(self, state: LatchState, error: Array, velocity: Array, period: float) -> LatchState:
        """Next state; once closed it stays closed.

        Args:
            state: state after the previous update.
            error: (..., 6) vehicle pose minus seat pose or the reverse, m and rad, any frame.
            velocity: (..., 6) relative velocity, m/s and rad/s, any frame.
            period: time since the previous update, s.
        """
        dwell = np.where(self.inside(error, velocity), state.dwell + period, 0.0)
        # Half a period of slack: sums of the period are not exact.
        closed = np.logical_or(state.closed, dwell >= self.dwell + 0.5 * period)
        return LatchState(dwell, closed)
