"""Strip theory: a slender body as a row of 2-D sections along x."""

import numpy as np
from numpy.typing import ArrayLike

from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.hydrodynamics.estimates._checks import not_negative

#: Two-point Gauss rule on [0, 1]: exact for what is linear in x times x^2.
GAUSS = (0.5 - np.sqrt(3) / 6, 0.5 + np.sqrt(3) / 6)


def _stations(x: ArrayLike, **values: ArrayLike) -> tuple[Array, list[Array]]:
    """Station positions (n,) and the values at them, each (n,).

    Raises:
        ModelError: fewer than two stations, not in ascending order, or a size does not fit.
    """
    stations = np.asarray(x, dtype=float)
    if stations.ndim != 1 or len(stations) < 2:
        raise ModelError(f"x has shape {stations.shape}, strip theory needs (n,) with n >= 2")
    if not np.all(np.diff(stations) > 0):
        raise ModelError("x is not in ascending order: give the stations from aft to fore")
    out = []
    for name, value in values.items():
        array = np.asarray(value, dtype=float)
        if array.shape not in ((), stations.shape):
            raise ModelError(
                f"{name} has shape {array.shape}, it must be one number or {stations.shape} as x"
            )
        if not np.all(np.isfinite(array)):
            raise ModelError(f"{name} has values that are not finite")
        out.append(np.broadcast_to(array, stations.shape).astype(float))
    return stations, out


def strip_added_mass(
    x: ArrayLike,
    sway: ArrayLike,
    heave: ArrayLike,
    *,
    roll: ArrayLike = 0.0,
    sway_roll: ArrayLike = 0.0,
    z: ArrayLike = 0.0,
    surge: float = 0.0,
) -> Array:
    """Added mass (6, 6) of a slender body about the body origin, FRD or FLU, SNAME order, positive.

    A section at x feels `v + x r - z p`, `w - x q` and p (the same in FRD and FLU axes), so that

        M22 = int a22 dx          M26 = int x a22 dx      M66 = int x^2 a22 dx
        M33 = int a33 dx          M35 = -int x a33 dx     M55 = int x^2 a33 dx
        M44 = int a44 dx          M24 = int a24 dx        M46 = int x a24 dx

    (Newman, Marine Hydrodynamics, sec. 7.3) for sections whose centres lie on the x axis. Between
    stations the sections change linearly and are integrated exactly. The matrix is symmetric, and
    positive semidefinite where every section is. The ends are not in it: near blunt ends a
    section's flow is weaker than in 2-D; multiply by the ratio of a 3-D table value to M22 to
    correct (Lamb's spheroid with a = 5 b: 0.894).

    Args:
        x: (n,) stations in ascending order, m from the body origin, forward positive.
        sway: (n,) or one number, `a22` of the sections, kg/m.
        heave: the same, `a33`, kg/m.
        roll: `a44` about the section's own centre, kg m2/m.
        sway_roll: `a24` about the section's own centre, kg m/m. It changes sign between FRD and
            FLU; the others do not.
        z: height of the section's centre in the body's axes (FRD: down, FLU: up), m.
        surge: `M11`, kg. Strip theory says nothing about it; take Lamb's spheroid.

    Raises:
        ModelError: sizes do not fit, stations are not in order, a value is not finite, or a section
            would give back energy (`a22, a33, a44 < 0`, or `a24^2 > a22 a44`).
    """
    not_negative(surge=surge)
    stations, (a22, a33, a44, a24, height) = _stations(
        x, sway=sway, heave=heave, roll=roll, sway_roll=sway_roll, z=z
    )
    for name, array in (("sway", a22), ("heave", a33), ("roll", a44)):
        if np.any(array < 0):
            i = int(np.argmin(array))
            raise ModelError(
                f"{name} = {array[i]:.4g} at x = {stations[i]:g} m is negative: added mass is "
                "positive here (M_A = -Y_vdot ...)"
            )
    excess = a24**2 - a22 * a44
    if np.any(excess > 1e-9 * np.maximum(a24**2, 1e-300)):
        i = int(np.argmax(excess))
        raise ModelError(
            f"sway_roll^2 = {a24[i] ** 2:.4g} is above sway * roll = {a22[i] * a44[i]:.4g} at "
            f"x = {stations[i]:g} m: the section is not positive semidefinite"
        )
    M = np.zeros((6, 6))
    M[0, 0] = surge
    for part in GAUSS:
        for i, length in enumerate(np.diff(stations)):
            at = [(1 - part) * value[i] + part * value[i + 1] for value in (a22, a33, a44, a24)]
            s22, s33, s44, s24 = at
            here = stations[i] + part * length
            up = (1 - part) * height[i] + part * height[i + 1]
            section = np.array([[s22, 0.0, s24], [0.0, s33, 0.0], [s24, 0.0, s44]])
            # Rows: sway and heave of the section's centre, roll; columns: the body's twist.
            H = np.zeros((3, 6))
            H[0, 1], H[0, 3], H[0, 5] = 1.0, -up, here
            H[1, 2], H[1, 4] = 1.0, -here
            H[2, 3] = 1.0
            M += 0.5 * length * H.T @ section @ H
    return 0.5 * (M + M.T)


def cross_flow_damping(x: ArrayLike, sway: ArrayLike, heave: ArrayLike) -> Array:
    """Quadratic damping `D_Q` (6, 6) of a slender body's cross-flow drag, lumped at the origin.

    For `force_i = -sum_j D_Q[i,j] |nu_j| nu_j` (FRD or FLU, SNAME order): exact in pure sway,
    heave, pitch and yaw; their combinations need the strips themselves (`strip_drag_frd`).

        D22 = int k_y dx    D26 = int k_y x|x| dx    D62 = int k_y x dx     D66 = int k_y |x|^3 dx
        D33 = int k_z dx    D35 = -int k_z x|x| dx   D53 = -int k_z x dx    D55 = int k_z |x|^3 dx

    Args:
        x: (n,) stations in ascending order, m from the body origin, forward positive.
        sway: (n,) or one number, drag per metre `k_y = rho/2 C_D d`, N s2/m3 (`quadratic_drag`).
        heave: the same, `k_z`.

    Raises:
        ModelError: sizes do not fit, stations are not in order, or a value is negative.
    """
    stations, (k_y, k_z) = _stations(x, sway=sway, heave=heave)
    if min(k_y.min(), k_z.min()) < 0:
        raise ModelError(f"drag per metre {min(k_y.min(), k_z.min()):.4g} N s2/m3 is negative")
    # |x| has its corner at the origin: a station there, then five-point Gauss is exact.
    if stations[0] < 0 < stations[-1] and not np.any(stations == 0):
        fine = np.sort(np.append(stations, 0.0))
        k_y, k_z = np.interp(fine, stations, k_y), np.interp(fine, stations, k_z)
        stations = fine
    nodes, weights = np.polynomial.legendre.leggauss(5)
    part = 0.5 * (nodes + 1)
    length = np.diff(stations)[:, None]
    here = stations[:-1, None] + part * length
    D = np.zeros((6, 6))
    for k, force, turn, sign in ((k_y, 1, 5, 1.0), (k_z, 2, 4, -1.0)):
        drag = (k[:-1, None] * (1 - part) + k[1:, None] * part) * 0.5 * weights * length
        D[force, force] = np.sum(drag)
        D[force, turn] = sign * np.sum(drag * here * np.abs(here))
        D[turn, force] = sign * np.sum(drag * here)
        D[turn, turn] = np.sum(drag * np.abs(here) ** 3)
    return D
