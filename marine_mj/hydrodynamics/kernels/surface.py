"""How wet a body is at the surface: the share of its added mass and damping that acts.

A submerged body has the wet part of its strips, or of a sphere. A floating one stands on four
columns that have the stiffness of its restoring matrix (`hydrodynamics.surface`): between the
water's end and the deck of a column its lift is linear, beyond them it is held. As long as the
columns carry half of the weight the body is as wet as afloat; from there the share falls to zero.
"""

import math

from numba import njit

from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.kernels.low_frequency import (
    low_frequency_velocity,
)
from marine_mj.hydrodynamics.kernels.memory import advance, field, float_value, floats, scratch
from marine_mj.hydrodynamics.kernels.water import (
    FAST,
    component,
    elevation,
    phasors,
    wet_fraction_cylinder,
    wet_fraction_sphere,
)

_ACT_DOT = field("d", "act_dot")
_XPOS = field("d", "xpos")
_XMAT = field("d", "xmat")
_TIMESTEP = field("m", "opt.timestep")
_WAVES = t_.MAX_WAVES

#: State of a body at the surface: wet share, rate at which it grows (1/s, 0 where it falls), its
#: slope over the share of the weight that is carried, 1 where a column is at its limit; then of
#: every column the immersed height and the elevation; depth at the origin and its slope along x.
(S_SHARE, S_ENTERING, S_SLOPE, S_LIMITED, S_COLUMN, S_WAVE, S_DEPTH, S_TRIM, S_SIZE) = (
    *(0, 1, 2, 3, 4, 8, 12, 13, 14),
)


@njit(fastmath=FAST)
def _mean_surface(table, amplitude, cosine, sine, out):
    """out (4): elevation [m] where the phasors are, its slopes (world), its rate [m/s]."""
    n = int(table[t_.E_WAVES])
    omega = component(table, t_.W_OMEGA)
    k = component(table, t_.W_K)
    bx = component(table, t_.W_BX)
    by = component(table, t_.W_BY)
    height = slope_x = slope_y = rate = 0.0
    for i in range(n):
        height += amplitude[i] * cosine[i]
        r = amplitude[i] * sine[i]
        rate += r * omega[i]
        r *= k[i]
        slope_x -= r * bx[i]
        slope_y -= r * by[i]
    out[0] = height
    out[1] = slope_x
    out[2] = slope_y
    out[3] = rate


@njit
def fade(carried):
    """Wet share of a hull whose water carries that share of its weight: 1 from a half on."""
    x = min(max(2.0 * carried, 0.0), 1.0)
    return x * x * (3.0 - 2.0 * x)


@njit
def publish_share(data, p, share):
    """Keep the wet share of a body for the rates of its radiation memory in the same forward pass.

    In the rate of the first low-frequency state, which is written behind those of the memories.
    """
    address = int(p[t_.B_LOW_FREQUENCY]) - 1
    if address >= 0:
        floats(data, _ACT_DOT)[address] = share


@njit
def published_share(model, data, table, p, R, nu, time):
    """Wet share of a floating body: published, or in calm water (no such state) formed again."""
    address = int(p[t_.B_LOW_FREQUENCY]) - 1
    if address >= 0:
        return floats(data, _ACT_DOT)[address]
    state, place, none = scratch(S_SIZE), scratch(3), scratch(1)
    back = float_value(model, _TIMESTEP)
    floating_state(data, table, p, R, nu, time, back, place, none, none, state)
    return state[S_SHARE]


