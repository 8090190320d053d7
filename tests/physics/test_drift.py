"""Wave drift: Newman's approximation in the kernel against double sums and closed forms."""

import mujoco
import numpy as np
import pytest
from conftest import numbers, one_body
from drift_cases import RHO, G, boat, expected_drift, force, forces, waves_of

import marine_mj
from marine_mj.environment import Environment, WaveField, irregular_sea
from marine_mj.environment.spectra import jonswap
from marine_mj.hydrodynamics import write_environment
from marine_mj.hydrodynamics.coefficients import read_coefficients
from marine_mj.hydrodynamics.estimates import plate_reflection, reflected_drift

# The law


@pytest.mark.parametrize("drift", ["mean", "slow"])
def test_regular_wave_pushes_constantly(drift):
    """a^2 T at any time and place, for a yaw of the table."""
    amplitude, omega, direction = 0.7, 1.3, np.radians(45)
    model = boat(waves_of([omega], amplitude, direction), drift)
    expected = amplitude**2 * expected_drift([omega], direction)
    for time, x, y in ((0.0, 0, 0), (3.3, 12.0, -7.0), (812.7, -40.0, 3.0)):
        got = force(model, time, x, y)
        # measured 2e-16 relative
        np.testing.assert_allclose(got[[0, 1, 5]], expected[:, 0], rtol=1e-12)
        assert (got[2:5] == 0).all()


def test_two_waves_beat():
    """Newman's arithmetic mean: a1^2 T1 + a2^2 T2 + a1 a2 (T1 + T2) cos((w1 - w2) t)."""
    omega, amplitude, chi = np.array([1.1, 1.6]), np.array([0.5, 0.3]), np.radians(150)
    model = boat(waves_of(omega, amplitude, chi))
    T = expected_drift(omega, chi)
    t = np.linspace(0, 60, 301)
    beat = amplitude.prod() * T.sum(axis=1)
    expected = (amplitude**2 * T).sum(axis=1) + np.cos((omega[1] - omega[0]) * t)[:, None] * beat
    # measured 6e-15 of the amplitude
    np.testing.assert_allclose(forces(model, t), expected, atol=1e-11 * abs(beat).max())


def double_sum(waves, T, t, x, y):
    """Newman's double sum (3,) at one instant and place."""
    along = x * np.cos(waves.direction) + y * np.sin(waves.direction)
    theta = waves.wavenumber * along - waves.omega * t + waves.phase
    pair = waves.amplitude[:, None] * waves.amplitude * np.cos(theta[:, None] - theta)
    return np.array([(0.5 * (row[:, None] + row) * pair).sum() for row in T])


@pytest.mark.parametrize("yaw_steps", [0, 5, 13, 23])
def test_irregular_sea_is_the_double_sum(yaw_steps):
    """Short-crested, turned vessel somewhere: at the tabulated headings exact."""
    waves = irregular_sea(1.2, 6.0, direction=0.3, components=60, seed=5, spreading=4)
    model = boat(waves)
    yaw = waves.direction[0] + 2 * np.pi * yaw_steps / 24  # where the table starts, and on
    T = expected_drift(waves.omega, waves.direction - yaw)
    for t, x, y in ((0.0, 0.0, 0.0), (17.3, 25.0, -60.0)):
        got = force(model, t, x, y, yaw)[[0, 1, 5]]
        expected = double_sum(waves, T, t, x, y)
        # measured 2e-15 of the largest
        np.testing.assert_allclose(got, expected, atol=1e-10 * abs(expected).max())


def test_between_the_tabulated_headings():
    """Cubic in the heading: largest error of the closed forms c|c|, s|s| and sin 2 chi."""
    model = boat(waves_of([1.0], 1.0, 0.2), "mean")
    yaws = np.radians(np.arange(-180, 180, 1.7))
    got = np.array([force(model, yaw=yaw)[[0, 1, 5]] for yaw in yaws])
    expected = np.array([expected_drift(1.0, 0.2 - yaw) for yaw in yaws])
    error = abs(got - expected).max(axis=0) / abs(expected).max(axis=0)
    # measured 0.08 % (bends of c|c| and s|s|) and 0.011 % of the largest force
    assert (error < 0.0015).all()


