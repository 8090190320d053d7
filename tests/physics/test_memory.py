"""Radiation memory in the simulation: against the frequency domain, and its bookkeeping."""

import pickle

import mujoco
import numpy as np
import pytest
from mujoco import batch, rollout

import marine_mj
from marine_mj.environment import Environment, irregular_sea, uniform_current
from marine_mj.hydrodynamics import (
    BodySettings,
    database_memory,
    load,
    read_coefficients,
    start_in_waves,
    write_environment,
)
from marine_mj.hydrodynamics.raos import database_path, read_responses
from marine_mj.hydrodynamics.stability import largest_timestep
from marine_mj.library import find_model
from marine_mj.validation import radiation as cases

USV = "dus_v5750"


@pytest.mark.parametrize(
    ("index", "column"), [(20, cases.AHEAD), (30, cases.OBLIQUE)]
)  # 2.3 s ahead, 2 s oblique
def test_regular_waves_give_the_rao(index, column):
    rao = read_responses(database_path("dus_v5750_box.nc"), "motion")[2][index, column]
    got = cases.response(index, column)
    for dof in cases.DOFS_OF[column]:
        ratio = got / rao
        # measured: within 0.31 % and 0.72 deg (0.5 and 0.7 deg of it the hull friction of surge and
        # sway, which the RAO has not)
        assert abs(abs(ratio[dof]) - 1) < 0.01, dof
        assert abs(np.degrees(np.angle(ratio[dof]))) < 3, dof


@pytest.mark.parametrize("integrator", ["implicitfast", "RK4"])
@pytest.mark.parametrize("dof", [2, 3, 4])
def test_decay_is_the_inverse_transform_of_the_frequency_response(dof, integrator):
    got, expected = cases.decay(dof, integrator)
    # measured: 0.9 % of the largest; 0.5 % with RK4
    assert np.abs(got - expected).max() < 0.015 * np.abs(expected).max()


def rates(model, data):
    """Rates of the states, independently: continuous, and over one step with nu held."""
    A, B, _ = database_memory("dus_v5750_box.nc").state_space()
    mujoco.mj_forward(model, data)
    yaw = np.arctan2(data.xmat[1, 3], data.xmat[1, 0])
    R = np.array([[np.cos(yaw), -np.sin(yaw), 0], [np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]])
    v = data.qvel[:3] - [0.3, -0.2, 0.0]  # the current below
    nu = np.concatenate([R.T @ v, R.T @ data.xmat[1].reshape(3, 3) @ data.qvel[3:6]])
    h = model.opt.timestep
    Phi, Gamma = database_memory("dus_v5750_box.nc").discrete(h)
    z = data.act[: len(A)]
    return A @ z + B @ nu, (Phi @ z + Gamma @ nu - z) / h


@pytest.mark.parametrize("integrator", [0, 1, 2, 3])  # Euler, RK4, implicit, implicitfast
def test_rates_and_force_of_a_random_state(integrator):
    current = uniform_current([0.3, -0.2, 0.0])
    model = load(USV, Environment(current=current))
    model.opt.integrator = integrator
    data, rng = mujoco.MjData(model), np.random.default_rng(3)
    data.qpos[3:7] = np.array([0.7, 0.1, -0.15, 0.69]) / np.linalg.norm([0.7, 0.1, -0.15, 0.69])
    data.qvel[:6] = rng.normal(size=6)
    count = database_memory("dus_v5750_box.nc").states  # behind them stands the low-frequency place
    data.act[:count] = rng.normal(size=count)
    continuous, held = rates(model, data)
    rk4 = integrator == mujoco.mjtIntegrator.mjINT_RK4
    expected = continuous if rk4 else held
    # measured 4e-14
    np.testing.assert_allclose(data.act_dot[:count], expected, atol=1e-11)
    C = database_memory("dus_v5750_box.nc").state_space()[2]
    ahead = data.act if rk4 else data.act + model.opt.timestep * data.act_dot
    ahead = ahead[:count]
    force = marine_mj.wrenches(model, data)["hull"]["radiation"]
    yaw = np.arctan2(data.xmat[1, 3], data.xmat[1, 0])
    R = np.array([[np.cos(yaw), -np.sin(yaw), 0], [np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]])
    turn = data.xmat[1].reshape(3, 3).T @ R
    wanted = -np.concatenate([turn @ (C @ ahead)[:3], turn @ (C @ ahead)[3:]])
    # measured 2e-12 N of 80 kN
    np.testing.assert_allclose(force, wanted, atol=1e-8)


def test_radiation_takes_no_net_energy_from_any_motion():
    """Work of the kernel's force on random velocities, held over each step."""
    model = load(USV)
    data, rng = mujoco.MjData(model), np.random.default_rng(0)
    pose, work, highest = data.qpos.copy(), 0.0, -np.inf
    nu = np.zeros(6)
    for _ in range(3000):
        nu = 0.97 * nu + rng.normal(size=6) * [1, 1, 1, 3, 1, 1]
        data.qpos[:], data.qvel[:6] = pose, nu
        mujoco.mj_forward(model, data)
        work += model.opt.timestep * marine_mj.wrenches(model, data)["hull"]["radiation"] @ nu
        highest = max(highest, work)
        mujoco.mj_step(model, data)
    # measured: highest -0.5 J (after the first step), -2.7e6 J at the end
    assert highest < 0 and work < -1e5


