"""Added mass of ellipsoids, spheres and thin plates: closed forms of potential flow.

Deeply submerged bodies in an unbounded ideal fluid. Matrices are (6, 6) about the body's centre in
SNAME order [surge, sway, heave, roll, pitch, yaw], positive (`M_A = -X_udot ...`), in kg and kg m2;
a diagonal one is the same in FRD and FLU axes. Take a matrix to another origin with
`move_added_mass`.
"""

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ellipe, elliprd

from marine_mj.errors import ModelError
from marine_mj.frames import Array, skew
from marine_mj.hydrodynamics.estimates._checks import positive


def ellipsoid_coefficients(a: float, b: float, c: float) -> Array:
    """Dimensionless added mass (6,) of an ellipsoid with semi-axes `a, b, c` [m] along x, y, z.

    The first three are `M_A / (rho V)`; the last three `M_A / I` with `I` the moment of inertia of
    the displaced water, e.g. `rho V (b^2 + c^2) / 5` about x. With Lamb's integrals (`2/3 a b c`
    times Carlson's R_D) alpha, beta, gamma along x, y, z

        alpha = a b c int_0^inf du / ((a^2 + u) sqrt((a^2 + u) (b^2 + u) (c^2 + u)))

    `k = alpha / (2 - alpha)` along x and, about x,

        k = (b^2 - c^2)^2 (gamma - beta)
            / ((b^2 + c^2) (2 (b^2 - c^2) + (b^2 + c^2) (beta - gamma)))

    (Lamb, Hydrodynamics, 6th ed., art. 114 and 121; about y and z by cyclic change.)

    Raises:
        ModelError: a semi-axis is not finite and above 0 (for plates see `disc_added_mass` and
            `elliptic_plate_added_mass`).
    """
    positive(a=a, b=b, c=c)
    # The coefficients depend on the shape only: scaled, so that no square over- or underflows.
    squares = (np.array([a, b, c], dtype=float) / max(a, b, c)) ** 2
    product = np.sqrt(squares.prod())
    alpha = np.array(
        [
            2 / 3 * product * elliprd(squares[(i + 1) % 3], squares[(i + 2) % 3], squares[i])
            for i in range(3)
        ]
    )
    turning = np.zeros(3)
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        difference, total = squares[j] - squares[k], squares[j] + squares[k]
        # A body of revolution moves no water about its axis.
        if difference == 0:
            continue
        push = alpha[k] - alpha[j]
        turning[i] = difference**2 * push / (total * (2 * difference - total * push))
    return np.concatenate([alpha / (2 - alpha), turning])


def ellipsoid_added_mass(a: float, b: float, c: float, density: float) -> Array:
    """Added mass (6, 6) of an ellipsoid, semi-axes `a, b, c` [m] along x, y, z, in water [kg/m3].

    `ellipsoid_coefficients` times mass and inertia of the displaced water `4/3 pi rho a b c`. It is
    `density * geom_fluid[6:12]` of a MuJoCo ellipsoid with `fluidshape="ellipsoid"`.

    Raises:
        ModelError: a semi-axis or the density is not finite and above 0.
    """
    positive(density=density)
    k = ellipsoid_coefficients(a, b, c)
    mass = 4 / 3 * np.pi * density * a * b * c
    inertia = mass / 5 * np.array([b * b + c * c, c * c + a * a, a * a + b * b])
    return np.diag(k * np.concatenate([np.full(3, mass), inertia]))


