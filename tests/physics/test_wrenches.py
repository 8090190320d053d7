"""`wrenches`: the causes add up to what moved the body."""

import mujoco
import numpy as np
import pytest
from conftest import kirchhoff, numbers, one_body, random_added_mass, rigid_mass

import marine_mj
from marine_mj.environment import (
    Current,
    Environment,
    fluctuating_current,
    gusty_wind,
    irregular_sea,
)
from marine_mj.hydrodynamics.wrenches import CAUSES, added_mass_of, body_acceleration

M_RB = rigid_mass(10.0, [0.02, 0.01, -0.05], [1.0, 2.0, 3.0])
SEA = irregular_sea(1.1, 5.5, components=100, seed=3)
ENVIRONMENT = Environment(
    waves=SEA,
    current=fluctuating_current(
        [[0.2, 0.1, 0], [0.5, -0.3, 0]], 0.1, 10.0, 60.0, levels=[-5.0, 0.0], seed=1
    ),
    wind=gusty_wind(9.0, 0.7, 60.0, seed=2),
)

#: Everything that a submerged body can have, and a floor, a latch and a tank.
EVERYTHING = {
    "added_mass": random_added_mass(1),
    "numerics": '<numeric name="a.displaced_volume" data="0.0105"/>'
    '<numeric name="a.linear_damping_flu" data="3 4 5 .3 .4 .5"/>'
    '<numeric name="a.quadratic_damping_flu" data="20 0 0 1 .5 .5"/>'
    '<numeric name="a.strips" data="6 -0.8 1"/>'
    '<numeric name="a.strip_drag_flu" data="30 50"/>'
    '<numeric name="a.submergence_height" data="0.2"/>'
    '<numeric name="a.wind" data="0.4 0.9 2 0.3 0.7 0.9 0.1"/>'
    '<numeric name="a.tank.pump" data="-0.3 0.1 0.2 1025"/>'
    '<numeric name="a.thrust_loss.t" data="0.5"/>',
    "extra": '<site name="a.center_of_buoyancy" pos="0.01 0 0.03"/>'
    '<geom type="sphere" size="0.25" pos="0.3 0 0" mass="0"/>'
    '<geom type="sphere" size="0.25" pos="-0.3 0.1 0" mass="0"/>'
    '<body name="fixed" pos="0.2 0.1 0"><geom type="box" size=".05 .05 .05" mass="0.7"/></body>',
    "world": '<geom type="plane" size="5 5 .1" pos="0 0 -0.5"/>',
    "tail": '<equality><weld body1="a" relpose="0 0 -0.05 1 0 0 0" solref="0.1 1"/></equality>',
    "pos": "0 0 -0.2",
}


def everything(integrator="implicitfast", **changes):
    """Model with every cause at once, in a state that uses all of them."""
    xml = one_body(integrator=integrator, **(EVERYTHING | changes))
    xml = xml.replace(
        "</actuator>",
        '<general name="pump" site="s" gear="0 0 0 0 0 0" dyntype="integrator"/></actuator>',
    )
    model = marine_mj.load_xml(xml, ENVIRONMENT, {"a": {"thrust_loss": True}})
    data = mujoco.MjData(model)
    data.time = 11.3
    data.qpos[2] = -0.27
    data.qpos[3:7] = [0.98, 0.1, -0.05, np.sqrt(1 - 0.98**2 - 0.01 - 0.0025)]
    data.qvel[:] = [0.5, -0.3, 0.2, 0.4, -0.6, 0.7]
    data.ctrl[:] = 7.0, 1e-4
    data.act[0] = 0.002
    data.qfrc_applied[:] = [1, 2, 3, 0.1, 0.2, 0.3]
    data.xfrc_applied[1] = [3, -2, 1, 0.3, -0.2, 0.1]
    data.xfrc_applied[2] = [1, 2, -1, 0.1, 0.1, 0.2]
    return model, data


def body_twist(model, data, body):
    """nu (6) of a body frame, body axes."""
    J = np.zeros((6, model.nv))
    mujoco.mj_jac(model, data, J[:3], J[3:], data.xpos[body], body)
    R = data.xmat[body].reshape(3, 3)
    return np.r_[R.T @ J[:3] @ data.qvel, R.T @ J[3:] @ data.qvel]


def momentum_rate(model, data, inertia):
    """d/dt of the rigid body's momentum (6) in body axes: M_RB nu_dot + C_RB(nu) nu."""
    nu = body_twist(model, data, 1)
    return inertia @ body_acceleration(model, data, 1) - kirchhoff(inertia, nu)


