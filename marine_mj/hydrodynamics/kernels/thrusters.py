"""What thrusters lose to the speed at which they advance through the water."""

import math

from numba import njit

from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.kernels.memory import advance, field, floats, scratch

_ACT = field("d", "act")
_CTRL = field("d", "ctrl")


@njit
def thrust_loss(data, q, own, R, flow, f):
    """Wrench that is missing: `-c sqrt(|F|) V_a` along the axis of every thruster.

    The bilinear propeller, `T = T_nn |n| n - T_nV |n| V_a` (Fossen 2021, sec. 9.1), with
    `F = T_nn |n| n` what the actuator gives at rest. own: attitude of the body (9), R: axes of the
    loads, flow (6): velocity relative to the water. q: see the table's TH_ entries.
    """
    small = scratch(12)
    place, axis, arm, along = small, advance(small, 3), advance(small, 6), advance(small, 9)
    for k in range(int(q[t_.TH_COUNT])):
        row = advance(q, t_.TH_ROWS + k * t_.TH_SIZE)
        address = int(row[t_.TH_ADDRESS])
        state = (
            floats(data, _ACT)[address] if row[t_.TH_LAG] > 0.0 else floats(data, _CTRL)[address]
        )
        force = min(max(row[t_.TH_GAIN] * state, row[t_.TH_LOW]), row[t_.TH_HIGH])
        for i in range(3):
            place[i] = axis[i] = 0.0
            for j in range(3):
                place[i] += own[3 * i + j] * row[t_.TH_PLACE + j]
                axis[i] += own[3 * i + j] * row[t_.TH_AXIS + j]
        for i in range(3):
            arm[i] = R[i] * place[0] + R[3 + i] * place[1] + R[6 + i] * place[2]
            along[i] = R[i] * axis[0] + R[3 + i] * axis[1] + R[6 + i] * axis[2]
        u = flow[0] + flow[4] * arm[2] - flow[5] * arm[1]
        v = flow[1] + flow[5] * arm[0] - flow[3] * arm[2]
        w = flow[2] + flow[3] * arm[1] - flow[4] * arm[0]
        speed = u * along[0] + v * along[1] + w * along[2]
        loss = -row[t_.TH_LOSS] * math.sqrt(abs(force)) * speed
        x, y, z = loss * along[0], loss * along[1], loss * along[2]
        f[0] += x
        f[1] += y
        f[2] += z
        f[3] += arm[1] * z - arm[2] * y
        f[4] += arm[2] * x - arm[0] * z
        f[5] += arm[0] * y - arm[1] * x
