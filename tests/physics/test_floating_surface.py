"""Floating bodies in the air and at the surface: lift, energy, damping of a catamaran."""

import mujoco
import numpy as np
import pytest
from conftest import model_error, numbers, numeric, one_body, rigid_mass
from scipy.integrate import solve_ivp
from surface_cases import (
    BOX,
    BOX_ADDED,
    BOX_INERTIA,
    BOX_MASS,
    RHO,
    STRIPS,
    G,
    bounces,
    share_of,
)

import marine_mj
from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.native import records, table_of

# Floating bodies


def box(numerics="", timestep=0.005, integrator="implicitfast", sea=None, added=None, **settings):
    """The USV's box as a body `a`."""
    xml = one_body(
        added_mass=BOX_ADDED if added is None else added,
        numerics=BOX + numerics,
        mass=BOX_MASS,
        center="0 0 0",
        inertia=numbers(BOX_INERTIA),
        timestep=timestep,
        integrator=integrator,
        pos="0 0 0",
    )
    model = marine_mj.load_xml(xml, sea, {"a": settings})
    return model, mujoco.MjData(model)


def test_lift_of_a_floating_body_is_that_of_a_wall_sided_hull():
    """clip(W - G33 z, 0, G33 D), and nothing else changes as long as it floats."""
    model, data = box()
    for z in np.linspace(-3, 1, 81):
        data.qpos[2] = z
        mujoco.mj_forward(model, data)
        lift = marine_mj.wrenches(model, data)["a"]["restoring"]
        expected = np.clip(BOX_MASS * G - 75414 * z, 0, 75414 * 1.3)
        # measured 4e-11
        np.testing.assert_allclose(lift, [0, 0, expected, 0, 0, 0], atol=1e-8)
        carried = expected / (BOX_MASS * G)
        assert (share_of(model, data) == 1.0) == (carried >= 0.5)
    data.qpos[2] = 0.1
    data.qpos[3:7] = np.r_[1, 0.05, 0.02, 0] / np.linalg.norm([1, 0.05, 0.02])
    mujoco.mj_forward(model, data)
    R = data.xmat[1].reshape(3, 3)
    roll, pitch = np.arctan2(R[2, 1], R[2, 2]), -np.arcsin(R[2, 0])
    expected = [*((BOX_MASS * G - 7541.4) * R[2]), -10745 * roll, -153703 * pitch, 0]
    lift = marine_mj.wrenches(model, data)["a"]["restoring"]
    np.testing.assert_allclose(lift, expected, atol=1e-8)


@pytest.mark.parametrize("integrator", ["implicitfast", "RK4"])
@pytest.mark.parametrize(
    ("axis", "angle"), [*((0, a) for a in (0.0, 0.3, 1.2, np.pi)), (1, 0.3), (1, 1.2)]
)
def test_a_dropped_hull_never_gains_energy(angle, axis, integrator):
    """From 3 m, upright, tilted or capsized, no damping: it bounces, each time lower."""
    for step in (0.002, 0.01):
        model, data = box(timestep=step, integrator=integrator)
        data.qpos[2] = 3.0
        data.qpos[3], data.qpos[4 + axis] = np.cos(angle / 2), np.sin(angle / 2)
        M = rigid_mass(BOX_MASS, [0, 0, 0], BOX_INERTIA)
        energies = bounces(model, data, M, 8.0)
        assert len(energies) > 20
        # measured: falls to 0.28-0.75 of the first, no rise
        assert np.maximum.accumulate(energies).max() <= energies[0] * (1 + 1e-9)
        marine_mj.check_state(model, data)
        assert np.abs(data.qvel).max() < 8.0


def test_potential_of_the_columns():
    """Work of the restoring wrench along a closed way through the surface is zero."""
    G_ = np.diag([0, 0, 75414.0, 10745, 153703, 0])
    G_[2, 4] = G_[4, 2] = 9000.0
    G_[3, 3] = -2000.0
    xml = one_body(
        added_mass=BOX_ADDED,
        numerics=numeric("restoring_flu", numbers(G_)) + numeric("hull_depth", 1.3),
        mass=BOX_MASS,
        center="0.1 0 0.3",
        inertia=numbers(BOX_INERTIA),
        pos="0 0 0",
    )
    model = marine_mj.load_xml(xml)
    data = mujoco.MjData(model)
    for axis in (0, 1):
        t = np.linspace(0, 2 * np.pi, 3001)
        heave, angle = 0.2 + 0.5 * np.cos(t), 0.1 + 0.25 * np.sin(t + 0.7)
        power = []
        for z, turn in zip(heave, angle, strict=True):
            data.qpos[2] = z
            data.qpos[3:7] = 0
            data.qpos[3], data.qpos[4 + axis] = np.cos(turn / 2), np.sin(turn / 2)
            mujoco.mj_forward(model, data)
            wrench = marine_mj.wrenches(model, data)["a"]["restoring"]
            R = data.xmat[1].reshape(3, 3)
            power.append([(R @ wrench[:3])[2], wrench[3 + axis]])
        up, turn = np.array(power).T
        middle = [0.5 * (v[1:] + v[:-1]) for v in (up, turn)]
        work = middle[0] @ np.diff(heave) + middle[1] @ np.diff(angle)
        scale = np.abs(middle[0] * np.diff(heave)).sum()
        # measured 1e-7 and 1e-6 of what is moved to and fro (steps of the sum)
        assert abs(work) < 1e-4 * scale


