"""Pressure head of the incident waves at the vertices of a hull, zero at the surface.

With s the submersion of a point below the surface above it, Wheeler's stretching (1970) of linear
theory gives

    p / (rho g) = s - D,   D(x, y, s') = sum a cos(theta) (1 - C(s')),   s' = s / (1 + zeta / h)

with C(s') = cosh k(h - s') / cosh kh, in deep water exp(-k s'): D vanishes at the surface, and so
does the pressure. The sums over the components are taken at a few Chebyshev nodes around the hull
only, and expanded in Chebyshev polynomials of place and submersion between them; how many nodes
the sea and the hull need is worked out when the table is packed (`hydrodynamics.expansion`). The
shortest components, which have little energy, are summed at every vertex.
"""

import math

from numba import njit

from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.kernels.functions import exponential, sin_cos
from marine_mj.hydrodynamics.kernels.memory import advance, scratch
from marine_mj.hydrodynamics.kernels.water import FAST, component, phasors, turn, water_left

_WAVES = t_.MAX_WAVES
_NODES = t_.MAX_NODES
_SHORT = t_.MAX_SHORT
_SQUARE = t_.MAX_NODES**2
_CUBE = t_.MAX_NODES**3
_NODE_WAVES = t_.MAX_NODES * t_.MAX_WAVES
_VERTICES = t_.MAX_HULL_VERTICES
_VERTEX_NODES = t_.MAX_HULL_VERTICES * t_.MAX_NODES
_VERTEX_SHORT = t_.MAX_HULL_VERTICES * t_.MAX_SHORT
#: Share of the wave amplitude below which a row of coefficients is not worth its time.
_SMALL = 1e-6


@njit(fastmath=FAST)
def _range(values, n):
    """(centre, half width) of n values, upwards from the lowest; a millimetre wide at least."""
    low = high = values[0]
    for i in range(n):
        low = min(low, values[i])
        high = max(high, values[i])
    half = max(0.5 * (high - low), 0.0005)
    return low + half, half


@njit(fastmath=FAST)
def _decay(k, n, s, depth, loss):
    """loss (n) = 1 - C(s) of every component, s >= 0."""
    if depth > 0.0:
        s = min(s, depth)
        for i in range(n):
            bottom = exponential(-2.0 * k[i] * depth)
            up = exponential(-k[i] * s)
            loss[i] = 1.0 - (up + exponential(k[i] * (s - 2.0 * depth))) / (1.0 + bottom)
    else:
        for i in range(n):
            loss[i] = 1.0 - exponential(-k[i] * s)


@njit(fastmath=FAST)
def _product(a, b, c, d, n, out):
    """out (n) = real part of (a + i b)(c + i d)."""
    for i in range(n):
        out[i] = a[i] * c[i] - b[i] * d[i]


@njit(fastmath=FAST)
def _scale(factor, n, values):
    """values *= factor."""
    for i in range(n):
        values[i] *= factor[i]


@njit(fastmath=FAST)
def _dot(a, b, n):
    """sum a b."""
    total = 0.0
    for i in range(n):
        total += a[i] * b[i]
    return total


@njit(fastmath=FAST)
def _transform(matrix, n, outer, inner, values):
    """Values (outer, n, inner) at the nodes to coefficients of the middle axis, in place."""
    line = scratch(_NODES)
    for o in range(outer):
        for r in range(inner):
            start = o * n * inner + r
            for i in range(n):
                line[i] = values[start + i * inner]
            for i in range(n):
                total = 0.0
                for j in range(n):
                    total += matrix[n * i + j] * line[j]
                values[start + i * inner] = total


@njit(fastmath=FAST)
def _polynomials(values, n, center, half, orders, out):
    """Chebyshev polynomials (orders, n) of n values, brought to [-1, 1]."""
    scale = 1.0 / half
    first = advance(out, n)
    for i in range(n):
        out[i] = 1.0
        first[i] = min(max((values[i] - center) * scale, -1.0), 1.0)
    for j in range(2, orders):
        last, before = advance(out, (j - 1) * n), advance(out, (j - 2) * n)
        row = advance(out, j * n)
        for i in range(n):
            row[i] = 2.0 * first[i] * last[i] - before[i]


@njit(fastmath=FAST)
def _add_row(c, rows, factor, n, out):
    """out (n) += factor (n) times the sum of eight coefficients times eight rows (n)."""
    # written out: the one form of this sum that the compiler keeps in registers
    c0, c1, c2, c3, c4, c5, c6, c7 = c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7]
    r0, r1, r2, r3 = rows, advance(rows, n), advance(rows, 2 * n), advance(rows, 3 * n)
    r4, r5 = advance(rows, 4 * n), advance(rows, 5 * n)
    r6, r7 = advance(rows, 6 * n), advance(rows, 7 * n)
    for i in range(n):
        low = c0 * r0[i] + c1 * r1[i] + c2 * r2[i] + c3 * r3[i]
        high = c4 * r4[i] + c5 * r5[i] + c6 * r6[i] + c7 * r7[i]
        out[i] += factor[i] * (low + high)


