"""Tables over the heading of a hull: cubic between their rows, periodic."""

import math

from numba import njit


@njit
def cubic_weights(s, w):
    """Weights w (4) of the values at -1, 0, 1, 2 for the cubic through them at s in [0, 1]."""
    w[0] = -s * (s - 1.0) * (s - 2.0) / 6.0
    w[1] = (s + 1.0) * (s - 1.0) * (s - 2.0) / 2.0
    w[2] = -(s + 1.0) * s * (s - 2.0) / 2.0
    w[3] = (s + 1.0) * s * (s - 1.0) / 6.0


@njit
def heading_rows(yaw, reference, headings, weights):
    """First of the four rows (modulo `headings`) around a yaw [rad], and their weights (4).

    The rows stand at the yaws `reference + 2 pi h / headings`. The reference is a direction of the
    sea, so a world turned as a whole gives the same bits up to rounding.
    """
    place = (yaw - reference) / (2.0 * math.pi) * headings
    lower = math.floor(place)
    cubic_weights(place - lower, weights)
    return int(lower) - 1
