"""From a model to the ship and back: Froude and Reynolds similarity."""

import math
from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.hydrodynamics.estimates._checks import positive

#: Exponent of the speed by law: speeds go with scale^(1/2) (waves) or scale^-1 (same water).
SPEED = MappingProxyType({"froude": 0.5, "reynolds": -1.0})
#: Exponents (mass, length, speed) of a quantity, as in density * length^3 ~ (1, 3, 0).
QUANTITIES: Mapping[str, tuple[int, int, int]] = MappingProxyType(
    {
        "length": (0, 1, 0),
        "area": (0, 2, 0),
        "volume": (0, 3, 0),
        "angle": (0, 0, 0),
        "speed": (0, 0, 1),
        "time": (0, 1, -1),
        "frequency": (0, -1, 1),
        "angular_rate": (0, -1, 1),
        "acceleration": (0, -1, 2),
        "angular_acceleration": (0, -2, 2),
        "mass": (1, 3, 0),
        "inertia": (1, 5, 0),
        "force": (1, 2, 2),
        "moment": (1, 3, 2),
        "pressure": (1, 0, 2),
        "energy": (1, 3, 2),
        "power": (1, 2, 3),
    }
)
#: What a 6x6 matrix multiplies: the quantities of a translation and a rotation, and their power.
MATRICES: Mapping[str, tuple[str, str, int]] = MappingProxyType(
    {
        "added_mass": ("acceleration", "angular_acceleration", 1),
        "linear_damping": ("speed", "angular_rate", 1),
        "quadratic_damping": ("speed", "angular_rate", 2),
        "restoring": ("length", "angle", 1),
    }
)


def reynolds_number(speed: float, length: float, viscosity: float) -> float:
    """Reynolds number `|u| L / nu`: m/s, m, kinematic viscosity in m2/s.

    Raises:
        ModelError: length or viscosity is not finite and above 0, or the speed is not finite.
    """
    positive(length=length, viscosity=viscosity)
    if not math.isfinite(speed):
        raise ModelError(f"speed = {speed} m/s is not finite")
    return abs(speed) * length / viscosity


def froude_number(speed: float, length: float, gravity: float = 9.81) -> float:
    """Froude number `|u| / sqrt(g L)` (m/s, m, m/s2).

    Raises:
        ModelError: length or gravity is not finite and above 0, or the speed is not finite.
    """
    positive(length=length, gravity=gravity)
    if not math.isfinite(speed):
        raise ModelError(f"speed = {speed} m/s is not finite")
    return abs(speed) / math.sqrt(gravity * length)


def _law(law: str) -> float:
    """Exponent of the speed.

    Raises:
        ModelError: unknown law.
    """
    if law not in SPEED:
        raise ModelError(f"unknown similarity law {law!r}, available: {', '.join(SPEED)}")
    return SPEED[law]


def scale_factor(
    quantity: str, scale: float, law: str = "froude", density_ratio: float = 1.0
) -> float:
    """Factor from the small body's quantity to that of a body `scale` times as long.

    Froude: speed and time with `scale^0.5`, force `scale^3`, moment `scale^4`. Reynolds (same
    water): speed `scale^-1`, time `scale^2`, force 1, moment `scale`. Forces and masses also with
    the density ratio. `scale_factor(q, 1 / scale)` goes back.

    Args:
        quantity: "length", "area", "volume", "angle", "speed", "time", "frequency",
            "angular_rate", "acceleration", "angular_acceleration", "mass", "inertia", "force",
            "moment", "pressure", "energy" or "power".
        scale: length of the wanted body over that of the given one.
        law: "froude" (gravity, waves) or "reynolds" (viscosity).
        density_ratio: density of the wanted body's water over that of the given one's.

    Raises:
        ModelError: unknown quantity or law, or a ratio that is not finite and above 0.
    """
    positive(scale=scale, density_ratio=density_ratio)
    if quantity not in QUANTITIES:
        raise ModelError(f"unknown quantity {quantity!r}, available: {', '.join(QUANTITIES)}")
    mass, length, speed = QUANTITIES[quantity]
    return float(density_ratio**mass * scale ** (length + speed * _law(law)))


def scale_matrix(
    matrix: ArrayLike, kind: str, scale: float, law: str = "froude", density_ratio: float = 1.0
) -> Array:
    """6x6 coefficients of a body `scale` times as long, from those of the given one.

    Each block by its own unit: under Froude's law added mass goes with `scale^3`, `^4`, `^5` (kg,
    kg m, kg m2), linear damping with `scale^2.5`, `^3.5`, `^4.5`, quadratic damping with `scale^2`,
    `^3` or `^4`, `^5`, restoring with `scale^2`, `^3`, `^4`.

    Args:
        matrix: (6, 6) or diagonal (6,), SNAME order, any axes, about the same point of the body.
        kind: "added_mass" (also rigid-body inertia), "linear_damping", "quadratic_damping" or
            "restoring" (Froude only).
        scale, law, density_ratio: as in `scale_factor`.

    Returns:
        Same shape as `matrix`.

    Raises:
        ModelError: unknown kind or law, a ratio that is not allowed, or another shape.
    """
    if kind not in MATRICES:
        raise ModelError(f"unknown kind {kind!r}, available: {', '.join(MATRICES)}")
    if kind == "restoring" and law == "reynolds":
        raise ModelError("restoring does not follow Reynolds' law: it comes from gravity")
    values = np.asarray(matrix, dtype=float)
    if values.shape not in ((6,), (6, 6)):
        raise ModelError(f"matrix has shape {values.shape}, allowed are (6,) and (6, 6)")
    linear, angular, power = MATRICES[kind]

    def factors(first: str, second: str) -> Array:
        pair = [scale_factor(name, scale, law, density_ratio) for name in (first, second)]
        return np.repeat(pair, 3)

    moving = np.array([scale_factor(name, scale, law) for name in (linear, angular)])
    table = factors("force", "moment")[:, None] / np.repeat(moving, 3)[None, :] ** power
    return values * (table.diagonal() if values.shape == (6,) else table)
