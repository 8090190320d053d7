"""Force laws that only some bodies have: one function each, chosen by the element's kind.

Every law adds to the wrench accumulators `f` (cause, 6) and may add an inertia matrix to `inertia`
(INERTIAS, 36), both about the body origin in the axes R of the loads: the body's own (FLU), or
level ones turned by its yaw where RAOs stand for the waves. `q` points at the parameters.
"""

import math

from numba import njit

from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.kernels.drift import drift
from marine_mj.hydrodynamics.kernels.equations import runge_kutta
from marine_mj.hydrodynamics.kernels.functions import sin_cos
from marine_mj.hydrodynamics.kernels.headings import heading_rows
from marine_mj.hydrodynamics.kernels.memory import (
    advance,
    field,
    float_value,
    floats,
    scratch,
)
from marine_mj.hydrodynamics.kernels.panels import panels
from marine_mj.hydrodynamics.kernels.radiation import memory
from marine_mj.hydrodynamics.kernels.surface import S_LIMITED, S_SHARE, limit_restoring
from marine_mj.hydrodynamics.kernels.thrusters import thrust_loss
from marine_mj.hydrodynamics.kernels.water import FAST, component, phasors
from marine_mj.hydrodynamics.kernels.wind import wind

_ACT = field("d", "act")
_XQUAT = field("d", "xquat")
_XPOS = field("d", "xpos")
_XMAT = field("d", "xmat")
_TIMESTEP = field("m", "opt.timestep")
_WAVES = t_.MAX_WAVES


@njit
def _rotate_to_body(R, x, y, z, out):
    """World vector in body axes: out = R^T [x y z]."""
    for i in range(3):
        out[i] = R[i] * x + R[3 + i] * y + R[6 + i] * z


@njit
def restoring(q, own, R, height, f):
    """Linear hydrostatics about the floating equilibrium: -G eta, and what carries the weight.

    own: attitude of the body (9), R: axes of the loads. Lift is vertical, whatever the attitude.
    q: G (36, FLU), equilibrium height, weight [N], centre of gravity (3).
    """
    eta = scratch(6)
    for i in range(6):
        eta[i] = 0.0
    eta[2] = height - q[36]
    eta[3] = math.atan2(own[7], own[8])
    eta[4] = -math.asin(min(max(own[6], -1.0), 1.0))
    for i in range(6):
        for j in range(2, 5):
            force = q[6 * i + j] * eta[j]
            if i == 2:
                for axis in range(3):
                    f[axis] -= R[6 + axis] * force
            else:
                f[i] -= force
    # the weight of the body acts at its centre of gravity: lift it there
    arm, up = scratch(3), scratch(3)
    for i in range(3):
        arm[i] = 0.0
        for j in range(3):
            world = own[3 * j] * q[38] + own[3 * j + 1] * q[39] + own[3 * j + 2] * q[40]
            arm[i] += R[3 * j + i] * world
    _rotate_to_body(R, 0.0, 0.0, q[37], up)
    for i in range(3):
        f[i] += up[i]
    f[3] += arm[1] * up[2] - arm[2] * up[1]
    f[4] += arm[2] * up[0] - arm[0] * up[2]
    f[5] += arm[0] * up[1] - arm[1] * up[0]


@njit(fastmath=FAST)
def _phasor_sum(real, imaginary, cosine, sine, n):
    """sum Re(X exp(i theta)) of n components."""
    total = 0.0
    for i in range(n):
        total += real[i] * cosine[i] - imaginary[i] * sine[i]
    return total


