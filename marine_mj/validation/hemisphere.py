"""Floating hemisphere in deep water by multipoles: an exact solution to test panels against."""

import numpy as np
from numpy.typing import NDArray
from scipy.special import j0, j1, jvp, lpmv, struve, y0, y1

#: Wave-free multipoles and collocation points: more change no digit that is shown.
ORDER, POINTS = 24, 60


def hemisphere(wavenumber: float, surge: bool = False) -> complex:
    """Added mass and damping of a floating hemisphere, `mu + i lambda`, by `2/3 pi rho a^3`.

    `A = 2/3 pi rho a^3 mu` and `B = 2/3 pi rho a^3 omega lambda` of heave or surge, as Hulme
    (1982), J. Fluid Mech. 121, tabulates. The potential is a wave source (heave) or horizontal
    wave dipole at the centre plus the wave-free multipoles of Havelock (1955) and Ursell,

        P_2n^m / r^(2n+1) + K / (2n - m) P_(2n-1)^m / r^2n   (heave m = 0; surge m = 1: n + 1/2),

    with the strengths from the body condition in the sense of least squares. The principal value
    in the source is `int e^(-kz) J0(kR) / (k - K) dk = -e^(-Kz) [pi/2 (H0 + Y0)(KR)
    + int_0^z e^(Kt) / sqrt(R^2 + t^2) dt]`.

    Args:
        wavenumber: K a, above 0.
    """
    K = float(wavenumber)
    node, weight = np.polynomial.legendre.leggauss(POINTS)
    mu, weight = 0.5 * (node + 1), 0.5 * weight  # cosine of the angle from straight down
    R, z = np.sqrt(1 - mu**2), mu
    potential, slope = _wave_singularity(K, R, z, surge)
    columns, slopes = [potential], [slope]
    for n in range(1, ORDER + 1):
        m, degree = (1, 2 * n + 1) if surge else (0, 2 * n)
        p, q = lpmv(m, degree, mu), lpmv(m, degree - 1, mu) * K / (2 * n)
        # Legendre functions of order 1 grow with the degree: scaled for the least squares.
        columns.append((p + q) / degree**m + 0j)
        slopes.append(-((degree + 1) * p + degree * q) / degree**m + 0j)
    A, scale = np.stack(slopes, axis=1), np.sqrt(weight)[:, None]
    wanted = (R if surge else mu) + 0j
    strength = np.linalg.lstsq(A * scale, wanted * scale[:, 0], rcond=None)[0]
    phi = np.stack(columns, axis=1) @ strength
    # F = -rho int phi n dS per unit acceleration, over the half sphere (surge: cos^2 gives pi).
    factor = np.pi if surge else 2 * np.pi
    force = -factor * (weight * phi * (R if surge else mu)).sum()
    result = force / (2 / 3 * np.pi)
    return complex(result.real, abs(result.imag))


def _wave_singularity(
    K: float, R: NDArray, z: NDArray, surge: bool
) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Potential and radial derivative on the unit sphere of the wave source or dipole."""
    node, weight = np.polynomial.legendre.leggauss(80)
    t = 0.5 * z[:, None] * (node + 1)
    part = 0.5 * z * (weight * np.exp(K * t) / np.hypot(R[:, None], t)).sum(axis=1)
    decay, x = np.exp(-K * z), K * R
    zero = -decay * (0.5 * np.pi * (struve(0, x) + y0(x)) + part)
    # int_0^inf e^(-kz) J1 dk = (1 - z / r) / R, r = 1
    first = (
        0.5
        * z
        * (weight * np.exp(K * t) * (1 - t / np.hypot(R[:, None], t)) / R[:, None]).sum(axis=1)
    )
    surface = 1 - 1 / x - 0.5 * np.pi * (struve(1, x) + y1(x))
    one = decay * (surface - first)
    lift = (1 - z) / R
    wave = 1j * np.pi * decay
    if not surge:
        # phi = 1 / r + K PV int e^(-kz) J0 / (k - K) dk + i pi K e^(-Kz) J0
        phi = 1 + K * zero + wave * K * j0(x)
        along_z = -z - K * (1 + K * zero) - wave * K**2 * j0(x)
        along_R = -R - K * (lift + K * one) - wave * K**2 * j1(x)
        return phi, R * along_R + z * along_z
    # phi = -d/dR of that: R / r^3 + K (int J1 e^(-kz) dk + K PV int J1 / (k - K)) + wave
    inner = lift + K * one  # PV int k e^(-kz) J1 / (k - K) dk
    phi = R + K * inner + wave * K**2 * j1(x)
    # int k e^(-kz) J1 dk = R / r^3;  int k e^(-kz) J0 dk = z / r^3
    along_z = -3 * R * z - K * (R + K * inner) - wave * K**3 * j1(x)
    # d/dR J1(kR) = k J0 - J1 / R under the integral sign
    slope = z + K * (1 + K * zero) - inner / R
    along_R = 1 - 3 * R**2 + K * slope + wave * K**3 * jvp(1, x)
    return phi, R * along_R + z * along_z
