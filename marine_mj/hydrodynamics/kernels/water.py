"""Water motion at a body: waves and current, summed natively.

Each wave component is a complex number: its phase times its depth factor, in water of finite depth
two of them. Along a straight row of points it follows from its neighbour by one multiplication, so
a body with strips costs two evaluations of the elementary functions and not one per strip.
"""

import math

from numba import njit

from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.kernels.functions import exponential, sin_cos
from marine_mj.hydrodynamics.kernels.memory import advance, scratch

#: Reassociation lets the sums vectorise; NaN and infinity keep their meaning.
FAST = {"reassoc", "contract", "nsz", "arcp"}

_WAVES = t_.MAX_WAVES
#: Share of its depth that the water keeps in Wheeler's stretching, as in `environment.WaveField`.
LEAST_WATER = 1e-3
#: Values per point: velocity, acceleration (world).
POINT = 6


@njit
def component(table, row):
    """One property (a row of the wave data) of all components."""
    return advance(table, int(table[t_.E_WAVE_DATA]) + row * int(table[t_.E_WAVES]))


@njit(fastmath=FAST)
def phasors(table, x, y, time, cosine, sine):
    """cos and sin of the phase of every component at (x, y), time."""
    n = int(table[t_.E_WAVES])
    omega = component(table, t_.W_OMEGA)
    k = component(table, t_.W_K)
    bx = component(table, t_.W_BX)
    by = component(table, t_.W_BY)
    phase = component(table, t_.W_PHASE)
    for i in range(n):
        s, c = sin_cos(k[i] * (bx[i] * x + by[i] * y) - omega[i] * time + phase[i])
        cosine[i] = c
        sine[i] = s


@njit(fastmath=FAST)
def elevation(table, x, y, time):
    """Surface elevation [m] at (x, y), time."""
    n = int(table[t_.E_WAVES])
    omega = component(table, t_.W_OMEGA)
    k = component(table, t_.W_K)
    bx = component(table, t_.W_BX)
    by = component(table, t_.W_BY)
    phase = component(table, t_.W_PHASE)
    amplitude = component(table, t_.W_AMPLITUDE)
    total = 0.0
    for i in range(n):
        _s, c = sin_cos(k[i] * (bx[i] * x + by[i] * y) - omega[i] * time + phase[i])
        total += amplitude[i] * c
    return total


@njit(fastmath=FAST)
def _state(n, k, speed, height, cosine, sine, real, imaginary):
    """Orbital speed of every component times its phasor: speed exp(k height) (cos + i sin)."""
    for i in range(n):
        size = speed[i] * exponential(k[i] * height)
        real[i] = size * cosine[i]
        imaginary[i] = size * sine[i]


@njit(fastmath=FAST)
def _sum(n, omega, k, bx, by, h_re, h_im, v_re, v_im, convective, out, gradient):
    """Velocity and local acceleration into out (6), velocity gradient into gradient (5).

    h, v: complex amplitude (n) of the horizontal and of the vertical motion of every component.
    """
    vx = vy = vz = ax = ay = az = 0.0
    for i in range(n):
        r = omega[i] * h_im[i]
        vx += h_re[i] * bx[i]
        vy += h_re[i] * by[i]
        vz += v_im[i]
        ax += r * bx[i]
        ay += r * by[i]
        az -= omega[i] * v_re[i]
    out[0] = vx
    out[1] = vy
    out[2] = vz
    out[3] = ax
    out[4] = ay
    out[5] = az
    if convective:
        gxx = gxy = gyy = gxz = gyz = 0.0
        for i in range(n):
            r = k[i] * h_im[i]
            w = k[i] * v_re[i]
            rx = r * bx[i]
            gxx -= rx * bx[i]
            gxy -= rx * by[i]
            gyy -= r * by[i] * by[i]
            gxz += w * bx[i]
            gyz += w * by[i]
        gradient[0] = gxx
        gradient[1] = gxy
        gradient[2] = gyy
        gradient[3] = gxz
        gradient[4] = gyz


@njit
def series(table, knots, interval, offset, time, value, slope):
    """Three values, linear between knots and held outside, and their time derivative."""
    for i in range(3):
        value[i] = 0.0
        slope[i] = 0.0
    if knots == 0:
        return
    place = time / interval
    if not place > 0.0:
        place = 0.0
    index = int(min(place, knots - 1.0))
    fraction = place - index
    inside = index < knots - 1
    for i in range(3):
        a = table[offset + 3 * index + i]
        value[i] = a
        if inside:
            rise = table[offset + 3 * index + 3 + i] - a
            value[i] = a + fraction * rise
            slope[i] = rise / interval


