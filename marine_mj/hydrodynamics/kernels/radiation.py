"""Radiation memory: the force of the states in `data.act`, and their rates.

One complex state z per pole and driving degree of freedom, `z' = lambda z + nu_j`; the force is
`-Re sum r z` (hydrodynamics.memory). nu is relative to the current, in level axes turned by the
low-frequency yaw.

MuJoCo's semi-implicit integrators do `act += h act_dot` with the velocity of the step's start, and
move the body with the velocity of its end. Their rate is that of the exact solution over the step
with nu held, and the force takes the states at the end of the same step: then it is in phase with
the position, and not late by a step. RK4 gets the derivative and the states as they are.

Where a body leaves the water, its wet share s scales the velocity that drives the states and the
force that they give alike: then the memory takes energy only, however fast s changes.
"""

import math

from numba import njit

from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.kernels.equations import (
    body_twist,
    load_axes,
    relative_velocity,
    runge_kutta,
)
from marine_mj.hydrodynamics.kernels.functions import exponential, sin_cos
from marine_mj.hydrodynamics.kernels.low_frequency import low_frequency_place
from marine_mj.hydrodynamics.kernels.memory import (
    advance,
    field,
    float_value,
    floats,
    scratch,
)
from marine_mj.hydrodynamics.kernels.surface import published_share
from marine_mj.hydrodynamics.kernels.water import FAST

_ACT = field("d", "act")
_ACT_DOT = field("d", "act_dot")
_XMAT = field("d", "xmat")
_XPOS = field("d", "xpos")
_TIMESTEP = field("m", "opt.timestep")
_POLES = t_.MAX_POLES


@njit(fastmath=FAST)
def _step_integrals(q, h, real, imag):
    """`int_0^h exp(lambda t) dt = (exp(lambda h) - 1) / lambda` of every pole."""
    n = int(q[t_.MM_POLES])
    decay = advance(q, t_.MM_DATA)
    turn = advance(decay, n)
    inverse_re, inverse_im = advance(decay, 2 * n), advance(decay, 3 * n)
    for i in range(n):
        e = exponential(decay[i] * h)
        s, c = sin_cos(turn[i] * h)
        a, b = e * c - 1.0, e * s
        real[i] = a * inverse_re[i] - b * inverse_im[i]
        imag[i] = a * inverse_im[i] + b * inverse_re[i]


@njit
def _turned(c, s, w, sign):
    """Both vectors of w (6) seen from axes turned by an angle (c, s) about the vertical."""
    for half in range(2):
        x, y = w[3 * half], w[3 * half + 1]
        w[3 * half] = c * x + sign * s * y
        w[3 * half + 1] = c * y - sign * s * x


@njit
def _slow_turn(data, p, R, x, turn):
    """turn (2): cos and sin of the angle from the axes R to those of the low-frequency yaw.

    The memory lives in these, like the wave force: what a force of first order in axes that yaw
    with the waves has of a mean is in the drift coefficients.
    """
    turn[0], turn[1] = 1.0, 0.0
    if p[t_.B_LOW_FREQUENCY] > 0.0:
        place = scratch(3)
        own = advance(floats(data, _XMAT), 9 * int(p[t_.B_BODY]))
        low_frequency_place(data, p, x, own, place)
        c, s = math.cos(place[2]), math.sin(place[2])
        turn[0], turn[1] = c * R[0] + s * R[3], s * R[0] - c * R[3]


@njit
def _relative_twist(table, p, R, x, turn, time, nu, out):
    """nu (6) relative to the current at the body origin x, in axes R turned by `turn`."""
    relative_velocity(table, R, x, time, False, nu, out)
    for i in range(3):
        out[3 + i] = nu[3 + i]
    _turned(turn[0], turn[1], out, 1.0)


