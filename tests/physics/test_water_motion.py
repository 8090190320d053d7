"""What a body feels in moving water: current, waves, strips."""

import mujoco
import numpy as np
import pytest
from conftest import numbers, one_body, random_added_mass

import marine_mj
from marine_mj.environment import (
    Current,
    Environment,
    WaveField,
    fluctuating_current,
    irregular_sea,
    regular_wave,
    uniform_current,
)

CB = '<site name="a.center_of_buoyancy"/>'


def buoyant(volume, drag="0 0 0 0 0 0", extra=""):
    """Numerics of a body of the given volume with quadratic drag."""
    return (
        f'<numeric name="a.displaced_volume" data="{volume!r}"/>'
        f'<numeric name="a.quadratic_damping_flu" data="{drag}"/>{extra}'
    )


def neutral(integrator="implicitfast"):
    """A body that floats in equilibrium at any depth, with drag."""
    return one_body(
        added_mass=random_added_mass(),
        numerics=buoyant(10 / 1025, "30 60 60 5 5 5"),
        center="0 0 0",
        extra=CB,
        integrator=integrator,
    )


@pytest.mark.parametrize("integrator", ["implicitfast", "RK4"])
def test_drifting_with_a_uniform_current_feels_nothing(integrator):
    velocity = np.array([0.7, -0.4, 0.0])
    current = Current(levels=np.array([0.0]), velocity=velocity[None])
    model = marine_mj.load_xml(neutral(integrator), Environment(current=current))
    data = mujoco.MjData(model)
    data.qpos[3:7] = [0.8, 0.3, -0.4, np.sqrt(1 - 0.64 - 0.09 - 0.16)]
    data.qvel[:3] = velocity
    mujoco.mj_step(model, data, 2000)
    np.testing.assert_allclose(data.qvel, [*velocity, 0, 0, 0], atol=1e-12)  # measured 3e-16


def test_current_shifts_the_frame():
    """Motion in a current = motion in still water seen from a moving frame (Galilei)."""
    velocity = np.array([0.7, -0.4, 0.0])
    xml = one_body(
        added_mass=random_added_mass(2),
        numerics=buoyant(10 / 1025, "30 60 60 5 5 5"),
        extra=CB,
        integrator="RK4",
        timestep=0.002,
    )
    ends = []
    for drift in (np.zeros(3), velocity):
        current = Current(levels=np.array([0.0]), velocity=drift[None])
        model = marine_mj.load_xml(xml, Environment(current=current))
        data = mujoco.MjData(model)
        data.qvel[:] = [0.3, 0.1, -0.2, 0.4, 0.5, -0.3]
        data.qvel[:3] += drift
        data.ctrl[0] = 5
        mujoco.mj_step(model, data, 2000)
        data.qpos[:3] -= drift * data.time
        data.qvel[:3] -= drift
        ends.append(np.concatenate([data.qpos, data.qvel]))
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-10)  # measured 2e-14


def test_calm_water_stays_calm():
    model = marine_mj.load_xml(neutral())
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 20000)
    assert np.abs(data.qvel).max() < 1e-9  # measured 2e-16


SEAS = {
    "deep": irregular_sea(1.1, 5.5, components=100, seed=3),
    "finite": irregular_sea(1.1, 7.0, components=60, depth=12.0, seed=4),
    "wheeler": irregular_sea(1.1, 5.5, components=40, seed=5, stretching="wheeler"),
    "none": irregular_sea(0.5, 5.5, components=40, seed=5, stretching="none"),
}


def probe(environment, position, time, convective=True, strips=""):
    """(velocity, acceleration) of the water as the kernel sees it, through two plain forces."""
    model = marine_mj.load_xml(
        one_body(
            numerics='<numeric name="a.linear_damping_flu" data="1 1 1 1 1 1"/>'
            f'<numeric name="a.displaced_volume" data="{1 / 1025!r}"/>{strips}',
            extra=CB,
            gravity=0,
        ),
        environment,
        {"a": {"convective": convective, "constant_buoyancy": True}},
    )
    data = mujoco.MjData(model)
    data.qpos[:3] = position
    data.time = time
    mujoco.mj_forward(model, data)
    forces = marine_mj.wrenches(model, data)["a"]
    return forces["damping"], forces["waves"]


