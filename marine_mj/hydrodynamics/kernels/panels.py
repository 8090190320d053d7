"""Pressure on the instantaneously wetted panels of a hull.

A triangle that the surface cuts is cut there (submersion linear over the triangle); the pressure
is linear over each wet part, zero at the cut, and its force and moment are integrated exactly.
"""

import math

from numba import njit

from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.kernels.memory import advance, scratch
from marine_mj.hydrodynamics.kernels.water import FAST
from marine_mj.hydrodynamics.kernels.wave_pressure import wave_pressure

_VERTICES = t_.MAX_HULL_VERTICES
_COLUMNS = t_.PANEL_COLUMNS


@njit(fastmath=FAST, inline="always")
def _push(a, pa, b, pb, c, pc, share, N, f):
    """Force and moment of a pressure linear over the triangle a b c, `share` of the panel N."""
    p = pa + pb + pc
    weight = share / 12.0
    # integral of p x dA over the area
    x = weight * (p * (a[0] + b[0] + c[0]) + pa * a[0] + pb * b[0] + pc * c[0])
    y = weight * (p * (a[1] + b[1] + c[1]) + pa * a[1] + pb * b[1] + pc * c[1])
    z = weight * (p * (a[2] + b[2] + c[2]) + pa * a[2] + pb * b[2] + pc * c[2])
    mean = p * share / 3.0
    f[0] -= mean * N[0]
    f[1] -= mean * N[1]
    f[2] -= mean * N[2]
    f[3] -= y * N[2] - z * N[1]
    f[4] -= z * N[0] - x * N[2]
    f[5] -= x * N[1] - y * N[0]


@njit(fastmath=FAST, inline="always")
def _cut(a, b, share, out):
    """Point out (3) on the edge from a to b, a share of the way."""
    for i in range(3):
        out[i] = a[i] + share * (b[i] - a[i])


@njit(fastmath=FAST)
def _integrate(table, q, x, below, head, unit, f):
    """Adds the wrench (6) of the pressure unit * head on the wet part of all triangles.

    x: vertices (n, 3), body axes; below: submersion (n), positive under water.
    """
    place = int(q[t_.P_TRIANGLE_DATA])
    small = scratch(12)
    total, first, second = small, advance(small, 6), advance(small, 9)
    for i in range(6):
        total[i] = 0.0
    for t in range(int(q[t_.P_TRIANGLES])):
        row = advance(table, place + _COLUMNS * t)
        i, j, k = int(row[0]), int(row[1]), int(row[2])
        N = advance(row, 3)
        wet = (1 if below[i] > 0.0 else 0) + (1 if below[j] > 0.0 else 0)
        wet += 1 if below[k] > 0.0 else 0
        if wet == 0:
            continue
        if wet < 3:
            # turn the corners so that the odd one comes first
            odd = wet == 1
            if (below[j] > 0.0) == odd and (below[i] > 0.0) != odd and (below[k] > 0.0) != odd:
                i, j, k = j, k, i
            elif (below[k] > 0.0) == odd and (below[i] > 0.0) != odd:
                i, j, k = k, i, j
        a, b, c = advance(x, 3 * i), advance(x, 3 * j), advance(x, 3 * k)
        if wet == 3:
            _push(a, head[i], b, head[j], c, head[k], 1.0, N, total)
            continue
        to_b = below[i] / (below[i] - below[j])
        to_c = below[i] / (below[i] - below[k])
        _cut(a, b, to_b, first)
        _cut(a, c, to_c, second)
        if wet == 1:
            _push(a, head[i], first, 0.0, second, 0.0, to_b * to_c, N, total)
        else:
            _push(b, head[j], c, head[k], second, 0.0, 1.0 - to_c, N, total)
            _push(b, head[j], second, 0.0, first, 0.0, (1.0 - to_b) * to_c, N, total)
    for i in range(6):
        f[i] += unit * total[i]


@njit
def _to_axes(own, R, wrench, f):
    """f += wrench (6) in body axes, turned into the axes R of the loads."""
    for half in range(2):
        w = advance(wrench, 3 * half)
        x = own[0] * w[0] + own[1] * w[1] + own[2] * w[2]
        y = own[3] * w[0] + own[4] * w[1] + own[5] * w[2]
        z = own[6] * w[0] + own[7] * w[1] + own[8] * w[2]
        for i in range(3):
            f[3 * half + i] += R[i] * x + R[3 + i] * y + R[6 + i] * z


@njit(fastmath=FAST)
def _level(n, ax, ay, az, hull_x, hull_y, hull_z, out):
    """out (n) = component of all vertices along the direction (ax, ay, az) in body axes."""
    for i in range(n):
        out[i] = ax * hull_x[i] + ay * hull_y[i] + az * hull_z[i]


@njit(fastmath=FAST)
def panels(table, q, own, R, x, time, still, waves):
    """Hydrostatic and Froude-Krylov wrench on the wet panels.

    own: attitude of the body (9), R: axes of the loads, x: position of the body origin.
    still: accumulator (6) of the pressure -rho g z below the still water level. waves: accumulator
    (6) of what the incident waves change about it: their pressure, and the moved surface.
    """
    n = int(q[t_.P_VERTICES])
    data = advance(table, int(q[t_.P_VERTEX_DATA]))
    hull_x, hull_y, hull_z = data, advance(data, n), advance(data, 2 * n)
    corners = advance(data, 3 * n)
    height, below = scratch(_VERTICES), scratch(_VERTICES)
    unit = table[t_.E_DENSITY] * table[t_.E_GRAVITY]
    _level(n, own[6], own[7], own[8], hull_x, hull_y, hull_z, height)
    for i in range(n):
        height[i] += x[2]
        below[i] = -height[i]
    wrench = scratch(6)
    for i in range(6):
        wrench[i] = 0.0
    _integrate(table, q, corners, below, below, unit, wrench)
    _to_axes(own, R, wrench, still)
    if q[t_.P_WAVES] == 0.0 or table[t_.E_WAVES] == 0.0:
        return
    yaw = math.atan2(own[3], own[0])
    c, s = math.cos(yaw), math.sin(yaw)
    u, v, head = scratch(_VERTICES), scratch(_VERTICES), scratch(_VERTICES)
    ax, ay, az = c * own[0] + s * own[3], c * own[1] + s * own[4], c * own[2] + s * own[5]
    _level(n, ax, ay, az, hull_x, hull_y, hull_z, u)
    ax, ay, az = c * own[3] - s * own[0], c * own[4] - s * own[1], c * own[5] - s * own[2]
    _level(n, ax, ay, az, hull_x, hull_y, hull_z, v)
    wave_pressure(table, q, n, x[0], x[1], c, s, u, v, height, time, below, head)
    for i in range(6):
        wrench[i] = -wrench[i]
    _integrate(table, q, corners, below, head, unit, wrench)
    _to_axes(own, R, wrench, waves)
