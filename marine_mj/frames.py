"""Frames and rotations: the only place where signs flip between conventions.

Simulation state is MuJoCo's: world NWU (x north, y west, z up), body FLU (x forward, y port,
z up). Marine literature uses NED world and FRD body (forward, starboard, down). Both pairs differ
by the same constant rotation by pi about x, `R_X = diag(1, -1, -1)`. Quaternions are wxyz.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from marine_mj import rigid_loops

Array = NDArray[np.float64]

#: Signs of a 3-vector under NED <-> NWU and FRD <-> FLU (its own inverse).
FLIP3 = np.array([1.0, -1.0, -1.0])
#: Signs of a 6-vector [linear; angular] under the same change of axes.
FLIP6 = np.concatenate([FLIP3, FLIP3])


def flip(vector: ArrayLike) -> Array:
    """Vector (..., 3) or (..., 6) in the other convention: NED <-> NWU, or FRD <-> FLU."""
    vector = np.asarray(vector, dtype=float)
    if vector.shape[-1] == 3:
        return vector * FLIP3
    if vector.shape[-1] == 6:
        return vector * FLIP6
    raise ValueError(f"last dimension is {vector.shape[-1]}, allowed are 3 and 6")


def flip_matrix(matrix: ArrayLike) -> Array:
    """Matrix (..., 6, 6) of a linear map in the other body convention: `T A T`, T = FLIP6."""
    return FLIP6[:, None] * np.asarray(matrix, dtype=float) * FLIP6[None, :]


def apply(matrix: ArrayLike, vector: ArrayLike) -> Array:
    """Products (..., n) of matrices (..., n, m) and vectors (..., m).

    Row by row: a vector gives the same bits alone or in a batch, which `vector @ matrix.T` does
    not promise.
    """
    return rigid_loops.apply(np.asarray(matrix, dtype=float), np.asarray(vector, dtype=float))


def apply_transposed(matrix: ArrayLike, vector: ArrayLike) -> Array:
    """Products (..., m) of transposed matrices (..., n, m) and vectors (..., n); see `apply`."""
    return rigid_loops.apply_transposed(
        np.asarray(matrix, dtype=float), np.asarray(vector, dtype=float)
    )


def cross(a: ArrayLike, b: ArrayLike) -> Array:
    """Cross products (..., 3); much faster than `numpy.cross`."""
    return rigid_loops.cross(np.asarray(a, dtype=float), np.asarray(b, dtype=float))


def length(vector: ArrayLike) -> Array:
    """Euclidean lengths (...,) of vectors (..., n); much faster than `numpy.linalg.norm`."""
    return rigid_loops.length(np.asarray(vector, dtype=float))


def ssa(angle: ArrayLike) -> Array:
    """Smallest signed angle [rad], in [-pi, pi)."""
    return (np.asarray(angle, dtype=float) + np.pi) % (2 * np.pi) - np.pi


def skew(vector: ArrayLike) -> Array:
    """Cross-product matrix (3, 3): `skew(a) @ b = a x b`."""
    x, y, z = np.asarray(vector, dtype=float)
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def rotation_from_quaternion(quaternion: ArrayLike) -> Array:
    """Rotation matrix (..., 3, 3), body to world, of unit quaternions (..., 4) wxyz."""
    return rigid_loops.rotation(np.asarray(quaternion, dtype=float), FLIP3)


def quaternion_from_euler(euler: ArrayLike) -> Array:
    """Quaternion (..., 4) wxyz of zyx Euler angles (..., 3) [phi, theta, psi] in rad.

    `R = Rz(psi) Ry(theta) Rx(phi)` (Fossen 2021, eq. 2.31), in whatever frame pair the angles
    are given.
    """
    half = 0.5 * np.asarray(euler, dtype=float)
    (cr, cp, cy) = np.moveaxis(np.cos(half), -1, 0)
    (sr, sp, sy) = np.moveaxis(np.sin(half), -1, 0)
    return np.stack(
        [
            cr * cp * cy + sr * sp * sy,
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
        ],
        axis=-1,
    )


def euler_from_quaternion(quaternion: ArrayLike) -> Array:
    """zyx Euler angles (..., 3) [phi, theta, psi] in rad of quaternions (..., 4) wxyz."""
    w, x, y, z = np.moveaxis(np.asarray(quaternion, dtype=float), -1, 0)
    sin_theta = np.clip(2 * (w * y - x * z), -1.0, 1.0)
    return np.stack(
        [
            np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
            np.arcsin(sin_theta),
            np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)),
        ],
        axis=-1,
    )


def flip_quaternion(quaternion: ArrayLike) -> Array:
    """Attitude (..., 4) wxyz in the other convention: FLU->NWU <-> FRD->NED (`R_X R R_X`)."""
    return np.asarray(quaternion, dtype=float) * np.array([1.0, 1.0, -1.0, -1.0])


def eta_ned(position: ArrayLike, quaternion: ArrayLike) -> Array:
    """Pose `eta` (..., 6) = [N, E, D, phi, theta, psi] (m, rad) of a body in NED/FRD.

    Args:
        position: (..., 3) world position, NWU, m.
        quaternion: (..., 4) attitude FLU -> NWU, wxyz.
    """
    return np.concatenate(
        [flip(position), euler_from_quaternion(flip_quaternion(quaternion))], axis=-1
    )


def pose_from_eta(eta: ArrayLike) -> tuple[Array, Array]:
    """World position (..., 3) NWU and quaternion (..., 4) wxyz of `eta` (..., 6) in NED/FRD."""
    eta = np.asarray(eta, dtype=float)
    return flip(eta[..., :3]), flip_quaternion(quaternion_from_euler(eta[..., 3:]))


def rotation_vector(quaternion: ArrayLike) -> Array:
    """Rotation vector (..., 3) in rad, shortest way, of quaternions (..., 4) wxyz."""
    return rigid_loops.rotation_vector(np.asarray(quaternion, dtype=float), FLIP3)


def quaternion_from_rotation_vector(vector: ArrayLike) -> Array:
    """Quaternion (..., 4) wxyz of a rotation vector (..., 3), rad."""
    vector = np.asarray(vector, dtype=float)
    half = 0.5 * np.sqrt(np.sum(vector**2, axis=-1))[..., None]
    return np.concatenate([np.cos(half), 0.5 * np.sinc(half / np.pi) * vector], axis=-1)


def quaternion_multiply(a: ArrayLike, b: ArrayLike) -> Array:
    """Hamilton product (..., 4) wxyz of `a` and `b`."""
    return rigid_loops.multiply(np.asarray(a, dtype=float), np.asarray(b, dtype=float))


def quaternion_conjugate(quaternion: ArrayLike) -> Array:
    """Conjugate (..., 4) wxyz: the inverse rotation of a unit quaternion."""
    return np.asarray(quaternion, dtype=float) * np.array([1.0, -1.0, -1.0, -1.0])
