"""Response tables of floating bodies: a wave database looked up for a given sea."""

from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from marine_mj.environment import WaveField
from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.hydrodynamics.netcdf import read_variables
from marine_mj.library import assets_folder, find_asset

#: Database variable of each response, with the dimension of its entries.
RESPONSES = {
    "force": ("excitation_force", "influenced_dof"),
    "diffraction": ("diffraction_force", "influenced_dof"),
    "motion": ("RAO", "radiating_dof"),
    "shelter": ("shelter_strength", "mode"),
}
DOFS = ["Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw"]
#: Entries of the axes of a wave database, in our order.
LABELS = {"radiating_dof": DOFS, "influenced_dof": DOFS}


def database_path(name: str) -> Path:
    """File of a wave database: a path, or a name in the package's assets.

    Raises:
        ModelError: there is no such file; the message lists the databases of the package.
    """
    path = find_asset(name)
    if path is None:
        raise ModelError(
            f"wave database {name!r} does not exist; the package has "
            f"{sorted(p.name for p in assets_folder().glob('*.nc'))}, any other needs its path"
        )
    return path


def _variables(path: Path, wanted: Mapping[str, tuple[str, ...]]) -> list[Array]:
    """omega, wave_direction and the wanted variables of a database, in the wanted order of axes."""
    grid = {"omega": ("omega",), "wave_direction": ("wave_direction",)}
    try:
        return list(read_variables(path, {**grid, **wanted}, LABELS).values())
    except (OSError, KeyError, ValueError) as error:
        needed = ", ".join(f"{name}({', '.join(axes)})" for name, axes in wanted.items())
        raise ModelError(
            f"{path.name} is not a wave database ({error}); needed are the variables {needed} as "
            "Capytaine names them"
        ) from error


@lru_cache(maxsize=16)
def read_responses(path: Path, response: str) -> tuple[Array, Array, NDArray[np.complex128]]:
    """omega (n,), wave direction (m,) and complex response (n, m, entries) per metre amplitude."""
    variable, dof = RESPONSES[response]
    axes = ("complex", "omega", "wave_direction", dof)
    omega, direction, table = _variables(path, {variable: axes})
    order = np.argsort(omega)
    return omega[order], direction, (table[0] + 1j * table[1])[order]


@lru_cache(maxsize=16)
def _read_radiation(path: Path) -> tuple[Array, Array, Array]:
    """omega (n,), added mass and radiation damping (n, 6, 6), body axes FLU."""
    axes = ("omega", "radiating_dof", "influenced_dof")
    wanted = {"added_mass": axes, "radiation_damping": axes}
    omega, _, added, damping = _variables(path, wanted)
    order = np.argsort(omega)
    return omega[order], added[order], damping[order]


def _at(omega: Array, table: Array, wanted: Array) -> Array:
    """Rows of `table` (n, ...) at the wanted frequencies, linear between and held outside."""
    wanted = np.clip(wanted, omega[0], omega[-1])
    right = np.clip(np.searchsorted(omega, wanted), 1, len(omega) - 1)
    share = (wanted - omega[right - 1]) / (omega[right] - omega[right - 1])
    share = share.reshape(-1, *(1,) * (table.ndim - 1))
    return (1 - share) * table[right - 1] + share * table[right]


def motion(w: Array, M: Array, D: Array, G: Array, force: NDArray) -> NDArray[np.complex128]:
    """Motion (N, 6) `[-w^2 M - i w D + G]^-1 F` at frequencies w (N,) [rad/s] under forces (N, 6).

    Phasors `x(t) = Re(X exp(-i w t))`; M, D, G are (6, 6), or (N, 6, 6) where they depend on w.
    """
    w = w[:, None, None]
    return np.linalg.solve(-(w**2) * M - 1j * w * D + G, force[..., None])[..., 0]