@pytest.mark.parametrize("name", SEAS)
@pytest.mark.parametrize("time", [0.0, 37.3, 4000.0])
def test_kernel_sees_the_wave_field(name, time):
    sea = SEAS[name]
    current = Current(
        levels=np.array([-10.0, -4.0, 0.0]),
        velocity=np.array([[0.1, 0, 0], [0.3, 0.2, 0], [0.8, -0.1, 0]]),
    )
    for point in ([3.0, -2.0, -2.5], [100.0, 50.0, -0.1], [-7.0, 1.0, 0.3]):
        velocity, acceleration = probe(
            Environment(waves=sea, current=current), point, time, convective=False
        )
        expected = sea.velocity(*point, time) + current.velocity_at(point[2], time)
        np.testing.assert_allclose(velocity[:3], expected, atol=1e-11)  # measured 3e-13
        np.testing.assert_allclose(acceleration[:3], sea.acceleration(*point, time), atol=1e-11)
        velocity, material = probe(Environment(waves=sea, current=current), point, time)
        gradient = sea.gradient(*point, time)
        step = 1e-6
        shear = current.velocity_at(point[2] + step, time) - current.velocity_at(
            point[2] - step, time
        )
        gradient[:, 2] += shear / (2 * step)
        np.testing.assert_allclose(
            material[:3], sea.acceleration(*point, time) + gradient @ velocity[:3], atol=1e-8
        )


def test_fluctuating_current():
    current = fluctuating_current([0.5, 0.1, 0], 0.2, 30.0, 100.0, seed=3)
    velocity, acceleration = probe(Environment(current=current), [0, 0, -3.0], 41.37)
    np.testing.assert_allclose(velocity[:3], current.velocity_at(-3.0, 41.37), atol=1e-13)
    np.testing.assert_allclose(acceleration[:3], current.acceleration_at(-3.0, 41.37), atol=1e-13)


def test_strips_sum_the_water_along_the_hull():
    """Wave force and moment of a strip body against a direct sum over the wave field."""
    sea = SEAS["deep"]
    strips = '<numeric name="a.strips" data="10 -1.5 1.0"/>'
    point, time = np.array([3.0, -2.0, -2.0]), 12.3
    _, waves = probe(Environment(waves=sea), point, time, convective=False, strips=strips)
    x = np.linspace(-1.5, 1.0, 21)[1::2]
    acceleration = sea.acceleration(point[0] + x, point[1], point[2], time)
    arm = x - x.mean()  # the centre of buoyancy is at the body origin
    force = acceleration.mean(axis=0)
    moment = np.mean(
        [np.cross([a, 0, 0], f) for a, f in zip(arm, acceleration, strict=True)], axis=0
    )
    np.testing.assert_allclose(waves, np.r_[force, moment], atol=1e-11)  # measured 1e-14


def test_cross_flow_drag_of_strips_in_pure_pitch():
    """Integral of D |q x| q x x over the length, and its convergence to D q|q| L^4 / 32."""
    q, drag, length = 0.4, 264.0, 1.9
    model = marine_mj.load_xml(
        one_body(
            numerics=f'<numeric name="a.strips" data="40 {-length / 2} {length / 2}"/>'
            f'<numeric name="a.strip_drag_frd" data="{drag} {drag}"/>',
            gravity=0,
        )
    )
    data = mujoco.MjData(model)
    data.qvel[4] = q
    mujoco.mj_forward(model, data)
    moment = marine_mj.wrenches(model, data)["a"]["damping"][4]
    # measured 0.13 % with 40 strips
    assert moment == pytest.approx(-drag * q * abs(q) * length**4 / 32, rel=2e-3)


def test_neutrally_buoyant_body_follows_the_orbit():
    """A small sphere at 3 m depth in deep regular waves against solve_ivp of a water particle."""
    from scipy.integrate import solve_ivp

    sea = regular_wave(1.0, 5.0)
    radius = 0.05
    volume = 4 / 3 * np.pi * radius**3
    mass = 1025 * volume
    model = marine_mj.load_xml(
        one_body(
            added_mass=np.array([0.5 * mass] * 3 + [0, 0, 0]),
            numerics=buoyant(volume),
            mass=mass,
            center="0 0 0",
            inertia=numbers(np.full(3, 0.4 * mass * radius**2)),
            extra=CB,
            integrator="RK4",
            pos="0 0 -3",
        ),
        Environment(waves=sea),
    )
    data = mujoco.MjData(model)
    data.qvel[:3] = sea.velocity(0, 0, -3, 0)
    mujoco.mj_step(model, data, 4000)
    path = solve_ivp(
        lambda t, x: sea.velocity(*x, t), (0, data.time), [0, 0, -3], rtol=1e-10, atol=1e-12
    )
    # measured 3e-6 m after four periods
    assert np.linalg.norm(data.qpos[:3] - path.y[:, -1]) < 1e-3


