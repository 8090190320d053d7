"""Floating bodies start a run as if they had been in these waves for long."""

from collections.abc import Iterator

import mujoco
import numpy as np

from marine_mj.frames import Array, quaternion_from_euler
from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.native import records, table_of


def _elements(table: Array) -> Iterator[tuple[int, Array]]:
    """(body, parameters) of every element that knows the motion RAOs of its body."""
    for record in records(table):
        place = int(record[t_.B_ELEMENT_DATA])
        for _ in range(int(record[t_.B_ELEMENTS])):
            size = int(table[place + t_.EL_SIZE])
            if table[place + t_.EL_KIND] in (t_.PRESCRIBED, t_.EXCITATION):
                yield int(record[t_.B_BODY]), table[place + t_.EL_DATA : place + size]
            place += size


def wave_pose(table: Array, q: Array, time: float) -> tuple[Array, Array]:
    """Position (3,) NWU and attitude (4,) wxyz by the RAOs of an element `q` at `time` [s]."""
    n = int(table[t_.E_WAVES])
    start = int(table[t_.E_WAVE_DATA]) + t_.W_OMEGA * n
    omega = table[start : start + n]
    offset = int(q[4])
    data = table[offset : offset + 12 * n].reshape(6, 2, n)
    x = data[:, 0] @ np.cos(omega * time) + data[:, 1] @ np.sin(omega * time)
    c, s = np.cos(q[3]), np.sin(q[3])
    position = q[:3] + np.array([c * x[0] - s * x[1], s * x[0] + c * x[1], x[2]])
    return position, quaternion_from_euler(x[3:] + np.array([0.0, 0.0, q[3]]))


def start_in_waves(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Give every floating body with RAOs the pose and velocity of its steady motion at `data.time`.

    Call it after a reset. Without it a body with prescribed motion jumps onto its path in the first
    step and throws away what touches it; a dynamic one starts at rest in waves that are there
    already, and drifts for as long as its small surge damping takes to forget that. Nothing happens
    on a model without such bodies.
    """
    table = table_of(model)
    step = 1e-4
    for body, q in _elements(table):
        joint = model.body_jntadr[body]
        address, dof = model.jnt_qposadr[joint], model.jnt_dofadr[joint]
        position, quaternion = wave_pose(table, q, data.time)
        before = wave_pose(table, q, data.time - step)
        after = wave_pose(table, q, data.time + step)
        data.qpos[address : address + 3] = position
        data.qpos[address + 3 : address + 7] = quaternion
        data.qvel[dof : dof + 3] = (after[0] - before[0]) / (2 * step)
        turn = np.zeros(3)
        mujoco.mju_subQuat(turn, after[1], before[1])
        data.qvel[dof + 3 : dof + 6] = turn / (2 * step)
