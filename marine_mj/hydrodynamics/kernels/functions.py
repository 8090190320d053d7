"""Elementary functions written so that the compiler can vectorise a loop over them."""

import math

from numba import njit

from marine_mj.hydrodynamics.kernels.memory import power_of_two

# pi/2 and ln 2 split so that n * HIGH is exact for |n| < 2**20 (Cody & Waite 1980)
_PI_2_HIGH = 1.5707963267341256
_PI_2_MID = 6.077100506303966e-11
_PI_2_LOW = 2.0222662487959506e-21
_LN2_HIGH = 0.693147180369123816490
_LN2_LOW = 1.90821492927058770002e-10


@njit(inline="always")
def sin_cos(x):
    """(sin x, cos x) to 2e-16 absolute for |x| < 1e6 rad."""
    n = math.floor(x * 0.6366197723675814 + 0.5)
    r = ((x - n * _PI_2_HIGH) - n * _PI_2_MID) - n * _PI_2_LOW
    r2 = r * r
    s = 1.58962301576546568060e-10 * r2 - 2.50507477628578072866e-8
    s = s * r2 + 2.75573136213857245213e-6
    s = s * r2 - 1.98412698295895385996e-4
    s = s * r2 + 8.33333333332211858878e-3
    s = s * r2 - 1.66666666666666307295e-1
    s = r + r * r2 * s
    c = -1.13585365213876817300e-11 * r2 + 2.08757008419747316778e-9
    c = c * r2 - 2.75573141792967388112e-7
    c = c * r2 + 2.48015872888517045348e-5
    c = c * r2 - 1.38888888888730564116e-3
    c = c * r2 + 4.16666666666665929218e-2
    c = 1.0 - 0.5 * r2 + r2 * r2 * c
    quadrant = n - 4.0 * math.floor(n * 0.25)
    odd = quadrant == 1.0 or quadrant == 3.0
    sine = c if odd else s
    cosine = s if odd else c
    sine = -sine if quadrant >= 2.0 else sine
    cosine = -cosine if (quadrant == 1.0 or quadrant == 2.0) else cosine
    return sine, cosine


@njit(inline="always")
def exponential(x):
    """exp(x) to 4e-16 relative for -700 < x < 700; clamped outside."""
    x = min(max(x, -700.0), 700.0)
    n = math.floor(x * 1.4426950408889634 + 0.5)
    r = (x - n * _LN2_HIGH) - n * _LN2_LOW
    p = 1.0 / 479001600.0  # Taylor series to r**12
    p = p * r + 1.0 / 39916800.0
    p = p * r + 1.0 / 3628800.0
    p = p * r + 1.0 / 362880.0
    p = p * r + 1.0 / 40320.0
    p = p * r + 1.0 / 5040.0
    p = p * r + 1.0 / 720.0
    p = p * r + 1.0 / 120.0
    p = p * r + 1.0 / 24.0
    p = p * r + 1.0 / 6.0
    p = p * r + 0.5
    p = p * r + 1.0
    p = p * r + 1.0
    return p * power_of_two(n)
