"""The low-frequency place of a body: where wave loads of first and second order are taken.

A first-order load taken at the oscillating position has the mean `1/2 Re(i F conj(k . X))`, which
is no drift force of the water: the drift coefficients are the total. Wave loads therefore follow
place and yaw behind filters that the wave motion does not pass. Those of the place are of sixth
order with all poles at the cut-off w_c and of type 3 (the numerator has the last three terms of the
denominator), so that constant speed and acceleration leave no lag:

    H(s) = (15 w_c^4 s^2 + 6 w_c^5 s + w_c^6) / (s + w_c)^6.

That of the yaw is of type 2 (without the term s^2; no lag at a constant rate of turn), 1.5 w_c:
it passes less at the waves' frequency, where a yaw that is let pass turns a large sway force
into a mean surge force, overshoots less and follows faster. Loads turn with a yaw that is never
more than 0.1 rad from the hull's.

The states are activations: 1 once the filter runs, then six for each of x, y and yaw. Where they
are 0, as after a reset, or far from the body, as after a jump, loads are taken at the body's own
place, and the states are set to it in the next step.
"""

import math

from numba import njit

from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.kernels.equations import body_twist, load_axes
from marine_mj.hydrodynamics.kernels.memory import advance, field, float_value, floats, scratch

_ACT = field("d", "act")
_ACT_DOT = field("d", "act_dot")
_XPOS = field("d", "xpos")
_XMAT = field("d", "xmat")
_TIMESTEP = field("m", "opt.timestep")
#: Largest distance [rad] between the yaw and that of the filter.
_FARTHEST_YAW = 1.0
#: Largest angle [rad] between the yaw of the loads and the hull's (ours): hulls yaw with waves by
#: less, and in a turn the filter must not turn the large pitch moment of the waves into roll.
_LARGEST_TURN = 0.1
#: Cut-off of the yaw over that of the place (ours): its filter passes less at the waves' frequency.
_YAW_CUTOFF = 1.5


@njit
def wrapped(angle):
    """Angle [rad] in [-pi, pi]."""
    return angle - 2.0 * math.pi * math.floor(angle / (2.0 * math.pi) + 0.5)


@njit
def _is_set(z):
    """Whether the filter with the states z has been set to a place."""
    return abs(z[t_.LF_SET] - 1.0) < 1e-9


@njit
def _runs(z, p, x, y, yaw):
    """Whether the filter with the states z has been set and is near the body."""
    if not _is_set(z):
        return False
    dx = x - z[t_.LF_X]
    dy = y - z[t_.LF_X + t_.LF_ORDER]
    turn = wrapped(yaw - z[t_.LF_X + 2 * t_.LF_ORDER])
    reach = p[t_.B_REACH]
    return dx * dx + dy * dy <= reach * reach and abs(turn) <= _FARTHEST_YAW


@njit
def low_frequency_place(data, p, x, own, place):
    """Fill place (3) with x, y [m] and yaw [rad], NWU, at which the waves act on a body.

    x: position (3) of the body origin, own: attitude of the body (9).
    """
    place[0], place[1], place[2] = x[0], x[1], math.atan2(own[3], own[0])
    address = int(p[t_.B_LOW_FREQUENCY]) - 1
    if address < 0:
        return
    z = advance(floats(data, _ACT), address)
    if _runs(z, p, place[0], place[1], place[2]):
        place[0], place[1] = z[t_.LF_X], z[t_.LF_X + t_.LF_ORDER]
        behind = wrapped(place[2] - z[t_.LF_X + 2 * t_.LF_ORDER])
        place[2] -= min(max(behind, -_LARGEST_TURN), _LARGEST_TURN)


@njit
def low_frequency_velocity(data, p, x, own, R, nu, slow):
    """Fill slow (3) with surge and sway [m/s] and yaw rate [rad/s] without the wave motion.

    In the level axes R of the loads; nu (6): twist of the body in them, which stands where the
    filter does not run.
    """
    slow[0], slow[1], slow[2] = nu[0], nu[1], nu[5]
    address = int(p[t_.B_LOW_FREQUENCY]) - 1
    if address < 0:
        return
    z = advance(floats(data, _ACT), address)
    if not _runs(z, p, x[0], x[1], math.atan2(own[3], own[0])):
        return
    first, second = advance(z, t_.LF_X), advance(z, t_.LF_X + t_.LF_ORDER)
    vx, vy = first[1] + 15.0 * first[3], second[1] + 15.0 * second[3]
    slow[0] = R[0] * vx + R[3] * vy
    slow[1] = R[1] * vx + R[4] * vy
    turn = advance(z, t_.LF_X + 2 * t_.LF_ORDER)
    slow[2] = turn[1] + 6.0 * turn[2]