def test_pushed_deep_it_comes_up_with_its_buoyancy_and_no_more():
    model, data = box()
    data.qpos[2] = -30.0
    mujoco.mj_forward(model, data)
    expected = (75414 * 1.3 - BOX_MASS * G) / (BOX_MASS + 3875)
    assert data.qacc[2] == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    ("numerics", "depth"),
    [
        ("", 3 * 2306 * G / 75414),
        (numeric("hull_depth", 0.9), 0.9),
        (numeric("submergence_height", 0.4), 0.8),
        ('<text name="a.hull_mesh" data="MESH"/>', 0.5 * 5 * 1.5 * RHO * G / 75414),
    ],
    ids=["default", "numeric", "half height", "mesh"],
)
def test_hull_depth(numerics, depth, tmp_path):
    import trimesh

    mesh = tmp_path / "box.obj"
    trimesh.creation.box((5, 1.5, 0.5)).export(mesh)
    xml = one_body(
        added_mass=BOX_ADDED,
        numerics=numeric("restoring_flu", "0 0 75414 10745 153703 0")
        + numerics.replace("MESH", str(mesh)),
        mass=BOX_MASS,
        pos="0 0 0",
    )
    model = marine_mj.load_xml(xml)
    table = table_of(model)
    block = table[int(records(table)[0][t_.B_SURFACE]) :]
    assert block[t_.SF_DEPTH] == pytest.approx(depth, rel=1e-9)


def test_hull_depth_refusals():
    shallow = numeric("restoring_flu", "0 0 75414 10745 153703 0") + numeric("hull_depth", 0.2)
    with model_error("hull_depth of 'a' is 0.2 m", "draught", "0.29"):
        marine_mj.load_xml(one_body(numerics=shallow, mass=BOX_MASS))
    with model_error("hull_depth but no restoring", "submergence_height"):
        marine_mj.load_xml(one_body(numerics=numeric("hull_depth", 1), added_mass=np.ones(6)))


# A catamaran-like body: restoring, strips, linear and quadratic damping

CATAMARAN = {
    "mass": 180.0,
    "inertia": (60.0, 250.0, 290.0),
    "added": np.array([15.0, 120, 200, 20, 120, 110]),
    "linear": np.array([12.0, 30, 300, 60, 300, 40]),
    "quadratic": np.array([14.0, 0, 0, 10, 10, 15]),
    "strips": (16, -1.4, 1.6, 90.0),
}


def catamaran(tilt=0.0):
    """Model and data of it, afloat with a tilt [rad] far below anything visible."""
    c = CATAMARAN
    number, aft, fore, drag = c["strips"]
    xml = one_body(
        added_mass=c["added"],
        numerics=numeric("linear_damping_flu", numbers(c["linear"]))
        + numeric("quadratic_damping_flu", numbers(c["quadratic"]))
        + numeric("restoring_flu", "0 0 12000 4000 9000 0")
        + numeric("strips", f"{number} {aft} {fore}")
        + numeric("strip_drag_flu", f"{drag} {drag}"),
        mass=c["mass"],
        center="0 0 0",
        inertia=numbers(c["inertia"]),
        pos="0 0 0",
        integrator="RK4",
    )
    xml = xml.replace(
        "</actuator>",
        '<motor name="sway" site="s" gear="0 1 0 0 0 0"/>'
        '<motor name="turn" site="s" gear="0 0 0 0 0 1"/></actuator>',
    )
    model = marine_mj.load_xml(xml)
    data = mujoco.MjData(model)
    data.qpos[3:7] = np.cos(tilt / 2), 0, np.sin(tilt / 2), 0
    return model, data


