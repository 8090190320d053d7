"""Bodies in the air, at the surface and through it: closed forms, momentum, energy."""

import mujoco
import numpy as np
import pytest
from conftest import model_error, numbers, numeric, one_body, random_added_mass, rigid_mass
from scipy.integrate import solve_ivp

import marine_mj
from marine_mj.environment import Environment, irregular_sea
from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.native import records, report, table_of
from marine_mj.hydrodynamics.wrenches import added_mass_of

RHO, G = 1025.0, 9.81
SEMI_IMPLICIT = ("Euler", "implicit", "implicitfast")


def share_of(model, data):
    """Wet share of the first body, by the added mass that acts on it."""
    acting = report(model, data)[0][6 * len(t_.CAUSES) :][:36].reshape(6, 6)
    whole = added_mass_of(model, 1)
    i, j = np.unravel_index(np.abs(whole).argmax(), whole.shape)
    np.testing.assert_allclose(acting, acting[i, j] / whole[i, j] * whole, atol=1e-12)
    return acting[i, j] / whole[i, j]


# In air

RADIUS, VOLUME = 0.3, 4 / 3 * np.pi * 0.3**3
SPHERE = numeric("displaced_volume", repr(VOLUME))
CENTER = '<site name="a.center_of_buoyancy"/>'
COEFFICIENTS = (
    numeric("linear_damping_flu", "20 30 40 5 6 7")
    + numeric("quadratic_damping_flu", "9 9 9 1 1 1"),
    numeric("submergence_height", RADIUS),
)
#: The USV's box afloat, and 1.3 m deep in all.
BOX = numeric("restoring_flu", "0 0 75414 10745 153703 0") + numeric("hull_depth", 1.3)
BOX_MASS, BOX_INERTIA = 2306.0, (1040.0, 5412.0, 5237.0)
BOX_ADDED = np.diag([327.0, 1293, 3875, 391, 7305, 2020])
STRIPS = numeric("strips", "8 -2 2") + numeric("strip_drag_flu", "50 80")
BODIES = {
    "sphere": SPHERE + COEFFICIENTS[0] + COEFFICIENTS[1],
    "volume alone": SPHERE + COEFFICIENTS[0],
    "strips": numeric("displaced_volume", 0.11) + STRIPS + COEFFICIENTS[0],
    "floating": BOX + COEFFICIENTS[0],
    "floating, strips": BOX + STRIPS + COEFFICIENTS[0],
}


@pytest.mark.parametrize("integrator", [*SEMI_IMPLICIT, "RK4"])
@pytest.mark.parametrize("body", BODIES)
def test_in_air_a_body_is_a_rigid_one(body, integrator):
    """It falls and tumbles as without any water: no added mass, no Munk moment, no restoring."""
    runs = []
    for numerics, added in ((BODIES[body], random_added_mass(2, 30.0)), ("", None)):
        xml = one_body(
            numerics=numerics,
            added_mass=added,
            mass=110,
            extra=CENTER,
            integrator=integrator,
            pos="0 0 40",
        )
        model = marine_mj.load_xml(xml)
        data = mujoco.MjData(model)
        data.qvel[:] = [1.0, -2.0, 3.0, 1.5, -1.0, 0.7]
        mujoco.mj_forward(model, data)
        centre = np.zeros(3)
        J = np.zeros((3, 6))
        mujoco.mj_jacBodyCom(model, data, J, None, 1)
        mujoco.mj_step(model, data, 200)
        centre = data.xipos[1] - model.body_ipos[1]
        runs.append(np.concatenate([data.qpos, data.qvel, centre]))
    # measured 0: before, added mass and Munk moment left it at 4.3 m/s2
    np.testing.assert_allclose(runs[0], runs[1], atol=1e-10)