def rigid_group():
    """Rigid inertia of the body with the box that is fixed to it."""
    box = rigid_mass(0.7, [0.2, 0.1, 0.0], np.full(3, 0.7 / 3 * (0.05**2 + 0.05**2)))
    return M_RB + box


@pytest.mark.parametrize("integrator", ["implicitfast", "RK4"])
def test_causes_sum_to_the_rate_of_momentum(integrator):
    model, data = everything(integrator)
    worst = 0.0
    for _ in range(40):
        mujoco.mj_forward(model, data)
        causes = marine_mj.wrenches(model, data)["a"]
        assert tuple(causes) == CAUSES
        if _ == 0:
            for name in set(CAUSES) - {"prescribed", "radiation"}:
                assert np.abs(causes[name]).max() > 1e-3, name
            assert data.ncon > 0
        expected = momentum_rate(model, data, rigid_group())
        scale = max(np.abs(w).max() for w in causes.values())
        worst = max(worst, np.abs(sum(causes.values()) - expected).max() / scale)
        mujoco.mj_step(model, data)
    # measured 1.4e-15
    assert worst < 1e-9


@pytest.mark.parametrize("integrator", ["implicitfast", "RK4"])
@pytest.mark.parametrize("motion", ["dynamic", "rao"])
def test_floating_body(motion, integrator):
    numerics = (
        '<numeric name="a.restoring_frd" data="0 0 75414 10745 153703 0"/>'
        '<numeric name="a.wind" data="2 6 5 0.5 0.7 0.9 0.1"/>'
        '<numeric name="a.linear_damping_flu" data="100 200 3000 300 4000 300"/>'
        '<text name="a.wave_database" data="dus_v5750_box.nc"/>'
    )
    xml = one_body(
        added_mass=[300, 800, 8000, 400, 9500, 1500],
        numerics=numerics,
        mass=2306,
        inertia="1040 5412 5237",
        pos="0 0 0",
        integrator=integrator,
    )
    model = marine_mj.load_xml(xml, ENVIRONMENT, {"a": {"motion": motion}})
    data = mujoco.MjData(model)
    data.time, data.ctrl[0] = 5.0, 300.0
    data.qpos[2] = SEA.elevation(0.0, 0.0, 5.0)  # afloat: at z = 0 it would hang over a trough
    mujoco.mj_step(model, data, 20)
    mujoco.mj_forward(model, data)
    causes = marine_mj.wrenches(model, data)["a"]
    own = rigid_mass(2306, [0.02, 0.01, -0.05], [1040, 5412, 5237])
    total = sum(causes.values())
    # measured 2e-11 N of 6 kN (dynamic), 3e-7 N beside the tracking force of an inertia of 1e9 kg
    tolerance = 1e-5 if motion == "rao" else 1e-9
    np.testing.assert_allclose(total, momentum_rate(model, data, own), atol=tolerance)
    assert (np.abs(causes["prescribed"]).max() > 0) == (motion == "rao")
    assert (np.abs(causes["radiation"]).max() > 1) == (motion == "dynamic")


@pytest.mark.parametrize("settings", [{}, {"hydrostatics": "panels"}], ids=["linear", "panels"])
@pytest.mark.parametrize("integrator", ["implicitfast", "RK4"])
def test_usv_through_the_surface(integrator, settings):
    """Dropped into waves and out again: the causes add up with every share of its coefficients."""
    model = marine_mj.load("dus_v5750", ENVIRONMENT, {"hull": settings})
    model.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator.upper()}")
    data = mujoco.MjData(model)
    data.time = 5.0
    data.qpos[2] = SEA.elevation(0.0, 0.0, 5.0) + 1.0
    data.qvel[:] = [1.0, 0.5, -4.0, 0.3, 0.2, 0.1]
    own = rigid_mass(2306, [0, 0, 0], [1040, 5412, 5237])
    entering = 0
    for _ in range(200):
        mujoco.mj_step(model, data)
        mujoco.mj_forward(model, data)
        causes = marine_mj.wrenches(model, data)["hull"]
        expected = momentum_rate(model, data, own)
        # measured 1e-10 N of 280 kN
        np.testing.assert_allclose(
            sum(causes.values()), expected, atol=1e-12 * max(1e5, np.abs(expected).max())
        )
        entering += 0 < np.abs(causes["restoring"][2]) < 0.5 * 2306 * 9.81
    assert entering > 3