@njit
def memory(model, data, table, p, q, R, nu, time, share, f):
    """Radiation force f (6) of one body beside that of A(inf), yet to be faded by its wet share."""
    x = advance(floats(data, _XPOS), 3 * int(p[t_.B_BODY]))
    nu_r, force, angle = scratch(6), scratch(6), scratch(2)
    _slow_turn(data, p, R, x, angle)
    _relative_twist(table, p, R, x, angle, time, nu, nu_r)
    for i in range(6):
        force[i] = 0.0
    for i in range(6):
        nu_r[i] *= share
    all_real, all_imag = scratch(_POLES), scratch(_POLES)
    ahead = not runge_kutta(model)
    if ahead:
        _step_integrals(q, float_value(model, _TIMESTEP), all_real, all_imag)
    count = int(q[t_.MM_POLES])
    z = advance(floats(data, _ACT), int(q[t_.MM_ADDRESS]))
    next_re, next_im = scratch(_POLES), scratch(_POLES)
    group = advance(q, t_.MM_DATA + 4 * count)
    for _ in range(int(q[t_.MM_GROUPS])):
        m, n, first = int(group[t_.MG_DOFS]), int(group[t_.MG_POLES]), int(group[t_.MG_FIRST])
        decay = advance(q, t_.MM_DATA + first)
        turn = advance(decay, count)
        real, imag = advance(all_real, first), advance(all_imag, first)
        residue = advance(group, t_.MG_RESIDUES)
        for j in range(m):
            velocity = nu_r[int(group[t_.MG_DOF + j])]
            z_im = advance(z, n)
            for k in range(n):
                a, b = z[k], z_im[k]
                if ahead:
                    rate_re = decay[k] * a - turn[k] * b + velocity
                    rate_im = decay[k] * b + turn[k] * a
                    a += real[k] * rate_re - imag[k] * rate_im
                    b += real[k] * rate_im + imag[k] * rate_re
                next_re[k], next_im[k] = a, b
            for i in range(m):
                total = 0.0
                for k in range(n):
                    total += residue[k] * next_re[k] - residue[n + k] * next_im[k]
                force[int(group[t_.MG_DOF + i])] -= total
                residue = advance(residue, 2 * n)
            z = advance(z, 2 * n)
        group = residue
    _turned(angle[0], angle[1], force, -1.0)
    for i in range(6):
        f[i] += force[i]


@njit
def _rates(model, data, q, nu_r):
    """Rates of the states of one body into act_dot."""
    all_real, all_imag = scratch(_POLES), scratch(_POLES)
    h = float_value(model, _TIMESTEP)
    held = not runge_kutta(model)
    if held:
        _step_integrals(q, h, all_real, all_imag)
    count = int(q[t_.MM_POLES])
    z = advance(floats(data, _ACT), int(q[t_.MM_ADDRESS]))
    out = advance(floats(data, _ACT_DOT), int(q[t_.MM_ADDRESS]))
    group = advance(q, t_.MM_DATA + 4 * count)
    for _ in range(int(q[t_.MM_GROUPS])):
        m, n, first = int(group[t_.MG_DOFS]), int(group[t_.MG_POLES]), int(group[t_.MG_FIRST])
        decay = advance(q, t_.MM_DATA + first)
        turn = advance(decay, count)
        real, imag = advance(all_real, first), advance(all_imag, first)
        for j in range(m):
            velocity = nu_r[int(group[t_.MG_DOF + j])]
            z_im, out_im = advance(z, n), advance(out, n)
            for k in range(n):
                rate_re = decay[k] * z[k] - turn[k] * z_im[k] + velocity
                rate_im = decay[k] * z_im[k] + turn[k] * z[k]
                if held:
                    a = (real[k] * rate_re - imag[k] * rate_im) / h
                    rate_im = (real[k] * rate_im + imag[k] * rate_re) / h
                    rate_re = a
                out[k], out_im[k] = rate_re, rate_im
            z, out = advance(z, 2 * n), advance(out, 2 * n)
        group = advance(group, t_.MG_RESIDUES + 2 * m * m * n)


@njit
def memory_rates(model, data, table, number, time):
    """Rates of the states of the body with that record number; nothing if it has no memory."""
    place = int(table[t_.H_FIRST_BODY])
    if number >= table[t_.H_BODIES]:
        return
    for _ in range(number):
        place += int(table[place + t_.B_SIZE])
    p = advance(table, place)
    element = int(p[t_.B_ELEMENT_DATA])
    for _ in range(int(p[t_.B_ELEMENTS])):
        if table[element + t_.EL_KIND] == t_.MEMORY:
            R, nu, nu_r = scratch(9), scratch(6), scratch(6)
            load_axes(data, p, R)
            body_twist(data, p, R, nu)
            x = advance(floats(data, _XPOS), 3 * int(p[t_.B_BODY]))
            angle = scratch(2)
            _slow_turn(data, p, R, x, angle)
            _relative_twist(table, p, R, x, angle, time, nu, nu_r)
            if p[t_.B_SURFACE] > 0.0:
                share = published_share(model, data, table, p, R, nu, time)
                for i in range(6):
                    nu_r[i] *= share
            _rates(model, data, advance(table, element + t_.EL_DATA), nu_r)
        element += int(table[element + t_.EL_SIZE])
