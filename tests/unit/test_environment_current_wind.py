"""Current, wind and sea-state table: interpolation, statistics, refusals."""

import pickle
import re

import numpy as np
import pytest
from scipy.special import gamma

from marine_mj.environment import (
    SEA_STATES,
    Current,
    Environment,
    Wind,
    fluctuating_current,
    gauss_markov,
    gust_density,
    gusty_wind,
    height_factor,
    no_current,
    no_wind,
    sea_state,
    steady_wind,
    uniform_current,
    uptime_percent,
    wandering_wind,
    wind_series,
)
from marine_mj.errors import SeaError

# Current


def test_uniform_current() -> None:
    current = uniform_current([0.1, -0.2, 0.0])
    np.testing.assert_array_equal(current.velocity_at(-30.0, 5.0), [0.1, -0.2, 0.0])
    assert current.velocity_at(np.zeros((4, 1)), np.zeros(5)).shape == (4, 5, 3)
    assert not current.acceleration_at(np.zeros(2), 0.0).any()
    assert not no_current().velocity_at(-1.0, 2.0).any()


def test_depth_profile_is_linear_and_held() -> None:
    current = Current(np.array([-20.0, -10.0, 0.0]), [[0, 0, 0], [1, 0, 0], [1, 2, 0]])
    z = [-50, -20, -15, -10, -2.5, 0, 3]
    expected = [[0, 0], [0, 0], [0.5, 0], [1, 0], [1, 1.5], [1, 2], [1, 2]]
    np.testing.assert_allclose(current.velocity_at(z, 0.0)[:, :2], expected, atol=1e-15)


def test_fluctuation_between_knots() -> None:
    series = np.array([[0.0, 0, 0], [1, 0, 0], [1, 4, 0]])
    current = Current(np.zeros(1), [[0.5, 0, 0]], 2.0, series)
    t = [-1.0, 0.0, 1.0, 2.0, 3.0, 4.0, 99.0]
    v = current.velocity_at(0.0, t)
    np.testing.assert_allclose(v[:, 0], [0.5, 0.5, 1.0, 1.5, 1.5, 1.5, 1.5], atol=1e-15)
    np.testing.assert_allclose(v[:, 1], [0, 0, 0, 0, 2, 4, 4], atol=1e-15)
    a = current.acceleration_at(0.0, t)
    np.testing.assert_allclose(a[:, 0], [0, 0.5, 0.5, 0, 0, 0, 0], atol=1e-15)
    np.testing.assert_allclose(a[:, 1], [0, 0, 0, 2, 2, 0, 0], atol=1e-15)


def test_gauss_markov_statistics() -> None:
    """Stationary from the first knot: variance std^2, autocorrelation exp(-lag / T)."""
    T, interval = 40.0, 4.0
    series = gauss_markov([0.3, 0.0], T, 4e5, interval=interval, seed=4)
    assert series.shape == (100_001, 2) and not series[:, 1].any()
    x = series[:, 0]
    # n_eff = duration / (2 T) for the mean: standard error 0.0042; T for the square: 1.4 %
    assert abs(x.mean()) < 0.013  # measured 0.0054
    assert np.mean(x**2) == pytest.approx(0.09, rel=0.03)  # measured ratio 1.003
    for lag in (1, 5, 10, 20):
        measured = np.mean(x[lag:] * x[:-lag]) / np.mean(x**2)
        assert measured == pytest.approx(np.exp(-lag * interval / T), abs=0.03)  # measured 0.006
    first = [gauss_markov([0.3], T, 1.0, seed=s)[0, 0] for s in range(2000)]
    assert np.std(first) == pytest.approx(0.3, rel=0.05)  # standard error 1.6 %, measured -1.5 %


def test_fluctuating_current() -> None:
    current = fluctuating_current([0.4, 0.1, 0.0], 0.05, 60.0, 600.0, seed=3)
    assert current == fluctuating_current([0.4, 0.1, 0.0], 0.05, 60.0, 600.0, seed=3)
    assert current != fluctuating_current([0.4, 0.1, 0.0], 0.05, 60.0, 600.0, seed=4)
    assert current.interval == 3.0 and current.fluctuation.shape == (201, 3)
    assert not current.fluctuation[:, 2].any()
    twin = pickle.loads(pickle.dumps(Environment(current=current)))
    assert twin.current == current and not twin.current.fluctuation.flags.writeable
    step = 1e-4
    rate = (current.velocity_at(0, 7.1 + step) - current.velocity_at(0, 7.1 - step)) / (2 * step)
    np.testing.assert_allclose(current.acceleration_at(0, 7.1), rate, atol=1e-10)
    environment = Environment(current=current)
    np.testing.assert_array_equal(
        environment.water_acceleration(0, 0, -1, 7.1), current.acceleration_at(-1, 7.1)
    )


# Wind