@njit
def _current(table, z, time, velocity, rate, shear):
    """Current velocity (3), its time derivative (3) and d/dz (3), world axes."""
    series(
        table,
        int(table[t_.E_KNOTS]),
        table[t_.E_INTERVAL],
        int(table[t_.E_KNOT_DATA]),
        time,
        velocity,
        rate,
    )
    levels = int(table[t_.E_LEVELS])
    height = int(table[t_.E_LEVEL_DATA])
    speed = height + levels
    lower = 0
    while lower < levels - 1 and z >= table[height + lower + 1]:
        lower += 1
    for i in range(3):
        shear[i] = 0.0
        if levels > 0:
            velocity[i] += table[speed + 3 * lower + i]
    if lower < levels - 1 and z > table[height + lower]:
        step = table[height + lower + 1] - table[height + lower]
        for i in range(3):
            shear[i] = (table[speed + 3 * lower + 3 + i] - table[speed + 3 * lower + i]) / step
            velocity[i] += shear[i] * (z - table[height + lower])


@njit
def _add_current(table, z, time, convective, out, gradient, velocity, rate, shear):
    """Current added to a wave velocity; local acceleration turned into the material one."""
    for i in range(3):
        velocity[i] = 0.0
        rate[i] = 0.0
        shear[i] = 0.0
    if table[t_.E_LEVELS] > 0.0 or table[t_.E_KNOTS] > 0.0:
        _current(table, z, time, velocity, rate, shear)
    for i in range(3):
        out[i] += velocity[i]
        out[3 + i] += rate[i]
    if convective:
        u, v, w = out[0], out[1], out[2]
        out[3] += gradient[0] * u + gradient[1] * v + (gradient[3] + shear[0]) * w
        out[4] += gradient[1] * u + gradient[2] * v + (gradient[4] + shear[1]) * w
        out[5] += gradient[3] * u + gradient[4] * v - (gradient[0] + gradient[2]) * w
        out[5] += shear[2] * w


@njit(inline="always")
def water_left(zeta, depth):
    """Depth of the water below the surface over that of still water: 1 + zeta / h, kept > 0."""
    return max(1.0 + zeta / depth, LEAST_WATER) if depth > 0.0 else 1.0


@njit
def _stretched(table, z, zeta):
    """Height at which the linear kinematics are evaluated; zeta: elevation above the point.

    Points below the bed count as at the bed, as in `environment.WaveField`.
    """
    mode, depth = table[t_.E_STRETCHING], table[t_.E_DEPTH]
    if mode == 1.0:
        z = min(z, 0.0)
    elif mode == 2.0:
        z = min(z, zeta)  # a point in the air gets the surface value
        z = (z - zeta) / water_left(zeta, depth)
    return max(z, -depth) if depth > 0.0 else z


# Short loops with few arrays each: the compiler vectorises a loop only where it can check that its
# arrays do not overlap.


@njit(fastmath=FAST)
def turn(n, k, bx, by, dx, dy, cosine, sine):
    """Turn of the phase of every component over the step (dx, dy)."""
    for i in range(n):
        s, c = sin_cos(k[i] * (bx[i] * dx + by[i] * dy))
        cosine[i] = c
        sine[i] = s


@njit(fastmath=FAST)
def _grow(n, k, dz, cosine, sine, real, imaginary):
    """Factor of every component's state over one step: exp(k dz) (cos + i sin)."""
    for i in range(n):
        factor = exponential(k[i] * dz)
        real[i] = factor * cosine[i]
        imaginary[i] = factor * sine[i]


@njit(fastmath=FAST)
def _step(n, factor_re, factor_im, real, imaginary):
    """Every component's state (or phasor) at the next point."""
    for i in range(n):
        re = real[i] * factor_re[i] - imaginary[i] * factor_im[i]
        imaginary[i] = imaginary[i] * factor_re[i] + real[i] * factor_im[i]
        real[i] = re


@njit(fastmath=FAST)
def _both(n, a, b, total, difference):
    """a + b and a - b."""
    for i in range(n):
        total[i] = a[i] + b[i]
        difference[i] = a[i] - b[i]


@njit(fastmath=FAST)
def _height(n, amplitude, cosine):
    """Elevation [m]: sum a cos(theta)."""
    total = 0.0
    for i in range(n):
        total += amplitude[i] * cosine[i]
    return total


@njit
def _without_waves(table, first, step, count, time, convective, surfaced, out, surface):
    """`water_row` of the current alone."""
    gradient, small = scratch(5), scratch(9)
    velocity, rate, shear = small, advance(small, 3), advance(small, 6)
    for i in range(5):
        gradient[i] = 0.0
    for j in range(count):
        point = advance(out, POINT * j)
        for i in range(POINT):
            point[i] = 0.0
        z = first[2] + j * step[2]
        _add_current(table, z, time, convective, point, gradient, velocity, rate, shear)
        if surfaced:
            surface[j] = elevation(table, first[0] + j * step[0], first[1] + j * step[1], time)