@pytest.mark.parametrize("settings", [{}, {"hydrostatics": "panels"}], ids=["linear", "panels"])
def test_usv_in_the_air_falls(settings):
    """Dynamic, with radiation memory, in waves: nothing but its weight acts on it."""
    sea = Environment(waves=irregular_sea(1.1, 5.5, components=40, seed=3))
    model = marine_mj.load("dus_v5750", sea, {"hull": settings})
    data = mujoco.MjData(model)
    data.qpos[2] = 6.0
    data.qvel[:] = [1.0, 0.5, 0.2, 0, 0, 0.3]
    data.act[:] = 0.1
    for _ in range(20):
        mujoco.mj_step(model, data)
    mujoco.mj_forward(model, data)
    # measured 0; before: the memory, the waves and 4 g by the restoring matrix
    assert data.qacc[2] == pytest.approx(-G, abs=1e-9)
    causes = marine_mj.wrenches(model, data)["hull"]
    braking = causes["wind"] / [*np.full(3, 2306), 1040, 5412, 5237]
    np.testing.assert_allclose(
        np.abs(data.qacc[[0, 1, 3, 4, 5]]).max(), np.abs(braking).max(), rtol=0.1
    )
    for cause in ("radiation", "waves", "restoring", "added_mass", "damping"):
        assert np.abs(causes[cause]).max() < 1e-9, cause


def test_constant_buoyancy_changes_nothing_at_the_surface():
    xml = one_body(
        added_mass=[30, 40, 50, 1, 1, 1],
        numerics=SPHERE,
        extra=CENTER,
        mass=100,
        center="0 0 0",
        pos="0 0 5",
    )
    model = marine_mj.load_xml(xml, settings={"a": {"constant_buoyancy": True}})
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert data.qacc[2] == pytest.approx((RHO * VOLUME - 100) * G / 150, rel=1e-12)


# Through the surface

ADDED = 0.5 * RHO * VOLUME


def through(speed, mass, integrator="implicitfast", timestep=0.005, numerics="", gravity=0):
    """Model and data of a sphere 0.4 m above the water (below it for speed > 0), moving."""
    model = marine_mj.load_xml(
        one_body(
            added_mass=np.r_[np.full(3, ADDED), 0, 0, 0],
            numerics=numerics + COEFFICIENTS[1],
            extra=CENTER,
            mass=mass,
            center="0 0 0",
            gravity=gravity,
            integrator=integrator,
            timestep=timestep,
            pos="0 0 0",
        )
    )
    data = mujoco.MjData(model)
    data.qpos[2] = 0.4 * np.sign(-speed)
    data.qvel[2] = speed
    return model, data


@pytest.mark.parametrize("integrator", SEMI_IMPLICIT)
@pytest.mark.parametrize("mass", [3.0, 300.0])
@pytest.mark.parametrize("speed", [0.05, 1.0, 20.0])
def test_momentum_through_the_entry(speed, mass, integrator):
    """von Karman: (M + A) v stays what M v was, at any speed, step and ratio of masses."""
    model, data = through(-speed, mass, integrator, 0.005)
    while data.qpos[2] > -0.5:
        mujoco.mj_step(model, data)
    assert share_of(model, data) == 1.0
    mujoco.mj_step(model, data)
    # measured 3e-15 (up to 19 times the dry mass added, 10 cm a step)
    assert data.qvel[2] == pytest.approx(-speed * mass / (mass + ADDED), rel=1e-12)


@pytest.mark.parametrize("integrator", [*SEMI_IMPLICIT, "RK4"])
@pytest.mark.parametrize("speed", [0.1, 3.0])
def test_exit_keeps_the_speed(speed, integrator):
    """Nothing pushes the body while it leaves its added mass behind in the water."""
    model, data = through(speed, 30.0, integrator)
    mujoco.mj_step(model, data, round(0.8 / speed / 0.005))
    assert share_of(model, data) == 0.0
    assert data.qvel[2] == pytest.approx(speed, rel=1e-12)


def sphere_share(z):
    """Wet share of the sphere with its centre at height z, and its slope."""
    s = np.clip(-z / RADIUS, -1, 1)
    return 0.25 * (2 + 3 * s - s**3), -0.75 * (1 - s**2) / RADIUS


def textbook_drop(speed, mass, t_end):
    """Height and speed at t_end by solve_ivp of `(M + A s) v' = F - max(s', 0) A v`."""

    def rate(t, y):
        share, slope = sphere_share(y[0])
        push = share * RHO * VOLUME * G - mass * G - max(slope * y[1], 0.0) * ADDED * y[1]
        return [y[1], push / (mass + share * ADDED)]

    start = [0.4, -speed]
    return solve_ivp(rate, (0, t_end), start, rtol=1e-10, atol=1e-12, max_step=0.002).y[:, -1]


