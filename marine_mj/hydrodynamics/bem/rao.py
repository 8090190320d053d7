"""Motion RAOs and natural periods of a hull from its linear coefficients.

Conventions are those of the wave databases: phasors `x(t) = Re(X exp(-i omega t))`, body axes FLU,
per metre of wave amplitude.
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import eigh
from scipy.optimize import brentq

from marine_mj.environment import WaveField
from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.hydrodynamics.raos import DOFS, motion, responses


def rao(
    database: str,
    omega: ArrayLike,
    direction: ArrayLike,
    dof: str,
    response: str = "motion",
) -> NDArray[np.complex128]:
    """Complex response of one degree of freedom to waves of 1 m amplitude, as a simulation uses it.

    Between the frequencies, directions and beyond them as in `hydrodynamics.raos.responses`.

    Args:
        database: file of a wave database, or its name in the package's assets.
        omega: rad/s.
        direction: direction of travel relative to the bow, rad, counter-clockwise; broadcasts.
        dof: "Surge" ... "Yaw".
        response: "motion" [m/m, rad/m] or "force" [N/m, N m/m].

    Raises:
        ModelError: there is no such database, response or degree of freedom.
    """
    if dof not in DOFS:
        raise ModelError(f"degree of freedom {dof!r} does not exist, there are {', '.join(DOFS)}")
    w, beta = np.broadcast_arrays(np.asarray(omega, dtype=float), np.asarray(direction, float))
    flat = w.ravel()
    waves = WaveField(
        omega=flat,
        wavenumber=flat**2 / 9.81,
        direction=beta.ravel(),
        amplitude=np.ones_like(flat),
        phase=np.zeros_like(flat),
    )
    return responses(database, response, waves, 0.0)[DOFS.index(dof)].reshape(w.shape)


def motion_raos(
    omega: Array, M: Array, B: Array, C: Array, excitation: NDArray
) -> NDArray[np.complex128]:
    """Motion RAOs (n, m, 6) `[-w^2 M - i w B + C]^-1 F`, m/m and rad/m.

    Args:
        omega: (n,) rad/s.
        M: (n, 6, 6) rigid-body inertia and added mass.
        B: (n, 6, 6) radiation and viscous damping.
        C: (6, 6) hydrostatic stiffness.
        excitation: (n, m, 6) complex, per metre of amplitude.
    """
    columns = [motion(omega, M, B, C, excitation[:, i]) for i in range(excitation.shape[1])]
    return np.stack(columns, axis=1)


def drag_motion_raos(
    omega: Array,
    M: Array,
    B: Array,
    C: Array,
    excitation: NDArray,
    quadratic: Array,
    amplitude: float,
) -> NDArray[np.complex128]:
    """Motion over amplitude (n, m, 6) in regular waves with quadratic damping of the body's rates.

    Equivalent linearisation over a period: `B_e = 8 / (3 pi) omega |X| D_Q` does the same work as
    `D_Q |v| v` at the amplitude |X|; solved by damped fixed-point iteration. The water's own motion
    is not subtracted, so it is meant for roll, pitch and yaw.

    Args:
        omega, M, B, C, excitation: see `motion_raos`.
        quadratic: (6,) diagonal D_Q, N s2/m2 ... N m s2.
        amplitude: of the waves, m.

    Raises:
        ModelError: a coefficient is negative, the amplitude is not above 0, or the iteration does
            not settle to 1e-6 in 200 steps.
    """
    D_Q = np.asarray(quadratic, dtype=float)
    if D_Q.shape != (6,) or not (D_Q >= 0).all() or not amplitude > 0:
        raise ModelError(
            f"quadratic damping {D_Q} with waves of {amplitude:g} m; allowed are 6 values >= 0 and "
            "an amplitude above 0"
        )
    X = motion_raos(omega, M, B, C, excitation)
    size = np.abs(X).max(axis=(0, 1))
    for _ in range(200):
        added = 8 / (3 * np.pi) * omega[:, None, None] * np.abs(X) * amplitude * D_Q
        columns = [
            motion(omega, M, B + added[:, i, :, None] * np.eye(6), C, excitation[:, i])
            for i in range(excitation.shape[1])
        ]
        new = np.stack(columns, axis=1)
        change = np.abs(np.abs(new) - np.abs(X)).max(axis=(0, 1))
        # The geometric mean of two steps: a large X gives much damping and so a small next one.
        X = new * np.sqrt(np.abs(X) / np.maximum(np.abs(new), 1e-300))
        if (change <= 1e-6 * np.maximum(size, 1e-300)).all():
            return new
    raise ModelError(
        f"the linearised quadratic damping does not settle (relative change {change / size} after "
        "200 steps); give a smaller wave amplitude or coefficient"
    )


def natural_frequency(omega: Array, added_mass: Array, inertia: float, stiffness: float) -> float:
    """Frequency [rad/s] at which `w^2 (m + A(w)) = C`, one degree of freedom; NaN if C <= 0.

    Args:
        omega: (n,) rad/s.
        added_mass: (n,) A(omega), linear between and held outside.
        inertia, stiffness: m and C.
    """
    if stiffness <= 0:
        return float("nan")

    def excess(w: float) -> float:
        return float(w * w * (inertia + np.interp(w, omega, added_mass)) - stiffness)

    high = np.sqrt(stiffness / (inertia + min(0.0, float(added_mass.min())))) * 1.01
    return float(brentq(excess, 0.0, high))


def viscous_damping(
    omega: Array,
    added_mass: Array,
    rigid: Array,
    stiffness: Array,
    ratios: Mapping[str, float],
    matrix: Array | None = None,
) -> Array:
    """Viscous damping (6, 6) beside radiation: a matrix plus shares of critical damping.

    `b = 2 zeta sqrt(C (I + A(w_n)))` of one degree of freedom about the origin, uncoupled, with
    w_n the frequency of the grid closest to its natural frequency.

    Args:
        omega: (n,) rad/s.
        added_mass: (n, 6, 6).
        rigid, stiffness: (6, 6).
        ratios: zeta by dof name.
        matrix: (6, 6) N s/m ... N m s.

    Raises:
        ModelError: a ratio is negative, its dof unknown or without stiffness, or the damping would
            feed energy.
    """
    out = np.zeros((6, 6)) if matrix is None else np.array(matrix, dtype=float)
    for dof, ratio in ratios.items():
        i = DOFS.index(dof) if dof in DOFS else -1
        if i < 0 or not ratio >= 0 or stiffness[i, i] <= 0:
            raise ModelError(
                f"damping ratio {ratio:g} of {dof!r}; allowed is >= 0 for a degree of freedom with "
                f"stiffness: {[d for k, d in enumerate(DOFS) if stiffness[k, k] > 0]}"
            )
        inertia = rigid[i, i] + added_mass[:, i, i]
        nearest = np.argmin(np.abs(omega - np.sqrt(stiffness[i, i] / inertia)))
        out[i, i] += 2 * ratio * np.sqrt(stiffness[i, i] * inertia[nearest])
    lowest = float(np.linalg.eigvalsh(0.5 * (out + out.T))[0])
    if lowest < -1e-9 * max(float(np.abs(out).max()), 1e-300):
        raise ModelError(
            f"viscous damping feeds energy: smallest eigenvalue {lowest:g}, allowed is >= 0"
        )
    return out


def natural_periods(
    omega: Array, added_mass: Array, rigid: Array, stiffness: Array
) -> dict[str, float]:
    """Undamped natural periods [s] of heave, roll and pitch, coupled with all other motions.

    Of `C x = w^2 (M_RB + A(w)) x` the mode with the largest share of its kinetic energy in that
    degree of freedom, A taken at the mode's own frequency by iteration; unstable ones are missing.

    Args:
        omega: (n,) rad/s.
        added_mass: (n, 6, 6).
        rigid, stiffness: (6, 6).
    """
    C = 0.5 * (stiffness + stiffness.T)
    found = {}
    for i in (2, 3, 4):
        w = natural_frequency(omega, added_mass[:, i, i], rigid[i, i], C[i, i])
        if not np.isfinite(w):
            continue
        for _ in range(30):
            A = np.array(
                [[np.interp(w, omega, added_mass[:, j, k]) for k in range(6)] for j in range(6)]
            )
            M = rigid + 0.5 * (A + A.T)
            values, modes = eigh(C, M)
            share = np.abs(modes[i] * (M @ modes)[i])
            share[values <= 1e-9 * values.max()] = 0.0
            new = float(np.sqrt(values[share.argmax()]))
            settled = abs(new - w) < 1e-9 * w
            w = 0.5 * (w + new)
            if settled:
                break
        found[DOFS[i]] = 2 * np.pi / w
    return found