@njit
def floating_state(data, table, p, R, nu, time, back, place, cosine, sine, state):
    """State of a floating body; `back`: seconds over which its share is compared with before.

    place (3), cosine, sine: its low-frequency place, and the phasors of the waves there.
    """
    b = advance(table, int(p[t_.B_SURFACE]))
    body = int(p[t_.B_BODY])
    x = advance(floats(data, _XPOS), 3 * body)
    own = advance(floats(data, _XMAT), 9 * body)
    heave = x[2] - b[t_.SF_HEIGHT]
    roll = math.atan2(own[7], own[8]) - b[t_.SF_ROLL]
    pitch = -math.asin(min(max(own[6], -1.0), 1.0)) - b[t_.SF_PITCH]
    # rates of the Euler angles from d/dt R = omega x R, world axes
    ox = R[0] * nu[3] + R[1] * nu[4] + R[2] * nu[5]
    oy = R[3] * nu[3] + R[4] * nu[4] + R[5] * nu[5]
    d6, d7, d8 = ox * own[3] - oy * own[0], ox * own[4] - oy * own[1], ox * own[5] - oy * own[2]
    level = max(own[7] * own[7] + own[8] * own[8], 1e-12)
    roll_rate = (own[8] * d7 - own[7] * d8) / level
    pitch_rate = -d6 / math.sqrt(level)
    rise = R[6] * nu[0] + R[7] * nu[1] + R[8] * nu[2]
    zeta = along = across = 0.0
    if table[t_.E_WAVES] > 0.0:
        sea, velocity = scratch(4), scratch(3)
        amplitude = advance(table, int(b[t_.SF_AMPLITUDES]))
        yaw = math.atan2(own[3], own[0])
        if b[t_.SF_FOLLOWS] > 0.0 and p[t_.B_LOW_FREQUENCY] > 0.0:
            # the surface that belongs to the wave force
            low_frequency_velocity(data, p, x, own, R, nu, sea)
            velocity[0] = R[0] * sea[0] + R[1] * sea[1]
            velocity[1] = R[3] * sea[0] + R[4] * sea[1]
            yaw = place[2]
            _mean_surface(table, amplitude, cosine, sine, sea)
        else:
            for i in range(2):
                velocity[i] = R[3 * i] * nu[0] + R[3 * i + 1] * nu[1] + R[3 * i + 2] * nu[2]
            own_c, own_s = scratch(_WAVES), scratch(_WAVES)
            phasors(table, x[0], x[1], time, own_c, own_s)
            _mean_surface(table, amplitude, own_c, own_s, sea)
        zeta = sea[0]
        c, s = math.cos(yaw), math.sin(yaw)
        along, across = c * sea[1] + s * sea[2], c * sea[2] - s * sea[1]
        rise -= sea[3] + sea[1] * velocity[0] + sea[2] * velocity[1]
    draught, depth = b[t_.SF_DRAUGHT], b[t_.SF_DEPTH]
    now = before = limited = 0.0
    for i in range(t_.COLUMNS):
        over_roll, over_pitch = b[t_.SF_ARMS + 2 * i], b[t_.SF_ARMS + 2 * i + 1]
        wave = zeta + over_roll * across - over_pitch * along
        height = draught - heave - over_roll * roll - over_pitch * pitch + wave
        state[S_COLUMN + i], state[S_WAVE + i] = height, wave
        if height < 0.0 or height > depth:
            limited = 1.0
        now += min(max(height, 0.0), depth)
        height += back * (rise + over_roll * roll_rate + over_pitch * pitch_rate)
        before += min(max(height, 0.0), depth)
    carried = now / (t_.COLUMNS * draught)
    share = fade(carried)
    state[S_SHARE] = share
    state[S_ENTERING] = max(share - fade(before / (t_.COLUMNS * draught)), 0.0) / back
    part = min(max(2.0 * carried, 0.0), 1.0)
    state[S_SLOPE] = 12.0 * part * (1.0 - part)
    state[S_LIMITED] = 1.0 if share < 1.0 else limited
    state[S_DEPTH], state[S_TRIM] = draught - heave + zeta, pitch + along


@njit
def _part(depth, half, strips):
    """Wet part of a strip or of a sphere."""
    return wet_fraction_cylinder(depth, half) if strips else wet_fraction_sphere(depth, half)


@njit
def _half_height(p, slant):
    """Half height [m] over which a strip leaves the water, its axis at that sine to the level."""
    half = p[t_.B_HALF_HEIGHT]
    if p[t_.B_STRIPS] > 0.0:
        return half * math.sqrt(max(1.0 - slant * slant, 0.0)) + 0.5 * p[t_.B_STRIP_DX] * slant
    return half


@njit
def near_surface(table, p, nu, first, step, count, back):
    """Whether a strip (or the sphere) may be in the air now or may have been `back` s ago."""
    half = p[t_.B_HALF_HEIGHT]
    if half == 0.0:
        return False
    strips = p[t_.B_STRIPS] > 0.0
    if strips:
        half += 0.5 * p[t_.B_STRIP_DX]
    ends = abs(p[t_.B_STRIP_X]) + count * p[t_.B_STRIP_DX] if strips else 0.0
    speed = abs(nu[0]) + abs(nu[1]) + abs(nu[2]) + ends * (abs(nu[4]) + abs(nu[5]))
    top = max(first[2], first[2] + (count - 1) * step[2])
    return top > -p[t_.B_HALF_HEIGHT] - table[t_.E_CREST] - half - 2.0 * back * speed