@njit(fastmath=FAST)
def _plane(coefficients, n_x, n_y, along, across, small, n, out):
    """out (n) = sum over (n_x, n_y) of coefficient times both polynomials.

    Rows of coefficients that sum up to less than `small` are left out.
    """
    row = scratch(8)
    for i in range(n):
        out[i] = 0.0
    for j in range(n_x):
        for m in range(0, n_y, 8):
            size = 0.0
            for i in range(8):
                row[i] = coefficients[j * n_y + m + i] if m + i < n_y else 0.0
                size += abs(row[i])
            if not size < small:
                _add_row(row, advance(across, m * n), advance(along, j * n), n, out)


@njit(fastmath=FAST)
def _subtract_product(a, b, n, out):
    """out (n) -= a b."""
    for i in range(n):
        out[i] -= a[i] * b[i]


@njit(fastmath=FAST)
def _submersion(n, z, depth, below, stretched):
    """From elevation to submersion `below` (n) and its stretched value, from surface to bed."""
    bed = depth if depth > 0.0 else math.inf
    for i in range(n):
        zeta = below[i]
        below[i] = zeta - z[i]
        stretched[i] = min(max(below[i] / water_left(zeta, depth), 0.0), bed)


@njit(fastmath=FAST)
def _crests(n, along, across, start, amplitude, u, v, crest, level):
    """One component at the vertices: crest (n) = a cos(theta), added to level (n)."""
    for i in range(n):
        _s, c = sin_cos(start + along * u[i] + across * v[i])
        crest[i] = amplitude * c
        level[i] += crest[i]


@njit(fastmath=FAST)
def _add_defect(n, k, depth, crest, stretched, defect):
    """defect (n) += crest (1 - C(s)) of one component at the vertices."""
    if depth > 0.0:
        scale = 1.0 / (1.0 + exponential(-2.0 * k * depth))
        for i in range(n):
            up = exponential(-k * stretched[i]) + exponential(k * (stretched[i] - 2.0 * depth))
            defect[i] += crest[i] * (1.0 - scale * up)
    else:
        for i in range(n):
            defect[i] += crest[i] * (1.0 - exponential(-k * stretched[i]))


@njit(fastmath=FAST)
def _direct(table, n, x0, y0, c, s, u, v, z, time, below, head):
    """The sums themselves at every vertex."""
    waves = int(table[t_.E_WAVES])
    k = component(table, t_.W_K)
    amplitude = component(table, t_.W_AMPLITUDE)
    depth = table[t_.E_DEPTH]
    cosine, sine, loss = scratch(_WAVES), scratch(_WAVES), scratch(_WAVES)
    wet = scratch(1)
    for p in range(n):
        x, y = x0 + c * u[p] - s * v[p], y0 + s * u[p] + c * v[p]
        phasors(table, x, y, time, cosine, sine)
        _scale(amplitude, waves, cosine)
        point = advance(below, p)
        total = 0.0
        for i in range(waves):
            total += cosine[i]
        point[0] = total
        _submersion(1, advance(z, p), depth, point, wet)
        head[p] = point[0]
        if wet[0] > 0.0:
            _decay(k, waves, wet[0], depth, loss)
            head[p] -= _dot(cosine, loss, waves)


