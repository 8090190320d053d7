"""Added mass of common sections and bodies: the tables of DNV-RP-C205 and DNV-RP-H103.

Unbounded fluid, no free surface. Between the rows the functions interpolate (PCHIP) in a variable
that holds the limit of the slenderest shape at a finite place; outside they refuse. Rows and digits
are those of DNV-RP-H103 (2011) app. A, except where a docstring says otherwise. The same rows stand
in DNV-RP-C205, app. D.
"""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
from scipy.interpolate import PchipInterpolator

from marine_mj.errors import ModelError
from marine_mj.hydrodynamics.estimates._checks import not_negative, positive

INF = float("inf")

#: `C_A` of long cylinders by half-breadth over half-height a/b; area pi a^2, motion along b.
SECTION_ROWS: Mapping[str, Mapping[float, float]] = MappingProxyType(
    {
        "rectangle": {
            0.1: 2.23, 0.2: 1.98, 0.5: 1.70, 1.0: 1.51, 2.0: 1.36, 5.0: 1.21, 10.0: 1.14, INF: 1.0,
        },
        "rhombus": {0.2: 0.61, 0.5: 0.67, 1.0: 0.76, 2.0: 0.85},
    }
)  # fmt: skip
#: `beta` of the added moment of inertia `beta rho pi l^4` of a rectangle, by long over short side.
RECTANGLE_INERTIA_ROWS = MappingProxyType(
    {1.0: 0.234, 2.0: 0.15, 5.0: 0.15, 10.0: 0.147, INF: 0.125}
)
#: `C_A` of a rectangular plate along its normal by long over short side; pi/4 short^2 long.
PLATE_ROWS = MappingProxyType(
    {
        1.0: 0.579, 1.25: 0.642, 1.5: 0.690, 1.59: 0.704, 2.0: 0.757, 2.5: 0.801, 3.0: 0.830,
        3.17: 0.840, 4.0: 0.872, 5.0: 0.897, 6.25: 0.917, 8.0: 0.934, 10.0: 0.947, INF: 1.0,
    }
)  # fmt: skip
#: `C_A` of a square prism along its axis by length over side; reference volume side^2 length.
PRISM_ROWS = MappingProxyType(
    {1.0: 0.68, 2.0: 0.36, 3.0: 0.24, 4.0: 0.19, 5.0: 0.15, 6.0: 0.13, 7.0: 0.11, 10.0: 0.08}
)
#: `C_A` of a circular cylinder across its axis by length over diameter; displaced volume.
CYLINDER_ROWS = MappingProxyType({1.2: 0.62, 2.5: 0.78, 5.0: 0.90, 9.0: 0.96, INF: 1.0})


def _share(ratio: float) -> float:
    """Ratio r in [0, inf] as r / (1 + r) in [0, 1]."""
    return 1.0 if ratio == INF else ratio / (1 + ratio)


def _interpolate(rows: Mapping[float, float], ratio: float, what: str) -> float:
    """Value of a table at a ratio.

    Raises:
        ModelError: the ratio is outside the table.
    """
    low, high = min(rows), max(rows)
    if not low <= ratio <= high:
        raise ModelError(
            f"{what} = {ratio:.4g} is outside the table, allowed is {low:g} to {high:g}"
        )
    curve = PchipInterpolator([_share(r) for r in rows], list(rows.values()))
    return float(curve(_share(ratio)))


def section_coefficient(shape: str, ratio: float = 1.0) -> float:
    """2-D added mass coefficient `C_A`, reference area `pi a^2`, of a long cylinder.

    Motion along the half-height `b`; `a` is the half-breadth across it.

    Args:
        shape: "circle", "ellipse", "plate", "cross" (all 1.0, exact), "rectangle" or "rhombus".
        ratio: a/b; rectangle 0.1 to infinity, rhombus 0.2 to 2. Not used by the other shapes.

    Rows and interpolation lie within 1 % of the exact values by conformal mapping.

    Raises:
        ModelError: unknown shape, or a ratio outside the table.
    """
    if shape in ("circle", "ellipse", "plate", "cross"):
        return 1.0
    if shape not in SECTION_ROWS:
        known = "circle, cross, ellipse, plate, rectangle, rhombus"
        raise ModelError(f"unknown section {shape!r}, available: {known}")
    return _interpolate(SECTION_ROWS[shape], ratio, f"a/b of the {shape}")


def section_added_mass(
    shape: str, half_breadth: float, half_height: float, density: float
) -> float:
    """Added mass per metre [kg/m] of a long cylinder: `rho C_A pi a^2`.

    Args:
        shape: as in `section_coefficient`.
        half_breadth: a, across the motion, m.
        half_height: b, along the motion, m; 0 for a plate.
        density: of the water, kg/m3.

    Raises:
        ModelError: a value is not allowed or the shape is outside its table.
    """
    positive(half_breadth=half_breadth, density=density)
    not_negative(half_height=half_height)
    ratio = half_breadth / half_height if half_height > 0 else INF
    return section_coefficient(shape, ratio) * density * np.pi * half_breadth**2