@pytest.mark.parametrize("speed", [0.2, 4.0])
@pytest.mark.parametrize("integrator", ["implicitfast", "RK4"])
def test_drop_and_bounce_converge_to_the_textbook(integrator, speed):
    """A light sphere drops in and jumps out again."""
    t_end = 1.0
    expected = textbook_drop(speed, 30.0, t_end)
    errors = []
    for step in (0.004, 0.002, 0.001):
        model, data = through(-speed, 30.0, integrator, step, SPHERE, gravity=G)
        mujoco.mj_step(model, data, round(t_end / step))
        errors.append(np.abs([data.qpos[2], data.qvel[2]] - expected).max())
    # measured 8.7e-3, 4.3e-3, 2.1e-3 (implicitfast, 0.2 m/s); 7e-4, 2e-4, 5e-5 (RK4, 4 m/s)
    assert errors[2] < (0.005 if integrator == "implicitfast" else 1e-3)
    assert errors[2] < 0.3 * errors[0]


def test_entry_force_in_waves():
    """-(s_n - s_(n-1)) / h M_A (v - v_w) beside s M_A Dv_w/Dt, all from the wave field itself."""
    sea = irregular_sea(0.5, 3.0, components=30, seed=2)
    model = marine_mj.load_xml(
        one_body(
            added_mass=np.r_[np.full(3, ADDED), 0, 0, 0],
            numerics=COEFFICIENTS[1],
            mass=40,
            center="0 0 0",
            gravity=0,
            pos="0 0 0.1",
        ),
        Environment(waves=sea),
        {"a": {"convective": False}},
    )
    data = mujoco.MjData(model)
    data.qvel[:3] = [0.3, 0.1, -0.05]
    entering, before, worst = 0, None, 0.0
    for _ in range(800):
        mujoco.mj_step1(model, data)
        x, time = data.qpos[:3], data.time
        share = sphere_share(x[2] - sea.elevation(x[0], x[1], time))[0]
        assert share_of(model, data) == pytest.approx(share, abs=1e-12)
        if before is not None:
            rate = max(share - before, 0.0) / 0.005
            water = sea.velocity(*x, time), sea.acceleration(*x, time)
            expected = ADDED * (share * water[1] - rate * (data.qvel[:3] - water[0]))
            worst = max(worst, np.abs(report(model, data)[0][:3] - expected).max())
            entering += rate > 0
        before = share
        mujoco.mj_step2(model, data)
    assert 100 < entering < 700
    # measured 2e-12 N of 30 N
    assert worst < 1e-9


def test_crane_lift():
    """Weight on the wire of a submerged body hauled out and lowered slowly: W - rho g V s(z)."""
    speed, step, mass = 0.02, 0.002, 300.0
    xml = one_body(
        added_mass=np.r_[np.full(3, ADDED), 0, 0, 0],
        numerics=SPHERE + COEFFICIENTS[1],
        extra=CENTER,
        mass=mass,
        center="0 0 0",
        timestep=step,
        pos="0 0 0",
    )
    xml = xml.replace('<freejoint name="a"/>', '<joint name="a" type="slide" axis="0 0 1"/>')
    xml = xml.replace(
        "</actuator>", '<position name="wire" joint="a" kp="3e6" kv="4e4"/></actuator>'
    )
    model = marine_mj.load_xml(xml)
    data = mujoco.MjData(model)
    for start, sign in ((-0.5, 1.0), (0.5, -1.0)):
        data.qpos[0], data.qvel[0] = start, sign * speed
        heights, wire = [], []
        for i in range(round(1.0 / speed / step)):
            data.ctrl[1] = start + sign * speed * step * (i + 1)
            mujoco.mj_step(model, data)
            heights.append(data.qpos[0])
            wire.append(data.actuator_force[1])
        heights, wire = np.array(heights[500:]), np.array(wire[500:])
        share = sphere_share(heights)[0]
        # measured 4e-5 of the weight (lag of the wire's spring)
        np.testing.assert_allclose(wire, mass * G - RHO * VOLUME * G * share, atol=2e-4 * mass * G)
        assert np.abs(np.diff(wire)).max() < 2e-4 * mass * G  # no jump; measured 4e-5


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
@pytest.mark.parametrize("axis", [0, 1], ids=["roll", "pitch"])
@pytest.mark.parametrize("angle", [0.0, 0.3, 1.2, np.pi])
def test_a_dropped_hull_never_gains_energy(angle, axis, integrator):
    """From 3 m, upright, tilted or capsized, no damping: it bounces, each time lower."""
    if axis == 1 and angle > 1.5:
        pytest.skip("pitch ends at 90 degrees")
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
    data.ctrl[:] = push
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