@njit(fastmath=FAST)
def water_row(table, first, step, count, time, orbital, convective, surfaced, out, surface):
    """Water velocity and acceleration at a row of points, and the surface above them.

    Args:
        first: position (3) of the first point, world, m.
        step: vector (3) to the next point, world, m.
        count: number of points.
        orbital: with the orbital motion of the waves; without, the current alone.
        convective: material acceleration instead of the local one.
        surfaced: whether `surface` is wanted.
        out: (count, 6): velocity [m/s] and material (or local) acceleration [m/s2], world.
        surface: (count): elevation above the points, m.
    """
    n = int(table[t_.E_WAVES])
    if n == 0 or not orbital:
        _without_waves(table, first, step, count, time, convective, surfaced, out, surface)
        return
    # one allocation per array: the compiler then knows that they do not overlap
    cosine, sine = scratch(_WAVES), scratch(_WAVES)
    turn_c, turn_s = scratch(_WAVES), scratch(_WAVES)
    up_re, up_im = scratch(_WAVES), scratch(_WAVES)
    down_re, down_im = scratch(_WAVES), scratch(_WAVES)
    rise_re, rise_im = scratch(_WAVES), scratch(_WAVES)
    fall_re, fall_im = scratch(_WAVES), scratch(_WAVES)
    h_re, h_im = scratch(_WAVES), scratch(_WAVES)
    v_re, v_im = scratch(_WAVES), scratch(_WAVES)
    gradient, small = scratch(5), scratch(9)
    velocity, rate, shear = small, advance(small, 3), advance(small, 6)
    omega, k = component(table, t_.W_OMEGA), component(table, t_.W_K)
    bx, by = component(table, t_.W_BX), component(table, t_.W_BY)
    speed, amplitude = component(table, t_.W_SPEED), component(table, t_.W_AMPLITUDE)
    depth, mode = table[t_.E_DEPTH], table[t_.E_STRETCHING]
    finite = depth > 0.0
    last = first[2] + (count - 1) * step[2]
    straight = mode == 0.0 or (mode == 1.0 and max(first[2], last) <= 0.0)
    if finite and not min(first[2], last) >= -depth:
        straight = False  # heights below the bed are held: no constant factor between neighbours
    straight = straight and count > 1
    for i in range(5):
        gradient[i] = 0.0
    phasors(table, first[0], first[1], time, cosine, sine)
    if count > 1:
        turn(n, k, bx, by, step[0], step[1], turn_c, turn_s)
    if straight:
        _grow(n, k, step[2], turn_c, turn_s, rise_re, rise_im)
        if finite:
            _grow(n, k, -step[2], turn_c, turn_s, fall_re, fall_im)
    for j in range(count):
        point = advance(out, POINT * j)
        z = first[2] + j * step[2]
        if j > 0 and straight:
            _step(n, rise_re, rise_im, up_re, up_im)
            if finite:
                _step(n, fall_re, fall_im, down_re, down_im)
        if j > 0 and (surfaced or not straight):
            _step(n, turn_c, turn_s, cosine, sine)
        zeta = 0.0
        if surfaced or mode == 2.0:
            zeta = _height(n, amplitude, cosine)
        if surfaced:
            surface[j] = zeta
        if j == 0 or not straight:
            height = _stretched(table, z, zeta)
            _state(n, k, speed, height, cosine, sine, up_re, up_im)
            if finite:
                _state(n, k, speed, -(height + 2.0 * depth), cosine, sine, down_re, down_im)
        if finite:
            # cosh and sinh of k (z + h)
            _both(n, up_re, down_re, h_re, v_re)
            _both(n, up_im, down_im, h_im, v_im)
            _sum(n, omega, k, bx, by, h_re, h_im, v_re, v_im, convective, point, gradient)
        else:
            _sum(n, omega, k, bx, by, up_re, up_im, up_re, up_im, convective, point, gradient)
        _add_current(table, z, time, convective, point, gradient, velocity, rate, shear)


@njit
def wet_fraction_cylinder(depth, half_height):
    """Submerged part of a lying cylinder whose axis is `depth` below the surface."""
    s = min(max(depth / half_height, -1.0), 1.0)
    return 0.5 + (s * math.sqrt(1.0 - s * s) + math.asin(s)) / math.pi


@njit
def wet_fraction_sphere(depth, half_height):
    """Submerged part of a sphere whose centre is `depth` below the surface."""
    s = min(max(depth / half_height, -1.0), 1.0)
    return 0.25 * (2.0 + 3.0 * s - s * s * s)
