"""Kalman filter steps as native loops over the leading dimensions: the same bits on one or many.

Last arguments of some stand for the size of a result that is work space.
"""

import numpy as np
from numba import njit

from marine_mj.frames import Array
from marine_mj.native_loops import native_loop

#: Error states of a rigid body: position, velocity, attitude, accelerometer and gyro bias.
CORE = 15


@native_loop(
    "void(f8[:,:], f8[:,:], f8[:], f8[:,:], f8, b1,"
    " f8[:], f8[:,:], f8[:], f8[:], f8[:,:], f8[:,:])",
    "(n,n),(m,n),(m),(m,m),(),()->(n),(n,n),(),(m),(m,m),(m,n)",
)
def _update(P, H, residual, R, gate, valid, dx, posterior, nis, white, L, W):
    n, m = P.shape[0], residual.shape[0]
    for i in range(n):
        dx[i] = 0.0
        for j in range(n):
            posterior[i, j] = P[i, j]
    nis[0] = np.nan
    if not valid:
        return
    for i in range(m):
        for j in range(n):
            total = 0.0
            for k in range(n):
                if H[i, k] != 0.0:
                    total += H[i, k] * P[k, j]
            W[i, j] = total
    # S = H P H' + R = L L'; each row of W and the residual become L^-1 times themselves.
    square = 0.0
    for i in range(m):
        for j in range(i + 1):
            total = R[i, j]
            for k in range(n):
                if H[j, k] != 0.0:
                    total += W[i, k] * H[j, k]
            L[i, j] = total
    for i in range(m):
        for j in range(i):
            total = L[i, j]
            for k in range(j):
                total -= L[i, k] * L[j, k]
            L[i, j] = total / L[j, j]
        total = L[i, i]
        for k in range(i):
            total -= L[i, k] * L[i, k]
        if not total > 0.0:
            return
        L[i, i] = np.sqrt(total)
    for i in range(m):
        for j in range(n):
            total = W[i, j]
            for k in range(i):
                total -= L[i, k] * W[k, j]
            W[i, j] = total / L[i, i]
        total = residual[i]
        for k in range(i):
            total -= L[i, k] * white[k]
        white[i] = total / L[i, i]
        square += white[i] * white[i]
        for j in range(n):
            dx[j] += W[i, j] * white[i]
    nis[0] = square
    if not square <= gate:
        for j in range(n):
            dx[j] = 0.0
        return
    for i in range(n):
        for j in range(i + 1):
            total = P[i, j]
            for k in range(m):
                total -= W[k, i] * W[k, j]
            posterior[i, j] = total
            posterior[j, i] = total


def kalman_update(
    covariance: Array,
    H: Array,
    residual: Array,
    R: Array,
    gate: Array | float = np.inf,
    valid: Array | bool = True,
) -> tuple[Array, Array, Array]:
    """Correction (..., n), posterior covariance (..., n, n) and NIS (...,) of a measurement.

    `S = H P H' + R`, `dx = P H' S^-1 r`, `P+ = P - P H' S^-1 H P` by the Cholesky factor of S, so
    P+ is symmetric; the normalised innovation squared is `r' S^-1 r` (Bar-Shalom, Li and
    Kirubarajan 2001, section 5.4). A measurement that is not valid gives no correction and NIS
    NaN; one above the gate (or not finite) no correction.

    Args:
        covariance: (..., n, n) prior P, symmetric.
        H: (..., m, n) measurement matrix.
        residual: (..., m) measurement minus prediction.
        R: (..., m, m) covariance of its noise.
        gate: largest NIS that is believed.
        valid: (...,) bool.
    """
    dx, posterior, nis, *_ = _update(covariance, H, residual, R, gate, valid)
    return dx, posterior, nis


@native_loop(
    "void(f8[:], f8[:,:], f8[:], f8, b1, f8[:], f8[:], f8[:,:])",
    "(n),(n,n),(a),(),(),(n)->(n),(n,n)",
)
def _planar(x, P, acceleration, T, turned, Q, mean, prior):
    s, c = 0.0, 1.0
    if turned:
        s, c = np.sin(x[2]), np.cos(x[2])
    mean[0] = x[0] + T * (c * x[3] + s * x[4])
    mean[1] = x[1] + T * (c * x[4] - s * x[3])
    mean[2] = x[2] + T * x[5]
    for i in range(3):
        mean[3 + i] = x[3 + i] + T * acceleration[i]
    # F = [[I, T R], [0, I]]: F P by columns, then (F P) F' by rows.
    for j in range(6):
        u, w, q = P[3, j], P[4, j], P[5, j]
        prior[0, j] = P[0, j] + T * (c * u + s * w)
        prior[1, j] = P[1, j] + T * (c * w - s * u)
        prior[2, j] = P[2, j] + T * q
        prior[3, j], prior[4, j], prior[5, j] = u, w, q
    for i in range(6):
        u, w, q = prior[i, 3], prior[i, 4], prior[i, 5]
        prior[i, 0] += T * (c * u + s * w)
        prior[i, 1] += T * (c * w - s * u)
        prior[i, 2] += T * q
    for i in range(6):
        for j in range(i):
            mean_ij = 0.5 * (prior[i, j] + prior[j, i])
            prior[i, j], prior[j, i] = mean_ij, mean_ij
        prior[i, i] += Q[i]


