"""Rotations and motions of rigid bodies as native loops over the leading dimensions.

Fast on a thousand rows, the same bits on one; `marine_mj.frames` and `controllers.kinematics` say
what they mean. Quaternions are wxyz, body to world; velocities (6,) are [linear; angular] in body
axes. The last argument of some stands for the size of the result only. All loops are in one file:
numba's disk cache does not see changes of what a loop calls in another one.
"""

import numpy as np
from numba import njit

from marine_mj.native_loops import native_loop


@njit(inline="always")
def _matrix(w, x, y, z):
    """Rotation matrix, by rows."""
    return (
        1 - 2 * (y * y + z * z),
        2 * (x * y - w * z),
        2 * (x * z + w * y),
        2 * (x * y + w * z),
        1 - 2 * (x * x + z * z),
        2 * (y * z - w * x),
        2 * (x * z - w * y),
        2 * (y * z + w * x),
        1 - 2 * (x * x + y * y),
    )


@njit(inline="always")
def _turn(r, x, y, z):
    """Vector in world axes."""
    return (
        r[0] * x + r[1] * y + r[2] * z,
        r[3] * x + r[4] * y + r[5] * z,
        r[6] * x + r[7] * y + r[8] * z,
    )


@njit(inline="always")
def _back(r, x, y, z):
    """Vector in body axes."""
    return (
        r[0] * x + r[3] * y + r[6] * z,
        r[1] * x + r[4] * y + r[7] * z,
        r[2] * x + r[5] * y + r[8] * z,
    )


@njit(inline="always")
def _product(aw, ax, ay, az, bw, bx, by, bz):
    """Hamilton product."""
    return (
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    )


@njit(inline="always")
def _cross(ax, ay, az, bx, by, bz):
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


@njit(inline="always")
def _shortest(w, x, y, z):
    """Rotation vector, the shortest way."""
    sign = -1.0 if w < 0 else 1.0
    norm = np.sqrt(x * x + y * y + z * z)
    scale = 2.0 * sign
    if norm > 1e-12:
        scale = 2.0 * np.arctan2(norm, sign * w) / norm * sign
    return scale * x, scale * y, scale * z


@native_loop("void(f8[:,:], f8[:], f8[:])", "(n,m),(m)->(n)")
def apply(matrix, vector, out):
    for i in range(matrix.shape[0]):
        total = 0.0
        for j in range(matrix.shape[1]):
            total += matrix[i, j] * vector[j]
        out[i] = total


@native_loop("void(f8[:,:], f8[:], f8[:])", "(n,m),(n)->(m)")
def apply_transposed(matrix, vector, out):
    for j in range(matrix.shape[1]):
        total = 0.0
        for i in range(matrix.shape[0]):
            total += matrix[i, j] * vector[i]
        out[j] = total


@native_loop("void(f8[:], f8[:], f8[:])", "(n),(n)->(n)")
def cross(a, b, out):
    out[0], out[1], out[2] = _cross(a[0], a[1], a[2], b[0], b[1], b[2])


@native_loop("void(f8[:], f8[:])", "(n)->()")
def length(vector, out):
    total = 0.0
    for i in range(vector.shape[0]):
        total += vector[i] * vector[i]
    out[0] = np.sqrt(total)


@native_loop("void(f8[:], f8[:], f8[:])", "(n),(n)->(n)")
def multiply(a, b, out):
    out[0], out[1], out[2], out[3] = _product(a[0], a[1], a[2], a[3], b[0], b[1], b[2], b[3])


@native_loop("void(f8[:], f8[:], f8[:,:])", "(n),(m)->(m,m)")
def rotation(q, size, out):
    r = _matrix(q[0], q[1], q[2], q[3])
    for i in range(3):
        for j in range(3):
            out[i, j] = r[3 * i + j]


@native_loop("void(f8[:], f8[:], f8[:])", "(n),(m)->(m)")
def rotation_vector(q, size, out):
    out[0], out[1], out[2] = _shortest(q[0], q[1], q[2], q[3])


