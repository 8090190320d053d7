"""Linear wave theory: dispersion, kinematics and published values."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from marine_mj.environment import (
    SEA_STATES,
    WaveField,
    group_speed,
    irregular_sea,
    phase_speed,
    regular_wave,
    wavenumber,
)

G = 9.81
DEPTHS = [np.inf, 25.0]


@pytest.fixture(params=DEPTHS, ids=["deep", "25 m"])
def sea(request: pytest.FixtureRequest) -> WaveField:
    """Short-crested sea, all linear theory (no stretching)."""
    return irregular_sea(
        2.0, 7.0, direction=0.7, spreading=4, depth=request.param, seed=3, stretching="none"
    )


@pytest.fixture
def points() -> np.ndarray:
    """x, y, z, t of 40 points in the water, (4, 40)."""
    rng = np.random.default_rng(11)
    return rng.uniform([[-50], [-50], [-24], [0]], [[50], [50], [0], [600]], (4, 40))


def derivative(function, points: np.ndarray, axis: int, step: float = 2e-3) -> np.ndarray:
    """Fourth-order central difference along one of x, y, z, t."""

    def at(n: int) -> np.ndarray:
        moved = points.copy()
        moved[axis] += n * step
        return function(*moved)

    return (8 * (at(1) - at(-1)) - (at(2) - at(-2))) / (12 * step)


# Dispersion


@given(
    omega=st.floats(0.01, 30.0),
    depth=st.one_of(st.just(np.inf), st.floats(0.05, 5000.0)),
    gravity=st.floats(1.0, 25.0),
)
@settings(max_examples=300, deadline=None)
def test_dispersion_residual(omega: float, depth: float, gravity: float) -> None:
    k = float(wavenumber(omega, depth, gravity))
    tanh = 1.0 if np.isinf(depth) else np.tanh(k * depth)
    # measured 9e-16 over the whole range
    assert gravity * k * tanh == pytest.approx(omega**2, rel=1e-13)


def test_wavenumber_against_root_finder() -> None:
    for period in (1.0, 4.6, 30.0, 200.0):
        for depth in (0.5, 10.0, 300.0):
            omega = 2 * np.pi / period
            root = brentq(
                lambda k, w=omega, h=depth: G * k * np.tanh(k * h) - w**2, 1e-9, 50, xtol=1e-15
            )
            assert float(wavenumber(omega, depth)) == pytest.approx(
                root, rel=1e-11
            )  # measured 3e-15


@pytest.mark.parametrize(
    ("period", "depth", "expected"),
    [
        (3, np.inf, 0.447145),
        (3, 10, 0.447261),
        (6, np.inf, 0.111786),
        (6, 10, 0.129801),
        (6, 30, 0.112055),
        (8, np.inf, 0.062880),
        (8, 10, 0.088622),
        (8, 30, 0.065413),
        (10, np.inf, 0.040243),
        (10, 10, 0.068019),
        (10, 30, 0.045764),
        (12, np.inf, 0.027947),
        (12, 10, 0.055457),
        (12, 30, 0.035490),
    ],
)
def test_wavenumber_table(period: float, depth: float, expected: float) -> None:
    # the table is printed to 1e-6
    assert float(wavenumber(2 * np.pi / period, depth)) == pytest.approx(expected, abs=6e-7)


def test_group_speed_is_derivative_of_dispersion() -> None:
    for depth in (np.inf, 3.0, 25.0, 1e4):
        omega, step = 0.9, 1e-5
        slope = (wavenumber(omega + step, depth) - wavenumber(omega - step, depth)) / (2 * step)
        assert float(group_speed(omega, depth)) == pytest.approx(1 / slope, rel=1e-8)  # 2e-11
    assert float(phase_speed(0.01, 2.0)) == pytest.approx(np.sqrt(G * 2.0), rel=1e-4)  # shallow


# Kinematics as derivatives of the potential


def test_velocity_is_gradient_of_potential(sea: WaveField, points: np.ndarray) -> None:
    numeric = np.stack([derivative(sea.potential, points, i) for i in range(3)], axis=-1)
    # measured 1e-10 of 0.7 m/s (differences)
    np.testing.assert_allclose(sea.velocity(*points), numeric, atol=1e-9)


def test_acceleration_is_time_derivative_of_velocity(sea: WaveField, points: np.ndarray) -> None:
    numeric = derivative(sea.velocity, points, 3)
    np.testing.assert_allclose(sea.acceleration(*points), numeric, atol=1e-9)  # measured 4e-11


def test_gradient_is_derivative_of_velocity(sea: WaveField, points: np.ndarray) -> None:
    numeric = np.stack([derivative(sea.velocity, points, j) for j in range(3)], axis=-1)
    gradient = sea.gradient(*points)
    np.testing.assert_allclose(gradient, numeric, atol=1e-9)  # measured 2e-11
    np.testing.assert_array_equal(gradient, np.swapaxes(gradient, -1, -2))  # no rotation
    # no divergence (Laplace); measured 6e-17 of 0.4 1/s
    np.testing.assert_allclose(np.trace(gradient, axis1=-2, axis2=-1), 0.0, atol=1e-14)


def test_pressure_is_time_derivative_of_potential(sea: WaveField, points: np.ndarray) -> None:
    numeric = -1000.0 * derivative(sea.potential, points, 3)
    np.testing.assert_allclose(
        sea.pressure(*points, 1000.0), numeric, atol=1e-5
    )  # measured 2e-7 Pa


def test_boundary_conditions(sea: WaveField, points: np.ndarray) -> None:
    x, y, _, t = points
    # kinematic, zeta_t = w at z = 0: measured 8e-11 m/s
    moved = np.stack([x, y, t])
    slope = derivative(sea.elevation, moved, 2)
    np.testing.assert_allclose(sea.velocity(x, y, 0.0, t)[:, 2], slope, atol=1e-10)
    # dynamic, p = rho g zeta at z = 0: measured 7e-12 Pa
    expected = 1025 * G * sea.elevation(x, y, t)
    np.testing.assert_allclose(sea.pressure(x, y, 0.0, t), expected, atol=1e-9)
    if np.isfinite(sea.depth):
        bed = sea.velocity(x, y, -sea.depth, t)
        assert np.abs(bed[:, 2]).max() == 0.0
        below = sea.velocity(x, y, -sea.depth - 5.0, t)
        np.testing.assert_array_equal(below, bed)


def test_deep_water_is_the_limit_of_finite_depth(points: np.ndarray) -> None:
    deep, finite = (regular_wave(2, 6, 0.3, depth=h) for h in (np.inf, 2000.0))
    for name in ("velocity", "acceleration", "gradient", "pressure", "potential"):
        a, b = (getattr(wave, name)(*points) for wave in (deep, finite))
        np.testing.assert_allclose(a, b, atol=1e-9)  # measured 0


@given(turn=st.floats(-3.1, 3.1), x=st.floats(-30, 30), z=st.floats(-20, 2), t=st.floats(0, 99))
@settings(max_examples=40, deadline=None)
def test_turned_sea_gives_turned_velocity(turn: float, x: float, z: float, t: float) -> None:
    straight, turned = (
        irregular_sea(2, 8, direction=d, spreading=3, seed=1, depth=20) for d in (0.0, turn)
    )
    c, s = np.cos(turn), np.sin(turn)
    R = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    x2, y2, _ = R @ [x, 5.0, z]
    v = R @ straight.velocity(x, 5.0, z, t)
    np.testing.assert_allclose(turned.velocity(x2, y2, z, t), v, atol=1e-12)  # 1e-14
    J = R @ straight.gradient(x, 5.0, z, t) @ R.T
    np.testing.assert_allclose(turned.gradient(x2, y2, z, t), J, atol=1e-12)


# Published deep-water values, a = 1 m, T = 8 s


def test_published_values() -> None:
    wave = regular_wave(2.0, 8.0)
    omega = 2 * np.pi / 8
    assert wave.velocity(0, 0, 0, 0)[0] == pytest.approx(0.78540, abs=5e-6)
    assert wave.velocity(0, 0, -10, 0)[0] == pytest.approx(0.41880, abs=5e-6)
    assert -wave.acceleration(0, 0, -10, 0)[2] == pytest.approx(0.32892, abs=5e-6)
    assert wave.pressure(0, 0, -10, 0) == pytest.approx(5361.79, abs=5e-3)
    assert float(phase_speed(omega)) == pytest.approx(12.4905, abs=5e-5)
    assert float(group_speed(omega)) == pytest.approx(6.2452, abs=5e-5)
    energy = 1025 * G * wave.significant_height**2 / 16  # rho g m0
    assert energy == pytest.approx(5027.6, abs=0.05)


def test_signs() -> None:
    """Under a crest the water moves with the wave and accelerates downwards."""
    for direction in (0.0, 2.0):
        wave = regular_wave(1.0, 6.0, direction)
        along = np.array([np.cos(direction), np.sin(direction), 0.0])
        assert wave.elevation(0, 0, 0) == 0.5
        np.testing.assert_allclose(
            wave.velocity(0, 0, -1, 0) @ along, 0.5 * 2 * np.pi / 6, rtol=0.2
        )
        assert wave.acceleration(0, 0, -1, 0)[2] < 0
        # the crest has moved along the direction a little later
        ahead = along * phase_speed(2 * np.pi / 6) * 0.5
        assert wave.elevation(ahead[0], ahead[1], 0.5) == pytest.approx(0.5, abs=1e-12)


@pytest.mark.parametrize(
    ("depth", "speed", "acceleration"),
    [(0, 0.3142, 0.3948), (2, 0.2277, 0.2861), (10, 0.0628, 0.0789), (30, 0.00251, 0.00316)],
)
def test_five_second_wave(depth: float, speed: float, acceleration: float) -> None:
    wave = regular_wave(0.5, 5.0)  # H 0.5 m, T 5 s of the ROV study
    assert float(wave.wavenumber[0]) == pytest.approx(0.160972, abs=5e-7)
    assert wave.velocity(0, 0, -depth, 0)[0] == pytest.approx(speed, abs=6e-5)
    assert -wave.acceleration(0, 0, -depth, 0)[2] == pytest.approx(acceleration, abs=6e-5)


@pytest.mark.parametrize("z", [0.0, -1.0, -7.5])
def test_orbit_radius(z: float) -> None:
    """V8: particle displacement amplitude a exp(k z), forward and upward."""
    wave = regular_wave(1.1, 4.6)
    omega, k = float(wave.omega[0]), float(wave.wavenumber[0])
    t = np.arange(64) * 2 * np.pi / omega / 64
    radius = np.linalg.norm(wave.velocity(0, 0, z, t), axis=-1) / omega
    np.testing.assert_allclose(radius, 0.55 * np.exp(k * z), rtol=1e-12)  # measured 2e-16


def test_stokes_drift() -> None:
    """Particles drift by a^2 omega k exp(2 k z): 0.04939 m/s for a = 1 m, T = 8 s, z = 0."""
    amplitude, period, z = 0.1, 8.0, -1.0
    wave = regular_wave(2 * amplitude, period, stretching="none")
    k = float(wave.wavenumber[0])

    def motion(t: float, p: np.ndarray) -> np.ndarray:
        return wave.velocity(p[0], 0.0, p[1], t)[[0, 2]]

    t = np.linspace(0, 40 * period, 1281)
    path = solve_ivp(motion, (0, t[-1]), [0, z], t_eval=t, rtol=1e-8, atol=1e-10).y
    # once a period, so that the orbit itself drops out
    speed = np.polyfit(t[::32], path[0, ::32], 1)[0]
    drift = speed / amplitude**2 / np.exp(2 * k * np.mean(path[1]))
    assert drift == pytest.approx(0.04939, rel=0.01)  # measured 0.6 % low


# Docking study, validation cases V1 to V3


def test_v1_wave_length() -> None:
    k = float(wavenumber(2 * np.pi / 4.6))
    assert 2 * np.pi / k == pytest.approx(33.04, rel=1e-3)  # measured 33.036
    assert np.pi / k == pytest.approx(16.5, rel=2e-3)  # printed to 3 digits, measured 16.518


def test_v2_wave_lengths_and_steepness() -> None:
    lengths = [19.13, 22.55, 27.54, 33.04, 40.61, 50.73, 70.09, 97.44, 120.9, 140.9, 156.1, 172.1]
    ratios = [38.3, 34.7, 34.4, 30.0, 24.6, 20.3, 19.5, 20.1, 19.8, 18.9, 17.9, 16.8]
    for state, length, ratio in zip(SEA_STATES[1:], lengths, ratios, strict=True):
        measured = 2 * np.pi / float(wavenumber(2 * np.pi / state.mean_period))
        assert measured == pytest.approx(length, rel=1e-3)  # measured 2.1e-4
        assert measured / state.H_s == pytest.approx(ratio, rel=5e-3)  # measured 2.6e-3


def test_v3_particle_speed() -> None:
    period = np.sqrt(2 * np.pi * 33.0 / G)
    wave = regular_wave(1.1, period)
    assert wave.velocity(0, 0, 0, 0)[0] == pytest.approx(0.752, rel=5e-3)  # measured 0.7517