# Energy


def bounces(model, data, M, duration):
    """Mechanical energy (n,) [J] at every step at which the first body is in the air."""
    energies = []
    for _ in range(round(duration / model.opt.timestep)):
        mujoco.mj_step1(model, data)
        if share_of(model, data) == 0.0:
            R = data.xmat[1].reshape(3, 3)
            nu = np.r_[R.T @ data.qvel[:3], data.qvel[3:]]
            energies.append(0.5 * nu @ M @ nu + M[0, 0] * G * data.qpos[2])
        mujoco.mj_step2(model, data)
    return np.array(energies)


@pytest.mark.parametrize("timestep", [0.002, 0.01, 0.02])
@pytest.mark.parametrize("integrator", ["implicitfast", "RK4"])
@pytest.mark.parametrize("speed", [0.5, 3.0, 10.0])
def test_a_bouncing_sphere_never_gains_energy(speed, integrator, timestep):
    for mass in (2.0, 30.0, 100.0):
        model, data = through(-speed, mass, integrator, timestep, SPHERE, gravity=G)
        energies = bounces(model, data, rigid_mass(mass, [0, 0, 0], [1, 2, 3]), 3.0)
        # measured: the first is the highest (up to 29 times the dry mass added, 20 cm a step)
        assert energies.max() <= energies[0] * (1 + 1e-9)


@pytest.mark.parametrize("tilt", [0.2, 1.4])
@pytest.mark.parametrize("integrator", ["implicitfast", "RK4"])
def test_a_leaping_slender_body_never_gains_energy(integrator, tilt):
    mass = 0.055 * RHO * 0.6
    inertia = mass * np.array([0.01, 0.3, 0.3])
    xml = one_body(
        added_mass=mass * np.array([0.1, 1, 1, 0, 0.3, 0.3]),
        numerics=numeric("displaced_volume", 0.055) + numeric("strips", "8 -0.95 0.95"),
        extra=CENTER,
        mass=mass,
        center="0 0 0",
        inertia=numbers(inertia),
        integrator=integrator,
        timestep=0.01,
        pos="0 0 0",
    )
    model = marine_mj.load_xml(xml)
    data = mujoco.MjData(model)
    data.qpos[2:6] = 1.5, np.cos(tilt / 2), 0, np.sin(tilt / 2)
    data.qvel[2] = -3.0
    energies = bounces(model, data, rigid_mass(mass, [0, 0, 0], inertia), 8.0)
    # measured: the first is the highest
    assert energies.max() <= energies[0] * (1 + 1e-9)


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


# What is left of it elsewhere


@pytest.mark.parametrize("height", [-10.0, 0.0, 10.0])
@pytest.mark.parametrize("body", ["sphere", "floating"])
def test_softness_of_contacts_does_not_depend_on_the_place_at_the_start(body, height):
    """Inverse weights with the whole added mass, wherever the body lies at qpos0."""
    xml = one_body(
        numerics=BODIES[body],
        added_mass=[30, 40, 50, 6, 7, 8],
        mass=110,
        center="0 0 0",
        extra=CENTER,
        pos=f"0 0 {height}",
    )
    sea = Environment(waves=irregular_sea(0.5, 3.0, components=5, seed=2))
    model = marine_mj.load_xml(xml, sea)
    expected = np.mean(1 / (110 + np.array([30.0, 40, 50])))
    assert model.body_invweight0[1, 0] == pytest.approx(expected, rel=1e-12)
    assert model.dof_invweight0[0] == pytest.approx(expected, rel=1e-12)
