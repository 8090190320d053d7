"""Response tables of floating bodies: a wave database looked up for a given sea."""

from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from marine_mj.environment import WaveField, wavenumber
from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.hydrodynamics.harmonics import (
    harmonics,
    highest_harmonic,
    lagrange_count,
    orders,
    round_step,
    unresolved,
)
from marine_mj.hydrodynamics.netcdf import read_variables
from marine_mj.hydrodynamics.wave_file import (
    Circle,
    HullSymmetry,
    circle_of,
    density_ratio,
    facts,
)
from marine_mj.library import assets_folder, find_asset

#: Database variable of each response, with the dimension of its entries.
RESPONSES = {
    "force": ("excitation_force", "influenced_dof"),
    "diffraction": ("diffraction_force", "influenced_dof"),
    "motion": ("RAO", "radiating_dof"),
    "shelter": ("shelter_strength", "mode"),
}
DOFS = ["Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw"]
#: Power of the wavenumber with which a response falls below the lowest frequency, where the body
#: follows the water. Heave force is the waterplane's stiffness, all others go with the slope of the
#: surface (Newman 1977, Marine Hydrodynamics, sec. 6.17); the disturbance of the hull goes with the
#: water's acceleration, so the velocities near it with one more power of omega.
LONG_WAVES = {
    "force": (1, 1, 0, 1, 1, 1),
    "diffraction": (1, 1, 1, 1, 1, 1),
    "motion": (0, 0, 0, 1, 1, 1),
    "shelter": (1,),
}
#: Error of `heading_count`, of the largest value of each axis: a third of what the loads between
#: the directions of a file may be wrong by.
HEADING_ERROR = 0.003
#: Estimated error above which directions are too coarse, of the largest value of each axis.
COARSE = 0.01
#: Entries of the axes of a wave database, in our order.
LABELS = {"radiating_dof": DOFS, "influenced_dof": DOFS}


def database_path(name: str) -> Path:
    """File of a wave database: a path, or a name in the package's assets.

    Raises:
        ModelError: there is no such file; the message lists the databases of the package.
    """
    path = find_asset(str.__str__(name))  # a path takes plain texts only
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


@lru_cache(maxsize=32)
def _read(
    path: Path, response: str, symmetry: HullSymmetry | None
) -> tuple[Array, Circle, NDArray[np.complex128]]:
    """omega (n,), directions all around and response (n, directions, entries); read once."""
    variable, dof = RESPONSES[response]
    axes = ("complex", "omega", "wave_direction", dof)
    omega, direction, table = _variables(path, {variable: axes})
    order = np.argsort(omega)
    order = order[np.isfinite(omega[order]) & (omega[order] > 0)]  # no waves at 0 and infinity
    rigid = dof in LABELS
    circle = circle_of(path, direction, symmetry, mirrors=rigid)
    values = circle.take((table[0] + 1j * table[1])[order], tuple(range(6)) if rigid else None)
    if not np.isfinite(values).all():
        raise ModelError(f"{variable} in {path.name} holds NaN or infinity; allowed is finite")
    return omega[order], circle, values


def read_responses(
    path: Path, response: str, symmetry: HullSymmetry | None = None
) -> tuple[Array, Array, NDArray[np.complex128]]:
    """omega (n,), wave direction (m,) and complex response (n, m, entries) per metre amplitude.

    Directions are all around and rise from 0, rad: a file that covers half of the circle is
    mirrored by the symmetry of its hull. In the water of the file.

    Raises:
        ModelError: the file is no wave database, or see `wave_file.circle_of`.
    """
    omega, circle, values = _read(path, response, symmetry)
    return omega, circle.angle, values


@lru_cache(maxsize=32)
def _harmonics(
    path: Path, response: str, symmetry: HullSymmetry | None
) -> tuple[Array, NDArray[np.complex128]]:
    """omega (n,) and harmonics (n, 2 M + 1, entries) of a response over the direction."""
    omega, circle, values = _read(path, response, symmetry)
    return omega, harmonics(circle, values)


@lru_cache(maxsize=32)
def _heading_count(path: Path, response: str, symmetry: HullSymmetry | None) -> int:
    """See `heading_count`."""
    found = _harmonics(path, response, symmetry)[1]
    return lagrange_count(found, HEADING_ERROR, response == "shelter")


def heading_count(name: str, response: str) -> int:
    """Number of equally spaced headings at which a response has to be tabulated.

    The smallest of `harmonics.HEADING_COUNTS` at which cubic Lagrange interpolation through the
    four nearest headings stays within `HEADING_ERROR` of the largest value of each axis (of all
    modes of a shelter), for every frequency of the file. It depends on the file (and its symmetry)
    only, not on the sea.

    Args:
        name: wave database, see `database_path`.
        response: as in `responses`.

    Raises:
        ModelError: the database does not exist or lacks the response.
    """
    return _heading_count(database_path(name), response, getattr(name, "hull_symmetry", None))