def prolate_spheroid_added_mass(a: float, b: float, density: float) -> Array:
    """Added mass (6, 6) of a prolate spheroid, semi-axes `a` along x and `b <= a` across [m].

    Closed form of Lamb's integrals with the eccentricity `e = sqrt(1 - (b/a)^2)` (Fossen 2021,
    sec. 8.2.1; the torpedo's first model: take `a` = half the length and `b` from the volume,
    `b = sqrt(3 V / (4 pi a))`). Density in kg/m3.

    Raises:
        ModelError: `b` is above `a`, or a value is not finite and above 0.
    """
    positive(a=a, b=b, density=density)
    if b > a:
        raise ModelError(
            f"b = {b} m is above a = {a} m: not a prolate spheroid, use ellipsoid_added_mass"
        )
    # The closed form cancels to nothing near the sphere (below e = 0.1: six digits or more lost).
    if 1 - (b / a) ** 2 < 0.01:
        return ellipsoid_added_mass(a, b, b, density)
    e = np.sqrt(1 - (b / a) ** 2)
    log = 2 * np.arctanh(e)
    alpha = 2 * (1 - e**2) / e**3 * (0.5 * log - e)
    beta = 1 / e**2 - (1 - e**2) / (2 * e**3) * log
    axial, lateral = alpha / (2 - alpha), beta / (2 - beta)
    turning = e**4 * (beta - alpha) / ((2 - e**2) * (2 * e**2 - (2 - e**2) * (beta - alpha)))
    mass = 4 / 3 * np.pi * density * a * b * b
    pitch = turning * mass * (a * a + b * b) / 5
    return np.diag([axial * mass, lateral * mass, lateral * mass, 0.0, pitch, pitch])


def sphere_added_mass(radius: float, density: float) -> Array:
    """Added mass (6, 6) of a sphere [m, kg/m3]: half the displaced water, no rotation.

    Raises:
        ModelError: a value is not finite and above 0.
    """
    positive(radius=radius, density=density)
    mass = 2 / 3 * np.pi * density * radius**3
    return np.diag([mass, mass, mass, 0.0, 0.0, 0.0])


def disc_added_mass(radius: float, density: float) -> Array:
    """Added mass (6, 6) of a thin circular disc [m, kg/m3] whose normal is z.

    `8/3 rho r^3` along the normal, `16/45 rho r^5` about each diameter (Lamb, art. 102 and 108);
    `C_A = 2/pi` with `V_R = 4/3 pi r^3` in DNV-RP-H103, table A-2.

    Raises:
        ModelError: a value is not finite and above 0.
    """
    positive(radius=radius, density=density)
    heave, turn = 8 / 3 * density * radius**3, 16 / 45 * density * radius**5
    return np.diag([0.0, 0.0, heave, turn, turn, 0.0])


def elliptic_plate_added_mass(a: float, b: float, density: float) -> float:
    """Added mass [kg] along the normal of a thin elliptic plate with semi-axes `a`, `b` [m].

    `rho 4/3 pi s^2 l / E(1 - s^2/l^2)`, s the short and l the long semi-axis, E the complete
    elliptic integral of the second kind: the thin limit of Lamb's ellipsoid. Density in kg/m3.
    The rows "elliptical disc" of DNV-RP-H103, table A-2, are its values.

    Raises:
        ModelError: a value is not finite and above 0.
    """
    positive(a=a, b=b, density=density)
    short, long = min(a, b), max(a, b)
    volume = 4 / 3 * np.pi * short**2 * long
    return float(density * volume / ellipe(1 - (short / long) ** 2))


def move_added_mass(added_mass: ArrayLike, position: ArrayLike) -> Array:
    """Added mass (6, 6) of a part about the body's origin, from that about the part's own centre.

    `H^T M_A H` with `H = [[I, -S(r)], [0, I]]` (Fossen 2021, sec. 3.3). Sums of parts (hull, fins,
    thruster ducts) built this way leave out what the parts do to each other's flow.

    Args:
        added_mass: (6, 6) or diagonal (6,), about the part's centre, body axes (FRD or FLU).
        position: (3,) of the part's centre from the origin, same axes, m.

    Raises:
        ModelError: the sizes are others.
    """
    matrix, r = np.asarray(added_mass, dtype=float), np.asarray(position, dtype=float)
    if matrix.shape == (6,):
        matrix = np.diag(matrix)
    if matrix.shape != (6, 6):
        raise ModelError(f"added_mass has shape {matrix.shape}, allowed are (6,) and (6, 6)")
    if r.shape != (3,):
        raise ModelError(f"position has shape {r.shape}, it must be (3,)")
    H = np.eye(6)
    H[:3, 3:] = -skew(r)
    return H.T @ matrix @ H
