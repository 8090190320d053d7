"""Docks that move, docks entered from behind, and the scenarios with them."""

import dataclasses

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from marine_mj.controllers import DockingPlan, Latch

from marine_mj import hydrodynamics
from marine_mj.errors import ModelError, ScenarioError
from marine_mj.scenario import Scenario
from marine_mj.scene import compile_scene, main_bodies
from marine_mj.simulation import run_batch
from marine_mj.tasks.dock_reader import DockReader
from marine_mj.tasks.docking_geometry import DockingGeometry

CALM = {"sea.spectrum": "none", "sea.sea_state": None, "sea.spreading": None}
SWINGING = """<mujoco><worldbody><body name="usv/hull"><freejoint/><geom size=".1"/>
  <body name="usv/dock/d" pos="0.3 -0.2 -1" euler="10 20 -30">
    <joint type="slide" axis="0 0.6 0.8" ref="0.05"/>
    <joint type="hinge" axis="0 1 0" pos="0.1 0.2 0.7"/>
    <joint type="hinge" axis="1 0 0" pos="-0.1 0.3 0.5" ref="0.1"/>
    <joint type="slide" axis="1 0 0"/>
    <geom size=".1"/></body></body></worldbody></mujoco>"""


def calm(name):
    return Scenario.load(name).with_values(CALM)


@pytest.fixture(scope="module")
def suspended():
    return compile_scene(calm("docking_suspended"), visual=False).model


def body_state(model, data, body):
    """Position, attitude, and twist FLU by MuJoCo."""
    velocity = np.zeros(6)
    mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_XBODY, body, velocity, 1)
    return data.xpos[body], data.xmat[body], np.roll(velocity, 3)


def test_dock_reader_agrees_with_mujoco(rng):
    model = mujoco.MjModel.from_xml_string(SWINGING)
    data = mujoco.MjData(model)
    reader = DockReader.of(model, 2, 1)
    qpos, qvel = rng.normal(size=(5, model.nq)), rng.normal(size=(5, model.nv))
    qpos[:, 3:7] /= np.linalg.norm(qpos[:, 3:7], axis=1, keepdims=True)
    many = reader.state(qpos, qvel)
    for i in range(5):
        data.qpos[:], data.qvel[:] = qpos[i], qvel[i]
        mujoco.mj_forward(model, data)
        position, attitude, twist = body_state(model, data, 2)
        # measured 4e-16, 3e-16, 2e-15
        np.testing.assert_allclose(many.position[i], position, atol=1e-12)
        np.testing.assert_allclose(many.rotation[i].ravel(), attitude, atol=1e-12)
        np.testing.assert_allclose(many.velocity[i], twist, atol=1e-12)
        single = reader.state(qpos[i], qvel[i])
        for name in ("position", "quaternion", "velocity"):
            assert (getattr(single, name) == getattr(many, name)[i]).all()


def test_suspended_dock_frames_are_those_of_the_dock_body(suspended, rng):
    geometry = DockingGeometry.of(suspended)
    data = mujoco.MjData(suspended)
    data.qpos[suspended.joint("usv/dock/heave").qposadr[0]] = 0.2
    data.qvel[:] = rng.normal(size=suspended.nv)
    mujoco.mj_forward(suspended, data)
    bearer = geometry.carrier_reader.state(data.qpos, data.qvel)
    aperture, seat = geometry.frames.states(bearer)
    np.testing.assert_allclose(aperture.position, data.site("usv/dock/aperture").xpos, atol=1e-12)
    np.testing.assert_allclose(seat.position, data.site("usv/dock/seat").xpos, atol=1e-12)
    assert geometry.axis == 2


def test_suspended_dock_swings_as_its_spring_and_wet_mass_say(suspended):
    """2 cm of free heave: period 2 pi sqrt((m + A33) / k), damped by the damper and the drag."""
    data = mujoco.MjData(suspended)
    auv = suspended.jnt_qposadr[suspended.body_jntadr[main_bodies(suspended)["auv"]]]
    data.qpos[auv] = -50.0
    joint = suspended.joint("usv/dock/heave")
    q, v = joint.qposadr[0], joint.dofadr[0]
    data.qpos[q] = 0.02
    crossings, before = [], 0.0
    for _ in range(6000):
        mujoco.mj_step(suspended, data)
        now = data.qvel[v]
        if before * now < 0:
            crossings.append(data.time - 0.005 * now / (now - before))
        before = now
    mass, spring, damper = 60 + 205, 160.0, 60.0
    closed = 2 * np.pi / np.sqrt(spring / mass - (damper / (2 * mass)) ** 2)
    # measured 8.19 s, closed form 8.17 s
    assert 2 * np.diff(crossings).mean() == pytest.approx(closed, rel=0.01)


