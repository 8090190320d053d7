"""Floating bodies start a run as if they had been in these waves for long."""

from collections.abc import Iterator

import mujoco
import numpy as np

from marine_mj.frames import Array, quaternion_from_euler
from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.low_frequency import filter_state
from marine_mj.hydrodynamics.memory_pack import memory_state
from marine_mj.hydrodynamics.native import records, table_of
from marine_mj.hydrodynamics.vector_fitting import Complex


def _elements(table: Array, *kinds: float) -> Iterator[tuple[int, Array]]:
    """(body, parameters) of every element of these kinds."""
    for record in records(table):
        place = int(record[t_.B_ELEMENT_DATA])
        for _ in range(int(record[t_.B_ELEMENTS])):
            size = int(table[place + t_.EL_SIZE])
            if table[place + t_.EL_KIND] in kinds:
                yield int(record[t_.B_BODY]), table[place + t_.EL_DATA : place + size]
            place += size


def _amplitudes(table: Array, q: Array) -> tuple[Array, Complex]:
    """omega (n,) and motion amplitudes X (6, n) of an element: `x = Re sum X exp(-i omega t)`."""
    n = int(table[t_.E_WAVES])
    start = int(table[t_.E_WAVE_DATA]) + t_.W_OMEGA * n
    offset = int(q[4])
    data = table[offset : offset + 12 * n].reshape(6, 2, n)
    return table[start : start + n], data[:, 0] + 1j * data[:, 1]


def wave_pose(table: Array, q: Array, time: float) -> tuple[Array, Array]:
    """Position (3,) NWU and attitude (4,) wxyz by the RAOs of an element `q` at `time` [s]."""
    omega, X = _amplitudes(table, q)
    x = X.real @ np.cos(omega * time) + X.imag @ np.sin(omega * time)
    c, s = np.cos(q[3]), np.sin(q[3])
    position = q[:3] + np.array([c * x[0] - s * x[1], s * x[0] + c * x[1], x[2]])
    return position, quaternion_from_euler(x[3:] + np.array([0.0, 0.0, q[3]]))


def _current(table: Array, height: float, time: float) -> Array:
    """Current velocity (3,) NWU at a height [m] and time [s]."""
    velocity = np.zeros(3)
    levels, knots = int(table[t_.E_LEVELS]), int(table[t_.E_KNOTS])
    place = int(table[t_.E_LEVEL_DATA])
    if levels:
        z = table[place : place + levels]
        profile = table[place + levels : place + 4 * levels].reshape(levels, 3)
        velocity += [np.interp(height, z, column) for column in profile.T]
    if knots:
        place = int(table[t_.E_KNOT_DATA])
        series = table[place : place + 3 * knots].reshape(knots, 3)
        times = table[t_.E_INTERVAL] * np.arange(knots)
        velocity += [np.interp(time, times, column) for column in series.T]
    return velocity


def _yaw(model: mujoco.MjModel, data: mujoco.MjData, body: int) -> float:
    """Yaw [rad], NWU, of a body in its present position."""
    mujoco.mj_kinematics(model, data)
    return float(np.arctan2(data.xmat[body, 3], data.xmat[body, 0]))


def start_in_waves(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Give every floating body with RAOs the pose and velocity of its steady motion at `data.time`.

    Call it once after a reset. Without it a body with prescribed motion jumps onto its path in the
    first step and throws away what touches it; a dynamic one starts at rest in waves that are there
    already, and drifts for as long as its small surge damping takes to forget that. A dynamic body
    moves about its pose at qpos0 and about the velocity that it has in `data`. Radiation memory
    starts as if the body had moved so for long; the low-frequency place of the wave loads is the
    one about which the body moves (without this call it starts where the body is). Nothing happens
    on a model without such bodies.
    """
    table = table_of(model)
    prescribed = {body for body, _ in _elements(table, t_.PRESCRIBED)}
    paths = dict(_elements(table, t_.PRESCRIBED, t_.EXCITATION))
    mean = {}
    for body in paths:
        dof = model.jnt_dofadr[model.body_jntadr[body]]
        mean[body] = np.zeros(6) if body in prescribed else data.qvel[dof : dof + 6].copy()
    # the semi-implicit integrators are one step ahead of the states (kernels.radiation)
    rk4 = model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4
    for body, q in _elements(table, t_.MEMORY):
        path = paths.get(body)
        yaw = _yaw(model, data, body) if path is None else path[3]
        c, s = np.cos(yaw), np.sin(yaw)
        u, v, w = mean.get(body, np.zeros(6))[:3] - _current(table, 0.0, data.time)
        nu = np.array([c * u + s * v, c * v - s * u, w, 0, 0, 0])
        time = data.time - (0.0 if rk4 else model.opt.timestep)
        waves = None if path is None else _amplitudes(table, path)
        states = memory_state(q, nu, waves, time)
        place = int(q[t_.MM_ADDRESS])
        data.act[place : place + len(states)] = states
    for record in records(table):
        place, body = int(record[t_.B_LOW_FREQUENCY]) - 1, int(record[t_.B_BODY])
        if place >= 0 and body in paths:
            pose = paths[body][[0, 1, 3]]
            data.act[place : place + t_.LF_STATES] = filter_state(pose, mean[body][[0, 1, 5]])
    for body, q in paths.items():
        _set_motion(model, data, body, table, q, mean[body])


def _set_motion(
    model: mujoco.MjModel, data: mujoco.MjData, body: int, table: Array, q: Array, mean: Array
) -> None:
    """Write pose and velocity of a body's wave motion about a mean velocity (6,)."""
    step, joint = 1e-4, model.body_jntadr[body]
    address, dof = model.jnt_qposadr[joint], model.jnt_dofadr[joint]
    position, quaternion = wave_pose(table, q, data.time)
    before = wave_pose(table, q, data.time - step)
    after = wave_pose(table, q, data.time + step)
    data.qpos[address : address + 3] = position
    data.qpos[address + 3 : address + 7] = quaternion
    data.qvel[dof : dof + 3] = mean[:3] + (after[0] - before[0]) / (2 * step)
    turn = np.zeros(3)
    mujoco.mju_subQuat(turn, after[1], before[1])
    data.qvel[dof + 3 : dof + 6] = mean[3:] + turn / (2 * step)
