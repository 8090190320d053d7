"""Loads on one hydrodynamic body: added mass, damping, displacement, elements."""

import math

from numba import njit

from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.kernels import elements
from marine_mj.hydrodynamics.kernels.equations import (
    body_twist,
    load_axes,
    relative_velocity,
    runge_kutta,
    turn_rate,
)
from marine_mj.hydrodynamics.kernels.long_wave import long_wave
from marine_mj.hydrodynamics.kernels.low_frequency import (
    low_frequency_place,
    low_frequency_velocity,
)
from marine_mj.hydrodynamics.kernels.memory import advance, field, float_value, floats, scratch
from marine_mj.hydrodynamics.kernels.shelter import shelter
from marine_mj.hydrodynamics.kernels.surface import (
    S_ENTERING,
    S_SHARE,
    S_SIZE,
    entry_loads,
    floating_state,
    near_surface,
    publish_share,
    wet_parts,
    wet_strips,
)
from marine_mj.hydrodynamics.kernels.water import POINT, phasors, water_row

_XPOS = field("d", "xpos")
_XMAT = field("d", "xmat")
_TIMESTEP = field("m", "opt.timestep")
#: RK4 wants the rate of the wet share at an instant: over this part of a step.
_INSTANT = 1.0 / 1024.0
_WAVES = t_.MAX_WAVES
_CAUSES = 6 * len(t_.CAUSES)
_INERTIAS = 36 * t_.INERTIAS
_STRIPS = t_.MAX_STRIPS
_STRIP_VALUES = POINT * t_.MAX_STRIPS


@njit
def _water_at_body(
    data, table, p, R, x, nu, time, back, place, cosine, sine, points, wet, state, nu_w, acc_w
):
    """Water twist nu_w (6) and acceleration acc_w (6) the body feels; wet parts and state.

    place (3), cosine, sine: low-frequency place and phasors of the waves there, where it has one.

    A body with strips gets the rigid motion that fits the water motion along its length best
    (weighted least squares of the transverse components); without strips, the motion at its
    centre of buoyancy.
    """
    small = scratch(16)
    first, step = small, advance(small, 3)
    count = int(p[t_.B_STRIPS])
    strips = count > 0
    if strips:
        offset, dx = p[t_.B_STRIP_X], p[t_.B_STRIP_DX]
        for i in range(3):
            first[i] = x[i] + R[3 * i] * offset
            step[i] = R[3 * i] * dx
    else:
        count = 1
        for i in range(3):
            first[i] = x[i]
            step[i] = 0.0
    orbital, convective = p[t_.B_SEAKEEPING] == 0.0, p[t_.B_CONVECTIVE] > 0.0
    if p[t_.B_LONG_WAVE] > 0.0 and not strips:
        orbital = False  # the law of long waves brings its own
    surface = scratch(_STRIPS)
    near = p[t_.B_SURFACE] == 0.0 and near_surface(table, p, nu, first, step, count, back)
    water_row(table, first, step, count, time, orbital, convective, near, points, surface)
    if p[t_.B_SHELTER] > 0.0:
        q = advance(table, int(p[t_.B_SHELTER]))
        shelter(data, table, q, first, step, count, time, points)

    # world to body axes, in place
    for j in range(count):
        g = advance(points, POINT * j)
        for part in range(2):
            a, b, c = g[3 * part], g[3 * part + 1], g[3 * part + 2]
            for i in range(3):
                g[3 * part + i] = R[i] * a + R[3 + i] * b + R[6 + i] * c

    weights = advance(table, int(p[t_.B_STRIP_WEIGHT]))
    if p[t_.B_SURFACE] > 0.0:
        floating_state(data, table, p, R, nu, time, back, place, cosine, sine, state)
        wet_strips(p, table[int(p[t_.B_SURFACE]) + t_.SF_DRAUGHT], state, wet)
    else:
        wet_parts(table, p, R, nu, first, step, count, time, back, near, surface, wet, state)

    for i in range(6):
        nu_w[i] = 0.0
        acc_w[i] = 0.0
    if not strips:
        for i in range(3):
            nu_w[i] = points[i]
            acc_w[i] = points[3 + i]
        return
    mean = p[t_.B_STRIP_MEAN]
    vy = vz = ay = az = 0.0
    for j in range(count):
        g = advance(points, POINT * j)
        w = weights[j]
        arm = w * (p[t_.B_STRIP_X] + j * p[t_.B_STRIP_DX] - mean)
        for i in range(3):
            nu_w[i] += w * g[i]
            acc_w[i] += w * g[3 + i]
        vy += arm * g[1]
        vz += arm * g[2]
        ay += arm * g[4]
        az += arm * g[5]
    spread = 1.0 / p[t_.B_STRIP_SPREAD]
    nu_w[4], nu_w[5] = -vz * spread, vy * spread
    acc_w[4], acc_w[5] = -az * spread, ay * spread
    # from the mean position of the strips to the body origin
    nu_w[1] -= nu_w[5] * mean
    nu_w[2] += nu_w[4] * mean
    acc_w[1] -= acc_w[5] * mean
    acc_w[2] += acc_w[4] * mean