def radiation(
    name: str, waves: WaveField, rigid: Array, restoring: Array, viscous: Array, yaw: float
) -> tuple[Array, Array]:
    """Constant added mass and radiation damping (6, 6), FLU, that serve one sea best.

    Radiation forces depend on frequency: the inertia that matters is that of the waves with most
    energy, the damping that of the resonances. Chosen are the two frequencies for each degree of
    freedom whose diagonal A and B give the response closest to that of the full
    frequency-dependent equations in this sea (least squares over the components), or the full
    matrices at the energy-weighted mean frequency where these are closer: in a regular wave they
    are exact.

    Args:
        name: wave database, see `database_path`.
        waves: wave field with at least one component.
        rigid: rigid-body inertia (6, 6) about the body origin.
        restoring: G (6, 6).
        viscous: linear damping (6, 6) beside radiation.
        yaw: heading of the body at the start, rad, NWU.

    Raises:
        ModelError: the database does not exist or lacks the radiation data.
    """
    omega, added, damping = _read_radiation(database_path(name))
    w = waves.omega
    force = responses(name, "force", waves, yaw).T
    M, D = rigid + _at(omega, added, w), viscous + _at(omega, damping, w)
    exact = motion(w, M, D, restoring, force)
    size = np.sqrt((np.abs(exact) ** 2).sum(axis=0))
    driven = size > 1e-9 * size.max()

    def error(A: Array, B: Array) -> float:
        wrong = motion(w, rigid + A, viscous + B, restoring, force) - exact
        return float(((np.abs(wrong) ** 2).sum(axis=0)[driven] / size[driven] ** 2).sum())

    energy = waves.amplitude**2
    center = np.array([w @ energy / max(energy.sum(), 1e-300)])
    at_center = _at(omega, added, center)[0], _at(omega, damping, center)[0]
    grid = np.linspace(omega[0], omega[-1], 48)
    choices = _at(omega, added, grid), _at(omega, damping, grid)
    A, B = np.zeros((6, 6)), np.zeros((6, 6))
    for dof in range(6):
        m, d, g = rigid[dof, dof], viscous[dof, dof], restoring[dof, dof]
        # without excitation (sway in head seas): as if every component pushed alike
        push = force[:, dof] if driven[dof] else waves.amplitude
        target = push / (g - w**2 * M[:, dof, dof] - 1j * w * D[:, dof, dof])
        a, b = choices[0][:, dof, dof, None, None], choices[1][:, dof, dof, None]
        response = push / (g - w**2 * (m + a) - 1j * w * (d + b))
        wrong = (np.abs(response - target) ** 2).sum(axis=-1)
        i, j = np.unravel_index(wrong.argmin(), wrong.shape)
        A[dof, dof], B[dof, dof] = choices[0][i, dof, dof], choices[1][j, dof, dof]
    if error(A, B) < error(*at_center):
        return A, B
    return tuple(0.5 * (matrix + matrix.T) for matrix in at_center)  # type: ignore[return-value]


def responses(name: str, response: str, waves: WaveField, yaw: float) -> NDArray[np.complex128]:
    """Complex response (6, N) of a body to each wave component, at its origin, heading frame.

    Strengths of the modes of a shelter database are (modes, N).

    `x_j(t) = Re sum_m X[j, m] exp(i theta_m(t))`, with `theta_m = k.x - omega t + phase` the
    phase of component m at the body origin (the amplitude is in X, the phase is not).

    Args:
        name: wave database, see `database_path`.
        response: "force" (wave excitation) or "diffraction" (its part beside the pressure of
            the undisturbed wave) [N, N m], "motion" [m, rad], or "shelter" [m/s].
        waves: wave field.
        yaw: heading of the body, rad, NWU.

    Raises:
        ModelError: the database does not exist or lacks the response.
    """
    omega, direction, table = read_responses(database_path(name), response)
    relative = np.mod(waves.direction - yaw, 2 * np.pi)
    # periodic in direction
    order = np.argsort(np.mod(direction, 2 * np.pi))
    angle = np.mod(direction, 2 * np.pi)[order]
    angle = np.concatenate([angle, [angle[0] + 2 * np.pi]])
    upper = np.clip(np.searchsorted(angle, relative, side="right"), 1, len(angle) - 1)
    share = (relative - angle[upper - 1]) / (angle[upper] - angle[upper - 1])
    columns = np.concatenate([order, order[:1]])
    # linear in frequency, held below the table (long waves), zero above it (short waves)
    right = np.clip(np.searchsorted(omega, waves.omega), 1, len(omega) - 1)
    fraction = np.clip(
        (waves.omega - omega[right - 1]) / (omega[right] - omega[right - 1]), 0.0, 1.0
    )
    result = np.zeros((table.shape[-1], len(waves.omega)), dtype=complex)
    for step, along in ((-1, 1 - fraction), (0, fraction)):
        for side, across in ((-1, 1 - share), (0, share)):
            values = table[right + step, columns[upper + side]]  # (N, entries)
            result += (along * across * values.T) * waves.amplitude
    return np.where(waves.omega > omega[-1] * (1 + 1e-9), 0.0, result)