def planar_predict(
    mean: Array,
    covariance: Array,
    acceleration: Array,
    period: float,
    noise: Array,
    turned: bool,
) -> tuple[Array, Array]:
    """Prior mean (..., 6) and covariance (..., 6, 6) of `[x, z, theta, u, w, q]` a period later.

    `eta+ = eta + T R nu`, `nu+ = nu + T z`, `P+ = F P F' + Q`, `F = [[I, T R], [0, I]]` (docking
    digest 5.3); `R(theta)` turns body velocities into NED, or is the identity.

    Args:
        mean: (..., 6) position NED m, pitch rad, velocities m/s and rad/s.
        covariance: (..., 6, 6).
        acceleration: (..., 3) measured rates of u, w, q.
        period: T, s.
        noise: (..., 6) diagonal of Q for one period.
        turned: velocities are those of the body axes; otherwise of the world axes.
    """
    return _planar(mean, covariance, acceleration, period, turned, noise)


@njit(cache=True)
def _turn(x, y, z, angle, blocks):
    """exp(-[v]x), by rows, into the last nine numbers of `blocks`."""
    a = np.sin(angle) / angle if angle > 1e-6 else 1.0
    b = (1.0 - np.cos(angle)) / (angle * angle) if angle > 1e-6 else 0.5
    blocks[9] = 1.0 - b * (y * y + z * z)
    blocks[10] = b * x * y + a * z
    blocks[11] = b * x * z - a * y
    blocks[12] = b * x * y - a * z
    blocks[13] = 1.0 - b * (x * x + z * z)
    blocks[14] = b * y * z + a * x
    blocks[15] = b * x * z + a * y
    blocks[16] = b * y * z - a * x
    blocks[17] = 1.0 - b * (x * x + y * y)


@njit(cache=True)
def _mix(e, T, R, blocks, keep):
    """Error states one period later, in place."""
    t0, t1, t2 = e[6], e[7], e[8]
    b0, b1, b2 = e[9], e[10], e[11]
    for i in range(3):
        e[i] += T * e[3 + i]
        k = 3 * i
        e[3 + i] += blocks[k] * t0 + blocks[k + 1] * t1 + blocks[k + 2] * t2
        e[3 + i] -= T * (R[k] * b0 + R[k + 1] * b1 + R[k + 2] * b2)
    for i in range(3):
        k = 9 + 3 * i
        turned = blocks[k] * t0 + blocks[k + 1] * t1 + blocks[k + 2] * t2
        e[6 + i] = turned - T * e[12 + i]
    for i in range(9, e.shape[0]):
        e[i] *= keep[i]