def test_still_body_in_waves_has_the_orbital_amplitude():
    """Free neutrally buoyant slender body in long waves moves like the water (digest V36)."""
    sea = regular_wave(1.1, 4.6)
    amplitude = 0.55 * np.exp(-sea.wavenumber[0] * 8)
    model = marine_mj.load("scout", Environment(waves=sea))
    data = mujoco.MjData(model)
    data.qpos[2] = -8
    lift = -(0.061 * 1025 - 61.5) * 9.81
    times, places = [], []
    for step in range(12000):
        data.qfrc_applied[2] = lift  # neutral
        mujoco.mj_step(model, data)
        if step >= 12000 - 1840:
            times.append(data.time)
            places.append(data.qpos[:3].copy())
    # it started at rest in moving water: fit the oscillation beside a slowing drift
    t, w = np.array(times), sea.omega[0]
    basis = np.stack([np.cos(w * t), np.sin(w * t), np.ones_like(t), t, t**2], axis=1)
    fit = np.linalg.lstsq(basis, np.array(places), rcond=None)[0]
    surge, _, heave = np.hypot(fit[0], fit[1])
    # measured 0.986 and 0.980; digest [OURS]: 1.00-1.06 within 10 %
    assert surge / amplitude == pytest.approx(1, abs=0.05)
    assert heave / amplitude == pytest.approx(1, abs=0.05)


@pytest.mark.parametrize("turn", [0.5, 2.0])
def test_turned_world_turns_the_motion(turn):
    """Yawing the sea, the current and the start pose yaws the whole run."""
    base = irregular_sea(1.5, 5.0, components=20, seed=9)
    c, s = np.cos(turn), np.sin(turn)
    R = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    ends = []
    for angle in (0.0, turn):
        sea = WaveField(
            base.omega, base.wavenumber, base.direction + angle, base.amplitude, base.phase
        )
        current = uniform_current(0.4 * np.array([np.cos(angle), np.sin(angle), 0]))
        model = marine_mj.load_xml(
            one_body(
                added_mass=random_added_mass(2),
                numerics=buoyant(0.0098, "30 60 60 5 5 5")
                + '<numeric name="a.strips" data="6 -1 1"/>'
                + '<numeric name="a.strip_drag_flu" data="20 30"/>',
                extra=CB,
                pos="0 0 -2",
            ),
            Environment(waves=sea, current=current),
        )
        data = mujoco.MjData(model)
        data.qpos[3:7] = np.cos(angle / 2), 0, 0, np.sin(angle / 2)
        mujoco.mj_step(model, data, 1000)
        ends.append(data.qpos[:3].copy())
    np.testing.assert_allclose(R @ ends[0], ends[1], atol=1e-9)  # measured 3e-13


def test_frd_coefficients_equal_flu_ones():
    M_A = random_added_mass(4)
    T = np.diag([1, -1, -1, 1, -1, -1])
    flu = one_body(added_mass=M_A, gravity=0)
    frd = one_body(
        numerics=f'<numeric name="a.added_mass_frd" data="{numbers(T @ M_A @ T)}"/>', gravity=0
    )
    ends = []
    for xml in (flu, frd):
        model = marine_mj.load_xml(xml)
        data = mujoco.MjData(model)
        data.qvel[:] = [0.4, 0.2, -0.3, 0.5, -0.7, 0.9]
        mujoco.mj_step(model, data, 500)
        ends.append(data.qpos.copy())
    assert (ends[0] == ends[1]).all()


def test_buoyancy_at_the_surface():
    """A floating sphere of half the density of water settles half submerged."""
    volume = 4 / 3 * np.pi * 0.5**3
    model = marine_mj.load_xml(
        one_body(
            added_mass=[200, 200, 200, 1, 1, 1],
            numerics=buoyant(volume, extra='<numeric name="a.submergence_height" data="0.5"/>')
            + '<numeric name="a.linear_damping_flu" data="900 900 900 50 50 50"/>',
            mass=0.5 * 1025 * volume,
            center="0 0 -0.1",
            inertia="20 20 20",
            extra=CB,
            pos="0 0 -0.3",
        )
    )
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 8000)
    assert data.qpos[2] == pytest.approx(0, abs=1e-6)  # measured 1e-12
    assert np.abs(data.qvel).max() < 1e-6