@njit
def _body_rates(data, p, own, rates):
    """rates (3): velocity of the body origin along world x, y [m/s], and yaw rate [rad/s]."""
    R, nu = scratch(9), scratch(6)
    load_axes(data, p, R)
    body_twist(data, p, R, nu)
    for i in range(2):
        rates[i] = R[3 * i] * nu[0] + R[3 * i + 1] * nu[1] + R[3 * i + 2] * nu[2]
    spin = scratch(3)
    for i in range(3):
        spin[i] = R[3 * i] * nu[3] + R[3 * i + 1] * nu[4] + R[3 * i + 2] * nu[5]
    # rate of atan2(own[3], own[0]), from d/dt own = spin x own
    level = own[0] * own[0] + own[3] * own[3]
    rates[2] = 0.0
    if level > 1e-12:
        rate_x = spin[1] * own[6] - spin[2] * own[3]
        rate_y = spin[2] * own[0] - spin[0] * own[6]
        rates[2] = (own[0] * rate_y - own[3] * rate_x) / level


@njit
def low_frequency_rates(model, data, table, number):
    """Rates of the filter states of the body with that record number, into act_dot."""
    if number >= table[t_.H_BODIES]:
        return
    start = int(table[t_.H_FIRST_BODY])
    for _ in range(number):
        start += int(table[start + t_.B_SIZE])
    p = advance(table, start)
    address = int(p[t_.B_LOW_FREQUENCY]) - 1
    if address < 0:
        return
    z, out = advance(floats(data, _ACT), address), advance(floats(data, _ACT_DOT), address)
    body = int(p[t_.B_BODY])
    x, own = advance(floats(data, _XPOS), 3 * body), advance(floats(data, _XMAT), 9 * body)
    place = scratch(3)
    place[0], place[1], place[2] = x[0], x[1], math.atan2(own[3], own[0])
    if not _runs(z, p, place[0], place[1], place[2]):
        _restart(model, data, p, own, z, place, out)
        return
    w = p[t_.B_CUTOFF]
    out[t_.LF_SET] = 0.0
    # place, speed (and acceleration) are driven by g, the error behind the remaining poles; g and
    # its derivatives by w_c, w_c^2 ... are in m/s or rad/s
    for i in range(2):
        s = advance(z, t_.LF_X + i * t_.LF_ORDER)
        rate = advance(out, t_.LF_X + i * t_.LF_ORDER)
        rate[0] = s[1] + 15.0 * s[3]
        rate[1] = s[2] + 6.0 * w * s[3]
        rate[2] = w * w * s[3]
        rate[3] = w * s[4]
        rate[4] = w * s[5]
        rate[5] = w * (w * (place[i] - s[0]) - 6.0 * s[5] - 15.0 * s[4] - 20.0 * s[3])
    w *= _YAW_CUTOFF
    s, rate = advance(z, t_.LF_X + 2 * t_.LF_ORDER), advance(out, t_.LF_X + 2 * t_.LF_ORDER)
    rate[0] = s[1] + 6.0 * s[2]
    rate[1] = w * s[2]
    for k in range(2, 5):
        rate[k] = w * s[k + 1]
    turn = wrapped(place[2] - s[0])
    rate[5] = w * (w * turn - 6.0 * s[5] - 15.0 * s[4] - 20.0 * s[3] - 15.0 * s[2])


@njit
def _restart(model, data, p, own, z, place, out):
    """Rates that set the states to place and speed of the body within a step.

    Runge-Kutta gets there by a factor 0.375 per step; it counts as set at the end of that.
    """
    rates = scratch(3)
    _body_rates(data, p, own, rates)
    per_step = 1.0 / float_value(model, _TIMESTEP)
    # a filter that has run and lost its body starts from 0 again
    aim = 0.0 if _is_set(z) else 1.0
    out[t_.LF_SET] = (aim - z[t_.LF_SET]) * per_step
    for i in range(3):
        s = advance(z, t_.LF_X + i * t_.LF_ORDER)
        rate = advance(out, t_.LF_X + i * t_.LF_ORDER)
        rate[0] = (place[i] - s[0]) * per_step
        rate[1] = (rates[i] - s[1]) * per_step
        for k in range(2, t_.LF_ORDER):
            rate[k] = -s[k] * per_step