@native_loop(
    "void(f8[:], f8[:,:], f8[:], f8[:], f8, f8, f8[:], f8[:], f8[:], f8[:],"
    " f8[:], f8[:,:], f8[:], f8[:])",
    "(x),(n,n),(i),(i),(),(),(n),(n),(b),(r)->(x),(n,n),(b),(r)",
)
def _inertial(x, P, force, rate, T, gravity, keep, drive, _b, _r, mean, prior, blocks, R):
    n = P.shape[0]
    # Rotation in the period and its first half; the specific force is that of the middle.
    wx, wy, wz = rate[0] - x[13], rate[1] - x[14], rate[2] - x[15]
    fx, fy, fz = force[0] - x[10], force[1] - x[11], force[2] - x[12]
    angle = T * np.sqrt(wx * wx + wy * wy + wz * wz)
    quarter = 0.25 * angle
    c4 = np.cos(quarter)
    s4 = 0.25 * T * (np.sin(quarter) / quarter if quarter > 1e-9 else 1.0)
    qw, qx, qy, qz = x[6], x[7], x[8], x[9]
    for half in range(2):
        a, b, c, d = c4, s4 * wx, s4 * wy, s4 * wz
        qw, qx, qy, qz = (
            qw * a - qx * b - qy * c - qz * d,
            qw * b + qx * a + qy * d - qz * c,
            qw * c - qx * d + qy * a + qz * b,
            qw * d + qx * c - qy * b + qz * a,
        )
        if half == 0:
            R[0], R[1], R[2] = (
                1 - 2 * (qy * qy + qz * qz), 2 * (qx * qy - qw * qz), 2 * (qx * qz + qw * qy)
            )  # fmt: skip
            R[3], R[4], R[5] = (
                2 * (qx * qy + qw * qz), 1 - 2 * (qx * qx + qz * qz), 2 * (qy * qz - qw * qx)
            )  # fmt: skip
            R[6], R[7], R[8] = (
                2 * (qx * qz - qw * qy), 2 * (qy * qz + qw * qx), 1 - 2 * (qx * qx + qy * qy)
            )  # fmt: skip
    norm = 1.0 / np.sqrt(qw * qw + qx * qx + qy * qy + qz * qz)
    for i in range(3):
        a = R[3 * i] * fx + R[3 * i + 1] * fy + R[3 * i + 2] * fz
        if i == 2:
            a -= gravity
        mean[i] = x[i] + T * x[3 + i] + 0.5 * T * T * a
        mean[3 + i] = x[3 + i] + T * a
    mean[6], mean[7], mean[8], mean[9] = qw * norm, qx * norm, qy * norm, qz * norm
    for i in range(10, x.shape[0]):
        mean[i] = keep[i - 1] * x[i]
    # Blocks: velocity by attitude, -T R [f]x; attitude by attitude, exp(-[w]x T).
    for i in range(3):
        r0, r1, r2 = R[3 * i], R[3 * i + 1], R[3 * i + 2]
        blocks[3 * i] = -T * (r1 * fz - r2 * fy)
        blocks[3 * i + 1] = -T * (r2 * fx - r0 * fz)
        blocks[3 * i + 2] = -T * (r0 * fy - r1 * fx)
    _turn(wx * T, wy * T, wz * T, angle, blocks)
    # F P by rows, which the compiler turns into vector instructions.
    for i in range(3):
        k, t = 3 * i, 9 + 3 * i
        for j in range(n):
            prior[i, j] = P[i, j] + T * P[3 + i, j]
            prior[3 + i, j] = (
                P[3 + i, j]
                + blocks[k] * P[6, j]
                + blocks[k + 1] * P[7, j]
                + blocks[k + 2] * P[8, j]
                - T * (R[k] * P[9, j] + R[k + 1] * P[10, j] + R[k + 2] * P[11, j])
            )
            prior[6 + i, j] = (
                blocks[t] * P[6, j]
                + blocks[t + 1] * P[7, j]
                + blocks[t + 2] * P[8, j]
                - T * P[12 + i, j]
            )
    for i in range(9, n):
        for j in range(n):
            prior[i, j] = keep[i] * P[i, j]
    # (F P) F': the rows of the core, the rest by symmetry.
    for i in range(CORE):
        _mix(prior[i, :], T, R, blocks, keep)
    for i in range(n):
        for j in range(i):
            if i < CORE:
                prior[i, j] = 0.5 * (prior[i, j] + prior[j, i])
            elif j < CORE:
                prior[i, j] = prior[j, i]
            else:
                prior[i, j] *= keep[j]
            prior[j, i] = prior[i, j]
        if i >= CORE:
            prior[i, i] *= keep[i]
        prior[i, i] += drive[i]


def inertial_predict(
    mean: Array,
    covariance: Array,
    force: Array,
    rate: Array,
    period: float,
    gravity: float,
    keep: Array,
    drive: Array,
) -> tuple[Array, Array]:
    """Prior mean (..., n + 1) and covariance (..., n, n) of a strapdown period.

    Mean: position and velocity NWU, quaternion wxyz, accelerometer bias, gyro bias, then further
    states. Errors: the same with a rotation vector in body axes, `q = q_hat exp(theta)` (Sola 2017,
    "Quaternion kinematics for the error-state Kalman filter", section 5; attitude to second order
    in the period: specific force in the axes of its middle).

    Args:
        mean: (..., n + 1).
        covariance: (..., n, n).
        force: (..., 3) mean specific force of the period, FLU, m/s2.
        rate: (..., 3) mean angular rate, FLU, rad/s.
        period: T, s.
        gravity: m/s2.
        keep: (n,) share of each state after a period: Gauss-Markov decay; 1 for pose and velocity.
        drive: (n,) variance that each state gains in a period.
    """
    prior_mean, prior, _, _ = _inertial(
        mean, covariance, force, rate, period, gravity, keep, drive, np.empty(18), np.empty(9)
    )
    return prior_mean, prior