def test_weight_of_a_dock_afloat_is_not_borne_twice(suspended):
    """The USV floats where it does with the massless cradle, the neutral dock at its rest."""
    data = mujoco.MjData(suspended)
    auv = suspended.jnt_qposadr[suspended.body_jntadr[main_bodies(suspended)["auv"]]]
    data.qpos[auv] = -50.0
    mujoco.mj_step(suspended, data, 2000)
    usv = suspended.jnt_qposadr[suspended.body_jntadr[main_bodies(suspended)["usv"]]]
    # measured 2e-9 and 8e-7 m; the dock's weight would sink the USV by 7.8 mm
    assert abs(data.qpos[usv + 2]) < 1e-4
    assert abs(data.qpos[suspended.joint("usv/dock/heave").qposadr[0]]) < 1e-3


def test_carrier_heave_reaches_a_suspended_dock_through_the_spring_only():
    """Waves of 3 s: the dock moves far less than the USV that carries it."""
    wave = {"sea.spectrum": "regular", "sea.sea_state": None, "sea.spreading": None}
    wave |= {"sea.height": 0.3, "sea.period": 3.0, "vehicles.usv.motion": "rao"}
    model = compile_scene(Scenario.load("docking_suspended").with_values(wave), visual=False).model
    data = mujoco.MjData(model)
    hydrodynamics.start_in_waves(model, data)
    auv = model.jnt_qposadr[model.body_jntadr[main_bodies(model)["auv"]]]
    data.qpos[auv] = -50.0
    usv, dock = main_bodies(model)["usv"], model.body("usv/dock/cradle").id
    heights = []
    for step in range(6000):
        mujoco.mj_step(model, data)
        if step > 3000:
            heights.append([data.xpos[usv, 2], data.xpos[dock, 2]])
    usv_span, dock_span = np.ptp(heights, axis=0)
    # measured 0.254 m and 0.173 m: of the wave's 0.3 m, exp(-k z) = 0.59 reaches 1.2 m depth
    assert usv_span > 0.22
    assert dock_span < 0.75 * usv_span


@pytest.mark.parametrize("name", ["docking_funnel", "docking_pole", "docking_suspended"])
def test_scenarios_dock(name):
    check_docking(name, [{"task.settings.hold": 0.1}])


@pytest.mark.validation
@pytest.mark.parametrize("name", ["docking_funnel", "docking_pole", "docking_suspended"])
def test_scenarios_dock_in_calm_water_and_other_seas(name):
    check_docking(name, [CALM, {"seed": 4}])


def check_docking(name, variations):
    for row in run_batch(Scenario.load(name), variations).rows:
        assert row["docked"] and not row["forbidden_contact"], row
        # measured at most 1.4 kN and 7 J
        assert row["peak_contact_force"] < 3000 and row["contact_energy"] < 20
        assert row["contact_penetration"] < 0.01


def test_horizontal_docks_are_entered_along_x():
    for name in ("docking_funnel", "docking_pole"):
        model = compile_scene(calm(name), visual=False).model
        assert DockingGeometry.of(model).axis == 0


def test_only_two_ways_into_a_dock():
    scene = compile_scene(calm("docking_funnel"), visual=False)
    scene.model.site("usv/dock/seat").pos[2] += 0.5
    with pytest.raises(ModelError, match=r"the seat lies at \[0\.84.*\] m from the aperture"):
        DockingGeometry.of(scene.model)
    with pytest.raises(ScenarioError, match=r"axis is 1, allowed are 2 .* and 0"):
        DockingPlan(axis=1)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('type="slide" axis="1 0 0"', 'type="ball"', "is of type mjJNT_BALL; allowed are slide"),
        ('<body name="usv/dock/d"', '<body name="x"/><body name="usv/dock/d"', None),
    ],
)
def test_docks_hang_on_slides_and_hinges(old, new, message):
    text = SWINGING.replace(old, new)
    if message is None:
        text = text.replace('<body name="x"/>', '<body name="x">').replace(
            "</body></body></worldbody>", "</body></body></body></worldbody>"
        )
        message = "hangs on 'x'; allowed is the main body of its carrier, 'usv/hull'"
    model = mujoco.MjModel.from_xml_string(text)
    with pytest.raises(ModelError, match=message):
        DockReader.of(model, model.body("usv/dock/d").id, 1)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.0, 0.3), st.floats(0.2, 2.5))
def test_latch_never_closes_outside_its_limits(seed, dwell, spread):
    """Random walks in and out of the limits: it closes when, and only when, all were kept."""
    rng = np.random.default_rng(seed)
    latch = dataclasses.replace(Latch(), dwell=dwell)
    scale = np.array([0.03] * 3 + [0.03] * 3 + [0.06] * 3 + [0.1] * 3) * spread
    state, period, kept = latch.initial((4,)), 0.01, np.zeros(4)
    walk = scale * rng.normal(size=(4, 12))
    for _ in range(80):
        walk = 0.9 * walk + 0.44 * scale * rng.normal(size=(4, 12))
        error, velocity = walk[:, :6], walk[:, 6:]
        length = [np.linalg.norm(part, axis=1) for part in np.split(walk, 4, axis=1)]
        inside = np.all(np.transpose(length) <= [0.05, np.deg2rad(3), 0.1, np.deg2rad(10)], axis=1)
        kept = np.where(inside, kept + 1, 0)
        before = state.closed
        state = latch.update(state, error, velocity, period)
        assert (state.closed == (before | (kept * period >= dwell + 0.5 * period))).all()
