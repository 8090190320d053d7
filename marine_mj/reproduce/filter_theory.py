"""What the study's two filters can know, from linear theory: no simulation in it.

Level bodies, so that both filters are `F = [[I, T I], [0, I]]` per step (digest 5.3); process noise
and assumed accelerations are those of tables 8.5 and 8.7 in every scenario, as in the study.
"""

import numpy as np
from scipy.linalg import solve_discrete_are, solve_discrete_lyapunov

from marine_mj.controllers.navigation.planar import PlanarNoise
from marine_mj.frames import Array

_PERIOD = 0.01
_F = np.eye(6) + _PERIOD * np.eye(6, k=3)
_PROCESS = np.square([0.003, 0.003, 0.001, 0.001, 0.001, 0.01])
_ASSUMED = np.array([0.01, 0.01, 0.05])


def _noise(acceleration: Array) -> Array:
    """Covariance (6, 6) that accelerations with such variances (3,) add per step."""
    return np.diag(np.concatenate([np.zeros(3), _PERIOD**2 * acceleration]))


def _added(noise: Array, steps: int) -> Array:
    """Covariance (6, 6) after so many steps of a noise (6, 6), from none."""
    powers = (np.linalg.matrix_power(_F, i) for i in range(steps))
    return sum((p @ noise @ p.T for p in powers), np.zeros((6, 6)))


def riccati(noise: PlanarNoise) -> tuple[Array, Array]:
    """Covariances (6, 6) of a filter before and after a fix, steady, as it believes them."""
    n = round(noise.fix_period / _PERIOD)
    R = np.diag(np.square(noise.fix))
    F = np.linalg.matrix_power(_F, n)
    Q = _added(np.diag(_PROCESS) + _noise(_ASSUMED), n)
    before = solve_discrete_are(F.T, np.eye(6), Q, R)
    return before, before - before @ np.linalg.solve(before + R, before)


def surge_error(noise: PlanarNoise) -> float:
    """True standard deviation of the carrier's x seen from the vehicle, m, mean over a cycle.

    Lyapunov equation of the error under the filters' gains; only the measurements are noisy, the
    bodies move as the filters think. Both filters contribute the same.
    """
    n = round(noise.fix_period / _PERIOD)
    R = np.diag(np.square(noise.fix))
    before, _ = riccati(noise)
    gain = np.linalg.solve(before + R, before).T
    rest = np.eye(6) - gain
    real = _noise(np.square(noise.acceleration))
    spread = rest @ _added(real, n) @ rest.T + gain @ R @ gain.T
    error = solve_discrete_lyapunov(rest @ np.linalg.matrix_power(_F, n), spread)
    powers = [np.linalg.matrix_power(_F, i) for i in range(n)]
    cycle = [(p @ error @ p.T + _added(real, i))[0, 0] for i, p in enumerate(powers)]
    return float(np.sqrt(2 * np.mean(cycle)))