def test_turned_and_moved_world():
    """The same relative situation elsewhere: same force in body axes."""
    turn, shift = np.radians(37), np.array([130.0, -48.0])
    waves = irregular_sea(1.0, 6.0, direction=-0.4, components=40, seed=2, spreading=6)
    c, s = np.cos(turn), np.sin(turn)
    moved = WaveField(
        waves.omega,
        waves.wavenumber,
        waves.direction + turn,
        waves.amplitude,
        waves.phase
        - waves.wavenumber
        * (np.cos(waves.direction + turn) * shift[0] + np.sin(waves.direction + turn) * shift[1]),
    )
    x, y = 5.0, 3.0
    here = force(boat(waves), 4.0, x, y, np.radians(30))
    there = force(
        boat(moved),
        4.0,
        shift[0] + c * x - s * y,
        shift[1] + s * x + c * y,
        np.radians(30) + turn,
    )
    # measured 1e-14 of the largest
    np.testing.assert_allclose(there, here, atol=1e-10 * abs(here).max())


def test_force_lies_level():
    """A heeled and pitched hull: the force stays horizontal, the moment vertical."""
    roll, pitch, yaw = 0.3, -0.2, np.radians(60)
    direction = yaw - np.radians(30)
    model = boat(waves_of([1.0], 1.0, direction), "mean")
    quat, q = np.zeros(4), np.zeros(4)
    mujoco.mju_euler2Quat(quat, [yaw, pitch, roll], "zyx")
    mujoco.mju_copy(q, quat)
    R = np.zeros(9)
    mujoco.mju_quat2Mat(R, q)
    R = R.reshape(3, 3)
    got = force(model, quat=q)
    world, moment = R @ got[:3], R @ got[3:]
    T = expected_drift(1.0, direction - yaw)
    c, s = np.cos(yaw), np.sin(yaw)
    np.testing.assert_allclose(world, [c * T[0] - s * T[1], s * T[0] + c * T[1], 0], atol=1e-8)
    np.testing.assert_allclose(moment, [0, 0, T[2]], atol=1e-8)  # measured 1e-12


# Statistics


def test_mean_of_a_long_record():
    """Mean force = sum a^2 T = 2 int S T d omega (Pinkster 1980) in head and beam seas."""
    spectrum = jonswap(1.5, 7.0)
    low, high, count = 0.4, 2.8, 120
    step = (high - low) / count
    for direction in (0.0, np.pi / 2):
        waves = irregular_sea(
            spectrum=spectrum,
            direction=direction,
            components=count,
            sampling="midpoint",
            frequency_range=(low, high),
        )
        model = boat(waves)
        # the record repeats after 2 pi / step: its mean has no sampling error
        times = np.arange(256) / 256 * 2 * np.pi / step
        mean = forces(model, times).mean(axis=0)
        T = expected_drift(waves.omega, direction)
        omega = np.linspace(low, high, 20001)
        integral = 2 * np.trapezoid(spectrum(omega) * expected_drift(omega, direction), omega)
        scale = abs(integral).max()
        # measured 2e-15, and 2e-5 (120 bins of the spectrum)
        np.testing.assert_allclose(mean, T @ waves.amplitude**2, atol=1e-11 * scale)
        np.testing.assert_allclose(mean, integral, atol=2e-4 * scale)
        alone = forces(boat(waves, "mean"), [0.0, 9.0])
        np.testing.assert_allclose(alone, [mean, mean], atol=1e-11 * scale)