@njit
def _added_mass_loads(A, nu, nu_r, spin, acc_w, f):
    """Everything of added mass but -M_A nu_dot: C_A(nu_r) nu_r and the water's acceleration.

    Kirchhoff's equations in axes that turn with `spin` (Fossen 2021, eq. 6.50, and Lamb 1932,
    art. 124), without the Munk moment `v x (A nu)`.
    """
    small = scratch(12)
    p, a = small, advance(small, 6)
    wx, wy, wz = spin[0], spin[1], spin[2]
    # acceleration of the water seen from the turning axes: R^T Dv/Dt - omega x v_w
    ux, uy, uz = nu[0] - nu_r[0], nu[1] - nu_r[1], nu[2] - nu_r[2]
    a[0] = acc_w[0] - (wy * uz - wz * uy)
    a[1] = acc_w[1] - (wz * ux - wx * uz)
    a[2] = acc_w[2] - (wx * uy - wy * ux)
    a[3], a[4], a[5] = acc_w[3], acc_w[4], acc_w[5]
    for i in range(6):
        p[i] = 0.0
        force = 0.0
        for j in range(6):
            p[i] += A[6 * i + j] * nu_r[j]
            force += A[6 * i + j] * a[j]
        f[i] += force
    f[0] -= wy * p[2] - wz * p[1]
    f[1] -= wz * p[0] - wx * p[2]
    f[2] -= wx * p[1] - wy * p[0]
    f[3] -= wy * p[5] - wz * p[4]
    f[4] -= wz * p[3] - wx * p[5]
    f[5] -= wx * p[4] - wy * p[3]


@njit
def _munk_moment(A, flow, spin, f):
    """Munk moment of a submerged body: f -= v x (A nu) (Lamb 1932, art. 124).

    flow (3): velocity relative to the water particles, spin (3): angular velocity.
    """
    m = scratch(3)
    for i in range(3):
        m[i] = A[6 * i] * flow[0] + A[6 * i + 1] * flow[1] + A[6 * i + 2] * flow[2]
        m[i] += A[6 * i + 3] * spin[0] + A[6 * i + 4] * spin[1] + A[6 * i + 5] * spin[2]
    f[3] -= flow[1] * m[2] - flow[2] * m[1]
    f[4] -= flow[2] * m[0] - flow[0] * m[2]
    f[5] -= flow[0] * m[1] - flow[1] * m[0]


@njit
def _slow_munk_moment(data, p, x, A, R, nu, nu_r, f):
    """Munk moment of a hull in first-order waves: about the vertical, of its slow motion.

    What products of first-order motions push is in the drift coefficients already, a database of
    zero speed has no part of them in heave and pitch, and the large added mass of a flat bottom in
    heave makes no roll moment of a hull that the surface ends at.
    """
    slow = scratch(3)
    own = advance(floats(data, _XMAT), 9 * int(p[t_.B_BODY]))
    low_frequency_velocity(data, p, x, own, R, nu, slow)
    # the water moves as nu - nu_r: the current
    u, v, r = slow[0] - nu[0] + nu_r[0], slow[1] - nu[1] + nu_r[1], slow[2]
    f[5] -= u * (A[6] * u + A[7] * v + A[11] * r) - v * (A[0] * u + A[1] * v + A[5] * r)


@njit
def _damping_loads(p, nu, nu_r, flow, points, wet, share, f):
    """Linear damping, and quadratic and cross-flow drag on the motion relative to the particles.

    share: wet share of the body; the drag of a strip goes with its own wet part.
    """
    linear, quadratic = advance(p, t_.B_LINEAR), advance(p, t_.B_QUADRATIC)
    for i in range(6):
        force = 0.0
        for j in range(6):
            force += linear[6 * i + j] * nu_r[j] + quadratic[6 * i + j] * abs(flow[j]) * flow[j]
        f[i] -= share * force
    drag_y, drag_z = p[t_.B_STRIP_DRAG], p[t_.B_STRIP_DRAG + 1]
    if drag_y == 0.0 and drag_z == 0.0:
        return
    dx = p[t_.B_STRIP_DX]
    for j in range(int(p[t_.B_STRIPS])):
        x = p[t_.B_STRIP_X] + j * dx
        g = advance(points, POINT * j)
        v = nu[1] + nu[5] * x - g[1]
        w = nu[2] - nu[4] * x - g[2]
        speed = wet[j] * dx * math.sqrt(v * v + w * w)
        y, z = -drag_y * speed * v, -drag_z * speed * w
        f[1] += y
        f[2] += z
        f[4] -= x * z
        f[5] += x * y


