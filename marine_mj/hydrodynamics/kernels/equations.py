"""From MuJoCo's state to the twist of a body, and from its loads into the equations of motion."""

import math

from numba import njit

from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.kernels.memory import advance, field, floats, int_value, ints, scratch
from marine_mj.hydrodynamics.kernels.water import FAST, POINT, water_row

_XPOS = field("d", "xpos")
_XMAT = field("d", "xmat")
_SUBTREE_COM = field("d", "subtree_com")
_CVEL = field("d", "cvel")
_CDOF = field("d", "cdof")
_CDOF_DOT = field("d", "cdof_dot")
_QVEL = field("d", "qvel")
_M = field("d", "M")
_QFRC = field("d", "qfrc_passive")
_DOF_PARENT = field("m", "dof_parentid")
_DOF_BODY = field("m", "dof_bodyid")
_DOF_JOINT = field("m", "dof_jntid")
_JOINT_TYPE = field("m", "jnt_type")
_JOINT_DOF = field("m", "jnt_dofadr")
_ROW_ADDRESS = field("m", "M_rowadr")
_ROW_LENGTH = field("m", "M_rownnz")
_FREE, _BALL = 0, 1  # mjJNT_FREE, mjJNT_BALL
_INTEGRATOR = field("m", "opt.integrator")
_RK4 = 1  # mjINT_RK4

_CHAIN_VALUES = 6 * t_.MAX_CHAIN
_NUMBER_OF_CAUSES = len(t_.CAUSES)


@njit
def runge_kutta(model):
    """Whether the model is integrated by RK4; the other integrators are semi-implicit."""
    return int_value(model, _INTEGRATOR) == _RK4


@njit
def relative_velocity(table, R, x, time, orbital, nu, flow):
    """Velocity flow (3) of a body relative to the water at its origin x, axes R.

    orbital: with the orbital motion of the waves, or relative to the current alone.
    """
    step, water = scratch(3), scratch(POINT)
    for i in range(3):
        step[i] = 0.0
    water_row(table, x, step, 1, time, orbital, False, False, water, water)
    for i in range(3):
        flow[i] = nu[i] - (R[i] * water[0] + R[3 + i] * water[1] + R[6 + i] * water[2])


@njit
def load_axes(data, p, R):
    """R (9): axes of the loads, to world. The body's own, or level ones turned by its yaw."""
    own = advance(floats(data, _XMAT), 9 * int(p[t_.B_BODY]))
    if p[t_.B_SEAKEEPING] > 0.0:
        yaw = math.atan2(own[3], own[0])
        c, s = math.cos(yaw), math.sin(yaw)
        R[0], R[1], R[2] = c, -s, 0.0
        R[3], R[4], R[5] = s, c, 0.0
        R[6], R[7], R[8] = 0.0, 0.0, 1.0
        return
    for i in range(9):
        R[i] = own[i]


@njit
def turn_rate(data, p, R, nu, spin):
    """spin (3): angular velocity of the axes of the loads, in those axes."""
    if p[t_.B_SEAKEEPING] > 0.0:
        own = advance(floats(data, _XMAT), 9 * int(p[t_.B_BODY]))
        # rate of atan2(own[3], own[0]), from d/dt R = omega x R
        ox = R[0] * nu[3] + R[1] * nu[4]
        oy = R[3] * nu[3] + R[4] * nu[4]
        rate_x = oy * own[6] - nu[5] * own[3]
        rate_y = nu[5] * own[0] - ox * own[6]
        level = own[0] * own[0] + own[3] * own[3]
        spin[0] = spin[1] = spin[2] = 0.0
        if level > 1e-12:
            spin[2] = (own[0] * rate_y - own[3] * rate_x) / level
        return
    for i in range(3):
        spin[i] = nu[3 + i]


@njit
def body_twist(data, p, R, nu):
    """nu (6) = [v; omega] of the body origin in the axes R, from MuJoCo's spatial velocity."""
    body, root = int(p[t_.B_BODY]), int(p[t_.B_ROOT])
    x = advance(floats(data, _XPOS), 3 * body)
    com = advance(floats(data, _SUBTREE_COM), 3 * root)
    c = advance(floats(data, _CVEL), 6 * body)
    rx, ry, rz = x[0] - com[0], x[1] - com[1], x[2] - com[2]
    vx = c[3] + c[1] * rz - c[2] * ry
    vy = c[4] + c[2] * rx - c[0] * rz
    vz = c[5] + c[0] * ry - c[1] * rx
    for i in range(3):
        nu[i] = R[i] * vx + R[3 + i] * vy + R[6 + i] * vz
        nu[3 + i] = R[i] * c[0] + R[3 + i] * c[1] + R[6 + i] * c[2]


