"""Water motion that a floating hull adds to the waves around and below it.

The disturbance is a sum of few modes in space, fixed to the hull, with strengths that follow the
waves at the hull's origin. So the sum over the wave components is taken once for each mode, and
every point costs one look-up in a grid.
"""

import math

from numba import njit

from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.kernels.headings import heading_rows
from marine_mj.hydrodynamics.kernels.memory import advance, field, floats, scratch
from marine_mj.hydrodynamics.kernels.water import FAST, POINT, component, phasors

_XPOS = field("d", "xpos")
_XMAT = field("d", "xmat")
_WAVES = t_.MAX_WAVES
_MODES = t_.MAX_SHELTER_MODES


@njit(fastmath=FAST)
def _sums(real, imaginary, omega, cosine, sine, n, out):
    """out (2) = sum Re(S exp(i theta)) and its rate of change, sum omega Im(S exp(i theta))."""
    value = rate = 0.0
    for i in range(n):
        value += real[i] * cosine[i] - imaginary[i] * sine[i]
        rate += omega[i] * (real[i] * sine[i] + imaginary[i] * cosine[i])
    out[0] = value
    out[1] = rate


@njit
def _strengths(table, q, x, y, yaw, time, value, rate):
    """Strength of every mode [m/s] and its rate [m/s2], cubic between the tabulated headings."""
    n, modes = int(table[t_.E_WAVES]), int(q[t_.SH_MODES])
    cosine, sine, out = scratch(_WAVES), scratch(_WAVES), scratch(2)
    phasors(table, x, y, time, cosine, sine)
    omega = component(table, t_.W_OMEGA)
    headings, weights = int(q[t_.SH_HEADINGS]), scratch(4)
    first = heading_rows(yaw, q[t_.SH_REFERENCE], headings, weights)
    for m in range(modes):
        value[m] = 0.0
        rate[m] = 0.0
    for side in range(4):
        if weights[side] == 0.0:
            continue
        heading = (first + side) % headings
        data = advance(table, int(q[t_.SH_STRENGTHS]) + heading * modes * 2 * n)
        for m in range(modes):
            real = advance(data, 2 * m * n)
            _sums(real, advance(real, n), omega, cosine, sine, n, out)
            value[m] += weights[side] * out[0]
            rate[m] += weights[side] * out[1]


@njit
def _cell(places, count, at, share):
    """Lower node of the interval around `at`, share (1) of the upper one; -1 outside or NaN."""
    if not (at >= places[0] and at <= places[count - 1]):
        return -1
    lower = 0
    while lower < count - 2 and at >= places[lower + 1]:
        lower += 1
    share[0] = (at - places[lower]) / (places[lower + 1] - places[lower])
    return lower


@njit(fastmath=FAST)
def _look_up(nodes, modes, weight, value, rate, out):
    """out (6) += weight times velocity and acceleration of all modes at one node."""
    for axis in range(3):
        v = a = 0.0
        row = advance(nodes, axis * modes)
        for m in range(modes):
            v += row[m] * value[m]
            a += row[m] * rate[m]
        out[axis] += weight * v
        out[3 + axis] += weight * a


@njit
def shelter(data, table, q, first, step, count, time, points):
    """Add the disturbance of a hull to the water motion at a row of points.

    The points are taken in the hull's axes about its origin, where the field is trilinear between
    the nodes of the grid, zero outside, and held above its shallowest nodes. Its acceleration is
    the local one: convective terms of the disturbance are of second order and left out.

    Args:
        q: shelter block, see `table`.
        first: position (3) of the first point, world, m.
        step: vector (3) to the next point, world, m.
        count: number of points.
        points: (count, 6) velocity [m/s] and acceleration [m/s2], world; added to.
    """
    hull = int(q[t_.SH_HULL])
    origin = advance(floats(data, _XPOS), 3 * hull)
    R = advance(floats(data, _XMAT), 9 * hull)
    nx, ny, nz = int(q[t_.SH_NODES]), int(q[t_.SH_NODES + 1]), int(q[t_.SH_NODES + 2])
    xs = advance(table, int(q[t_.SH_PLACES]))
    ys, modes = advance(xs, nx), int(q[t_.SH_MODES])
    zs = advance(ys, ny)
    nodes = advance(table, int(q[t_.SH_FIELD]))
    value, rate = scratch(_MODES), scratch(_MODES)
    small = scratch(9)
    sx, sy, sz, own = small, advance(small, 1), advance(small, 2), advance(small, 3)
    summed = False
    for j in range(count):
        dx = first[0] + j * step[0] - origin[0]
        dy = first[1] + j * step[1] - origin[1]
        dz = first[2] + j * step[2] - origin[2]
        i = _cell(xs, nx, R[0] * dx + R[3] * dy + R[6] * dz, sx)
        k = _cell(ys, ny, R[1] * dx + R[4] * dy + R[7] * dz, sy)
        m = _cell(zs, nz, min(R[2] * dx + R[5] * dy + R[8] * dz, zs[nz - 1]), sz)
        if i < 0 or k < 0 or m < 0:
            continue
        if not summed:
            _strengths(table, q, origin[0], origin[1], math.atan2(R[3], R[0]), time, value, rate)
            summed = True
        for c in range(6):
            own[c] = 0.0
        for corner in range(8):
            a, b, c = corner & 1, corner >> 1 & 1, corner >> 2
            weight = sx[0] if a else 1.0 - sx[0]
            weight *= sy[0] if b else 1.0 - sy[0]
            weight *= sz[0] if c else 1.0 - sz[0]
            place = ((i + a) * ny + k + b) * nz + m + c
            _look_up(advance(nodes, place * 3 * modes), modes, weight, value, rate, own)
        out = advance(points, POINT * j)
        for part in range(2):
            g, w = advance(own, 3 * part), advance(out, 3 * part)
            for c in range(3):
                w[c] += R[3 * c] * g[0] + R[3 * c + 1] * g[1] + R[3 * c + 2] * g[2]