@lru_cache(maxsize=32)
def _coarse(path: Path, response: str, symmetry: HullSymmetry | None) -> str:
    """See `coarse_directions`."""
    omega, circle, values = _read(path, response, symmetry)
    error = unresolved(circle, values, response == "shelter")
    fine = error <= COARSE
    if fine.all():
        return ""
    depth, gravity = facts(path).depth or np.inf, facts(path).gravity or 9.81
    k = np.asarray(wavenumber(omega, depth, gravity))
    last = int(np.flatnonzero(fine).max(initial=-1))
    radius = facts(path).radius
    if radius:
        step = 180.0 / highest_harmonic(float(k[-1]), radius)
    else:  # as many directions per wave length as where they are enough
        step = np.degrees(circle.gap) * (k[last] / k[-1] if last >= 0 else 0.5)
    step = min(step, 0.9 * float(np.degrees(circle.gap)))
    until = f"enough up to {omega[last]:.3g} rad/s" if last >= 0 else "too few at all frequencies"
    return (
        f"{RESPONSES[response][0]} in {path.name} has wave directions up to "
        f"{np.degrees(circle.gap):.3g} deg apart, {until}; at {omega[int(error.argmax())]:.3g} "
        f"rad/s about {100 * error.max():.2g} % of the largest value is lost between them: compute "
        f"it every {round_step(step):g} deg"
    )


def coarse_directions(name: str, response: str) -> str:
    """What is wrong with the directions of a response between which loads are lost; "": nothing.

    The step that is needed comes from the hull's size, if the file states it (or its
    `hydrostatic_stiffness`).

    Args and Raises: see `heading_count`.
    """
    return _coarse(database_path(name), response, getattr(name, "hull_symmetry", None))


@lru_cache(maxsize=16)
def _read_radiation(path: Path) -> tuple[Array, Array, Array]:
    """omega (n,), added mass and radiation damping (n, 6, 6), body axes FLU."""
    axes = ("omega", "radiating_dof", "influenced_dof")
    wanted = {"added_mass": axes, "radiation_damping": axes}
    omega, _, added, damping = _variables(path, wanted)
    order = np.argsort(omega)
    order = order[np.isfinite(omega[order]) & (omega[order] > 0)]
    for name, table in (("added_mass", added), ("radiation_damping", damping)):
        if not np.isfinite(table[order]).all():
            raise ModelError(
                f"{name} of {path.name} holds numbers that are not finite, allowed are finite "
                "ones: compute the database again"
            )
    return omega[order], added[order], damping[order]


def _at(omega: Array, table: NDArray, wanted: Array) -> NDArray:
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
    path = database_path(name)
    omega, added, damping = _read_radiation(path)
    ratio = density_ratio(name, path)
    added, damping = ratio * added, ratio * damping
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


def responses(
    name: str, response: str, waves: WaveField, yaw: float | Array
) -> NDArray[np.complex128]:
    """Complex response (6, N) of a body to each wave component, at its origin, heading frame.

    Strengths of the modes of a shelter database are (modes, N). For headings (h,) the result has
    one more axis in front, and takes little longer than for one.

    `x_j(t) = Re sum_m X[j, m] exp(i theta_m(t))`, with `theta_m = k.x - omega t + phase` the
    phase of component m at the body origin (the amplitude is in X, the phase is not).

    Over the direction the response is the trigonometric polynomial of the file's directions
    (`harmonics`). Over the frequency it is linear; zero above the table (short waves); below it
    that of long waves (`LONG_WAVES`). Forces are those in the density of the water that `name`
    carries (`wave_file.WaveDatabase`), without one in that of the file.

    Args:
        name: wave database, see `database_path`.
        response: "force" (wave excitation) or "diffraction" (its part beside the pressure of
            the undisturbed wave) [N, N m], "motion" [m, rad], or "shelter" [m/s].
        waves: wave field.
        yaw: heading of the body, rad, NWU; a number, or (h,).

    Raises:
        ModelError: the database does not exist or lacks the response.
    """
    path = database_path(name)
    omega, coefficients = _harmonics(path, response, getattr(name, "hull_symmetry", None))
    m = orders(coefficients)
    factor = waves.amplitude * np.where(waves.omega > omega[-1] * (1 + 1e-9), 0.0, 1.0)
    if response in ("force", "diffraction"):
        factor = factor * density_ratio(name, path)
    # (entries, 2 M + 1, N), turned to the directions of the waves
    table = _at(omega, coefficients, waves.omega).transpose(2, 1, 0)
    table = table * np.exp(1j * np.outer(m, waves.direction))
    table *= (factor[:, None] * _long_waves(response, omega[0], waves, len(table))).T[:, None]
    turn = np.exp(-1j * np.outer(np.atleast_1d(yaw), m))
    # one small product per heading and entry: no threads, and one heading has the bits of many
    found = (turn[:, None, None, :] @ np.ascontiguousarray(table))[:, :, 0]
    return np.asarray(found if np.ndim(yaw) else found[0], dtype=complex)


def _long_waves(response: str, lowest: float, waves: WaveField, entries: int) -> Array:
    """Factors (N, entries) on the response at the lowest frequency for waves below it."""
    below = waves.omega < lowest
    factor = np.ones((len(waves.omega), entries))
    if below.any():
        k = float(wavenumber(lowest, waves.depth, waves.gravity))
        ratio = waves.wavenumber[below] / k
        factor[below] = ratio[:, None] ** np.array(LONG_WAVES[response])
        if response == "shelter":
            factor[below] *= (waves.omega[below] / lowest)[:, None]
    return factor
