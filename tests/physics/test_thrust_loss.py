"""Thrust that thrusters lose to the advance speed."""

import mujoco
import numpy as np
import pytest
from scipy.optimize import brentq

import marine_mj
from marine_mj.errors import ModelError
from marine_mj.hydrodynamics.loader import load
from marine_mj.scenario import Scenario
from marine_mj.scene import compile_scene
from marine_mj.weather import environment_of

FORWARD = slice(0, 4)
LOSS = 1.96


def scout(**settings):
    model = load("scout", settings={"hull": {"thrust_loss": True, **settings}})
    data = mujoco.MjData(model)
    data.qpos[2] = -50.0
    return model, data


def test_speed_ahead_solves_the_balance_of_thrust_and_drag():
    model, data = scout(constant_buoyancy=True)
    data.ctrl[FORWARD] = 48.0
    for _ in range(round(20 / model.opt.timestep)):
        data.qpos[3:7], data.qvel[1:] = [1, 0, 0, 0], 0.0  # straight ahead is unstable
        mujoco.mj_step(model, data)
    balance = brentq(lambda u: 4 * (48 - LOSS * np.sqrt(48) * u) - 42.1 * u * u, 0, 3)
    assert balance == pytest.approx(1.5858, abs=1e-4)
    assert data.qvel[0] == pytest.approx(balance, rel=1e-6)  # 4e-11


def test_wrench_is_the_bilinear_law_at_every_thruster():
    model, data = scout()
    random = np.random.default_rng(3)
    data.qpos[3:7] = random.normal(size=4)
    data.qpos[3:7] /= np.linalg.norm(data.qpos[3:7])
    data.qvel[:] = random.normal(size=model.nv)
    data.act[:] = random.uniform(-30, 30, size=model.na)
    mujoco.mj_forward(model, data)
    report = marine_mj.wrenches(model, data)["hull"]
    R = data.xmat[1].reshape(3, 3)
    v, w = R.T @ data.qvel[:3], data.qvel[3:]
    expected = np.zeros(6)
    for i in range(8):
        r = model.site_pos[model.actuator_trnid[i, 0]]
        axis = model.actuator_gear[i, :3]
        loss = -LOSS * np.sqrt(abs(data.act[i])) * ((v + np.cross(w, r)) @ axis) * axis
        expected += np.concatenate([loss, np.cross(r, loss)])
    np.testing.assert_allclose(report["thrust_loss"], expected, atol=1e-12)  # 2e-14
    assert np.abs(expected).min() > 0.1


def test_a_current_takes_thrust_as_speed_does():
    current = marine_mj.environment.uniform_current([-1.0, 0.0, 0.0])
    settings = {"hull": {"thrust_loss": True}}
    model = load("scout", marine_mj.environment.Environment(current=current), settings)
    data = mujoco.MjData(model)
    data.qpos[2] = -50.0
    data.act[FORWARD] = 40.0
    mujoco.mj_forward(model, data)
    force = marine_mj.wrenches(model, data)["hull"]["thrust_loss"]
    assert force[0] == pytest.approx(-4 * LOSS * np.sqrt(40.0), rel=1e-12)


def test_without_the_setting_there_is_none():
    model = load("scout")
    data = mujoco.MjData(model)
    data.qvel[0], data.act[:] = 1.0, 20.0
    mujoco.mj_forward(model, data)
    assert not marine_mj.wrenches(model, data)["hull"]["thrust_loss"].any()


BODY = """<mujoco><custom><numeric name="a.added_mass_frd" data="1 1 1 0 0 0"/>
  <numeric name="a.thrust_loss.{actuator}" data="{loss}"/></custom>
  <worldbody><body name="a"><freejoint/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
  <site name="s" euler="0 0 90"/></body></worldbody>
  <actuator><general name="t" site="s" gear="{gear}" gainprm="2" ctrllimited="true"
  ctrlrange="-1 3"/></actuator></mujoco>"""


def body(actuator="t", loss="0.5", gear="4 0 0 0 0 0"):
    xml = BODY.format(actuator=actuator, loss=loss, gear=gear)
    return marine_mj.load_xml(xml, settings={"a": {"thrust_loss": True}})


def test_a_thruster_without_lag_is_read_from_its_clipped_command():
    model = body()
    data = mujoco.MjData(model)
    data.ctrl[0], data.qvel[1] = 5.0, 2.0  # the site looks to port
    mujoco.mj_forward(model, data)
    force = marine_mj.wrenches(model, data)["a"]["thrust_loss"]
    np.testing.assert_allclose(force, [0, -0.5 * np.sqrt(2 * 4 * 3) * 2, 0, 0, 0, 0], atol=1e-12)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"actuator": "u"}, "names the actuator 'u', which does not exist"),
        ({"loss": "-1"}, r"'a.thrust_loss.t' is \[-1.\]; allowed is one number >= 0"),
        ({"loss": "1 2"}, "allowed is one number >= 0"),
        ({"gear": "1 0 0 0 0 1"}, "thrust_loss of 't': allowed is an actuator with a fixed gain"),
    ],
)
def test_what_is_refused(change, message):
    with pytest.raises(ModelError, match=message):
        body(**change)


def test_an_ideal_wrench_has_no_thrusters_to_lose_thrust():
    ideal = Scenario.load("docking_demo").with_values({"vehicles.auv.actuation": "wrench"})
    model = compile_scene(ideal, environment_of(ideal), visual=False).model
    assert not any("thrust_loss" in model.numeric(i).name for i in range(model.nnumeric))
    lossy = ideal.with_values({"vehicles.auv.thrust_loss": True})
    with pytest.raises(ModelError, match=r"vehicles.auv: thrust_loss = true with actuation"):
        compile_scene(lossy, environment_of(lossy), visual=False)


def test_a_vehicle_without_coefficients_is_refused():
    with pytest.raises(ModelError, match="thrust_loss is True for 'hull', whose model has no"):
        load("bluerov2", settings={"hull": {"thrust_loss": True}})
