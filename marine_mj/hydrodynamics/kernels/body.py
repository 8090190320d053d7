"""Loads on one hydrodynamic body: added mass, damping, displacement, elements."""

import math

from numba import njit

from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.kernels import elements
from marine_mj.hydrodynamics.kernels.equations import (
    body_twist,
    load_axes,
    relative_velocity,
    turn_rate,
)
from marine_mj.hydrodynamics.kernels.memory import advance, field, floats, scratch
from marine_mj.hydrodynamics.kernels.shelter import shelter
from marine_mj.hydrodynamics.kernels.water import (
    POINT,
    water_row,
    wet_fraction_cylinder,
    wet_fraction_sphere,
)

_XPOS = field("d", "xpos")
_CAUSES = 6 * len(t_.CAUSES)
_INERTIAS = 36 * t_.INERTIAS
_STRIPS = t_.MAX_STRIPS
_STRIP_VALUES = POINT * t_.MAX_STRIPS


@njit
def _water_at_body(data, table, p, R, x, time, points, wet, nu_w, acc_w):
    """Water twist nu_w (6) and acceleration acc_w (6) the body feels; wet part of every point.

    A body with strips gets the rigid motion that fits the water motion along its length best
    (weighted least squares of the transverse components); without strips, the motion at its
    centre of buoyancy. Returns the mean wet fraction.
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
    half = p[t_.B_HALF_HEIGHT]
    reach = half + table[t_.E_CREST]
    slant = abs(R[6])
    if strips:
        half = half * math.sqrt(max(1.0 - slant * slant, 0.0)) + 0.5 * p[t_.B_STRIP_DX] * slant
    surface = scratch(_STRIPS)
    near = half > 0.0 and max(first[2], first[2] + (count - 1) * step[2]) > -reach
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

    # wet part: 1 unless the body is near the surface
    mean_wet = 0.0
    weights = advance(table, int(p[t_.B_STRIP_WEIGHT]))
    for j in range(count):
        pz = first[2] + j * step[2]
        fraction = 1.0
        if near and pz > -reach:
            depth = surface[j] - pz
            if strips:
                fraction = wet_fraction_cylinder(depth, half)
            else:
                fraction = wet_fraction_sphere(depth, half)
        wet[j] = fraction
        mean_wet += fraction * (weights[j] if strips else 1.0)

    for i in range(6):
        nu_w[i] = 0.0
        acc_w[i] = 0.0
    if not strips:
        for i in range(3):
            nu_w[i] = points[i]
            acc_w[i] = points[3 + i]
        return mean_wet
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
    return mean_wet


@njit
def _added_mass_loads(A, nu, nu_r, flow, spin, acc_w, f):
    """Everything of added mass but -M_A nu_dot: C_A(nu_r) nu_r and the water's acceleration.

    Kirchhoff's equations in axes that turn with `spin` (Fossen 2021, eq. 6.50, and Lamb 1932,
    art. 124); the Munk moment from `flow`, the velocity (3) relative to the water particles.
    """
    small = scratch(15)
    p, a, m = small, advance(small, 6), advance(small, 12)
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
    for i in range(3):
        m[i] = A[6 * i] * flow[0] + A[6 * i + 1] * flow[1] + A[6 * i + 2] * flow[2]
        m[i] += A[6 * i + 3] * nu_r[3] + A[6 * i + 4] * nu_r[4] + A[6 * i + 5] * nu_r[5]
    f[0] -= wy * p[2] - wz * p[1]
    f[1] -= wz * p[0] - wx * p[2]
    f[2] -= wx * p[1] - wy * p[0]
    f[3] -= wy * p[5] - wz * p[4] + flow[1] * m[2] - flow[2] * m[1]
    f[4] -= wz * p[3] - wx * p[5] + flow[2] * m[0] - flow[0] * m[2]
    f[5] -= wx * p[4] - wy * p[3] + flow[0] * m[1] - flow[1] * m[0]


@njit
def _damping_loads(p, nu, nu_r, flow, points, wet, mean_wet, f):
    """Linear damping, and quadratic and cross-flow drag on the motion relative to the particles."""
    linear, quadratic = advance(p, t_.B_LINEAR), advance(p, t_.B_QUADRATIC)
    for i in range(6):
        force = 0.0
        for j in range(6):
            force += linear[6 * i + j] * nu_r[j] + quadratic[6 * i + j] * abs(flow[j]) * flow[j]
        f[i] -= mean_wet * force
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
def body_loads(model, data, table, p, time, R, nu, f, inertia):
    """Wrenches by cause f (cause, 6) and inertia matrices (INERTIAS, 36) of one body record.

    Both about the body origin in the axes R (9) of the loads, which it returns, with the twist nu.
    """
    body = int(p[t_.B_BODY])
    x = advance(floats(data, _XPOS), 3 * body)
    for i in range(_CAUSES):
        f[i] = 0.0
    for i in range(_INERTIAS):
        inertia[i] = 0.0
    small = scratch(27)
    nu_w, acc_w, nu_r, spin = small, advance(small, 6), advance(small, 12), advance(small, 18)
    flow = advance(small, 21)
    points, wet = scratch(_STRIP_VALUES), scratch(_STRIPS)
    load_axes(data, p, R)
    body_twist(data, p, R, nu)
    turn_rate(data, p, R, nu, spin)
    mean_wet = _water_at_body(data, table, p, R, x, time, points, wet, nu_w, acc_w)
    for i in range(6):
        nu_r[i] = nu[i] - nu_w[i]
        flow[i] = nu_r[i]
    if p[t_.B_SEAKEEPING] > 0.0:
        # RAOs leave no orbital motion in nu_r; what grows with the square of the relative velocity
        # still needs it: a hull that moves with the wave meets no flow
        relative_velocity(table, R, x, time, True, nu, flow)
    A = advance(p, t_.B_ADDED_MASS)
    for i in range(36):
        inertia[i] = A[i]
    _added_mass_loads(A, nu, nu_r, flow, spin, acc_w, f)
    _damping_loads(p, nu, nu_r, flow, points, wet, mean_wet, advance(f, 6 * t_.C_DAMPING))
    buoyancy, waves = advance(f, 6 * t_.C_RESTORING), advance(f, 6 * t_.C_WAVES)
    _displacement_loads(table, p, R, points, wet, buoyancy, waves)
    elements.apply(model, data, table, p, body, R, nu, flow, time, f, inertia)