def waves(seed=1):
    """An irregular sea with a current."""
    return Environment(
        waves=irregular_sea(0.5, 4.0, components=20, seed=seed),
        current=uniform_current([0.3, 0.1, 0.0]),
    )


def state(model, data):
    """Everything that a step depends on."""
    kind = mujoco.mjtState.mjSTATE_INTEGRATION
    out = np.zeros(mujoco.mj_stateSize(model, kind))
    mujoco.mj_getState(model, data, out, kind)
    return out


@pytest.mark.parametrize("integrator", ["implicitfast", "RK4"])
def test_same_bits_everywhere(integrator, tmp_path):
    model = load(USV, waves())
    model.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator.upper()}")
    data = mujoco.MjData(model)
    start_in_waves(model, data)
    begin = state(model, data)
    mujoco.mj_step(model, data, 200)
    half = state(model, data)
    mujoco.mj_step(model, data, 200)
    end = state(model, data)
    assert np.abs(data.act).max() > 0.01
    # restored in the middle
    other = mujoco.MjData(model)
    mujoco.mj_setState(model, other, half, mujoco.mjtState.mjSTATE_INTEGRATION)
    mujoco.mj_step(model, other, 200)
    assert (state(model, other) == end).all()
    # pickle, .mjb
    file = tmp_path / "model.mjb"
    mujoco.mj_saveModel(model, str(file))
    for copy in (pickle.loads(pickle.dumps(model)), mujoco.MjModel.from_binary_path(str(file))):
        other = mujoco.MjData(copy)
        mujoco.mj_setState(copy, other, begin, mujoco.mjtState.mjSTATE_INTEGRATION)
        mujoco.mj_step(copy, other, 400)
        assert (state(copy, other) == end).all()
    # rollout
    full = mujoco.mjtState.mjSTATE_FULLPHYSICS
    first = np.zeros(mujoco.mj_stateSize(model, full))
    other = mujoco.MjData(model)
    mujoco.mj_setState(model, other, begin, mujoco.mjtState.mjSTATE_INTEGRATION)
    mujoco.mj_getState(model, other, first, full)
    states, _ = rollout.rollout(model, other, first[None], nstep=400)
    last = np.zeros(len(first))
    mujoco.mj_getState(model, data, last, full)
    assert (states[0, -1] == last).all()
    # batch
    for threads in (1, 2):
        pool = batch.Batch(model, 3, nthread=threads)
        other = mujoco.MjData(model)
        mujoco.mj_setState(model, other, begin, mujoco.mjtState.mjSTATE_INTEGRATION)
        for name in ("qpos", "qvel", "act"):
            pool.bind(name)[:] = getattr(other, name)
        pool.step(nstep=400)
        for name in ("qpos", "qvel", "act"):
            assert (pool.bind(name) == getattr(data, name)).all()


def test_start_leaves_no_transient():
    """The states a run starts with are those that the waves would have left."""
    sea = Environment(waves=irregular_sea(0.01, 4.0, components=20, seed=1))
    model = load(USV, sea)
    data = mujoco.MjData(model)
    start_in_waves(model, data)
    mujoco.mj_step(model, data, 4000)
    long, size = data.act.copy(), np.abs(data.act).max()
    fresh = mujoco.MjData(model)
    fresh.time = data.time
    start_in_waves(model, fresh)
    # measured 0.9 % of the largest state; from zero it would be 100 %
    assert np.abs(fresh.act - long).max() < 0.03 * size


def test_start_in_a_current_is_steady():
    model = load(USV, Environment(current=uniform_current([0.5, 0.2, 0.0])))
    data = mujoco.MjData(model)
    start_in_waves(model, data)
    mujoco.mj_forward(model, data)
    moving = marine_mj.wrenches(model, data)["hull"]["radiation"]
    data.act[:] = 0
    data.qvel[0] = 0.01
    mujoco.mj_step(model, data)
    sudden = marine_mj.wrenches(model, data)["hull"]["radiation"]
    # K(0) = 0: measured 3e-13 N, against 53 N after one step of a sudden start
    assert np.abs(moving).max() < 1e-6 < 1.0 < np.abs(sudden).max()


def test_another_sea_fits_into_the_same_model():
    spec = mujoco.MjSpec.from_file(str(find_model(USV)))
    bodies = read_coefficients(spec)
    model, other = load(USV, waves(1)), load(USV, waves(2))
    write_environment(model, bodies, waves(2))
    assert (model.numeric_data == other.numeric_data).all()


@pytest.mark.parametrize("integrator", ["implicitfast", "RK4"])
def test_time_step_bound(integrator):
    """Just below the bound a small motion dies out, well above it grows."""
    spec = mujoco.MjSpec.from_file(str(find_model(USV)))
    body = read_coefficients(spec)[0]
    model = load(USV)
    model.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator.upper()}")
    bound = largest_timestep(model, body, BodySettings())
    ends = []
    for factor in (0.98, 1.15):
        model.opt.timestep = factor * bound
        data = mujoco.MjData(model)
        data.qvel[:6] = 1e-6
        mujoco.mj_step(model, data, 300)
        ends.append(np.abs(data.qvel[2:5]).max())
    # measured: 4e-14 and 2e-13, and NaN
    assert ends[0] < 1e-6 and not ends[1] < 1e-3
