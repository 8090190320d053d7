"""Contacts and constraints see the added mass."""

import mujoco
import numpy as np
import pytest
from conftest import numbers, one_body, random_added_mass, rigid_mass

import marine_mj
from marine_mj.hydrodynamics.table import CONTACT_SENSOR
from marine_mj.scenario import Scenario
from marine_mj.scene import build_scene, compile_scene

M_RB = rigid_mass(10.0, [0.02, 0.01, -0.05], [1.0, 2.0, 3.0])
BALL = '<geom type="sphere" size="0.3" mass="0" solref="0.02 1" friction="0"/>'
PLANE = '<geom type="plane" size="5 5 .1" pos="0 0 -11" friction="0"/>'


@pytest.mark.parametrize("solver", ["Newton", "CG"])
def test_contact_impulse_is_that_of_the_wet_mass(solver):
    M_A = random_added_mass(3)
    model = marine_mj.load_xml(
        one_body(
            added_mass=M_A,
            extra=BALL,
            world=PLANE,
            gravity=0,
            timestep=0.0005,
            option=f'solver="{solver}" tolerance="1e-14" iterations="300"',
        )
    )
    data = mujoco.MjData(model)
    data.qpos[2] = -10.699  # about to touch
    data.qvel[2] = -0.5
    M = M_RB + M_A
    impulse, worst, touched = np.zeros(6), 0.0, 0
    for _ in range(600):
        before = data.qvel.copy()
        mujoco.mj_step(model, data)
        if data.ncon == 0:
            continue
        touched += 1
        # one step of the discrete equations: M (v+ - v) = h (constraint + velocity products)
        smooth = data.qfrc_passive - data.qfrc_bias
        gain = np.zeros(6)
        mujoco.mj_mulM(model, data, gain, data.qvel - before)
        worst = max(worst, np.abs(gain - 0.0005 * (data.qfrc_constraint + smooth)).max())
        impulse += 0.0005 * data.qfrc_constraint
    assert touched > 20
    # measured 2e-14 (Newton), 1e-10 (CG)
    assert worst < 1e-6
    # all of the added mass is in M: its upper left block in world axes
    dense = np.zeros((6, 6))
    mujoco.mju_sparse2dense(dense, data.M, model.M_rownnz, model.M_rowadr, model.M_colind)
    dense = np.tril(dense) + np.tril(dense, -1).T
    R = data.xmat[1].reshape(3, 3)
    T = np.block([[R.T, np.zeros((3, 3))], [np.zeros((3, 3)), np.eye(3)]])
    np.testing.assert_allclose(dense, T.T @ M @ T, atol=1e-10)


def test_impulse_of_a_central_impact():
    """A sphere that stops on a wall takes (M_RB + M_A) dv, computed without the simulator's M."""
    model = marine_mj.load_xml(
        one_body(
            added_mass=[7, 7, 7, 1, 1, 1],
            center="0 0 0",
            extra=BALL,
            world=PLANE,
            gravity=0,
            timestep=0.001,
        )
    )
    data = mujoco.MjData(model)
    data.qpos[2], data.qvel[2] = -10.69, -0.5
    impulse = 0.0
    for _ in range(1000):
        mujoco.mj_step(model, data)
        impulse += 0.001 * data.qfrc_constraint[2]
    # measured 3e-15 relative
    assert impulse == pytest.approx(17.0 * (data.qvel[2] + 0.5), rel=1e-6)
    assert data.qvel[2] > -1e-6


def bounce(xml):
    """(exit speed, deepest penetration) of a body that falls on the plane."""
    model = marine_mj.load_xml(xml)
    data = mujoco.MjData(model)
    data.qpos[2], data.qvel[2] = -10.6, -1.0
    deepest = 0.0
    for _ in range(2000):
        mujoco.mj_step(model, data)
        if data.ncon:
            deepest = min(deepest, data.contact[0].dist)
    return data.qvel[2], deepest


def test_bounce_equals_that_of_a_natively_heavier_body():
    ball = BALL.replace("0.02 1", "0.02 0.3")
    common = {"center": "0 0 0", "extra": ball, "world": PLANE, "gravity": 0, "timestep": 0.001}
    wet = bounce(one_body(added_mass=[15, 15, 15, 3, 3, 3], mass=5, **common))
    heavy = bounce(one_body(added_mass=np.zeros(6), mass=20, inertia="4 5 6", **common))
    # measured equal to 1e-13; exit speed 0.28 m/s: a real bounce
    assert wet[0] > 0.1
    np.testing.assert_allclose(wet, heavy, rtol=1e-9)


def test_several_islands_keep_the_equations_of_motion():
    """Two wet bodies in separate contacts: M qacc = smooth + constraint for both."""
    bodies = "".join(
        f"""<body name="{n}" pos="{x} 0 -10.69"><freejoint/>
        <inertial pos="0.02 0.01 -0.05" mass="10" diaginertia="1 2 3"/>
        <geom type="sphere" size="0.3" mass="0"/></body>"""
        for n, x in (("b", 3), ("c", 6))
    )
    numerics = "".join(
        f'<numeric name="{n}.added_mass_flu" data="{numbers(random_added_mass(i))}"/>'
        for i, n in enumerate("bc")
    )
    model = marine_mj.load_xml(
        one_body(
            added_mass=random_added_mass(5),
            numerics=numerics,
            extra=BALL,
            world=PLANE + bodies,
            pos="0 0 -10.69",
            timestep=0.001,
            option='tolerance="1e-14" iterations="200"',
        )
    )
    data = mujoco.MjData(model)
    data.qvel[2] = data.qvel[8] = data.qvel[14] = -0.2
    worst = 0.0
    for _ in range(200):
        mujoco.mj_step(model, data)
        mujoco.mj_forward(model, data)
        force = np.zeros(model.nv)
        mujoco.mj_mulM(model, data, force, data.qacc)
        worst = max(worst, np.abs(force - data.qfrc_smooth - data.qfrc_constraint).max())
    assert data.ncon == 3
    # measured 2e-7 N of some 1000 N: what the solver's convergence leaves
    assert worst < 1e-5


