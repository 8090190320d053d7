"""Every refusal of a running simulation, of tables and of callbacks, by its words."""

import subprocess
import sys

import mujoco
import numpy as np
import pytest
from conftest import numeric, one_body, with_database

import marine_mj
from marine_mj.environment import Environment, regular_wave
from marine_mj.errors import MarineMjError, ModelError, SimulationError
from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.native import table_of

pytestmark = pytest.mark.usefixtures("log_elsewhere")


# A running simulation


def test_nan_control():
    model = marine_mj.load_xml(one_body(added_mass=np.ones(6), gravity=0))
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 10)
    marine_mj.check_state(model, data)
    data.ctrl[0] = np.nan
    mujoco.mj_step(model, data)
    with pytest.raises(SimulationError, match=r"control of actuator 't' is nan at t = 0\.0550 s"):
        marine_mj.check_state(model, data)
    assert np.isfinite(data.qpos).all()


def test_divergence_names_time_and_body():
    other = '<body name="{}" pos="{} 5 0"><freejoint/><geom size="0.1"/></body>'
    xml = one_body(
        added_mass=[5, 5, 5, 1, 1, 1],
        numerics=numeric("quadratic_damping_flu", "100 100 100 1 1 1"),
        world="".join(other.format(f"b{i}", i) for i in range(8)),
        gravity=0,
    )
    model = marine_mj.load_xml(xml)
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data)
    data.qvel[model.joint("a").dofadr[0]] = 1e4
    mujoco.mj_step(model, data, 200)
    # without automatic reset the time goes on
    assert data.time == pytest.approx(201 * 0.005)
    with pytest.raises(SimulationError, match=r"diverged at t = 1\.0050 s: body 'a'.*time step"):
        marine_mj.check_state(model, data)


def test_bad_position_names_the_right_body():
    bodies = "".join(
        f'<body name="b{i}" pos="{i} 5 0"><freejoint/><geom size="0.1"/></body>' for i in range(9)
    )
    model = marine_mj.load_xml(one_body(added_mass=np.ones(6), world=bodies, gravity=0))
    data = mujoco.MjData(model)
    # the last entry of the quaternion of b2; a's and b3's degrees of freedom are numbered alike
    data.qpos[model.joint(2).qposadr[0] + 6] = np.inf
    mujoco.mj_step(model, data)
    with pytest.raises(SimulationError, match="body 'b2'"):
        marine_mj.check_state(model, data)


def test_state_that_is_not_finite():
    model = marine_mj.load_xml(one_body(added_mass=np.ones(6), gravity=0))
    data = mujoco.MjData(model)
    data.qvel[2] = np.nan
    with pytest.raises(SimulationError, match=r"not finite numbers at t = 0\.0000 s"):
        marine_mj.check_state(model, data)


def test_nan_state_does_not_crash_the_kernel():
    sea = Environment(waves=regular_wave(2.0, 6.0))
    for motion in ("rao", "dynamic"):
        model = marine_mj.load_xml(
            with_database("dus_v5750_box.nc"), sea, {"a": {"motion": motion}}
        )
        data = mujoco.MjData(model)
        data.qpos[:] = np.nan
        data.qvel[:] = np.nan
        mujoco.mj_step(model, data, 3)
        with pytest.raises(SimulationError):
            marine_mj.check_state(model, data)


# Tables and callbacks


def test_wrenches_of_a_plain_model():
    model = marine_mj.load_xml(one_body())
    data = mujoco.MjData(model)
    with pytest.raises(ModelError, match=r"no hydrodynamics table: make it with marine_mj\.load"):
        marine_mj.wrenches(model, data)


def step_table(change):
    """Surge acceleration of a pushed body after `change(table)`; the model."""
    model = marine_mj.load_xml(one_body(added_mass=np.full(6, 10.0), center="0 0 0", gravity=0))
    change(table_of(model))
    data = mujoco.MjData(model)
    data.ctrl[0] = 1.0
    mujoco.mj_forward(model, data)
    return data.qacc[0], model, data


def test_tables_of_others_are_ignored():
    def nothing(table):
        pass

    def version(table):
        table[t_.H_VERSION] = t_.VERSION + 1

    def magic(table):
        table[t_.H_MAGIC] = 1.0

    def length(table):
        table[t_.H_LENGTH] += 1

    assert step_table(nothing)[0] == pytest.approx(0.05)
    refusals = ((version, "version 3"), (magic, "no hydrodynamics"), (length, "damaged"))
    for change, expected in refusals:
        acceleration, model, data = step_table(change)
        assert acceleration == pytest.approx(0.1)
        with pytest.raises(ModelError, match=expected):
            marine_mj.wrenches(model, data)


def in_new_process(code):
    """Output of a Python program."""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    return done.stdout + done.stderr


@pytest.mark.parametrize("name", ["passive", "act_dyn"])
def test_callback_of_somebody_else(name):
    out = in_new_process(f"import mujoco\nmujoco.set_mjcb_{name}(lambda *a: 0)\nimport marine_mj\n")
    assert "MarineMjError" in out
    assert f"mjcb_{name} is already set" in out
    assert f"mujoco.set_mjcb_{name}(None)" in out


def test_struct_layout_of_another_mujoco():
    from marine_mj.hydrodynamics import layout

    with pytest.raises(MarineMjError, match=r"MjModel\.nnumeric.*supports mujoco >=3\.17,<4"):
        layout._check({"nnumeric": 8}, {})


def test_importing_twice_is_harmless():
    from marine_mj.hydrodynamics.native import install, self_test

    install()
    self_test()


def test_callback_set_after_the_import():
    xml = one_body(added_mass=np.ones(6))
    out = in_new_process(
        "import marine_mj, mujoco\n"
        "mujoco.set_mjcb_passive(lambda m, d: None)\n"
        f"marine_mj.load_xml('''{xml}''')\n"
    )
    assert "MarineMjError" in out
    assert "mjcb_passive is already set" in out


def test_removed_callback_comes_back_with_the_next_load():
    mujoco.set_mjcb_passive(None)
    model = marine_mj.load_xml(one_body(added_mass=np.full(6, 10.0), center="0 0 0", gravity=0))
    data = mujoco.MjData(model)
    data.ctrl[0] = 1.0
    mujoco.mj_forward(model, data)
    assert data.qacc[0] == pytest.approx(0.05)