@native_loop(
    "void(f8[:], f8[:], f8[:], f8[:], f8[:], f8[:], f8[:], f8[:])",
    "(p),(q),(s),(p),(q)->(p),(q),(s)",
)
def attached(position, q, v, offset, relative, place, attitude, twist):
    x, y, z = offset[0], offset[1], offset[2]
    arm = _turn(_matrix(q[0], q[1], q[2], q[3]), x, y, z)
    spin = _cross(v[3], v[4], v[5], x, y, z)
    r = _matrix(relative[0], relative[1], relative[2], relative[3])
    linear = _back(r, v[0] + spin[0], v[1] + spin[1], v[2] + spin[2])
    angular = _back(r, v[3], v[4], v[5])
    for i in range(3):
        place[i] = position[i] + arm[i]
        twist[i], twist[3 + i] = linear[i], angular[i]
    attitude[0], attitude[1], attitude[2], attitude[3] = _product(
        q[0], q[1], q[2], q[3], relative[0], relative[1], relative[2], relative[3]
    )


@native_loop("void(f8[:], f8[:], f8[:], f8[:], f8[:], f8[:])", "(p),(q),(p),(q),(s)->(s)")
def pose_error(target, target_q, position, q, size, out):
    r = _matrix(q[0], q[1], q[2], q[3])
    d = _back(r, target[0] - position[0], target[1] - position[1], target[2] - position[2])
    turn = _product(q[0], -q[1], -q[2], -q[3], target_q[0], target_q[1], target_q[2], target_q[3])
    angle = _shortest(turn[0], turn[1], turn[2], turn[3])
    for i in range(3):
        out[i], out[3 + i] = d[i], angle[i]


@native_loop("void(f8[:], f8[:], f8[:], f8[:], f8[:])", "(q),(s),(q),(s)->(s)")
def relative_velocity(q, v, reference_q, reference, out):
    r = _matrix(q[0], q[1], q[2], q[3])
    f = _matrix(reference_q[0], reference_q[1], reference_q[2], reference_q[3])
    a = _turn(r, v[0], v[1], v[2])
    b = _turn(f, reference[0], reference[1], reference[2])
    linear = _back(r, a[0] - b[0], a[1] - b[1], a[2] - b[2])
    spin = _turn(f, reference[3], reference[4], reference[5])
    angular = _back(r, spin[0], spin[1], spin[2])
    for i in range(3):
        out[i], out[3 + i] = linear[i], v[3 + i] - angular[i]


@native_loop("void(f8[:], f8[:], f8[:])", "(q),(s)->(s)")
def world_velocity(q, v, out):
    r = _matrix(q[0], q[1], q[2], q[3])
    linear, angular = _turn(r, v[0], v[1], v[2]), _turn(r, v[3], v[4], v[5])
    for i in range(3):
        out[i], out[3 + i] = linear[i], angular[i]


@native_loop("void(f8[:], f8[:], f8[:], f8[:])", "(q),(s),(s)->(s)")
def body_acceleration(q, v, a, out):
    r = _matrix(q[0], q[1], q[2], q[3])
    linear, angular = _back(r, a[0], a[1], a[2]), _back(r, a[3], a[4], a[5])
    turning = _cross(v[3], v[4], v[5], v[0], v[1], v[2])
    for i in range(3):
        out[i], out[3 + i] = linear[i] - turning[i], angular[i]


@native_loop("void(f8[:], f8[:], f8[:], f8[:], f8[:], f8[:])", "(p),(q),(s),(s),(p)->(s)")
def acceleration_at(position, q, v, a, point, out):
    x, y, z = point[0] - position[0], point[1] - position[1], point[2] - position[2]
    w = _turn(_matrix(q[0], q[1], q[2], q[3]), v[3], v[4], v[5])
    turning = _cross(a[3], a[4], a[5], x, y, z)
    swing = _cross(w[0], w[1], w[2], x, y, z)
    inward = _cross(w[0], w[1], w[2], swing[0], swing[1], swing[2])
    for i in range(3):
        out[i], out[3 + i] = a[i] + turning[i] + inward[i], a[3 + i]
