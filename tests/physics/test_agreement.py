"""One physics, many ways to run it: all of them give the same bits."""

import copy
import pickle

import mujoco
import numpy as np
import pytest
from mujoco import batch, rollout

import marine_mj
from marine_mj.environment import Environment, fluctuating_current, gusty_wind, irregular_sea
from marine_mj.hydrodynamics import compile_spec, pack_table, read_coefficients
from marine_mj.hydrodynamics.native import table_of, table_slice

STEPS = 150
SETTINGS = {"usv": {"motion": "rao"}}

#: A slender vehicle with strips, thrust with lag and a tank, pressed against the bottom of a
#: vessel that plays back motion RAOs.
SCENE = """<mujoco>
<option timestep="0.005" integrator="{}"/>
<custom>
  <numeric name="auv.added_mass_frd" data="5.8 65.1 65.1 0.1 11.9 11.9"/>
  <numeric name="auv.displaced_volume" data="0.09"/>
  <numeric name="auv.strips" data="8 -0.95 0.95"/>
  <numeric name="auv.strip_drag_frd" data="264 264"/>
  <numeric name="auv.quadratic_damping_frd" data="42 0 0 1 5 5"/>
  <numeric name="auv.tank.pump" data="-0.3 0 0.05 1025"/>
  <numeric name="usv.added_mass_frd" data="300 800 8000 400 9500 1500"/>
  <numeric name="usv.restoring_frd" data="0 0 75414 10745 153703 0"/>
  <numeric name="usv.wind" data="2 6 5 0.5 0.7 0.9 0.1"/>
  <text name="usv.wave_database" data="dus_v5750_box.nc"/>
</custom>
<worldbody>
  <body name="auv" pos="0.2 0.1 -0.45"><freejoint/>
    <inertial pos="0 0 0" mass="61.5" diaginertia="0.31 14.22 14.22"/>
    <geom type="capsule" fromto="-0.85 0 0 0.85 0 0" size="0.1" mass="0"/>
    <site name="auv.center_of_buoyancy" pos="0 0 0.01"/><site name="s" pos="-0.9 0 0"/>
  </body>
  <body name="usv"><freejoint/>
    <inertial pos="0 0 0" mass="2306" diaginertia="1040 5412 5237"/>
    <geom type="box" size="2.5 0.75 0.3" pos="0 0 0" mass="0"/>
  </body>
</worldbody>
<actuator>
  <general name="t" site="s" gear="1 0 0 0.1 0 0" dyntype="filterexact" dynprm="0.15"/>
  <general name="u" site="s" gear="0 1 0 0 0 0" dyntype="user" dynprm="1 0.3 -50 60"/>
  <general name="pump" site="s" gear="0 0 0 0 0 0" dyntype="integrator"/>
</actuator></mujoco>"""


def environment(seed=0):
    """Sea of 100 components, fluctuating current, gusts."""
    return Environment(
        waves=irregular_sea(0.8, 4.6, components=100, seed=seed, spreading=2.0),
        current=fluctuating_current([0.3, 0.1, 0], 0.1, 5.0, 20.0, seed=seed),
        wind=gusty_wind(6.0, 0.7, 20.0, seed=seed),
    )


def build(integrator="implicitfast", seed=0):
    """(model, coefficients) of the scene."""
    spec = mujoco.MjSpec.from_string(SCENE.format(integrator))
    bodies = read_coefficients(spec)
    return compile_spec(spec, environment(seed), SETTINGS), bodies


@pytest.fixture(scope="module", params=["implicitfast", "RK4"])
def model(request):
    """The scene."""
    return build(request.param)[0]


CONTROLS = np.random.default_rng(5).uniform(-30, 30, size=(4, STEPS, 3)) * [1, 1, 1e-5]


def run(model, data, steps, controls=None):
    """Plain loop."""
    for step in range(steps):
        if controls is not None:
            data.ctrl[:] = controls[step]
        mujoco.mj_step(model, data)
    return data


def state(model, data):
    """Everything that decides the future."""
    out = np.zeros(mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_INTEGRATION))
    mujoco.mj_getState(model, data, out, mujoco.mjtState.mjSTATE_INTEGRATION)
    return out


