"""Added mass close to a wall."""

import numpy as np
from numpy.typing import ArrayLike

from marine_mj.errors import ModelError
from marine_mj.frames import Array

# Images that are summed at most: the rest is below 2e-4 even for a cylinder that touches the wall.
_IMAGES = 10000


def cylinder_near_wall(radius: float, gap: ArrayLike) -> Array:
    """Added mass of a circular cylinder parallel to a flat wall, over that far away from it.

    In 2-D, the same across and along the wall. The dipole in the cylinder is imaged in the wall and
    in the cylinder in turn (Lamb, Hydrodynamics, art. 98; Milne-Thomson's circle theorem):

        1 + 2 sum_n mu_n,  mu_n+1 = mu_n (R / (2 h - q_n))^2,  q_n+1 = R^2 / (2 h - q_n)

    from mu_0 = 1, q_0 = 0, with h = R + gap; pi^2 / 3 - 1 = 2.29 where it touches.

    Args:
        radius: R, m.
        gap: (...,) between cylinder and wall, m.

    Returns:
        (...,) factor, 1 far away.

    Raises:
        ModelError: the radius is not positive, or a gap is negative.
    """
    gap = np.asarray(gap, dtype=float)
    if not radius > 0:
        raise ModelError(f"radius is {radius:g}; allowed is a number above 0 m")
    if not np.all(gap >= 0):
        raise ModelError(f"gap is {gap.min():g}; allowed are numbers from 0 m on")
    between = 2 * (1 + gap / radius)  # cylinder to its mirror image, in radii
    strength, place, total = np.ones(gap.shape), np.zeros(gap.shape), np.ones(gap.shape)
    for _ in range(_IMAGES):
        strength = strength / (between - place) ** 2
        place = 1 / (between - place)
        total = total + 2 * strength
        if np.all(strength < 1e-9):
            break
    return total
