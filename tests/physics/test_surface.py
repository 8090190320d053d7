"""Submerged bodies in the air and through the surface: closed forms, momentum, energy."""

import mujoco
import numpy as np
import pytest
from conftest import numbers, numeric, one_body, random_added_mass, rigid_mass
from scipy.integrate import solve_ivp
from surface_cases import (
    BODIES,
    CENTER,
    COEFFICIENTS,
    RADIUS,
    RHO,
    SEMI_IMPLICIT,
    SPHERE,
    VOLUME,
    G,
    bounces,
    share_of,
)

import marine_mj
from marine_mj.environment import Environment, irregular_sea
from marine_mj.hydrodynamics.native import report

# In air


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


# Energy


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
