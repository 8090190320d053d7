"""From a wanted wrench to thruster commands that respect each thruster's limits.

Weighted pseudo-inverse with redistribution: what a saturated thruster cannot give is asked from
the others, then the rest is clipped (Fossen 2021, section 11.2; Bodson 2002 for the
redistribution). Wrenches are FLU at the body origin, [X, Y, Z, K, M, N].
"""

from dataclasses import dataclass, field

import numpy as np
from marine_mj.controllers.pid import Limits

from marine_mj.errors import ScenarioError
from marine_mj.frames import Array

# Damping of the inverse relative to the largest eigenvalue: axes no thruster reaches stay finite.
_DAMPING = 1e-9


@dataclass(frozen=True)
class Allocator:
    """Least-effort allocation of a wrench to thrusters with asymmetric limits.

    Attributes:
        effectiveness: `B` (6, m): wrench per unit of each thruster, FLU.
        limits: thrust limits (m,) of each thruster.
        axis_weight: (6,) importance of an error in each axis, 1/N and 1/(N m); default: moments
            count as forces at an arm of 0.3 m.
        passes: how often saturated thrusters are fixed and the rest is asked again.
    """

    effectiveness: Array
    limits: Limits
    axis_weight: Array = field(default_factory=lambda: np.array([1, 1, 1, 3.3, 3.3, 3.3]))
    passes: int = 3

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
        effort = (0.5 * (self.limits.high - self.limits.low)) ** 2
        commands = np.zeros((flat.shape[0], scaled.shape[1]))
        free = np.ones(commands.shape, dtype=bool)
        pending = np.arange(flat.shape[0])
        for _ in range(self.passes):
            residual = self.axis_weight * flat[pending] - commands[pending] @ scaled.T
            weight = np.where(free[pending], effort, 0.0)
            weighted = weight[:, None, :] * scaled  # (k, 6, m)
            gram = weighted @ scaled.T
            gram += (_DAMPING * np.trace(gram, axis1=1, axis2=2) + 1e-30)[:, None, None] * np.eye(6)
            step = np.linalg.solve(gram, residual[..., None])
            step = (np.swapaxes(weighted, 1, 2) @ step)[..., 0]
            wanted = commands[pending] + step
            limited = self.limits.clip(wanted)
            commands[pending] = limited
            hit = limited != wanted
            free[pending] &= ~hit
            pending = pending[hit.any(axis=1) & free[pending].any(axis=1)]
            if pending.size == 0:
                break
        commands = commands.reshape(*wrench.shape[:-1], -1)
        return commands, commands @ self.effectiveness.T
