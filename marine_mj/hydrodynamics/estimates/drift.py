"""Wave drift coefficients of a hull by the waves that it reflects."""

import numpy as np
from numpy.typing import ArrayLike

from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.hydrodynamics.estimates._checks import positive


def plate_reflection(wavenumber: ArrayLike, draft: float) -> Array:
    """Reflection coefficient R of a fixed vertical plate that pierces the surface.

    `R = pi I_1(kT) / sqrt(pi^2 I_1(kT)^2 + K_1(kT)^2)` in deep water, waves square to the plate
    (Ursell 1947, Proc. Camb. Phil. Soc. 43): 0 for long waves, 1 for short ones.

    Args:
        wavenumber: k, rad/m, >= 0, any shape, which is that of the result.
        draft: T of the lower edge, m.

    Raises:
        ModelError: a wavenumber is negative or not finite, or the draft is not positive.
    """
    from scipy.special import i1e, k1e

    positive(draft=draft)
    k = np.asarray(wavenumber, dtype=float)
    if not (np.isfinite(k) & (k >= 0)).all():
        raise ModelError(f"wavenumber is {k}; allowed is finite and >= 0 rad/m")
    kT = np.maximum(k * draft, 1e-150)
    # K_1 / I_1 with the exponentials taken out of both
    ratio = k1e(kT) * np.exp(-2 * kT) / (np.pi * i1e(kT))
    return np.where(k > 0, 1 / np.hypot(1, ratio), 0.0)


def reflected_drift(
    omega: ArrayLike, length: float, breadth: float, draft: float, gravity: float = 9.81
) -> Array:
    """Rows (n, 4) of `BODY.drift` of a hull whose sides and ends reflect like plates in deep water.

    `omega, R^2 B, R^2 L, 0` with R from `plate_reflection`: mean drift `1/2 rho g a^2 R^2 (B c|c|,
    L s|s|, 0)` of a wave at the angle chi, c = cos chi and s = sin chi. Between the rows the
    coefficients are linear in omega, so take them close where R rises (125 rows are allowed).

    Args:
        omega: wave frequencies, rad/s, > 0 and rising.
        length: L between perpendiculars, m.
        breadth: B, m.
        draft: T, m.
        gravity: m/s2.

    Raises:
        ModelError: a value is not positive.
    """
    positive(length=length, breadth=breadth, gravity=gravity)
    omega = np.asarray(omega, dtype=float)
    square = plate_reflection(omega**2 / gravity, draft) ** 2
    return np.stack([omega, square * breadth, square * length, np.zeros_like(omega)], axis=-1)