def textbook_catamaran(push, t_end):
    """(u, v, r) at t_end by solve_ivp of the equations in surge, sway and yaw (Fossen 2021)."""
    c = CATAMARAN
    number, aft, fore, drag = c["strips"]
    x = aft + (fore - aft) * (np.arange(number) + 0.5) / number
    dx = (fore - aft) / number
    m, A = c["mass"], c["added"]
    mx, my, inertia = m + A[0], m + A[1], c["inertia"][2] + A[5]

    def rate(t, y):
        u, v, r = y
        local = v + r * x
        cross = drag * dx * np.abs(local) * local
        X = push[0] - c["linear"][0] * u - c["quadratic"][0] * abs(u) * u + my * v * r
        Y = push[1] - c["linear"][1] * v - cross.sum() - mx * u * r
        N = push[2] - c["linear"][5] * r - c["quadratic"][5] * abs(r) * r - (cross * x).sum()
        return [X / mx, Y / my, (N - (A[1] - A[0]) * u * v) / inertia]

    return solve_ivp(rate, (0, t_end), np.zeros(3), rtol=1e-10, atol=1e-12).y[:, -1]


@pytest.mark.parametrize("push", [(120, 0, 0), (0, 150, 0), (0, 0, 60), (120, 0, 25)])
def test_terminal_speeds_and_steady_turn_of_a_catamaran(push):
    """Before: each strip wet or dry by a micron, 0.36 to 0.67 of all damping, flickering."""
    model, data = catamaran(tilt=1e-6)
    data.ctrl[:3] = push
    mujoco.mj_step(model, data, 8000)
    R = data.xmat[1].reshape(3, 3)
    measured = [*(R.T @ data.qvel[:3])[:2], data.qvel[5]]
    # measured 3e-9
    np.testing.assert_allclose(measured, textbook_catamaran(push, 40.0), atol=1e-6, rtol=1e-3)


@pytest.mark.parametrize("height", [-1e-6, 0.0, 1e-6])
def test_all_damping_acts_as_long_as_it_floats(height):
    for tilt in (-1e-7, 0.0, 1e-9, 0.02):
        model, data = catamaran(tilt)
        data.qpos[2] = height
        data.qvel[:] = [0.0, 1.0, 0, 0, 0, 0]
        mujoco.mj_forward(model, data)
        damping = marine_mj.wrenches(model, data)["a"]["damping"]
        assert damping[1] == pytest.approx(-30 - 90 * 3.0, rel=1e-12)


def test_a_lifted_bow_loses_the_drag_of_its_strips_only():
    model, data = catamaran(-0.3)  # bow up: 0.42 m at 1.4 m, of a draught of 0.147 m
    data.qvel[:] = [0.0, 1.0, 0, 0, 0, 0]
    mujoco.mj_forward(model, data)
    damping = marine_mj.wrenches(model, data)["a"]["damping"]
    assert share_of(model, data) == 1.0
    assert -30 - 90 * 2.2 < damping[1] < -30 - 90 * 1.2


def test_strips_without_volume_do_not_flicker():
    """A body with strips that says nothing of its height is wet as a whole."""
    xml = one_body(numerics=STRIPS, gravity=0, timestep=0.001, pos="0 0 0", center="0 0 0")
    model = marine_mj.load_xml(xml)
    data = mujoco.MjData(model)
    for tilt in (-1e-8, 1e-8, 0.0):
        data.qpos[3:7] = np.cos(tilt / 2), 0, np.sin(tilt / 2), 0
        data.qvel[1] = 1.0
        mujoco.mj_forward(model, data)
        damping = marine_mj.wrenches(model, data)["a"]["damping"]
        assert damping[1] == pytest.approx(-200, rel=1e-9)


@pytest.mark.parametrize(
    "settings", [{}, {"hydrostatics": "panels"}, {"radiation": "constant"}], ids=str
)
@pytest.mark.parametrize(("angle", "axis"), [(0.0, 0), (0.4, 0), (0.4, 1), (np.pi, 0)])
def test_dropped_usv_floats_in_the_end(settings, angle, axis):
    """From 3 m, with its radiation memory: no energy is gained, and it comes to rest afloat."""
    model = marine_mj.load("dus_v5750", None, {"hull": settings})
    data = mujoco.MjData(model)
    data.qpos[2] = 3.0
    data.qpos[3], data.qpos[4 + axis] = np.cos(angle / 2), np.sin(angle / 2)
    M = rigid_mass(2306, [0, 0, 0], [1040, 5412, 5237])
    energies = bounces(model, data, M, 10.0)
    assert energies.max() <= energies[0] * (1 + 1e-9)
    # the box of the panels lies upside down in balance: draught 0.3 m from the deck at 1 m
    afloat = 0.7 if angle == np.pi and "hydrostatics" in settings else 0.0
    # measured 4 mm, 10 s after it was dropped
    assert abs(data.qpos[2] - afloat) < 0.02
    assert np.abs(data.qvel[:3]).max() < 0.1
