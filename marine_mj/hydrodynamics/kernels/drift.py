"""Wave drift: the steady push of the waves and its slow variation in wave groups."""

import math

from numba import njit

from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.kernels.headings import heading_rows
from marine_mj.hydrodynamics.kernels.memory import advance, scratch
from marine_mj.hydrodynamics.kernels.water import FAST, component


@njit(fastmath=FAST)
def _sum(values, cosine, sine, n, out):
    """out (2) = sum values exp(i theta)."""
    real = imaginary = 0.0
    for i in range(n):
        real += values[i] * cosine[i]
        imaginary += values[i] * sine[i]
    out[0] = real
    out[1] = imaginary


@njit
def drift(table, q, R, place, cosine, sine, f):
    """Wave drift in surge, sway and yaw, by mean drift coefficients of the single components.

    With theta_i the phase of component i at the low-frequency place, Newman's approximation in its
    form with the arithmetic mean (Newman 1974; Faltinsen 1990, Sea Loads, eq. 5.42-5.45) is

        F = sum_ij a_i a_j (T_i + T_j) / 2 cos(theta_i - theta_j) = Re(conj(S_0) S_1),
        S_0 = sum a e^(i theta),  S_1 = sum a T e^(i theta):

    two sums instead of a double one, and no sum frequencies. The mean part is sum a^2 T. Forces
    lie in the horizontal plane along the low-frequency heading, the moment is about the vertical
    through the body origin.

    place (3): x, y and yaw, see `low_frequency_place`, with the phasors of the waves there. q: mode
    (`DRIFT_MODES`), number of headings H, offset of a T [N/m, N m/m] (H, 3, components), or of sum
    a^2 T [N, N m] (H, 3) for the mean alone, yaw of the first heading; cubic between headings.
    """
    n = int(table[t_.E_WAVES])
    headings = int(q[1])
    small = scratch(12)
    weights, total, first, push = small, advance(small, 4), advance(small, 6), advance(small, 8)
    row_before = heading_rows(place[2], q[3], headings, weights)
    for i in range(3):
        push[i] = 0.0
    slow = q[0] == 1.0
    width = n if slow else 1
    if slow:
        _sum(component(table, t_.W_AMPLITUDE), cosine, sine, n, total)
    for side in range(4):
        if abs(weights[side]) > 0.0:  # false for NaN
            row = (row_before + side) % headings
            data = advance(table, int(q[2]) + row * 3 * width)
            for i in range(3):
                if slow:
                    _sum(advance(data, i * n), cosine, sine, n, first)
                    value = total[0] * first[0] + total[1] * first[1]
                else:
                    value = data[i]
                push[i] += weights[side] * value
    c, s = math.cos(place[2]), math.sin(place[2])
    surge, sway = c * push[0] - s * push[1], s * push[0] + c * push[1]
    for i in range(3):
        f[i] += R[i] * surge + R[3 + i] * sway
        f[3 + i] += R[6 + i] * push[2]
