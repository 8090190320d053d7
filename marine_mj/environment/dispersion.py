"""Linear dispersion of gravity waves: wavenumber, phase speed, group speed."""

import numpy as np
from numpy.typing import ArrayLike

from marine_mj.environment._checks import number
from marine_mj.errors import SeaError
from marine_mj.frames import Array


def wavenumber(omega: ArrayLike, depth: float = np.inf, gravity: float = 9.81) -> Array:
    """Wavenumber k [rad/m] with `omega^2 = g k tanh(k h)`, to 1e-12 relative or better.

    Newton's method on `x tanh(x) = y`, x = k h, y = omega^2 h / g, from Eckart's (1952) guess
    `x = y / sqrt(tanh y)`; in deep water `k = omega^2 / g`.

    Args:
        omega: angular frequency, any shape, rad/s.
        depth: water depth h, m; inf for deep water.
        gravity: g, m/s2.

    Raises:
        SeaError: a frequency, the depth or gravity is not > 0.
    """
    omega = np.asarray(omega, dtype=float)
    if not (np.isfinite(omega) & (omega > 0)).all():
        bad = omega[~(np.isfinite(omega) & (omega > 0))].flat[0]
        raise SeaError(f"omega is {bad} rad/s, allowed is > 0, finite: give 2 pi / period")
    number("depth", depth, "m", "give the water depth, inf for deep water", above=0, infinite=True)
    number("gravity", gravity, "m/s2", "9.81 on Earth", above=0)
    if np.isinf(depth):
        return omega**2 / gravity
    y = omega**2 * depth / gravity
    x = y / np.sqrt(np.tanh(y))
    # The guess is within 5 %; convergence is quadratic, five steps reach rounding.
    for _ in range(5):
        tanh = np.tanh(x)
        x = x - (x * tanh - y) / (tanh + x * (1 - tanh**2))
    return x / depth


def phase_speed(omega: ArrayLike, depth: float = np.inf, gravity: float = 9.81) -> Array:
    """Phase speed `c = omega / k` [m/s]; arguments and errors as `wavenumber`."""
    return np.asarray(omega, dtype=float) / wavenumber(omega, depth, gravity)


def group_speed(omega: ArrayLike, depth: float = np.inf, gravity: float = 9.81) -> Array:
    """Group speed `d omega / d k = (c/2) (1 + 2kh / sinh 2kh)` [m/s]; see `wavenumber`."""
    k = wavenumber(omega, depth, gravity)
    c = np.asarray(omega, dtype=float) / k
    if np.isinf(depth):
        return 0.5 * c
    kh = np.minimum(k * depth, 300.0)  # sinh(600) is still finite, the ratio is 0
    return 0.5 * c * (1 + 2 * kh / np.sinh(2 * kh))