def finned_circle_added_mass(radius: float, span: float, density: float) -> float:
    """Added mass per metre [kg/m] of a circle with a pair of fins, motion across the fins.

    `rho pi s^2 (1 - (r/s)^2 + (r/s)^4)`, exact, with the radius r and the span s from the axis to a
    fin tip (DNV-RP-H103, table A-1; a cross of four fins has it in both directions). Along the fins
    a pair adds nothing: `rho pi r^2`.

    Raises:
        ModelError: the span is below the radius, or a value is not finite and above 0.
    """
    positive(radius=radius, span=span, density=density)
    if span < radius:
        raise ModelError(
            f"span = {span} m is below radius = {radius} m; it is measured from the axis"
        )
    part = (radius / span) ** 2
    return density * np.pi * span**2 * (1 - part + part**2)


def section_added_inertia(
    shape: str, half_breadth: float, half_height: float, density: float
) -> float:
    """Added moment of inertia per metre [kg m2/m] of a long cylinder about its centre line.

    Circle 0; ellipse `rho pi/8 (b^2 - a^2)^2`; plate `rho pi/8 a^4`; cross `2/pi rho a^4`;
    rectangle `beta rho pi l^4`, l the longer half-side. The beta rows are those commonly quoted of
    DNV-RP-H103, table A-1, 1 to 2.5 % above the exact values by conformal mapping. Interpolated
    is `beta / (1 + (s/l)^2)^2` over `((l - s) / (l + s))^2`, which is smooth at the square
    (within 3 % of the exact values).

    Args:
        shape: "circle", "ellipse", "plate", "cross" or "rectangle".
        half_breadth: a, m.
        half_height: b, m; 0 for a plate, not used by the cross (four arms of length a).
        density: of the water, kg/m3.

    Raises:
        ModelError: a value is not allowed or the shape is not in the table.
    """
    positive(half_breadth=half_breadth, density=density)
    not_negative(half_height=half_height)
    a, b = half_breadth, half_height
    if shape == "circle":
        return 0.0
    if shape == "ellipse":
        return density * np.pi / 8 * (b * b - a * a) ** 2
    if shape == "plate":
        return density * np.pi / 8 * a**4
    if shape == "cross":
        return density * 2 / np.pi * a**4
    if shape == "rectangle":
        long, short = max(a, b), min(a, b)
        rows = np.array([[1 / r, beta] for r, beta in RECTANGLE_INERTIA_ROWS.items()])
        flatness = ((1 - rows[:, 0]) / (1 + rows[:, 0])) ** 2
        curve = PchipInterpolator(flatness, rows[:, 1] / (1 + rows[:, 0] ** 2) ** 2)
        share = short / long
        beta = float(curve(((1 - share) / (1 + share)) ** 2)) * (1 + share**2) ** 2
        return beta * density * np.pi * long**4
    raise ModelError(
        f"no added inertia for section {shape!r}, available: circle, cross, ellipse, plate, "
        "rectangle"
    )


def cylinder_added_mass(radius: float, length: float, density: float) -> float:
    """Added mass [kg] of a flat-ended circular cylinder across its axis: `rho C_A pi r^2 L`.

    Length over diameter from 1.2 to infinity (DNV-RP-C205, app. D). Panel calculations agree to
    2 % up to 5 diameters and lie 3 % below the row at 9.

    Raises:
        ModelError: a value is not finite and above 0, or the cylinder is shorter.
    """
    positive(radius=radius, length=length, density=density)
    ratio = length / (2 * radius)
    coefficient = _interpolate(CYLINDER_ROWS, ratio, "length over diameter of the cylinder")
    return coefficient * density * np.pi * radius**2 * length


def square_prism_added_mass(side: float, length: float, density: float) -> float:
    """Added mass [kg] of a square prism along its axis: `rho C_A a^2 b`, a the side, b the length.

    Length over side from 1 (cube) to 10. Panel calculations lie 2 to 6 % below the rows (converged
    cube: 0.64 against 0.68). Interpolated is `C_A b/a`, which hardly changes with the length.

    Raises:
        ModelError: a value is not finite and above 0, or the prism is outside the table (flatter:
            between `rectangular_plate_added_mass` and the cube).
    """
    positive(side=side, length=length, density=density)
    ratio = length / side
    ends = {r: c * r for r, c in PRISM_ROWS.items()}
    return _interpolate(ends, ratio, "length over side of the prism") * density * side**3


def rectangular_plate_added_mass(length: float, breadth: float, density: float) -> float:
    """Added mass [kg] along the normal of a thin rectangular plate: `rho C_A pi/4 a^2 b`.

    `a` is the shorter and `b` the longer of the two sides [m], in any order.

    Raises:
        ModelError: a value is not finite and above 0.
    """
    positive(length=length, breadth=breadth, density=density)
    a, b = min(length, breadth), max(length, breadth)
    coefficient = _interpolate(PLATE_ROWS, b / a, "b/a of the plate")
    return coefficient * density * np.pi / 4 * a**2 * b