def test_steady_wind() -> None:
    wind = steady_wind(10.0, np.pi / 2)  # towards west
    np.testing.assert_allclose(wind.velocity_at([0.0, 50.0]), [[0, 10, 0]] * 2, atol=1e-14)
    assert not no_wind().velocity_at(3.0).any()
    assert no_wind(1.3).air_density == 1.3


def test_wind_series_is_linear_and_clipped() -> None:
    wind = wind_series([4.0, -1.0, 6.0], [0.0, 0.0, 0.0], 2.0)
    np.testing.assert_allclose(wind.velocity_at([0, 1, 2, 3, 9])[:, 0], [4, 2, 0, 3, 6])


def test_classical_gust_variance() -> None:
    """Davenport: 6 c U^2; Harris: 4 c U^2 sqrt(pi) Gamma(1/3) / (2^(4/3) Gamma(5/6))."""
    f = np.geomspace(1e-7, 1e5, 200_001)
    harris = 4 * np.sqrt(np.pi) * gamma(1 / 3) / (2 ** (4 / 3) * gamma(5 / 6))
    for name, factor in (("davenport", 6.0), ("harris", harris)):
        variance = np.trapezoid(gust_density(f, 15.0, name), f)
        assert variance == pytest.approx(factor * 0.0026 * 15.0**2, rel=1e-3)  # 3e-5


@pytest.mark.parametrize("speed", [10.0, 20.0, 30.0])
def test_npd_spectrum_agrees_with_its_turbulence_intensity(speed: float) -> None:
    """ISO 19901-1 gives the intensity 0.06 (1 + 0.043 U) apart from the spectrum: one hour."""
    f = np.geomspace(1 / 3600, 0.5, 20_001)
    intensity = np.sqrt(np.trapezoid(gust_density(f, speed), f)) / speed
    # measured 1.100, 1.085, 1.015 of the formula: two separate fits to the same data
    assert intensity == pytest.approx(0.06 * (1 + 0.043 * speed), rel=0.12)


@pytest.mark.parametrize("spectrum", ["npd", "harris", "davenport"])
def test_gust_series_has_the_variance_of_its_spectrum(spectrum) -> None:
    f = np.geomspace(1 / 600, 0.5, 20_001)
    expected = np.trapezoid(gust_density(f, 12.0, spectrum), f)
    winds = [gusty_wind(12.0, 0.0, 3600.0, spectrum=spectrum, seed=s) for s in range(30)]
    series = np.array([wind.velocity[:, 0] for wind in winds])
    # thirty hours: measured 0.984, 0.982, 0.987 (standard error 0.9 %)
    assert np.mean((series - 12.0) ** 2) / expected == pytest.approx(1, abs=0.03)
    assert np.mean(series) == pytest.approx(12.0, abs=0.02)  # measured 12.000


def test_gusts_blow_along_the_wind_and_repeat_by_seed() -> None:
    wind = gusty_wind(12.0, 0.5, 60.0, seed=1)
    np.testing.assert_allclose(wind.velocity[:, 1] / wind.velocity[:, 0], np.tan(0.5), rtol=1e-12)
    assert wind == gusty_wind(12.0, 0.5, 60.0, seed=1) != gusty_wind(12.0, 0.5, 60.0, seed=2)
    assert wind.interval == 0.5 and len(wind.velocity) == 121
    assert not gusty_wind(0.0, 0.5, 60.0).velocity.any()


def test_wandering_wind_variance() -> None:
    """Random walk: power t; with a correlation time T in the end power T / 2."""
    ends, bounded, angles = [], [], []
    for seed in range(400):
        v = wandering_wind(20.0, 0.0, 100.0, interval=1.0, seed=seed).velocity[-1]
        ends.append(np.hypot(*v[:2]) - 20.0)
        angles.append(np.arctan2(v[1], v[0]))
        v = wandering_wind(20, 0, 100, correlation_time=20, interval=1, seed=seed).velocity[-1]
        bounded.append(np.hypot(*v[:2]) - 20.0)
    # standard error of a variance from 400 values 7 %
    assert np.var(ends) == pytest.approx(0.1, rel=0.2)  # measured 0.097
    assert np.var(np.degrees(angles)) == pytest.approx(10.0, rel=0.2)  # measured 10.6
    assert np.var(bounded) == pytest.approx(0.01, rel=0.2)  # measured 0.0107


def test_turning_wind() -> None:
    wind = wandering_wind(
        5, 0.2, 200, speed_power=0, direction_power=0, turn=1.0, turn_start=50, turn_time=50
    )
    v = wind.velocity_at([0, 50, 100, 200])
    angle = np.arctan2(v[:, 1], v[:, 0])
    np.testing.assert_allclose(angle, 0.2 + np.array([0, 0, 1 - np.exp(-1), 1 - np.exp(-3)]))


