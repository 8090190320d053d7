"""From a wanted wrench to thruster commands that respect each thruster's limits.

Bounded weighted least squares by an active set (Härkegård 2002, "Efficient active set algorithms
for solving constrained least squares problems in aircraft control allocation"): what cannot be
given is missed where it weighs least. Clipping a pseudo-inverse does not do that: a pitch moment
out of reach saturates the forward thrusters against each other and surge is lost with it. Wrenches
are FLU at the body origin, [X, Y, Z, K, M, N].
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from marine_mj.controllers.pid import Limits
from numba import njit

from marine_mj.errors import ScenarioError
from marine_mj.frames import Array

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

    @cached_property
    def _problem(self) -> tuple[Array, Array, Array]:
        """Cholesky factor (m, m), Hessian (m, m), and slope (6, m) of the cost over the wrench."""
        scaled = self.axis_weight[:, None] * self.effectiveness  # (6, m)
        # Effort is measured relative to each thruster's range.
        span = 0.5 * np.maximum(self.limits.high - self.limits.low, 1e-12)
        hessian = scaled.T @ scaled
        effort = _EFFORT * np.trace(hessian) * np.mean(span) ** 2 / len(span) / span**2
        hessian += np.diag(effort + 1e-30)
        factor = np.asarray(np.linalg.cholesky(hessian), dtype=float)
        return factor, hessian, self.axis_weight[:, None] * scaled

    def allocate(self, wrench: Array) -> tuple[Array, Array]:
        """Thruster commands (..., m) within the limits, and the wrench (..., 6) they give.

        Args:
            wrench: (..., 6) wanted wrench, FLU.
        """
        wrench = np.asarray(wrench, dtype=float)
        flat = np.ascontiguousarray(wrench.reshape(-1, 6))
        commands = np.empty((len(flat), self.effectiveness.shape[1]))
        given = np.empty_like(flat)
        _allocate(
            *self._problem,
            self.effectiveness,
            flat,
            np.asarray(self.limits.low, dtype=float),
            np.asarray(self.limits.high, dtype=float),
            self.iterations,
            commands,
            given,
        )
        return commands.reshape(*wrench.shape[:-1], -1), given.reshape(wrench.shape)


@njit(cache=True)
def _allocate(
    factor, hessian, slope, effectiveness, wrench, low, high, iterations, commands, given
):
    """Fill commands (k, m) and given wrench (k, 6), row by row: a row's bits know no other row."""
    rows, m = commands.shape
    q, step, gradient = np.empty(m), np.empty(m), np.empty(m)
    free = np.empty(m, dtype=np.bool_)
    index = np.empty(m, dtype=np.int64)
    work = np.empty((m, m))
    for k in range(rows):
        u = commands[k]
        for j in range(m):
            q[j] = 0.0
            for i in range(6):
                q[j] += wrench[k, i] * slope[i, j]
            u[j] = q[j]
        _substitute(factor, m, u)
        inside = True
        for j in range(m):
            free[j] = low[j] <= u[j] <= high[j]
            inside = inside and free[j]
            u[j] = min(max(u[j], low[j]), high[j])
        if not inside:
            _bounded(hessian, q, low, high, iterations, u, free, index, work, step, gradient)
        for i in range(6):
            given[k, i] = 0.0
            for j in range(m):
                given[k, i] += effectiveness[i, j] * u[j]


@njit(cache=True)
def _substitute(L, n, x):
    """Overwrite x[:n] with the solution of L L^T y = x."""
    for i in range(n):
        for j in range(i):
            x[i] -= L[i, j] * x[j]
        x[i] /= L[i, i]
    for i in range(n - 1, -1, -1):
        for j in range(i + 1, n):
            x[i] -= L[j, i] * x[j]
        x[i] /= L[i, i]


@njit(cache=True)
def _newton(hessian, free, index, work, gradient, step):
    """Step to the minimum over the free thrusters, Cholesky of their block."""
    n = 0
    for j in range(len(step)):
        step[j] = 0.0
        if free[j]:
            index[n] = j
            n += 1
    for i in range(n):
        for j in range(i + 1):
            total = hessian[index[i], index[j]]
            for k in range(j):
                total -= work[i, k] * work[j, k]
            work[i, j] = np.sqrt(total) if i == j else total / work[j, j]
    for i in range(n):
        gradient[i] = -gradient[index[i]]  # index[i] >= i: nothing needed is overwritten
    _substitute(work, n, gradient)
    for i in range(n - 1, -1, -1):
        step[index[i]] = gradient[i]


@njit(cache=True)
def _bounded(hessian, q, low, high, iterations, u, free, index, work, step, gradient):
    """Move u (m,) to the minimum of `u H u / 2 - q u` within the limits, from inside them."""
    m = len(u)
    largest = 0.0
    for j in range(m):
        largest = max(largest, abs(q[j]))
    for _ in range(iterations):
        _gradient(hessian, q, u, gradient)
        _newton(hessian, free, index, work, gradient, step)
        first, room = -1, 1.0
        for j in range(m):
            if free[j] and step[j] != 0.0:
                share = ((high[j] if step[j] > 0 else low[j]) - u[j]) / step[j]
                if share < room:
                    first, room = j, share
        for j in range(m):
            u[j] = min(max(u[j] + room * step[j], low[j]), high[j])
        if first >= 0:
            u[first] = high[first] if step[first] > 0 else low[first]
            free[first] = False
            continue
        # A thruster at its limit is let go when the cost falls towards the inside.
        _gradient(hessian, q, u, gradient)
        worst, most = -1, 1e-9 * (1.0 + largest)
        for j in range(m):
            if not free[j] and low[j] < high[j]:
                pull = gradient[j] if u[j] >= high[j] else -gradient[j]
                if pull > most:
                    worst, most = j, pull
        if worst < 0:
            break
        free[worst] = True


@njit(cache=True)
def _gradient(hessian, q, u, out):
    """out (m,) = H u - q."""
    for i in range(len(u)):
        out[i] = -q[i]
        for j in range(len(u)):
            out[i] += hessian[i, j] * u[j]