@njit
def _bias_acceleration(model, data, p, R, nu, a):
    """a (6) = Jdot qvel: what is left of the rate of nu when qacc = 0, in the axes of the loads."""
    if p[t_.B_FREE] > 0.0:
        spin = scratch(3)
        turn_rate(data, p, R, nu, spin)
        for i in range(2):
            v = advance(nu, 3 * i)
            a[3 * i] = -(spin[1] * v[2] - spin[2] * v[1])
            a[3 * i + 1] = -(spin[2] * v[0] - spin[0] * v[2])
            a[3 * i + 2] = -(spin[0] * v[1] - spin[1] * v[0])
        return
    body, root = int(p[t_.B_BODY]), int(p[t_.B_ROOT])
    x = advance(floats(data, _XPOS), 3 * body)
    com = advance(floats(data, _SUBTREE_COM), 3 * root)
    rx, ry, rz = x[0] - com[0], x[1] - com[1], x[2] - com[2]
    qvel = floats(data, _QVEL)
    # world velocity of the body origin
    vx = R[0] * nu[0] + R[1] * nu[1] + R[2] * nu[2]
    vy = R[3] * nu[0] + R[4] * nu[1] + R[5] * nu[2]
    vz = R[6] * nu[0] + R[7] * nu[1] + R[8] * nu[2]
    lx = ly = lz = ax = ay = az = 0.0
    dof = int(p[t_.B_LAST_DOF])
    parents = ints(model, _DOF_PARENT)
    while dof >= 0:
        c = advance(floats(data, _CDOF), 6 * dof)
        joint = ints(model, _DOF_JOINT)[dof]
        kind = ints(model, _JOINT_TYPE)[joint]
        turning = kind == _BALL or (kind == _FREE and dof >= ints(model, _JOINT_DOF)[joint] + 3)
        if turning:  # MuJoCo keeps these axes fixed in cdof_dot: cross product with cvel instead
            w = advance(floats(data, _CVEL), 6 * ints(model, _DOF_BODY)[dof])
            d0, d1, d2 = w[1] * c[2] - w[2] * c[1], w[2] * c[0] - w[0] * c[2], 0.0
            d2 = w[0] * c[1] - w[1] * c[0]
            e0 = w[1] * c[5] - w[2] * c[4] + w[4] * c[2] - w[5] * c[1]
            e1 = w[2] * c[3] - w[0] * c[5] + w[5] * c[0] - w[3] * c[2]
            e2 = w[0] * c[4] - w[1] * c[3] + w[3] * c[1] - w[4] * c[0]
        else:
            d = advance(floats(data, _CDOF_DOT), 6 * dof)
            d0, d1, d2, e0, e1, e2 = d[0], d[1], d[2], d[3], d[4], d[5]
        rate = qvel[dof]
        lx += rate * (e0 + d1 * rz - d2 * ry + c[1] * vz - c[2] * vy)
        ly += rate * (e1 + d2 * rx - d0 * rz + c[2] * vx - c[0] * vz)
        lz += rate * (e2 + d0 * ry - d1 * rx + c[0] * vy - c[1] * vx)
        ax += rate * d0
        ay += rate * d1
        az += rate * d2
        dof = parents[dof]
    for i in range(3):
        a[i] = R[i] * lx + R[3 + i] * ly + R[6 + i] * lz
        a[3 + i] = R[i] * ax + R[3 + i] * ay + R[6 + i] * az
    a[0] -= nu[4] * nu[2] - nu[5] * nu[1]
    a[1] -= nu[5] * nu[0] - nu[3] * nu[2]
    a[2] -= nu[3] * nu[1] - nu[4] * nu[0]


@njit(fastmath=FAST)
def apply_loads(model, data, p, R, nu, f, inertia):
    """M += J^T A J and qfrc_passive += J^T (sum of causes - A Jdot qvel), nu = J qvel."""
    body, root = int(p[t_.B_BODY]), int(p[t_.B_ROOT])
    small = scratch(48)
    A, total, bias = small, advance(small, 36), advance(small, 42)
    for i in range(36):
        A[i] = 0.0
        for law in range(t_.INERTIAS):
            A[i] += inertia[36 * law + i]
    _bias_acceleration(model, data, p, R, nu, bias)
    for i in range(6):
        total[i] = 0.0
        for cause in range(_NUMBER_OF_CAUSES):
            total[i] += f[6 * cause + i]
        for j in range(6):
            total[i] -= A[6 * i + j] * bias[j]
    x = advance(floats(data, _XPOS), 3 * body)
    com = advance(floats(data, _SUBTREE_COM), 3 * root)
    rx, ry, rz = x[0] - com[0], x[1] - com[1], x[2] - com[2]
    parents = ints(model, _DOF_PARENT)
    force = floats(data, _QFRC)
    M = floats(data, _M)
    J, AJ = scratch(_CHAIN_VALUES), scratch(6)
    dof = int(p[t_.B_LAST_DOF])
    n = 0
    while dof >= 0:
        c = advance(floats(data, _CDOF), 6 * dof)
        lx = c[3] + c[1] * rz - c[2] * ry
        ly = c[4] + c[2] * rx - c[0] * rz
        lz = c[5] + c[0] * ry - c[1] * rx
        column = advance(J, 6 * n)
        for i in range(3):
            column[i] = R[i] * lx + R[3 + i] * ly + R[6 + i] * lz
            column[3 + i] = R[i] * c[0] + R[3 + i] * c[1] + R[6 + i] * c[2]
        push = 0.0
        for i in range(6):
            push += column[i] * total[i]
        force[dof] += push
        dof = parents[dof]
        n += 1
    # row of a dof in M: its ancestors in rising order, itself last
    dof = int(p[t_.B_LAST_DOF])
    for a in range(n):
        column = advance(J, 6 * a)
        for i in range(6):
            AJ[i] = 0.0
            for j in range(6):
                AJ[i] += A[6 * i + j] * column[j]
        entry = ints(model, _ROW_ADDRESS)[dof] + ints(model, _ROW_LENGTH)[dof] - 1
        for b in range(a, n):
            other = advance(J, 6 * b)
            value = 0.0
            for i in range(6):
                value += other[i] * AJ[i]
            M[entry] += value
            entry -= 1
        dof = parents[dof]