@njit
def excitation(table, q, R, place, cosine, sine, f):
    """Wave-exciting wrench of a floating body from its force RAOs.

    place (3): x, y and yaw, see `low_frequency_place`, with the phasors of the waves there; the
    forces lie in level axes turned by that yaw. q: path (5, where a run starts, not used here),
    number of headings H, offset of (H, 6, 2, components): complex force per component, level axes,
    phase taken at the body origin; yaw of the first heading. Cubic between headings.
    """
    n = int(table[t_.E_WAVES])
    if n == 0:
        return
    small = scratch(13)
    weights, total, turned = small, advance(small, 4), advance(small, 10)
    headings = int(q[5])
    first = heading_rows(place[2], q[7], headings, weights)
    for i in range(6):
        total[i] = 0.0
    for side in range(4):
        if not abs(weights[side]) > 0.0:  # true for NaN
            continue
        data = advance(table, int(q[6]) + (first + side) % headings * 12 * n)
        for i in range(6):
            real = advance(data, 2 * i * n)
            total[i] += weights[side] * _phasor_sum(real, advance(real, n), cosine, sine, n)
    c, s = math.cos(place[2]), math.sin(place[2])
    for half in range(2):
        w, out = advance(total, 3 * half), advance(f, 3 * half)
        _rotate_to_body(R, c * w[0] - s * w[1], s * w[0] + c * w[1], w[2], turned)
        for i in range(3):
            out[i] += turned[i]


@njit
def _motion(table, q, time, x, v, a):
    """Prescribed pose deviation x (6), its velocity v and acceleration a, at `time`."""
    n = int(table[t_.E_WAVES])
    omega = component(table, t_.W_OMEGA)
    data = advance(table, int(q[4]))
    for i in range(6):
        x[i] = 0.0
        v[i] = 0.0
        a[i] = 0.0
    for m in range(n):
        w = omega[m]
        s, c = sin_cos(w * time)
        for i in range(6):
            re = data[2 * i * n + m]
            im = data[(2 * i + 1) * n + m]
            p = re * c + im * s
            x[i] += p
            v[i] += w * (im * c - re * s)
            a[i] -= w * w * p


@njit
def prescribed(model, data, table, q, body, R, nu, time, f, inertia):
    """Motion RAO playback that contacts can feel: a very large inertia driven along a path.

    q: x_ref, y_ref, z_ref, yaw_ref, offset of (6, 2, components) complex pose deviation in the
    reference frame, inertia [kg], inertia [kg m2]. Dead-beat in the position for the semi-implicit
    integrators, critically damped tracking for RK4 (physics of both: a spring to the path).
    """
    h = float_value(model, _TIMESTEP)
    rk4 = runge_kutta(model)
    small = scratch(40)
    x, v, a = small, advance(small, 6), advance(small, 12)
    _motion(table, q, time if rk4 else time + h, x, v, a)
    c, s = math.cos(q[3]), math.sin(q[3])
    position = advance(floats(data, _XPOS), 3 * body)
    # attitude: reference yaw, then zyx Euler angles (yaw, pitch, roll) of the deviation
    cr, sr = math.cos(0.5 * x[3]), math.sin(0.5 * x[3])
    cp, sp = math.cos(0.5 * x[4]), math.sin(0.5 * x[4])
    cy, sy = math.cos(0.5 * (x[5] + q[3])), math.sin(0.5 * (x[5] + q[3]))
    d0 = cr * cp * cy + sr * sp * sy
    d1 = sr * cp * cy - cr * sp * sy
    d2 = cr * sp * cy + sr * cp * sy
    d3 = cr * cp * sy - sr * sp * cy
    quat = advance(floats(data, _XQUAT), 4 * body)
    q0, q1, q2, q3 = quat[0], -quat[1], -quat[2], -quat[3]
    # rotation still to go, in body axes: conj(q) d
    e0 = q0 * d0 - q1 * d1 - q2 * d2 - q3 * d3
    e = advance(small, 18)
    e[0] = q0 * d1 + q1 * d0 + q2 * d3 - q3 * d2
    e[1] = q0 * d2 - q1 * d3 + q2 * d0 + q3 * d1
    e[2] = q0 * d3 + q1 * d2 - q2 * d1 + q3 * d0
    if e0 < 0.0:
        e0 = -e0
        for i in range(3):
            e[i] = -e[i]
    length = math.sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2])
    scale = 2.0 * math.atan2(length, e0) / length if length > 1e-12 else 2.0
    # world error of the position, and (RK4) the path's velocity and acceleration
    error, rate, push = advance(small, 21), advance(small, 24), advance(small, 27)
    error[0] = q[0] + c * x[0] - s * x[1] - position[0]
    error[1] = q[1] + s * x[0] + c * x[1] - position[1]
    error[2] = q[2] + x[2] - position[2]
    rate[0], rate[1], rate[2] = c * v[0] - s * v[1], s * v[0] + c * v[1], v[2]
    push[0], push[1], push[2] = c * a[0] - s * a[1], s * a[0] + c * a[1], a[2]
    spin, twist = advance(small, 30), advance(small, 33)
    # body rates of the zyx Euler angles (Fossen 2021, eq. 2.39), small second-order terms dropped
    sphi, cphi = math.sin(x[3]), math.cos(x[3])
    sth, cth = math.sin(x[4]), math.cos(x[4])
    spin[0] = v[3] - sth * v[5]
    spin[1] = cphi * v[4] + sphi * cth * v[5]
    spin[2] = -sphi * v[4] + cphi * cth * v[5]
    twist[0] = a[3] - sth * a[5]
    twist[1] = cphi * a[4] + sphi * cth * a[5]
    twist[2] = -sphi * a[4] + cphi * cth * a[5]
    body_error, body_rate, body_push = advance(small, 36), scratch(3), scratch(3)
    _rotate_to_body(R, error[0], error[1], error[2], body_error)
    _rotate_to_body(R, rate[0], rate[1], rate[2], body_rate)
    _rotate_to_body(R, push[0], push[1], push[2], body_push)
    w = 0.25 / h  # tracking frequency for RK4, well inside its stability region
    for i in range(3):
        if rk4:
            linear = body_push[i] + 2.0 * w * (body_rate[i] - nu[i]) + w * w * body_error[i]
            angular = twist[i] + 2.0 * w * (spin[i] - nu[3 + i]) + w * w * scale * e[i]
        else:
            linear = (body_error[i] / h - nu[i]) / h
            angular = (scale * e[i] / h - nu[3 + i]) / h
        f[i] += q[5] * linear
        f[3 + i] += q[6] * angular
        inertia[7 * i] += q[5]
        inertia[7 * (3 + i)] += q[6]
    # the twist rate above is in turning axes: take the rotation of the axes out again
    f[0] -= q[5] * (nu[4] * nu[2] - nu[5] * nu[1])
    f[1] -= q[5] * (nu[5] * nu[0] - nu[3] * nu[2])
    f[2] -= q[5] * (nu[3] * nu[1] - nu[4] * nu[0])