@njit
def _displacement_loads(table, p, R, points, wet, buoyancy, pressure):
    """Buoyancy and Froude-Krylov force rho V Dv/Dt of the wet volume, strip by strip."""
    volume = p[t_.B_VOLUME]
    if volume == 0.0:
        return
    count = int(p[t_.B_STRIPS])
    strips = count > 0
    if not strips:
        count = 1
    weights = advance(table, int(p[t_.B_STRIP_WEIGHT]))
    lift = table[t_.E_DENSITY] * table[t_.E_GRAVITY]
    krylov = table[t_.E_DENSITY] * p[t_.B_FROUDE_KRYLOV]
    cx, cy, cz = p[t_.B_CB], p[t_.B_CB + 1], p[t_.B_CB + 2]
    for j in range(count):
        g = advance(points, POINT * j)
        part = volume * wet[j]
        x = cx
        if strips:
            part *= weights[j]
            x += p[t_.B_STRIP_X] + j * p[t_.B_STRIP_DX] - p[t_.B_STRIP_MEAN]
        for law in range(2):
            if law == 0:
                fx, fy, fz = part * lift * R[6], part * lift * R[7], part * lift * R[8]
                f = buoyancy
            else:
                fx, fy, fz = part * krylov * g[3], part * krylov * g[4], part * krylov * g[5]
                f = pressure
            f[0] += fx
            f[1] += fy
            f[2] += fz
            f[3] += cy * fz - cz * fy
            f[4] += cz * fx - x * fz
            f[5] += x * fy - cy * fx


@njit
def _long_waves(table, p, R, x, place, time, share, nu_w, acc_w, f):
    """Water about a hull in long waves, nu_w and acc_w (6), and the wet share of their force."""
    at, force = scratch(3), scratch(6)
    at[0], at[1], at[2] = place[0], place[1], x[2]
    for i in range(6):
        force[i] = 0.0
    convective = p[t_.B_CONVECTIVE] > 0.0
    q = advance(table, int(p[t_.B_LONG_WAVE]))
    long_wave(table, q, R, at, place[2], time, convective, nu_w, acc_w, force)
    for i in range(6):
        f[i] += share * force[i]


@njit
def body_loads(model, data, table, p, time, stepping, R, nu, f, inertia):
    """Wrenches by cause f (cause, 6) and inertia matrices (INERTIAS, 36) of one body record.

    Both about the body origin in the axes R (9) of the loads, which it returns, with the twist nu.
    stepping: within a forward pass, whose rates of activations come next.
    """
    body = int(p[t_.B_BODY])
    x = advance(floats(data, _XPOS), 3 * body)
    for i in range(_CAUSES):
        f[i] = 0.0
    for i in range(_INERTIAS):
        inertia[i] = 0.0
    small, state = scratch(27), scratch(S_SIZE)
    nu_w, acc_w, nu_r, spin = small, advance(small, 6), advance(small, 12), advance(small, 18)
    flow = advance(small, 21)
    h = float_value(model, _TIMESTEP)
    back = h * _INSTANT if runge_kutta(model) else h
    points, wet = scratch(_STRIP_VALUES), scratch(_STRIPS)
    load_axes(data, p, R)
    body_twist(data, p, R, nu)
    turn_rate(data, p, R, nu, spin)
    place, cosine, sine = scratch(3), scratch(_WAVES), scratch(_WAVES)
    low_frequency_place(data, p, x, advance(floats(data, _XMAT), 9 * body), place)
    if int(p[t_.B_LOW_FREQUENCY]) > 0:
        phasors(table, place[0], place[1], time, cosine, sine)
    _water_at_body(
        data, table, p, R, x, nu, time, back, place, cosine, sine, points, wet, state, nu_w, acc_w
    )
    share = state[S_SHARE]
    if stepping:
        publish_share(data, p, share)
    if p[t_.B_LONG_WAVE] > 0.0:
        force = advance(f, 6 * t_.C_WAVES)
        _long_waves(table, p, R, x, place, time, share, nu_w, acc_w, force)
    for i in range(6):
        nu_r[i] = nu[i] - nu_w[i]
        flow[i] = nu_r[i]
    if p[t_.B_SEAKEEPING] > 0.0:
        # RAOs leave no orbital motion in nu_r; what grows with the square of the relative velocity
        # still needs it: a hull that moves with the wave meets no flow
        relative_velocity(table, R, x, time, True, nu, flow)
    A = advance(p, t_.B_ADDED_MASS)
    for i in range(36):
        inertia[i] = share * A[i]
    _added_mass_loads(inertia, nu, nu_r, spin, acc_w, f)
    if p[t_.B_SEAKEEPING] > 0.0 or p[t_.B_LONG_WAVE] > 0.0:
        _slow_munk_moment(data, p, x, inertia, R, nu, nu_r, f)
    else:
        _munk_moment(inertia, flow, advance(nu_r, 3), f)
    if state[S_ENTERING] > 0.0:
        # a step can stop no more than what is there: at most twice the acting mass (RK4)
        entry_loads(A, flow, min(state[S_ENTERING], 2.0 * share / h), f)
    _damping_loads(p, nu, nu_r, flow, points, wet, share, advance(f, 6 * t_.C_DAMPING))
    buoyancy, waves = advance(f, 6 * t_.C_RESTORING), advance(f, 6 * t_.C_WAVES)
    _displacement_loads(table, p, R, points, wet, buoyancy, waves)
    elements.apply(
        model, data, table, p, body, R, nu, flow, time, place, cosine, sine, state, f, inertia
    )