def test_each_cause_alone():
    """Causes that have a closed form in a simple state."""
    model = marine_mj.load_xml(
        one_body(
            added_mass=[5, 6, 7, 1, 2, 3],
            numerics='<numeric name="a.linear_damping_flu" data="3 4 5 .3 .4 .5"/>'
            '<numeric name="a.buoyancy" data="120"/>',
            center="0 0 0",
            extra='<site name="a.center_of_buoyancy" pos="0 0 0.1"/>',
        )
    )
    data = mujoco.MjData(model)
    roll = 0.3
    data.qpos[3:7] = np.cos(roll / 2), np.sin(roll / 2), 0, 0
    data.qvel[0] = 2.0
    data.ctrl[0] = 9.0
    mujoco.mj_forward(model, data)
    causes = marine_mj.wrenches(model, data)["a"]
    up = np.array([0, np.sin(roll), np.cos(roll)])
    np.testing.assert_allclose(causes["gravity"], [*(-98.1 * up), 0, 0, 0], atol=1e-12)
    moment = np.cross([0, 0, 0.1], 120 * up)
    np.testing.assert_allclose(causes["restoring"], [*(120 * up), *moment], atol=1e-12)
    np.testing.assert_allclose(causes["damping"], [-6, 0, 0, 0, 0, 0], atol=1e-12)
    np.testing.assert_allclose(causes["propulsion"], [9, 0, 0, 0, 0, 0], atol=1e-12)
    nu_dot = body_acceleration(model, data, 1)
    expected = -np.array([5, 6, 7, 1, 2, 3]) * nu_dot
    np.testing.assert_allclose(causes["added_mass"], expected, atol=1e-12)
    for name in ("waves", "wind", "ballast", "prescribed", "contact", "constraint", "applied"):
        assert (causes[name] == 0).all(), name


TREE = """<mujoco><option timestep="0.002" integrator="implicitfast"/>
<custom>{}</custom>
<worldbody><body name="a" pos="0 0 -1.2"><freejoint/>
  <inertial pos="0.02 0.01 -0.05" mass="10" diaginertia="1 2 3"/>
  <site name="s" pos="0.1 0 0"/><site name="a.center_of_buoyancy" pos="0 0 .02"/>
  <body name="b" pos=".5 0 0"><joint name="flap" type="hinge" axis="0 1 0" damping=".1"/>
    <inertial pos="0.3 0 0" mass="2" diaginertia=".1 .2 .3"/>
    <site name="b.center_of_buoyancy" pos="0.3 0 .02"/>
    <geom type="sphere" size="0.2" pos="0.3 0 0" mass="0"/>
    <body name="c" pos=".5 0 0"><joint type="ball"/>
      <inertial pos="0.3 0.1 0" mass="2" diaginertia=".1 .2 .3"/></body></body></body>
  <geom type="plane" size="5 5 .1" pos="0 0 -1.39"/>
</worldbody>
<actuator><motor name="t" site="s" gear="1 0 0 0 0 0"/><motor name="f" joint="flap"/></actuator>
</mujoco>"""


def tree(added=True):
    """Vehicle with a flap and a towed body, all with added mass, in motion and in contact."""
    text = "".join(
        f'<numeric name="{n}.added_mass_flu" data="{numbers(random_added_mass(i, 0.5))}"/>'
        f'<numeric name="{n}.quadratic_damping_flu" data="5 9 9 1 1 1"/>'
        for i, n in enumerate("abc")
    )
    text += "".join(f'<numeric name="{n}.displaced_volume" data="0.008"/>' for n in "ab")
    model = marine_mj.load_xml(TREE.format(text if added else ""), ENVIRONMENT)
    data = mujoco.MjData(model)
    data.time = 3.3
    data.qvel[:] = np.random.default_rng(1).normal(size=model.nv)
    data.ctrl[:] = 8.0, 0.5
    return model, data