@njit
def tank(data, q, R, nu, gravity, f, inertia):
    """Liquid in a tank as a point mass: inertia, Coriolis and weight.

    q: index of the activation that holds the content, mass per unit of it [kg], position (3).
    The momentum flux of filling and emptying is left out (quasi-static filling).
    """
    mass = q[1] * max(floats(data, _ACT)[int(q[0])], 0.0)
    x, y, z = q[2], q[3], q[4]
    # M = m [[I, -S(r)], [S(r), -S(r)^2]] about the body origin
    for i in range(3):
        inertia[7 * i] += mass
    inertia[4] += mass * z
    inertia[5] -= mass * y
    inertia[9] -= mass * z
    inertia[11] += mass * x
    inertia[15] += mass * y
    inertia[16] -= mass * x
    inertia[19] -= mass * z
    inertia[24] += mass * z
    inertia[20] += mass * y
    inertia[30] -= mass * y
    inertia[26] -= mass * x
    inertia[31] += mass * x
    inertia[21] += mass * (y * y + z * z)
    inertia[28] += mass * (x * x + z * z)
    inertia[35] += mass * (x * x + y * y)
    inertia[22] -= mass * x * y
    inertia[27] -= mass * x * y
    inertia[23] -= mass * x * z
    inertia[33] -= mass * x * z
    inertia[29] -= mass * y * z
    inertia[34] -= mass * y * z
    # -m (omega x (v + omega x r)) and the weight, both at r
    p, qq, r = nu[3], nu[4], nu[5]
    vx = nu[0] + qq * z - r * y
    vy = nu[1] + r * x - p * z
    vz = nu[2] + p * y - qq * x
    down = scratch(3)
    _rotate_to_body(R, 0.0, 0.0, -gravity, down)
    fx = mass * (down[0] - (qq * vz - r * vy))
    fy = mass * (down[1] - (r * vx - p * vz))
    fz = mass * (down[2] - (p * vy - qq * vx))
    f[0] += fx
    f[1] += fy
    f[2] += fz
    f[3] += y * fz - z * fy
    f[4] += z * fx - x * fz
    f[5] += x * fy - y * fx