def test_weld_gives_way_like_that_of_a_natively_heavier_body():
    tail = '<equality><weld name="w" body1="a"/></equality>'
    poses = []
    for xml in (
        one_body(added_mass=[70, 70, 70, 7, 14, 21], center="0 0 0", tail=tail, gravity=0),
        one_body(mass=80, inertia="8 16 24", center="0 0 0", tail=tail, gravity=0),
    ):
        model = marine_mj.load_xml(xml)
        data = mujoco.MjData(model)
        data.ctrl[0] = 100
        mujoco.mj_step(model, data, 1000)
        poses.append(data.qpos.copy())
        np.testing.assert_allclose(model.dof_invweight0, [1 / 80] * 3 + [0.0763888889] * 3)
    # measured equal to 1e-14; 100 N pull the weld open by 69 mm
    assert poses[0][0] > 0.01
    np.testing.assert_allclose(poses[0], poses[1], atol=1e-10)


def test_contact_sensor_sums_what_mujoco_reports():
    """Native force, forbidden contacts, power and overlap against mj_contactForce and mj_jac."""
    calm = {"sea.spectrum": "none", "sea.sea_state": None, "sea.spreading": None}
    # the vehicle sits in the hull of the carrier: pads, forks and the forbidden bottom are touched
    calm["vehicles.auv.position_ned"] = [10.0, 0.3, 0.2]
    model = compile_scene(Scenario.load("docking_demo").with_values(calm)).model
    data = mujoco.MjData(model)
    address = int(model.sensor(CONTACT_SENSOR).adr[0])
    most = 0
    for _ in range(20):
        before = data.qvel.copy()
        mujoco.mj_step(model, data)
        total, forbidden, power, overlap, wrench = 0.0, 0, 0.0, 0.0, np.zeros(6)
        middle = before + 0.5 * model.opt.timestep * data.qacc
        for number in range(data.ncon):
            first, second = data.contact[number].geom
            roots = model.body_rootid[model.geom_bodyid[[first, second]]]
            mujoco.mj_contactForce(model, data, number, wrench)
            if roots[0] != roots[1]:
                total += abs(wrench[0])
                overlap = max(overlap, -data.contact[number].dist)
                contact, slip = data.contact[number], np.zeros(3)
                for geom, sign in ((first, -1.0), (second, 1.0)):
                    J = np.zeros((3, model.nv))
                    mujoco.mj_jac(model, data, J, None, contact.pos, model.geom_bodyid[geom])
                    slip += sign * J @ middle
                power -= wrench[:3] @ contact.frame.reshape(3, 3) @ slip
            names = (model.geom(int(g)).name.split("/")[-1] for g in (first, second))
            forbidden += any(name.startswith("forbidden_") for name in names)
        assert data.sensordata[address] == pytest.approx(total, rel=1e-12)
        assert data.sensordata[address + 1] == forbidden
        assert data.sensordata[address + 2] == pytest.approx(power, rel=1e-9, abs=1e-9)
        assert data.sensordata[address + 3] == overlap
        most = max(most, forbidden)
    assert most > 0


@pytest.mark.parametrize("cone", ["pyramidal", "elliptic"])
@pytest.mark.parametrize("friction", [0.1, 0.25])
def test_force_on_a_squeezed_body_is_that_of_the_documented_stiffness(cone, friction):
    """A body 3 mm too thick between two bars cannot give way: force = overlap times stiffness.

    MuJoCo's (computation chapter, constraint parameters): d k m d / (1 - d), with k from solref and
    d from solimp; the pyramid has four edges of regularisation 2 mu2 (1 + mu2) each.
    """
    mass, overlap, constant, impedance = 126.6, 0.003, 0.035, 0.95
    bars = "".join(
        f'<geom type="capsule" size="0.02" fromto="0 -.3 {z} 0 .3 {z}" priority="1" '
        f'solref="{constant} 1" solimp="0.9 {impedance} 0.002 0.5 2" friction="{friction}"/>'
        for z in (0.12 - overlap, overlap - 0.12)
    )
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option gravity="0 0 0" cone="{cone}"/><worldbody><body><freejoint/>'
        f'<inertial pos="0 0 0" mass="{mass}" diaginertia="26 26 26"/>'
        f'<geom type="capsule" fromto="-.9 0 0 .9 0 0" size="0.1"/></body>{bars}'
        "</worldbody></mujoco>"
    )
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    wrench = np.zeros(6)
    mujoco.mj_contactForce(model, data, 0, wrench)
    stiffness = mass * impedance / (1 - impedance) * impedance / (impedance * constant) ** 2
    if cone == "pyramidal":
        stiffness *= 4 / (2 * friction**2 * (1 + friction**2))
    # 2.07 MN/m; by pyramids 409 MN/m at 0.1 and 62 MN/m at 0.25
    assert wrench[0] == pytest.approx(stiffness * overlap, rel=1e-3)


def test_friction_cone_of_a_scenario():
    for cone, number in (("pyramidal", 0), ("elliptic", 1)):
        changes = {"friction_cone": cone, "vehicles.usv.dock": None}
        scenario = Scenario.load("docking_demo").with_values(changes)
        assert build_scene(scenario).option.cone == number
