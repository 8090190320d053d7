"""Drag of sections and hulls: quadratic drag, Morison, Hoerner's cross-flow, ITTC 1957."""

import numpy as np
from numpy.typing import ArrayLike

from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.hydrodynamics.estimates._checks import not_negative, positive
from marine_mj.hydrodynamics.estimates.scaling import reynolds_number

#: Hoerner's 2-D cross-flow drag coefficient of a ship section by B/(2T), read from the curve.
HOERNER_ROWS = np.array(
    [
        [0.0108623, 1.96608],
        [0.176606, 1.96573],
        [0.353025, 1.89756],
        [0.451863, 1.78718],
        [0.472838, 1.58374],
        [0.492877, 1.27862],
        [0.493252, 1.21082],
        [0.558473, 1.08356],
        [0.646401, 0.998631],
        [0.833589, 0.87959],
        [0.988002, 0.828415],
        [1.30807, 0.759941],
        [1.63918, 0.691442],
        [1.85998, 0.657076],
        [2.31288, 0.630693],
        [2.59998, 0.596186],
        [3.00877, 0.586846],
        [3.45075, 0.585909],
        [3.7379, 0.559877],
        [4.00309, 0.559315],
    ]
)
#: Reynolds number below which a hull has no turbulent boundary layer to speak of.
LOWEST_REYNOLDS = 1e4


def quadratic_drag(drag_coefficient: float, size: float, density: float) -> float:
    """Coefficient of `F = -D |u| u`: `1/2 rho C_D size`.

    Args:
        drag_coefficient: C_D for that size.
        size: reference area, m2: D in N s2/m2 (an entry of `quadratic_damping`); or the width of a
            section, m: D per metre of length in N s2/m3 (`strip_drag_frd`, `cross_flow_damping`).
        density: of the water, kg/m3.

    Raises:
        ModelError: a value is negative or not finite.
    """
    not_negative(drag_coefficient=drag_coefficient, size=size)
    positive(density=density)
    return 0.5 * density * drag_coefficient * size


def morison_force(
    water_velocity: ArrayLike,
    water_acceleration: ArrayLike,
    body_velocity: ArrayLike = 0.0,
    body_acceleration: ArrayLike = 0.0,
    *,
    diameter: float,
    drag_coefficient: float,
    added_mass_coefficient: float,
    density: float,
) -> Array:
    """Force per metre [N/m] across a circular cylinder that moves in moving water.

        f = 1/2 rho C_D d |u - v| (u - v) + rho A (1 + C_A) du/dt - rho A C_A dv/dt,  A = pi d^2 / 4

    (DNV-RP-C205, sec. 6.2; u water, v body, along one axis across the cylinder.) For checks and
    small structures: vehicles of the package get these terms from the coefficients in the model.

    Args:
        water_velocity, water_acceleration, body_velocity, body_acceleration: m/s and m/s2, arrays
            that broadcast.
        diameter: d, m.
        drag_coefficient: C_D.
        added_mass_coefficient: C_A (inertia coefficient minus one).
        density: of the water, kg/m3.

    Raises:
        ModelError: diameter or density is not above 0, or a coefficient is negative.
    """
    positive(diameter=diameter)
    not_negative(added_mass_coefficient=added_mass_coefficient)
    drag = quadratic_drag(drag_coefficient, diameter, density)
    mass = density * np.pi / 4 * diameter**2
    u, du, v, dv = (
        np.asarray(value, dtype=float)
        for value in (water_velocity, water_acceleration, body_velocity, body_acceleration)
    )
    relative = u - v
    inertia = mass * ((1 + added_mass_coefficient) * du - added_mass_coefficient * dv)
    return drag * np.abs(relative) * relative + inertia


def hoerner_cross_flow_coefficient(beam: float, draught: float) -> float:
    """2-D cross-flow drag coefficient of a ship section in sway, for the area draught x length.

    Linear in B/(2T) between the points of Hoerner's curve (Fluid-Dynamic Drag, 1965) as digitized
    in the Marine Systems Simulator, B/(2T) from 0.0109 to 4.003.

    Args:
        beam: B at the water line, m.
        draught: T, m.

    Raises:
        ModelError: a value is not finite and above 0, or B/(2T) is outside the curve; the message
            gives the value at its end.
    """
    positive(beam=beam, draught=draught)
    ratio = beam / (2 * draught)
    (low, first), (high, last) = HOERNER_ROWS[0], HOERNER_ROWS[-1]
    if not low <= ratio <= high:
        raise ModelError(
            f"B/(2T) = {ratio:.4g} is outside Hoerner's curve, allowed is {low:.4g} to {high:.4g}; "
            f"its value at that end is {first if ratio < low else last:.4g}"
        )
    return float(np.interp(ratio, HOERNER_ROWS[:, 0], HOERNER_ROWS[:, 1]))


def ittc57_friction(reynolds: float) -> float:
    """Friction coefficient of the ITTC 1957 line: `C_F = 0.075 / (log10 Re - 2)^2`.

    For turbulent flow, with the wetted surface; below Re = 5e5 a smooth hull may be partly laminar
    and then drags less.

    Raises:
        ModelError: the Reynolds number is below 1e4 or not finite.
    """
    if not (np.isfinite(reynolds) and reynolds >= LOWEST_REYNOLDS):
        raise ModelError(
            f"Reynolds number {reynolds:.4g} is outside the ITTC 1957 line, allowed is "
            f"{LOWEST_REYNOLDS:g} and above"
        )
    return float(0.075 / (np.log10(reynolds) - 2) ** 2)


def streamlined_form_factor(diameter: float, length: float) -> float:
    """Form factor `1 + k = 1 + 1.5 (D/L)^1.5 + 7 (D/L)^3` of a streamlined body (Hoerner 1965).

    Diameter and length in m. It is for bodies with a pointed tail; a flat one adds base drag.

    Raises:
        ModelError: a value is not finite and above 0, or the body is wider than long.
    """
    positive(diameter=diameter, length=length)
    ratio = diameter / length
    if ratio > 1:
        raise ModelError(f"diameter = {diameter} m is above length = {length} m")
    return 1 + 1.5 * ratio**1.5 + 7 * ratio**3


def hull_resistance(
    speed: float,
    length: float,
    wetted_surface: float,
    density: float,
    viscosity: float,
    *,
    form_factor: float = 1.0,
    allowance: float = 0.0,
) -> float:
    """Viscous resistance [N] of a hull, with the sign of the speed (it acts against it).

    `R = 1/2 rho S ((1 + k) C_F + dC_F) |u| u` with C_F of `ittc57_friction`; no waves.

    Args:
        speed: u through the water, m/s; 0 gives 0.
        length: for the Reynolds number, m.
        wetted_surface: S, m2.
        density: of the water, kg/m3.
        viscosity: kinematic, m2/s.
        form_factor: 1 + k.
        allowance: dC_F for roughness and model-ship correlation.

    Raises:
        ModelError: a value is not allowed, or the Reynolds number is above 0 and below 1e4.
    """
    positive(wetted_surface=wetted_surface, density=density, form_factor=form_factor)
    not_negative(allowance=allowance)
    reynolds = reynolds_number(speed, length, viscosity)
    if reynolds == 0:
        return 0.0
    coefficient = form_factor * ittc57_friction(reynolds) + allowance
    return 0.5 * density * wetted_surface * coefficient * abs(speed) * speed
