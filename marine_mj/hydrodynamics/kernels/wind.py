"""Wind on the part of a body above water (Fossen 2021, sec. 10.1)."""

import math

from numba import njit

from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.kernels.memory import advance, scratch
from marine_mj.hydrodynamics.kernels.water import series


@njit
def _constant(q, cosine, sine, c):
    """C_X = -c_x cos(gamma), C_Y = c_y sin(gamma), C_N = c_n sin(2 gamma)."""
    c[0] = -q[0] * cosine
    c[1] = q[1] * sine
    c[2] = 2.0 * q[2] * sine * cosine


@njit
def _from_table(q, gamma, c):
    """Coefficients between the rows of a table over the whole circle."""
    rows = int(q[t_.WT_ROWS])
    if gamma < 0.0:
        gamma += 2.0 * math.pi
    row = advance(q, t_.WT_DATA)
    for _ in range(rows - 2):
        if not gamma >= row[t_.WT_COLUMNS]:
            break
        row = advance(row, t_.WT_COLUMNS)
    after = advance(row, t_.WT_COLUMNS)
    share = (gamma - row[0]) / (after[0] - row[0])
    for i in range(4):
        c[i] = row[1 + i] + share * (after[1 + i] - row[1 + i])


@njit
def _blendermann(q, cosine, sine, gamma, c):
    """Blendermann (1994) as printed by the Viknes study, eq. 6.34-6.38, with |gamma| in C_N.

    q: CD_t, CD_l for wind from ahead and from astern, their CD_lAF, delta, s_L / L_oa.
    """
    side = 0 if cosine >= 0.0 else 1
    twist = 2.0 * sine * cosine
    loss = 1.0 - 0.5 * q[5] * (1.0 - q[1 + side] / q[0]) * twist * twist
    c[0] = -q[3 + side] * cosine / loss
    c[1] = q[0] * sine / loss
    c[2] = (q[6] - 0.18 * (abs(gamma) - 0.5 * math.pi)) * c[1]


@njit
def wind(table, q, R, nu, time, f):
    """Wind force from the angle and square of the relative wind at the lateral centroid.

    gamma: angle of attack of the relative wind in FRD, 0 from ahead, positive from port.
    """
    small = scratch(13)
    speed, rate, flow, c = small, advance(small, 3), advance(small, 6), advance(small, 9)
    series(
        table,
        int(table[t_.E_WIND_KNOTS]),
        table[t_.E_WIND_INTERVAL],
        int(table[t_.E_WIND_DATA]),
        time,
        speed,
        rate,
    )
    for i in range(3):
        flow[i] = R[i] * speed[0] + R[3 + i] * speed[1] + R[6 + i] * speed[2]
    # velocity of the air as seen from the body, FLU
    u, v = q[t_.WD_PROFILE] * flow[0] - nu[0], q[t_.WD_PROFILE] * flow[1] - nu[1]
    square = u * u + v * v
    if square == 0.0:
        return
    length = math.sqrt(square)
    cosine, sine = -u / length, -v / length
    law, data = q[t_.WD_LAW], advance(q, t_.WD_DATA)
    if law == t_.WIND_CONSTANT:
        _constant(data, cosine, sine, c)
    else:
        gamma = math.atan2(sine, cosine)
        if law == t_.WIND_TABLE:
            _from_table(data, gamma, c)
        else:
            _blendermann(data, cosine, sine, gamma, c)
    pressure = 0.5 * table[t_.E_AIR_DENSITY] * square
    x = pressure * c[0] * q[t_.WD_FRONT]
    side = pressure * q[t_.WD_LATERAL]
    y = -side * c[1]  # to port
    f[0] += x
    f[1] += y
    if q[t_.WD_ROLL] > 0.0:
        f[3] += side * c[3] * q[t_.WD_HEIGHT]
    else:
        f[3] -= q[t_.WD_HEIGHT] * y
    f[4] += q[t_.WD_HEIGHT] * x
    f[5] -= side * c[2] * q[t_.WD_LENGTH]
