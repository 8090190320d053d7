"""Waves that are long beside a floating hull: the mean water motion about it, and their force.

The hull meets one rigid motion of the water, the mean over an equivalent box: over its length and
breadth (a wave of wave number k passes with `sin(kL/2) / (kL/2)`) and over its draught. Added mass
and damping act on the motion relative to it, so the diffraction of long waves is in them (Newman
1977, Marine Hydrodynamics, sec. 6.18; Faltinsen 1990, Sea Loads, ch. 3). What is left is the
pressure of the undisturbed wave, added here: on the waterplane its elevation, on the displaced
water its mass times its acceleration (Gauss' theorem; exact for a box).
"""

import math

from numba import njit

from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.kernels.functions import sin_cos
from marine_mj.hydrodynamics.kernels.memory import advance, scratch
from marine_mj.hydrodynamics.kernels.water import FAST, component, phasors, water_row

_WAVES = t_.MAX_WAVES
#: Below this square of the argument, series stand for quotients that lose their digits.
_SMALL = 0.04


@njit(fastmath=FAST)
def _filters(n, k, bx, by, along, across, half, mean, slope):
    """How much of each component is left over `half` a length along (along, across), world.

    mean: sin(X) / X, of the mean; slope: 3 (sin X - X cos X) / X^3, of the slope of the line that
    fits best (least squares), X = k half cos(angle).
    """
    for i in range(n):
        X = k[i] * half * (bx[i] * along + by[i] * across)
        Q = X * X
        s, c = sin_cos(X)
        small = Q < _SMALL
        D = 1.0 if small else X
        a = 1.0 - Q / 6.0 * (1.0 - Q / 20.0 * (1.0 - Q / 42.0 * (1.0 - Q / 72.0)))
        b = 1.0 - Q / 10.0 * (1.0 - Q / 28.0 * (1.0 - Q / 54.0 * (1.0 - Q / 88.0)))
        mean[i] = a if small else s / D
        slope[i] = b if small else 3.0 * (s - X * c) / (D * D * D)


@njit(fastmath=FAST)
def _sums(table, q, cy, sy, ux, uy, cosine, sine, mx, gx, my, gy, out):
    """Sums over the components into out (15), heading axes, at the centre of the waterplane.

    Velocity (3) and rates of turn (3) of the water, their time derivatives (6) for an observer
    that moves with (ux, uy), elevation of the surface and its slopes along x and y.
    """
    n = int(table[t_.E_WAVES])
    omega = component(table, t_.W_OMEGA)
    k = component(table, t_.W_K)
    bx = component(table, t_.W_BX)
    by = component(table, t_.W_BY)
    amplitude = component(table, t_.W_AMPLITUDE)
    horizontal = advance(table, int(q[t_.LW_SPEEDS]))
    vertical = advance(horizontal, n)
    u = v = w = p = t = r = 0.0
    du = dv = dw = dp = dt = dr = zeta = zx = zy = 0.0
    for i in range(n):
        along = bx[i] * cy + by[i] * sy
        across = by[i] * cy - bx[i] * sy
        rate = omega[i] - k[i] * (bx[i] * ux + by[i] * uy)
        whole, bow, side = mx[i] * my[i], gx[i] * my[i], mx[i] * gy[i]
        kx, ky = k[i] * along * bow, k[i] * across * side
        c, s = cosine[i], sine[i]
        h, f = horizontal[i], vertical[i]
        u += h * whole * along * c
        v += h * whole * across * c
        w += f * whole * s
        p += f * ky * c
        t -= f * kx * c
        r -= h * across * kx * s
        du += rate * h * whole * along * s
        dv += rate * h * whole * across * s
        dw -= rate * f * whole * c
        dp += rate * f * ky * s
        dt -= rate * f * kx * s
        dr += rate * h * across * kx * c
        zeta += amplitude[i] * whole * c
        zx -= amplitude[i] * kx * s
        zy -= amplitude[i] * ky * s
    out[0], out[1], out[2], out[3], out[4], out[5] = u, v, w, p, t, r
    out[6], out[7], out[8], out[9], out[10], out[11] = du, dv, dw, dp, dt, dr
    out[12], out[13], out[14] = zeta, zx, zy


