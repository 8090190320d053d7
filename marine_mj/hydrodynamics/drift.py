"""Mean wave drift of a body in a given sea, from its database or its vehicle file."""

from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from marine_mj.environment import Environment
from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.hydrodynamics.coefficients import BodyCoefficients
from marine_mj.hydrodynamics.netcdf import read_variables
from marine_mj.hydrodynamics.raos import database_path
from marine_mj.hydrodynamics.wave_file import HullSymmetry, circle_of, density_ratio

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

Drift = Literal["none", "mean", "slow"]
VARIABLE = "mean_drift_force"
_DOFS = ["Surge", "Sway", "Yaw"]
_AXES = ("omega", "wave_direction", "drift_dof")
#: Numbers of the degrees of freedom of drift among the six.
_PLACES = (0, 1, 5)


@lru_cache(maxsize=16)
def _read(path: Path, symmetry: HullSymmetry | None) -> "tuple[Array, CubicSpline] | None":
    """omega (n,) and drift (n, 3) as a function of the direction; None if there is no drift."""
    from scipy.interpolate import CubicSpline  # here: it takes a quarter of a second

    try:
        grid = {axis: (axis,) for axis in _AXES[:2]}
        wanted = {**grid, VARIABLE: _AXES}
        data = read_variables(path, wanted, {"drift_dof": _DOFS}, optional=wanted)
        if VARIABLE not in data:
            return None
        omega, direction, table = (data[name] for name in wanted)
    except (OSError, KeyError, ValueError) as error:
        raise ModelError(
            f"{path.name} has no mean drift that can be read ({error}); needed is the variable "
            f"{VARIABLE}({', '.join(_AXES)}) with the drift_dof {', '.join(_DOFS)}"
        ) from error
    order = np.argsort(omega)
    omega, table = omega[order], table[order]
    if not np.isfinite(table).all():
        raise ModelError(f"{VARIABLE} in {path.name} holds NaN or infinity; allowed is finite")
    circle = circle_of(path, direction, symmetry)
    knots = np.append(circle.angle, circle.angle[0] + 2 * np.pi)
    table = circle.take(table, _PLACES)
    around = np.concatenate([table, table[:, :1]], axis=1)
    omega, around = _from_zero(omega, around)
    return omega, CubicSpline(knots, np.moveaxis(around, 1, 0), bc_type="periodic")


def _of_file(name: str) -> "tuple[Array, CubicSpline] | None":
    """Drift of a wave database in the water of its file; None if it has none."""
    return _read(database_path(name), getattr(name, "hull_symmetry", None))


def drift_of(body: BodyCoefficients, drift: Drift | None, motion: str) -> Drift:
    """The drift a body gets.

    Without a setting (None) "slow" where `body` has drift coefficients or is "dynamic" with a
    database that holds `mean_drift_force`, else "none".

    Raises:
        ModelError: drift is asked for without coefficients or with prescribed motion.
    """
    prescribed = motion in ("rao", "fixed")
    if drift == "none" or (drift is None and prescribed):
        return "none"
    if prescribed:
        raise ModelError(
            f"drift {drift!r} of {body.name!r} with motion {motion!r}: prescribed motion gives way "
            "to no force; allowed is drift 'none', or another motion"
        )
    given = body.drift is not None
    if not given and body.wave_database and (drift or motion == "dynamic"):
        given = _of_file(body.wave_database) is not None
    if drift is None:
        return "slow" if given else "none"
    if not given:
        raise ModelError(
            f"drift {drift!r} of {body.name!r} needs coefficients; allowed is 'none', or a "
            f"<numeric name='{body.name}.drift' .../>, or a wave database with {VARIABLE}"
        )
    return drift


def _from_zero(omega: Array, table: Array) -> tuple[Array, Array]:
    """Frequencies and rows with a row of zeros at omega = 0 in front: long waves pass by."""
    return np.append(0.0, omega), np.concatenate([np.zeros_like(table[:1]), table])


def _between(omega: Array, wanted: Array) -> tuple[NDArray[np.intp], Array]:
    """Upper row and its share (N, 1) at the wanted frequencies, linear, held above the last."""
    wanted = np.minimum(wanted, omega[-1])
    upper = np.clip(np.searchsorted(omega, wanted), 1, len(omega) - 1)
    return upper, ((wanted - omega[upper - 1]) / (omega[upper] - omega[upper - 1]))[:, None]


def mean_drift(body: BodyCoefficients, environment: Environment, yaw: float) -> Array:
    """Mean drift T (3, N) [N/m2, N/m2, N m/m2] of each wave component: surge, sway, yaw.

    A component of amplitude a alone pushes with `a^2 T`, in the level axes of the heading (x
    forward, y port), moment about the body origin. Coefficients of the vehicle file come before
    the database. With chi the direction of travel relative to the heading, those of the file give

        T = 1/2 rho g (D_x c|c|, D_y s|s|, D_n sin 2 chi),   c = cos chi, s = sin chi

    (Faltinsen 1990, Sea Loads, sec. 5: short waves push a wall with 1/2 rho g a^2 sin^2 per metre
    of its length): D_x and D_y are the breadth and the length times the square of the reflection
    coefficient, m, and D_n the couple, m2. Between frequencies T is linear, falling to 0 at omega
    = 0 below the first and held above the last. Between directions of a database it is a periodic
    cubic spline; that of half a circle is mirrored by the symmetry of the hull, and its drift is
    that in the environment's density.

    Args:
        body: with `drift` or a database that holds `mean_drift_force`, see `drift_of`.
        environment: waves, density of the water and gravity.
        yaw: heading of the body, rad, NWU.

    Raises:
        ModelError: the database has no drift.
    """
    waves = environment.waves
    chi = waves.direction - yaw
    if body.drift is not None:
        c, s = np.cos(chi), np.sin(chi)
        shape = np.stack([c * np.abs(c), s * np.abs(s), 2 * s * c])
        omega, table = _from_zero(body.drift[:, 0], body.drift[:, 1:])
        upper, share = _between(omega, waves.omega)
        widths = (1 - share) * table[upper - 1] + share * table[upper]
        return 0.5 * environment.water_density * environment.gravity * shape * widths.T
    path = database_path(str(body.wave_database))
    found = _of_file(str(body.wave_database))
    if found is None:
        raise ModelError(f"{path.name} has no {VARIABLE}: add it, or set drift to 'none'")
    omega, spline = found
    upper, share = _between(omega, waves.omega)
    start = spline.x[0]
    table = spline(start + np.mod(chi - start, 2 * np.pi))  # (N, frequencies, 3)
    each = np.arange(len(chi))
    drift = (1 - share) * table[each, upper - 1] + share * table[each, upper]
    return density_ratio(str(body.wave_database), path) * drift.T