def physics(model, data):
    """Time, positions, velocities and activations."""
    out = np.zeros(mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS))
    mujoco.mj_getState(model, data, out, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    return out


def started(model):
    """Data some way into the run, in contact."""
    data = mujoco.MjData(model)
    data.ctrl[:] = 20.0, -10.0, 1e-4
    return run(model, data, 100)


def test_the_scene_uses_what_it_should(model):
    data = mujoco.MjData(model)
    data.ctrl[:] = 20.0, -10.0, 1e-4
    touched = 0
    for _ in range(100 + STEPS):
        mujoco.mj_step(model, data)
        touched += data.ncon > 0
    marine_mj.check_state(model, data)
    assert touched > 50
    mujoco.mj_forward(model, data)
    causes = marine_mj.wrenches(model, data)
    for cause in ("added_mass", "damping", "restoring", "waves", "ballast", "propulsion"):
        assert np.abs(causes["auv"][cause]).max() > 1e-3, cause
    for cause in ("restoring", "wind", "prescribed"):
        assert np.abs(causes["usv"][cause]).max() > 1, cause


def test_many_steps_in_one_call(model):
    ends = []
    for together in (False, True):
        data = started(model)
        if together:
            mujoco.mj_step(model, data, STEPS)
        else:
            run(model, data, STEPS)
        ends.append(state(model, data))
    assert (ends[0] == ends[1]).all()


def test_save_and_restore(model):
    data = started(model)
    saved = state(model, data)
    first = state(model, run(model, data, STEPS))
    # back in the same data, and in fresh ones
    mujoco.mj_setState(model, data, saved, mujoco.mjtState.mjSTATE_INTEGRATION)
    assert (state(model, run(model, data, STEPS)) == first).all()
    fresh = mujoco.MjData(model)
    mujoco.mj_setState(model, fresh, saved, mujoco.mjtState.mjSTATE_INTEGRATION)
    assert (state(model, run(model, fresh, STEPS)) == first).all()


def test_copies(model):
    data = started(model)
    twins = [copy.copy(data), copy.deepcopy(data), pickle.loads(pickle.dumps(data))]
    models = [model, copy.deepcopy(model), pickle.loads(pickle.dumps(model))]
    first = state(model, run(model, data, STEPS))
    for twin, own in zip(twins, models, strict=True):
        assert (state(own, run(own, twin, STEPS)) == first).all()


def test_binary_file(model, tmp_path):
    path = str(tmp_path / "scene.mjb")
    mujoco.mj_saveModel(model, path, None)
    loaded = mujoco.MjModel.from_binary_path(path)
    ends = [state(m, run(m, started(m), STEPS)) for m in (model, loaded)]
    assert (ends[0] == ends[1]).all()


def loops(model):
    """States (simulation, step, ...) of plain loops from the rest with all controls."""
    result = []
    for controls in CONTROLS:
        data, states = mujoco.MjData(model), []
        for control in controls:
            run(model, data, 1, control[None])
            states.append(physics(model, data))
        result.append(states)
    return np.array(result)


def test_rollout_with_two_threads(model):
    start = physics(model, mujoco.MjData(model))
    data = [mujoco.MjData(model) for _ in range(2)]
    states, _ = rollout.rollout(model, data, np.tile(start, (len(CONTROLS), 1)), CONTROLS)
    assert (states == loops(model)).all()


@pytest.mark.parametrize("persistent", [False, True])
def test_batch_with_one_and_two_threads(model, persistent):
    expected = loops(model)
    for threads in (1, 2):
        simulations = batch.Batch(model, len(CONTROLS), nthread=threads, persistent=persistent)
        record = mujoco.mjtState.mjSTATE_FULLPHYSICS
        got = simulations.rollout(
            STEPS, CONTROLS, int(mujoco.mjtState.mjSTATE_CTRL), record=[record]
        )[record]
        assert (got == expected).all()


@pytest.mark.parametrize("integrator", ["implicitfast", "RK4"])
def test_batch_over_seeds(integrator):
    """Tables of other seeds in one batch equal separately compiled models."""
    model, bodies = build(integrator)
    simulations = batch.Batch(model, 4, nthread=2)
    tables = simulations.expand("numeric_data")
    place = table_slice(model)
    chosen = {"usv": marine_mj.hydrodynamics.BodySettings(motion="rao")}
    ends = []
    for seed in range(4):
        tables[seed, place] = pack_table(model, bodies, environment(seed), chosen)
        own = build(integrator, seed)[0]
        assert (table_of(own) == tables[seed, place]).all()
        data = mujoco.MjData(own)
        data.ctrl[:] = 20.0, -10.0, 1e-4
        mujoco.mj_step(own, data, STEPS)
        ends.append(np.concatenate([data.qpos, data.qvel, data.act]))
    simulations.bind("ctrl")[:] = 20.0, -10.0, 1e-4
    simulations.step(nstep=STEPS)
    got = np.concatenate([simulations.bind(f) for f in ("qpos", "qvel", "act")], axis=1)
    assert (got == np.array(ends)).all()
    # the seeds differ: positions of the vehicle spread by centimetres
    assert np.ptp(got[:, :3], axis=0).max() > 0.01


def test_bound_arrays_of_a_batch_are_the_plain_forces(model):
    """Added mass is in the qacc that a batch reports, too."""
    simulations = batch.Batch(model, 1, nthread=1)
    qacc = simulations.bind("qacc")  # outputs are copied out once they are bound
    simulations.forward()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert (qacc[0] == data.qacc).all()


def test_rerun_in_the_same_data(model):
    """mj_resetData leaves nothing behind."""
    data = started(model)
    first = state(model, run(model, data, STEPS))
    mujoco.mj_resetData(model, data)
    data.ctrl[:] = 20.0, -10.0, 1e-4
    run(model, data, 100)
    assert (state(model, run(model, data, STEPS)) == first).all()