def test_height_factor() -> None:
    assert height_factor(10.0) == 1.0
    assert height_factor(1.0, 0.4) == pytest.approx(0.398, abs=5e-4)  # Viknes study
    assert height_factor([1.0, 100.0]).shape == (2,)


# Sea states


def test_sea_state_table() -> None:
    assert [s.ss_bft for s in SEA_STATES] == list(range(13))
    state = sea_state(5)
    assert (state.name, state.H_s, state.mean_period) == ("fresh breeze", 1.65, 5.1)
    peaks = [4.197, 4.556, 5.036, 5.515, 6.115, 6.834, 8.033, 9.472, 10.551, 11.391, 11.990, 12.590]
    np.testing.assert_allclose([s.T_p for s in SEA_STATES[1:]], peaks, atol=6e-4)
    assert state.wind_speed == pytest.approx(9.774, abs=1e-3)  # 19 kn


def test_uptime_is_exact_at_the_table() -> None:
    assert uptime_percent(1.65) == 59.4
    assert uptime_percent([0.0, 0.25, 4.85, 20.0]).tolist() == [0.0, 3.95, 98.3, 100.0]


SERIES = np.zeros((3, 3))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Current([], np.empty((0, 3))), "levels is [] m, allowed are 1 or more"),
        (lambda: Current([0, -1], SERIES[:2]), "levels is [0.0, -1.0] m, allowed are 1 or more"),
        (lambda: Current([-1, 0], SERIES), "velocity has shape (3, 3), allowed is (2, 3)"),
        (lambda: Current([0], SERIES[:1], 0.0), "interval is 0.0 s, allowed is > 0, finite"),
        (lambda: Current([0], SERIES[:1], 1.0, np.zeros((4, 2))), "allowed is (m, 3): reshape it"),
        (lambda: uniform_current([1.0, 2.0]), "velocity has shape (2,), allowed is (3,)"),
        (lambda: uniform_current([1, np.inf, 0]), "velocity[1] is inf m/s, allowed are finite"),
        (lambda: gauss_markov([-0.1], 10, 10), "std is [-0.1], allowed are values >= 0"),
        (lambda: gauss_markov([0.1], 0, 10), "correlation_time is 0 s, allowed is > 0"),
        (lambda: gauss_markov([0.1], 10, 0), "duration is 0 s, allowed is > 0"),
        (lambda: gauss_markov([0.1], 10, 10, interval=-1), "interval is -1 s, allowed is > 0"),
        (
            lambda: gauss_markov([0.1], 1, 1e6),
            "duration 1e+06 s at interval 0.05 s makes 20000001 knots, allowed are 1000000: use a",
        ),
        (lambda: fluctuating_current([0, 0, 0], -1, 10, 10), "std is -1 m/s, allowed is >= 0"),
        (lambda: Wind(1.0, np.empty((0, 3))), "velocity has 0 knots, allowed are 1 or more"),
        (lambda: Wind(-1.0, SERIES), "interval is -1.0 s, allowed is > 0"),
        (lambda: Wind(1.0, np.zeros(3)), "velocity has shape (3,), allowed is (m, 3)"),
        (lambda: Wind(1.0, SERIES, 0.0), "air_density is 0.0 kg/m3, allowed is > 0"),
        (lambda: steady_wind(-3, 0), "speed is -3 m/s, allowed is >= 0, finite: give the mean"),
        (lambda: wind_series([1, 2], [0], 1), "direction has shape (1,), allowed is (2,)"),
        (lambda: gusty_wind(-3, 0, 10), "speed is -3 m/s, allowed is >= 0"),
        (
            lambda: gust_density(1, 1, "kaimal"),
            "spectrum is 'kaimal', allowed are npd, harris, dav",
        ),
        (lambda: wandering_wind(3, 0, 10, speed_power=-1), "speed_power is -1 m2/s3"),
        (lambda: wandering_wind(3, 0, 10, direction_power=-1), "direction_power is -1 rad2/s"),
        (lambda: wandering_wind(3, 0, 10, correlation_time=0), "correlation_time is 0 s"),
        (lambda: wandering_wind(3, 0, 10, turn_time=0), "turn_time is 0 s, allowed is > 0"),
        (lambda: height_factor(0.0), "height is 0.0 m, allowed is > 0: give the height above"),
        (lambda: height_factor(5.0, 2.0), "exponent is 2.0, allowed is >= 0 and <= 1"),
        (lambda: sea_state(13), "ss_bft is 13, allowed are whole numbers from 0 to 12: give the"),
        (lambda: sea_state(2.5), "ss_bft is 2.5, allowed are whole numbers"),
        (lambda: sea_state(True), "ss_bft is True, allowed are whole numbers"),
    ],
)
def test_refusals(call, message: str) -> None:
    with pytest.raises(SeaError, match=re.escape(message)):
        call()
