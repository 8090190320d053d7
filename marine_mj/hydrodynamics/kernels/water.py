"""Water motion at a body: waves and current, summed natively.

Each wave component is a pair (cos, sin) of its phase and a pair of depth factors. Along a straight
row of points both follow from their neighbours by one multiplication, so a body with strips costs
two evaluations of the elementary functions and not one per strip.
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
def _depth_factors(table, z, rising, falling):
    """Orbital speed of every component at height z, split as cosh +- sinh: a omega e^{+-k(z+h)}.

    Points below the bed count as at the bed, as in `environment.WaveField`.
    """
    n = int(table[t_.E_WAVES])
    k = component(table, t_.W_K)
    speed = component(table, t_.W_SPEED)
    depth = table[t_.E_DEPTH]
    if depth > 0.0:
        z = max(z, -depth)
    for i in range(n):
        rising[i] = speed[i] * exponential(k[i] * z)
    if depth > 0.0:
        for i in range(n):
            falling[i] = speed[i] * exponential(-k[i] * (z + 2.0 * depth))
    else:
        for i in range(n):
            falling[i] = 0.0


@njit(fastmath=FAST)
def _sum(table, cosine, sine, rising, falling, convective, out, gradient):
    """Velocity and local acceleration into out (6), velocity gradient into gradient (5)."""
    n = int(table[t_.E_WAVES])
    omega = component(table, t_.W_OMEGA)
    k = component(table, t_.W_K)
    bx = component(table, t_.W_BX)
    by = component(table, t_.W_BY)
    vx = vy = vz = ax = ay = az = 0.0
    for i in range(n):
        horizontal = rising[i] + falling[i]
        vertical = rising[i] - falling[i]
        p = horizontal * cosine[i]
        r = omega[i] * horizontal * sine[i]
        vx += p * bx[i]
        vy += p * by[i]
        vz += vertical * sine[i]
        ax += r * bx[i]
        ay += r * by[i]
        az -= omega[i] * vertical * cosine[i]
    out[0] = vx
    out[1] = vy
    out[2] = vz
    out[3] = ax
    out[4] = ay
    out[5] = az
    if convective:
        gxx = gxy = gyy = gxz = gyz = 0.0
        for i in range(n):
            r = k[i] * (rising[i] + falling[i]) * sine[i]
            w = k[i] * (rising[i] - falling[i]) * cosine[i]
            gxx -= r * bx[i] * bx[i]
            gxy -= r * bx[i] * by[i]
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
def _stretched(table, x, y, z, time):
    """Height at which the linear kinematics are evaluated."""
    mode = table[t_.E_STRETCHING]
    if mode == 1.0:
        return min(z, 0.0)
    if mode == 2.0:
        zeta = elevation(table, x, y, time)
        depth = table[t_.E_DEPTH]
        z = min(z, zeta)  # a point in the air gets the surface value
        return (z - zeta) / water_left(zeta, depth)
    return z


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
def _growth(n, k, dz, factor):
    """exp(k dz) of every component."""
    for i in range(n):
        factor[i] = exponential(k[i] * dz)


@njit(fastmath=FAST)
def _rotate(n, turn_c, turn_s, cosine, sine):
    """Phase of every component turned by one step."""
    for i in range(n):
        c = cosine[i] * turn_c[i] - sine[i] * turn_s[i]
        sine[i] = sine[i] * turn_c[i] + cosine[i] * turn_s[i]
        cosine[i] = c


@njit(fastmath=FAST)
def _multiply(n, factor, values):
    """values *= factor."""
    for i in range(n):
        values[i] *= factor[i]


@njit(fastmath=FAST)
def water_row(table, first, step, count, time, orbital, convective, out):
    """Water velocity and acceleration at a row of points.

    Args:
        first: position (3) of the first point, world, m.
        step: vector (3) to the next point, world, m.
        count: number of points.
        orbital: with the orbital motion of the waves; without, the current alone.
        convective: material acceleration instead of the local one.
        out: (count, 6): velocity [m/s] and material (or local) acceleration [m/s2], world.
    """
    # one allocation per array: the compiler then knows that they do not overlap
    cosine, sine = scratch(_WAVES), scratch(_WAVES)
    rising, falling = scratch(_WAVES), scratch(_WAVES)
    small = scratch(16)
    gradient = small
    velocity, rate, shear = advance(small, 5), advance(small, 8), advance(small, 11)
    for i in range(5):
        gradient[i] = 0.0
    n = int(table[t_.E_WAVES])
    if n == 0 or not orbital:
        for j in range(count):
            point = advance(out, POINT * j)
            for i in range(POINT):
                point[i] = 0.0
            z = first[2] + j * step[2]
            _add_current(table, z, time, convective, point, gradient, velocity, rate, shear)
        return
    mode = table[t_.E_STRETCHING]
    depth = table[t_.E_DEPTH]
    last = first[2] + (count - 1) * step[2]
    straight = mode == 0.0 or (mode == 1.0 and max(first[2], last) <= 0.0)
    if depth > 0.0 and not min(first[2], last) >= -depth:
        straight = False  # heights below the bed are held: no constant factor between neighbours
    if straight and count > 1:
        turn_c, turn_s = scratch(_WAVES), scratch(_WAVES)
        rise, fall = scratch(_WAVES), scratch(_WAVES)
        k = component(table, t_.W_K)
        bx = component(table, t_.W_BX)
        by = component(table, t_.W_BY)
        turn(n, k, bx, by, step[0], step[1], turn_c, turn_s)
        _growth(n, k, step[2], rise)
        _growth(n, k, -step[2], fall)
        phasors(table, first[0], first[1], time, cosine, sine)
        _depth_factors(table, first[2], rising, falling)
        for j in range(count):
            point = advance(out, POINT * j)
            _sum(table, cosine, sine, rising, falling, convective, point, gradient)
            z = first[2] + j * step[2]
            _add_current(table, z, time, convective, point, gradient, velocity, rate, shear)
            _rotate(n, turn_c, turn_s, cosine, sine)
            _multiply(n, rise, rising)
            _multiply(n, fall, falling)
        return
    for j in range(count):
        point = advance(out, POINT * j)
        x = first[0] + j * step[0]
        y = first[1] + j * step[1]
        z = first[2] + j * step[2]
        phasors(table, x, y, time, cosine, sine)
        _depth_factors(table, _stretched(table, x, y, z, time), rising, falling)
        _sum(table, cosine, sine, rising, falling, convective, point, gradient)
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