def test_spectrum_of_the_slow_force():
    """S_F(mu) = 8 int S(w + mu) S(w) T(w + mu/2)^2 dw (Pinkster 1980), in bands of mu."""
    spectrum = jonswap(1.5, 7.0)
    low, high, count, seeds, samples = 0.4, 2.4, 100, 24, 256
    step = (high - low) / count
    sea = {"components": count, "sampling": "midpoint", "frequency_range": (low, high)}
    waves = irregular_sea(spectrum=spectrum, direction=np.pi / 2, **sea)
    rows = np.array([[0.4, 0, 1.0, 0], [2.4, 0, 5.0, 0]])  # T linear in omega: both means agree
    numerics = f'<numeric name="a.drift" data="{numbers(rows)}"/>'
    spec = mujoco.MjSpec.from_string(one_body(numerics=numerics, pos="0 0 0", gravity=0))
    model = marine_mj.hydrodynamics.compile_spec(spec, Environment(waves=waves))
    bodies = read_coefficients(spec)
    times = np.arange(samples) / samples * 2 * np.pi / step
    density = np.zeros(samples // 2)
    for seed in range(seeds):
        waves = irregular_sea(spectrum=spectrum, direction=np.pi / 2, seed=seed, **sea)
        write_environment(model, bodies, Environment(waves=waves))
        lines = np.fft.rfft(forces(model, times)[:, 1])[: samples // 2] / samples
        density += 2 * abs(lines) ** 2 / step / seeds
    for first, last in ((1, 11), (11, 31)):
        expected = 0.0
        for line in range(first, last):
            mu = line * step
            omega = np.linspace(low, high - mu, 2001)
            T = 0.5 * RHO * G * np.interp(omega + mu / 2, [0, 0.4, 2.4], [0, 1.0, 5.0])
            expected += 8 * np.trapezoid(spectrum(omega + mu) * spectrum(omega) * T**2, omega)
        ratio = density[first:last].sum() / expected
        # one record scatters by 40 % and 25 % (random phases), the mean of 24 by 8 % and 5 %:
        # measured 0.912 and 0.990
        assert ratio == pytest.approx(1, abs=0.16)


def test_drifting_speed():
    """Terminal speed in a regular wave from the side: a^2 T = D v; deep down, no orbital motion."""
    waves, damping = waves_of([1.3], 0.5, np.pi / 2), 400.0
    extra = f'<numeric name="a.linear_damping_flu" data="{numbers(np.full(6, damping))}"/>'
    model = boat(waves, numerics=extra, center="0 0 0", mass=100.0, pos="0 0 -300")
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 2000)
    expected = 0.25 * expected_drift(1.3, np.pi / 2)[1] / damping
    # measured 5e-15 relative
    assert data.qvel[1] == pytest.approx(expected, rel=1e-10)


# Reflection


def test_plate_reflection():
    """Long waves pi (kT)^2 / 2, short ones all; nothing is lost (Ursell 1947)."""
    k = np.array([0.0, 1e-3, 50.0, 1e4])
    got = plate_reflection(k, 1.0)
    assert got[0] == 0
    assert got[1] == pytest.approx(np.pi / 2 * 1e-6, rel=1e-4)  # measured 4e-6
    assert got[2:] == pytest.approx(1, abs=1e-12)
    # R^2 + (transmitted)^2 = 1 with T = K_1 / sqrt(pi^2 I_1^2 + K_1^2)
    from scipy.special import i1, k1

    kT = np.linspace(0.05, 5, 40)
    through = k1(kT) / np.hypot(np.pi * i1(kT), k1(kT))
    np.testing.assert_allclose(plate_reflection(kT / 0.76, 0.76) ** 2 + through**2, 1, rtol=1e-13)


def test_drift_of_a_reflecting_hull():
    """X = 1/2 rho g a^2 R^2 B c|c|, Y = 1/2 rho g a^2 R^2 L s|s|, N = 0 for a boat of 7.2 m."""
    from scipy.special import i1, k1

    length, breadth, draft = 7.2, 2.02, 0.76
    omega, amplitude, chi = np.array([0.8, 1.37, 2.4]), np.array([0.3, 0.2, 0.05]), 0.35
    grid = np.linspace(0.03, 3.75, 125)
    rows = reflected_drift(grid, length, breadth, draft)
    model = boat(waves_of(omega, amplitude, chi), "mean", rows)
    kT = omega**2 / G * draft
    R = np.pi * i1(kT) / np.sqrt(np.pi**2 * i1(kT) ** 2 + k1(kT) ** 2)
    push = 0.5 * RHO * G * (amplitude * R) ** 2
    c, s = np.cos(chi), np.sin(chi)
    expected = [(push * breadth * c * abs(c)).sum(), (push * length * s * abs(s)).sum(), 0.0]
    # measured 4e-4 relative: linear between 125 rows, cubic between headings
    np.testing.assert_allclose(force(model)[[0, 1, 5]], expected, rtol=2e-3, atol=1e-9)