@njit(fastmath=FAST)
def wave_pressure(table, q, n, x0, y0, c, s, u, v, z, time, below, head):
    """Submersion and pressure head at the vertices of a hull in waves.

    Args:
        table: packed table.
        q: parameters of the panels.
        n: number of vertices.
        x0, y0: origin of the body, world, m.
        c, s: cosine and sine of its yaw.
        u, v: place (n) of the vertices from there, level axes turned by the yaw, m.
        z: height (n) above still water, m.
        time: s.
        below: out (n): submersion below the surface above the vertex, m; negative in the air.
        head: out (n): p / (rho g), m; without meaning in the air.
    """
    n_x, n_y = int(q[t_.P_COUNTS]), int(q[t_.P_COUNTS + 1])
    n_s = int(q[t_.P_COUNTS + 2])
    if n_x == 0:
        _direct(table, n, x0, y0, c, s, u, v, z, time, below, head)
        return
    waves = int(q[t_.P_LONG])
    short = min(int(table[t_.E_WAVES]) - waves, _SHORT)
    k, bx, by = component(table, t_.W_K), component(table, t_.W_BX), component(table, t_.W_BY)
    amplitude = component(table, t_.W_AMPLITUDE)
    depth = table[t_.E_DEPTH]
    nodes, transforms = advance(q, t_.P_NODES), advance(q, t_.P_TRANSFORMS)
    u_0, u_h = _range(u, n)
    v_0, v_h = _range(v, n)
    # a cos(theta) at node (j, m) = Re(along_j across_m)
    start_c, start_s = scratch(_WAVES), scratch(_WAVES)
    along_c, along_s = scratch(_NODE_WAVES), scratch(_NODE_WAVES)
    across_c, across_s = scratch(_NODE_WAVES), scratch(_NODE_WAVES)
    phasors(table, x0 + c * u_0 - s * v_0, y0 + s * u_0 + c * v_0, time, start_c, start_s)
    _scale(amplitude, waves, start_c)
    _scale(amplitude, waves, start_s)
    for j in range(n_x):
        t = nodes[j] * u_h
        cosine, sine = advance(along_c, j * waves), advance(along_s, j * waves)
        turn(waves, k, bx, by, c * t, s * t, cosine, sine)
    turn_c, turn_s = scratch(_WAVES), scratch(_WAVES)
    for m in range(n_y):
        t = nodes[_NODES + m] * v_h
        turn(waves, k, bx, by, -s * t, c * t, turn_c, turn_s)
        cosine, sine = advance(across_c, m * waves), advance(across_s, m * waves)
        for i in range(waves):
            cosine[i] = start_c[i] * turn_c[i] - start_s[i] * turn_s[i]
            sine[i] = start_s[i] * turn_c[i] + start_c[i] * turn_s[i]
    wave, surface = scratch(_WAVES), scratch(_SQUARE)
    for j in range(n_x):
        for m in range(n_y):
            _product(
                advance(along_c, j * waves),
                advance(along_s, j * waves),
                advance(across_c, m * waves),
                advance(across_s, m * waves),
                waves,
                wave,
            )
            total = 0.0
            for i in range(waves):
                total += wave[i]
            surface[j * n_y + m] = total
    _transform(transforms, n_x, 1, n_y, surface)
    _transform(advance(transforms, _SQUARE), n_y, n_x, 1, surface)
    # elevation, then submersion at the vertices; `head` keeps the stretched submersion for now
    level, small = scratch(_VERTICES), 0.0
    for i in range(waves):
        small += amplitude[i] * amplitude[i]
    small = _SMALL * math.sqrt(small)
    t_u, t_v, t_s = scratch(_VERTEX_NODES), scratch(_VERTEX_NODES), scratch(_VERTEX_NODES)
    _polynomials(u, n, u_0, u_h, n_x, t_u)
    _polynomials(v, n, v_0, v_h, 8 * ((n_y + 7) // 8), t_v)  # whole rows of eight
    _plane(surface, n_x, n_y, t_u, t_v, small, n, level)
    crests, shallow = scratch(_VERTEX_SHORT), scratch(_VERTICES)
    omega, phase = component(table, t_.W_OMEGA), component(table, t_.W_PHASE)
    for m in range(short):
        i = waves + m
        along, across = k[i] * (c * bx[i] + s * by[i]), k[i] * (c * by[i] - s * bx[i])
        start = k[i] * (bx[i] * x0 + by[i] * y0) - omega[i] * time + phase[i]
        _crests(n, along, across, start, amplitude[i], u, v, advance(crests, m * n), level)
    for i in range(n):
        below[i] = level[i]
        shallow[i] = 0.0
    _submersion(n, z, depth, below, head)
    for m in range(short):
        _add_defect(n, k[waves + m], depth, advance(crests, m * n), head, shallow)
    s_0, s_h = _range(head, n)
    # the pressure defect D at the nodes; the first node downwards may be the surface: D = 0 there
    losses, defect = scratch(_NODE_WAVES), scratch(_CUBE)
    for r in range(n_s):
        t = s_0 + s_h * nodes[2 * _NODES + r]
        _decay(k, waves, max(t, 0.0), depth, advance(losses, r * waves))
    plane = n_x * n_y
    for j in range(n_x):
        for m in range(n_y):
            _product(
                advance(along_c, j * waves),
                advance(along_s, j * waves),
                advance(across_c, m * waves),
                advance(across_s, m * waves),
                waves,
                wave,
            )
            for r in range(n_s):
                value = _dot(wave, advance(losses, r * waves), waves)
                defect[r * plane + j * n_y + m] = value
    _transform(advance(transforms, 2 * _SQUARE), n_s, 1, plane, defect)
    _transform(transforms, n_x, n_s, n_y, defect)
    _transform(advance(transforms, _SQUARE), n_y, n_s * n_x, 1, defect)
    _polynomials(head, n, s_0, s_h, n_s, t_s)
    for i in range(n):
        head[i] = below[i] - shallow[i]
    for r in range(n_s):
        _plane(advance(defect, r * plane), n_x, n_y, t_u, t_v, small, n, level)
        _subtract_product(level, advance(t_s, r * n), n, head)