def test_articulated_vehicle():
    """Rigid equations of motion driven by the reported causes, in generalized coordinates.

    `M_rigid qacc + bias = sum J_b^T (causes of b) + actuators + constraints + joint damping`.
    """
    model, data = tree()
    dry, dry_data = tree(added=False)
    touched = []
    for _ in range(30):
        mujoco.mj_step(model, data)
        mujoco.mj_forward(model, data)
        forces = marine_mj.wrenches(model, data)
        push = data.qfrc_actuator + data.qfrc_constraint + data.qfrc_damper
        for name in "abc":
            body = model.body(name).id
            R = data.xmat[body].reshape(3, 3)
            J = np.zeros((6, model.nv))
            mujoco.mj_jac(model, data, J[:3], J[3:], data.xpos[body], body)
            water = sum(
                forces[name][cause] for cause in ("added_mass", "damping", "restoring", "waves")
            )
            push += J[:3].T @ R @ water[:3] + J[3:].T @ R @ water[3:]
            for cause in ("propulsion", "constraint", "applied"):
                assert (forces[name][cause] == 0).all() or name == "a"
        dry_data.qpos[:], dry_data.qvel[:], dry_data.qacc[:] = data.qpos, data.qvel, data.qacc
        mujoco.mj_forward(dry, dry_data)
        needed = np.zeros(model.nv)
        mujoco.mj_mulM(dry, dry_data, needed, data.qacc)
        # measured 1e-12 N
        np.testing.assert_allclose(needed + dry_data.qfrc_bias, push, atol=1e-9)
        touched.append([np.abs(forces[name]["contact"]).max() for name in "abc"])
    # the contact is that of the flap and is reported there only
    contacts = np.max(touched, axis=0)
    assert contacts[1] > 10
    assert contacts[0] == contacts[2] == 0


@pytest.mark.parametrize("body", ["a", "b", "c"])
def test_body_acceleration_is_the_slope_of_the_twist(body):
    model, data = tree()
    mujoco.mj_forward(model, data)
    index = model.body(body).id
    expected = body_acceleration(model, data, index)
    step, twists = 1e-5, []
    probe = mujoco.MjData(model)
    for sign in (1, -1):
        probe.qpos[:] = data.qpos
        # second order in time, as the real path
        mujoco.mj_integratePos(
            model, probe.qpos, data.qvel + 0.5 * sign * step * data.qacc, sign * step
        )
        probe.qvel[:] = data.qvel + sign * step * data.qacc
        mujoco.mj_kinematics(model, probe)
        mujoco.mj_comPos(model, probe)
        twists.append(body_twist(model, probe, index))
    slope = (twists[0] - twists[1]) / (2 * step)
    # measured 5e-7 of 100 (truncation and rounding of the difference)
    np.testing.assert_allclose(expected, slope, atol=1e-8 * max(1, np.abs(slope).max()))


def test_added_mass_of():
    model, _ = tree()
    for i, name in enumerate("abc"):
        np.testing.assert_array_equal(
            added_mass_of(model, model.body(name).id), random_added_mass(i, 0.5)
        )
    np.testing.assert_array_equal(added_mass_of(model, 0), np.zeros((6, 6)))


def test_asking_does_not_disturb():
    """Reports between the steps change no bit of the run."""
    ends = []
    for asking in (False, True):
        model, data = everything()
        for _ in range(50):
            mujoco.mj_step(model, data)
            if asking:
                marine_mj.wrenches(model, data)
        ends.append(np.concatenate([data.qpos, data.qvel, data.act]))
    assert (ends[0] == ends[1]).all()


def test_uniform_current_only():
    """The constructor that others use: a steady profile is a cause through damping alone."""
    current = Current(levels=np.zeros(1), velocity=np.array([[0.5, 0, 0]]))
    model = marine_mj.load_xml(
        one_body(
            added_mass=[5, 5, 5, 1, 1, 1],
            numerics='<numeric name="a.linear_damping_flu" data="3 4 5 .3 .4 .5"/>',
            center="0 0 0",
            gravity=0,
        ),
        Environment(current=current),
    )
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    causes = marine_mj.wrenches(model, data)["a"]
    np.testing.assert_allclose(causes["damping"], [1.5, 0, 0, 0, 0, 0], atol=1e-14)
    np.testing.assert_allclose(causes["added_mass"][0], -5 * 1.5 / 15, atol=1e-14)


def test_inverse_dynamics_gives_back_the_thrust():
    """MuJoCo's mj_inverse works from the mass matrix, added mass included."""
    joint = '<body name="b" pos="1 0 0"><joint name="h" type="hinge" axis="0 1 0"/>'
    joint += '<inertial pos="0.3 0 0" mass="2" diaginertia=".1 .2 .3"/></body>'
    numerics = f'<numeric name="b.added_mass_flu" data="{numbers(random_added_mass(3))}"/>'
    model = marine_mj.load_xml(
        one_body(added_mass=random_added_mass(2), numerics=numerics, extra=joint, gravity=0)
    )
    data = mujoco.MjData(model)
    data.qvel[:] = [0.4, 0.2, -0.3, 0.5, -0.7, 0.9, 1.1]
    data.ctrl[0] = 7
    mujoco.mj_forward(model, data)
    mujoco.mj_inverse(model, data)
    # measured 1e-14
    np.testing.assert_allclose(data.qfrc_inverse, data.qfrc_actuator, atol=1e-10)