@njit
def _to_body(R, cy, sy, level, out):
    """Vector (3) in heading axes in those of R."""
    x, y, z = cy * level[0] - sy * level[1], sy * level[0] + cy * level[1], level[2]
    for i in range(3):
        out[i] = R[i] * x + R[3 + i] * y + R[6 + i] * z


@njit
def _pressure(q, R, cy, sy, sums, f):
    """Force of the undisturbed wave, f (6): elevation of the surface, inertia of displaced water.

    sums: of `_sums`, at the centre of the waterplane.
    """
    small = scratch(9)
    eta, push, turn = small, advance(small, 3), advance(small, 6)
    eta[0] = sums[12] - sums[13] * q[t_.LW_PLACE] - sums[14] * q[t_.LW_PLACE + 1]
    eta[1], eta[2] = sums[14], -sums[13]
    for i in range(6):
        for j in range(3):
            f[i] += q[t_.LW_STIFFNESS + 3 * i + j] * eta[j]
    _to_body(R, cy, sy, advance(sums, 6), push)
    _to_body(R, cy, sy, advance(sums, 9), turn)
    for i in range(3):
        push[i] *= q[t_.LW_MASS]
        f[i] += push[i]
        f[3 + i] += q[t_.LW_INERTIA + i] * turn[i]
    x, y, z = q[t_.LW_CENTER], q[t_.LW_CENTER + 1], q[t_.LW_CENTER + 2]
    f[3] += y * push[2] - z * push[1]
    f[4] += z * push[0] - x * push[2]
    f[5] += x * push[1] - y * push[0]


@njit
def long_wave(table, q, R, x, yaw, time, convective, nu_w, acc_w, f):
    """Waves on a floating body at the place x (3) with heading `yaw` (NWU), as if they were long.

    Args:
        q: long-wave block of the body.
        R: axes of the loads.
        convective: the water's acceleration follows the current.
        nu_w, acc_w: get the twist (6) of the water and its rate, axes R, at the body origin.
        f: the force (6) of the undisturbed wave is added to it.
    """
    cy, sy = math.cos(yaw), math.sin(yaw)
    small = scratch(24)
    water, step, sums = small, advance(small, 6), advance(small, 9)
    for i in range(3):
        step[i] = 0.0
    water_row(table, x, step, 1, time, False, convective, False, water, water)
    ux, uy = (water[0], water[1]) if convective else (0.0, 0.0)
    n = int(table[t_.E_WAVES])
    px, py, pz = q[t_.LW_PLACE], q[t_.LW_PLACE + 1], q[t_.LW_PLACE + 2]
    cosine, sine = scratch(_WAVES), scratch(_WAVES)
    mx, gx, my, gy = scratch(_WAVES), scratch(_WAVES), scratch(_WAVES), scratch(_WAVES)
    phasors(table, x[0] + cy * px - sy * py, x[1] + sy * px + cy * py, time, cosine, sine)
    k = component(table, t_.W_K)
    bx, by = component(table, t_.W_BX), component(table, t_.W_BY)
    _filters(n, k, bx, by, cy, sy, q[t_.LW_HALF], mx, gx)
    _filters(n, k, bx, by, -sy, cy, q[t_.LW_HALF + 1], my, gy)
    _sums(table, q, cy, sy, ux, uy, cosine, sine, mx, gx, my, gy, sums)
    _pressure(q, R, cy, sy, sums, f)
    for part in range(2):
        # from the centre of the waterplane to the body origin
        g = advance(sums, 6 * part)
        g[0] += g[5] * py - g[4] * pz
        g[1] += g[3] * pz - g[5] * px
        g[2] += g[4] * px - g[3] * py
        out = acc_w if part == 1 else nu_w
        flow = advance(water, 3 * part)
        _to_body(R, cy, sy, g, out)
        _to_body(R, cy, sy, advance(g, 3), advance(out, 3))
        for i in range(3):
            out[i] += R[i] * flow[0] + R[3 + i] * flow[1] + R[6 + i] * flow[2]