@njit
def _faded(kind, surface):
    """Whether a law fades with the wet share of the body: wave forces, memory of a floating body.

    The pressure on panels knows itself what is wet.
    """
    return kind == t_.EXCITATION or kind == t_.DRIFT or (kind == t_.MEMORY and surface > 0)


@njit
def apply(
    model, data, table, record, body, R, nu, flow, time, place, cosine, sine, state, f, inertia
):
    """All elements of one body record.

    flow (6): velocity of the body relative to the water particles. place (3), cosine, sine: its
    low-frequency place and the phasors of the waves there. state: how wet it is
    (`kernels.surface`).
    """
    share, surface = state[S_SHARE], int(record[t_.B_SURFACE])
    before = scratch(12)
    waves, radiation = advance(f, 6 * t_.C_WAVES), advance(f, 6 * t_.C_RADIATION)
    own = advance(floats(data, _XMAT), 9 * body)
    x = advance(floats(data, _XPOS), 3 * body)
    count = int(record[t_.B_ELEMENTS])
    start = int(record[t_.B_ELEMENT_DATA])
    known = record[t_.B_LOW_FREQUENCY] > 0.0
    for _ in range(count):
        kind = table[start + t_.EL_KIND]
        q = advance(table, start + t_.EL_DATA)
        fading = share < 1.0 and _faded(kind, surface)
        if fading:
            for i in range(6):
                before[i], before[6 + i] = waves[i], radiation[i]
        if (kind == t_.EXCITATION or kind == t_.DRIFT) and not known:
            phasors(table, place[0], place[1], time, cosine, sine)
            known = True
        if kind == t_.RESTORING:
            restoring(q, own, R, x[2], advance(f, 6 * t_.C_RESTORING))
            if state[S_LIMITED] > 0.0:
                force = advance(f, 6 * t_.C_RESTORING)
                limit_restoring(advance(table, surface), q, own, R, x[2], state, force)
        elif kind == t_.EXCITATION:
            excitation(table, q, R, place, cosine, sine, advance(f, 6 * t_.C_WAVES))
        elif kind == t_.PRESCRIBED:
            force = advance(f, 6 * t_.C_PRESCRIBED)
            matrix = advance(inertia, 36 * t_.M_PRESCRIBED)
            prescribed(model, data, table, q, body, R, nu, time, force, matrix)
        elif kind == t_.WIND:
            wind(table, q, R, nu, time, advance(f, 6 * t_.C_WIND))
        elif kind == t_.TANK:
            force = advance(f, 6 * t_.C_BALLAST)
            matrix = advance(inertia, 36 * t_.M_BALLAST)
            tank(data, q, R, nu, table[t_.E_GRAVITY], force, matrix)
        elif kind == t_.THRUSTERS:
            thrust_loss(data, q, own, R, flow, advance(f, 6 * t_.C_THRUST_LOSS))
        elif kind == t_.DRIFT:
            drift(table, q, R, place, cosine, sine, advance(f, 6 * t_.C_WAVES))
        elif kind == t_.MEMORY:
            force = advance(f, 6 * t_.C_RADIATION)
            drive = share if surface > 0 else 1.0
            memory(model, data, table, record, q, R, nu, time, drive, force)
        elif kind == t_.PANELS:
            still = advance(f, 6 * t_.C_RESTORING)
            panels(table, q, own, R, x, time, still, waves)
        if fading:
            for i in range(6):
                waves[i] = before[i] + share * (waves[i] - before[i])
                radiation[i] = before[6 + i] + share * (radiation[i] - before[6 + i])
        start += int(table[start + t_.EL_SIZE])
