"""Rigid-body inertia of bodies and of what they carry."""

from collections.abc import Collection

import mujoco
import numpy as np

from marine_mj.frames import Array, skew


def rigid_inertia(model: mujoco.MjModel, body: int) -> Array:
    """Rigid-body inertia (6, 6) of one body about its frame origin, body axes FLU."""
    mass, center = model.body_mass[body], model.body_ipos[body]
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, model.body_iquat[body])
    R = turn.reshape(3, 3)
    S = skew(center)
    inertia = R @ np.diag(model.body_inertia[body]) @ R.T - mass * S @ S
    return np.block([[mass * np.eye(3), -mass * S], [mass * S, inertia]])


def subtree_inertia(
    model: mujoco.MjModel, body: int, afloat: Collection[int] = ()
) -> tuple[float, Array, Array]:
    """Mass, CG and rigid inertia (6, 6) about the body origin of a body with all it carries.

    `afloat`: bodies with a buoyancy of their own; below `body` they and what they carry are left
    out.
    """
    inside = [
        b
        for b in range(model.nbody)
        if _carried(model, b, body)
        and not any(_carried(model, b, a) for a in afloat if a > body and _carried(model, a, body))
    ]
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    R0, x0 = data.xmat[body].reshape(3, 3), data.xpos[body]
    mass, moment, total = 0.0, np.zeros(3), np.zeros((6, 6))
    for part in inside:
        R = R0.T @ data.xmat[part].reshape(3, 3)
        r = R0.T @ (data.xpos[part] - x0)
        shift = np.eye(6)
        shift[:3, 3:] = -skew(r)
        T = np.block([[R.T, np.zeros((3, 3))], [np.zeros((3, 3)), R.T]]) @ shift
        total += T.T @ rigid_inertia(model, part) @ T
        mass += float(model.body_mass[part])
        moment += model.body_mass[part] * (r + R @ model.body_ipos[part])
    return mass, moment / max(mass, 1e-300), total


def _carried(model: mujoco.MjModel, body: int, ancestor: int) -> bool:
    """Whether `body` hangs below `ancestor`."""
    while body > ancestor:
        body = int(model.body_parentid[body])
    return body == ancestor
