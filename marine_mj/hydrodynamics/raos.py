"""Response tables of floating bodies: a wave database looked up for a given sea."""

from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import marine_mj.assets
from marine_mj.environment import WaveField
from marine_mj.errors import ModelError
from marine_mj.frames import Array

#: Database variable of each response, with its dof dimension.
RESPONSES = {"force": ("excitation_force", "influenced_dof"), "motion": ("RAO", "radiating_dof")}
DOFS = ["Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw"]


def database_path(name: str) -> Path:
    """File of a wave database: a path, or a name in the package's assets.

    Raises:
        ModelError: there is no such file; the message lists the databases of the package.
    """
    assets = Path(marine_mj.assets.__file__).parent
    for path in (Path(name), assets / name):
        if path.is_file():
            return path.resolve()
    raise ModelError(
        f"wave database {name!r} does not exist; the package has "
        f"{sorted(p.name for p in assets.glob('*.nc'))}, any other needs its path"
    )


def _variables(path: Path, wanted: Mapping[str, tuple[str, ...]]) -> list[Array]:
    """omega, wave_direction and the wanted variables of a database, in the wanted order of axes."""
    import xarray as xr  # here: it doubles the time that `import marine_mj` takes

    try:
        with xr.open_dataset(path, engine="h5netcdf") as data:
            found = []
            for name, axes in wanted.items():
                order = {axis: DOFS for axis in axes if axis.endswith("_dof")}
                found.append(np.asarray(data[name].sel(order).transpose(*axes), dtype=float))
            return [data["omega"].values, data["wave_direction"].values, *found]
    except (OSError, KeyError, ValueError) as error:
        needed = ", ".join(f"{name}({', '.join(axes)})" for name, axes in wanted.items())
        raise ModelError(
            f"{path.name} is not a wave database ({error}); needed are the variables {needed} as "
            "Capytaine names them"
        ) from error


@lru_cache(maxsize=16)
def _read(path: Path, response: str) -> tuple[Array, Array, NDArray[np.complex128]]:
    """omega (n,), wave direction (m,) and complex response (n, m, 6), per metre of amplitude."""
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


def radiation(name: str, waves: WaveField) -> tuple[Array, Array]:
    """Added mass and radiation damping (6, 6), FLU, at the energy-weighted mean frequency of a sea.

    The constant-coefficient approximation of the frequency-dependent radiation forces: exact for a
    regular wave, good for a narrow spectrum.
    """
    omega, added, damping = _read_radiation(database_path(name))
    energy = waves.amplitude**2
    center = float(waves.omega @ energy / max(energy.sum(), 1e-300))
    center = float(np.clip(center, omega[0], omega[-1]))
    right = int(np.clip(np.searchsorted(omega, center), 1, len(omega) - 1))
    share = (center - omega[right - 1]) / (omega[right] - omega[right - 1])
    pair = [(1 - share) * table[right - 1] + share * table[right] for table in (added, damping)]
    return 0.5 * (pair[0] + pair[0].T), 0.5 * (pair[1] + pair[1].T)


def responses(name: str, response: str, waves: WaveField, yaw: float) -> NDArray[np.complex128]:
    """Complex response (6, N) of a body to each wave component, at its origin, heading frame.

    `x_j(t) = Re sum_m X[j, m] exp(i theta_m(t))`, with `theta_m = k.x - omega t + phase` the
    phase of component m at the body origin (the amplitude is in X, the phase is not).

    Args:
        name: wave database, see `database_path`.
        response: "force" [N, N m] or "motion" [m, rad].
        waves: wave field.
        yaw: heading of the body, rad, NWU.

    Raises:
        ModelError: the database does not exist or lacks the response.
    """
    omega, direction, table = _read(database_path(name), response)
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
    result = np.zeros((6, len(waves.omega)), dtype=complex)
    for step, along in ((-1, 1 - fraction), (0, fraction)):
        for side, across in ((-1, 1 - share), (0, share)):
            values = table[right + step, columns[upper + side]]  # (N, 6)
            result += (along * across * values.T) * waves.amplitude
    return np.where(waves.omega > omega[-1] * (1 + 1e-9), 0.0, result)