@njit
def wet_parts(table, p, R, nu, first, step, count, time, back, near, surface, wet, state):
    """Wet part of every strip (or of the sphere), and the state of the body they make up.

    near: see `near_surface`; surface (count): elevation above the strips where it is true.
    """
    strips = p[t_.B_STRIPS] > 0.0
    for i in range(S_SIZE):
        state[i] = 0.0
    state[S_SHARE] = 1.0
    if not near:
        for j in range(count):
            wet[j] = 1.0
        return
    reach = p[t_.B_HALF_HEIGHT] + table[t_.E_CREST]
    half = _half_height(p, abs(R[6]))
    slant = min(abs(R[6] - back * (R[7] * nu[5] - R[8] * nu[4])), 1.0)
    half_before = _half_height(p, slant)
    weights = advance(table, int(p[t_.B_STRIP_WEIGHT]))
    now = before = 0.0
    dry = False
    for j in range(count):
        px, py, pz = first[0] + j * step[0], first[1] + j * step[1], first[2] + j * step[2]
        arm = p[t_.B_STRIP_X] + j * p[t_.B_STRIP_DX] if strips else 0.0
        u, v, w = nu[0], nu[1] + nu[5] * arm, nu[2] - nu[4] * arm
        # deeper than this it was under water a moment ago, too
        margin = half + 2.0 * back * (abs(u) + abs(v) + abs(w))
        fraction = past = 1.0
        if pz > -reach - margin:
            depth = surface[j] - pz
            fraction = past = _part(depth, half, strips)
            if fraction > 0.0 and depth < half + margin:
                px -= back * (R[0] * u + R[1] * v + R[2] * w)
                py -= back * (R[3] * u + R[4] * v + R[5] * w)
                pz -= back * (R[6] * u + R[7] * v + R[8] * w)
                depth = elevation(table, px, py, time - back) - pz
                past = _part(depth, half_before, strips)
        dry = dry or fraction < 1.0
        wet[j] = fraction
        weight = weights[j] if strips else 1.0
        now += fraction * weight
        before += past * weight
    if dry or before < now:
        state[S_SHARE] = now
        state[S_ENTERING] = max(now - before, 0.0) / back


@njit
def wet_strips(p, draught, state, wet):
    """Wet part of every strip of a floating body: 1 as long as half of its draught is left."""
    for j in range(int(p[t_.B_STRIPS])):
        x = p[t_.B_STRIP_X] + j * p[t_.B_STRIP_DX]
        wet[j] = fade((state[S_DEPTH] + x * state[S_TRIM]) / draught)


@njit
def entry_loads(A, flow, rate, f):
    """f -= dM_A/dt nu_r while the wet share grows (von Karman 1929); on exit nothing acts.

    A: the whole added mass (36), flow: motion relative to the water (6), rate: of the share, 1/s.
    With the share's growth over the last step the semi-implicit integrators keep the momentum
    `(M + s A) v` to the last bit, and at any step and speed the energy does not grow.
    """
    for i in range(6):
        momentum = 0.0
        for j in range(6):
            momentum += A[6 * i + j] * flow[j]
        f[i] -= rate * momentum


@njit
def limit_restoring(b, q, own, R, height, state, f):
    """What the limits of the columns change about the restoring wrench f (6) of `restoring`.

    b: surface block. q: parameters of the restoring element. height: of the body origin, m. The sum
    has a potential: the lift of the columns, and the wet share s of the rest U of the linear law,
    whose force is `-s dU/dq - U ds/dq`.
    """
    share = state[S_SHARE]
    k, depth = b[t_.SF_STIFFNESS], b[t_.SF_DEPTH]
    small = scratch(9)
    eta, arm, up = small, advance(small, 3), advance(small, 6)
    eta[0] = height - b[t_.SF_HEIGHT]
    eta[1] = math.atan2(own[7], own[8])
    eta[2] = -math.asin(min(max(own[6], -1.0), 1.0))
    mean_roll = mean_pitch = 0.0
    for i in range(t_.COLUMNS):
        mean_roll += b[t_.SF_ARMS + 2 * i] / t_.COLUMNS
        mean_pitch += b[t_.SF_ARMS + 2 * i + 1] / t_.COLUMNS
    energy = 0.0
    for i in range(6):
        force = 0.0
        for j in range(3):
            force += b[t_.SF_REST + 3 * i + j] * eta[j]
        f[i] += (1.0 - share) * force
        if i == 3 or i == 4:
            energy += 0.5 * force * eta[i - 2]
    # the weight lifted at the centre of gravity, less what the columns have of it
    weight = q[37]
    for i in range(3):
        arm[i] = 0.0
        for j in range(3):
            world = own[3 * j] * q[38] + own[3 * j + 1] * q[39] + own[3 * j + 2] * q[40]
            arm[i] += R[3 * j + i] * world
        up[i] = weight * R[6 + i]
    lost = share - 1.0
    f[3] += lost * (arm[1] * up[2] - arm[2] * up[1] - weight * mean_roll)
    f[4] += lost * (arm[2] * up[0] - arm[0] * up[2] - weight * mean_pitch)
    f[5] += lost * (arm[0] * up[1] - arm[1] * up[0])
    energy += weight * (q[40] - own[6] * q[38] - own[7] * q[39] - own[8] * q[40])
    energy += weight * (mean_roll * eta[1] + mean_pitch * eta[2])
    push = state[S_SLOPE] * energy * k / weight
    for i in range(t_.COLUMNS):
        height = state[S_COLUMN + i]
        change = k * (min(max(height, 0.0), depth) - height)
        change += (1.0 - share) * k * state[S_WAVE + i]
        if 0.0 < height < depth:
            change += push
        for j in range(3):
            f[j] += change * R[6 + j]
        f[3] += change * b[t_.SF_ARMS + 2 * i]
        f[4] += change * b[t_.SF_ARMS + 2 * i + 1]
