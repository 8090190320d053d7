"""From a wanted wrench to thruster commands that respect each thruster's limits.

Bounded weighted least squares by an active set (Härkegård 2002, "Efficient active set algorithms
for solving constrained least squares problems in aircraft control allocation"): what cannot be
given is missed where it weighs least. Clipping a pseudo-inverse does not do that: a pitch moment
out of reach saturates the forward thrusters against each other and surge is lost with it. Wrenches
are FLU at the body origin, [X, Y, Z, K, M, N].
"""

from dataclasses import dataclass, field

import numpy as np
from marine_mj.controllers.pid import Limits
from numpy.typing import NDArray

from marine_mj.errors import ScenarioError
from marine_mj.frames import Array

Flags = NDArray[np.bool_]

# Weight of the effort relative to that of the wrench: small enough not to be seen in the wrench.
_EFFORT = 1e-7


@dataclass(frozen=True)
class Allocator:
    """Least-effort allocation of a wrench to thrusters with asymmetric limits.

    Attributes:
        effectiveness: `B` (6, m): wrench per unit of each thruster, FLU.
        limits: thrust limits (m,) of each thruster.
        axis_weight: (6,) importance of an error in each axis, 1/N and 1/(N m); default: moments
            count as forces at an arm of 0.3 m.
        iterations: most changes of the set of saturated thrusters.
    """

    effectiveness: Array
    limits: Limits
    axis_weight: Array = field(default_factory=lambda: np.array([1.0, 1, 1, 3.3, 3.3, 3.3]))
    iterations: int = 40

    def __post_init__(self) -> None:
        """Raise ScenarioError when shapes do not fit or a thruster cannot be at rest."""
        matrix = np.asarray(self.effectiveness, dtype=float)
        object.__setattr__(self, "effectiveness", matrix)
        if matrix.ndim != 2 or matrix.shape[0] != 6:
            raise ScenarioError(f"effectiveness must have shape (6, m), got {matrix.shape}")
        if np.shape(self.limits.low) != (matrix.shape[1],):
            raise ScenarioError(
                f"{matrix.shape[1]} thrusters need {matrix.shape[1]} limits, got "
                f"{np.shape(self.limits.low)}"
            )
        if np.any(self.limits.low > 0) or np.any(self.limits.high < 0):
            raise ScenarioError("thruster limits must contain zero thrust")

    def allocate(self, wrench: Array) -> tuple[Array, Array]:
        """Thruster commands (..., m) within the limits, and the wrench (..., 6) they give.

        Args:
            wrench: (..., 6) wanted wrench, FLU.
        """
        wrench = np.asarray(wrench, dtype=float)
        flat = wrench.reshape(-1, 6)
        scaled = self.axis_weight[:, None] * self.effectiveness  # (6, m)
        # Effort is measured relative to each thruster's range.
        span = 0.5 * np.maximum(self.limits.high - self.limits.low, 1e-12)
        hessian = scaled.T @ scaled
        effort = _EFFORT * np.trace(hessian) * np.mean(span) ** 2 / len(span) / span**2
        hessian += np.diag(effort + 1e-30)
        slope = (self.axis_weight * flat) @ scaled  # (k, m)
        # One row at a time gives the same bits as a batch.
        commands = np.zeros_like(slope)
        for i, row in enumerate(slope):
            commands[i] = np.linalg.solve(hessian, row)
        limited = self.limits.clip(commands)
        saturated = np.flatnonzero((limited != commands).any(axis=1))
        for k in saturated:
            limited[k] = self._bounded(hessian, slope[k], limited[k], limited[k] == commands[k])
        commands = limited.reshape(*wrench.shape[:-1], -1)
        return commands, commands @ self.effectiveness.T

    def _bounded(self, hessian: Array, slope: Array, start: Array, free: Flags) -> Array:
        """Minimum (m,) of `u H u / 2 - slope u` within the limits, from a start inside them."""
        low, high = self.limits.low, self.limits.high
        u, free = start.copy(), free.copy()
        for _ in range(self.iterations):
            gradient = hessian @ u - slope
            step = np.zeros_like(u)
            if free.any():
                step[free] = np.linalg.solve(hessian[np.ix_(free, free)], -gradient[free])
            with np.errstate(divide="ignore", invalid="ignore"):
                room = np.where(step > 0, (high - u) / step, (low - u) / step)
            room[~free | (step == 0)] = np.inf
            first = int(np.argmin(room))
            if room[first] < 1.0:
                u = self.limits.clip(u + room[first] * step)
                u[first] = high[first] if step[first] > 0 else low[first]
                free[first] = False
                continue
            u = self.limits.clip(u + step)
            # A thruster at its limit is let go when the cost falls towards the inside.
            gradient = hessian @ u - slope
            pull = np.where(u >= high, gradient, -gradient)
            pull[free | (low == high)] = -np.inf
            worst = int(np.argmax(pull))
            if pull[worst] <= 1e-9 * (1.0 + np.abs(slope).max()):
                break
            free[worst] = True
        return u
