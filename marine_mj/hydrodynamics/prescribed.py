"""Bodies with prescribed motion: where their path begins."""

from collections.abc import Iterator

import mujoco
import numpy as np

from marine_mj.frames import Array, quaternion_from_euler
from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.native import table_of


def _elements(table: Array, kind: float) -> Iterator[tuple[int, Array]]:
    """(body, parameters) of every element of a kind."""
    place = int(table[t_.H_FIRST_BODY])
    for _ in range(int(table[t_.H_BODIES])):
        element = int(table[place + t_.B_ELEMENT_DATA])
        for _ in range(int(table[place + t_.B_ELEMENTS])):
            size = int(table[element + t_.EL_SIZE])
            if table[element + t_.EL_KIND] == kind:
                yield int(table[place + t_.B_BODY]), table[element + t_.EL_DATA : element + size]
            element += size
        place += int(table[place + t_.B_SIZE])


def prescribed_pose(table: Array, q: Array, time: float) -> tuple[Array, Array]:
    """Position (3,) NWU and attitude (4,) wxyz of a PRESCRIBED element `q` at `time` [s]."""
    n = int(table[t_.E_WAVES])
    start = int(table[t_.E_WAVE_DATA]) + t_.W_OMEGA * n
    omega = table[start : start + n]
    offset = int(q[4])
    data = table[offset : offset + 12 * n].reshape(6, 2, n)
    x = data[:, 0] @ np.cos(omega * time) + data[:, 1] @ np.sin(omega * time)
    c, s = np.cos(q[3]), np.sin(q[3])
    position = q[:3] + np.array([c * x[0] - s * x[1], s * x[0] + c * x[1], x[2]])
    return position, quaternion_from_euler(x[3:] + np.array([0.0, 0.0, q[3]]))


def place_prescribed_bodies(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Put every body with prescribed motion on its path at `data.time`, with the path's velocity.

    Call it after a reset: from anywhere else the body would jump onto its path in one step, and
    whatever touches it would be thrown away. Nothing happens on a model without such bodies.
    """
    table = table_of(model)
    step = 1e-4
    for body, q in _elements(table, t_.PRESCRIBED):
        joint = model.body_jntadr[body]
        address, dof = model.jnt_qposadr[joint], model.jnt_dofadr[joint]
        position, quaternion = prescribed_pose(table, q, data.time)
        before = prescribed_pose(table, q, data.time - step)
        after = prescribed_pose(table, q, data.time + step)
        data.qpos[address : address + 3] = position
        data.qpos[address + 3 : address + 7] = quaternion
        data.qvel[dof : dof + 3] = (after[0] - before[0]) / (2 * step)
        turn = np.zeros(3)
        mujoco.mju_subQuat(turn, after[1], before[1])
        data.qvel[dof + 3 : dof + 6] = turn / (2 * step)
