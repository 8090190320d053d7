"""Wave field and seas: construction, stretching, shapes, reproducibility, refusals."""

import copy
import dataclasses
import pickle
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from marine_mj.environment import (
    Environment,
    WaveField,
    calm,
    irregular_sea,
    jonswap,
    regular_wave,
    tabulated,
    wavenumber,
)
from marine_mj.environment.bins import energy_bins
from marine_mj.environment.dispersion import group_speed
from marine_mj.errors import SeaError

ONE = np.ones(1)


def test_shapes_broadcast() -> None:
    sea = irregular_sea(2, 8, components=7)
    x, t = np.zeros((4, 1)), np.arange(5.0)
    assert sea.elevation(x, 0, t).shape == (4, 5)
    assert sea.potential(x, 0, -1, t).shape == (4, 5)
    assert sea.pressure(x, 0, -1, t).shape == (4, 5)
    assert sea.velocity(x, 0, -1, t).shape == (4, 5, 3)
    assert sea.acceleration(0, 0, -1, 0).shape == (3,)
    assert sea.gradient(x, 0, -1, t).shape == (4, 5, 3, 3)
    assert sea.phasors(x, np.zeros(5)).shape == (4, 5, 7)
    assert sea.velocity(np.empty(0), 0, -1, 0).shape == (0, 3)
    assert isinstance(sea.elevation(0, 0, 0), float)


def test_many_points_equal_single_points() -> None:
    """Blocks of points change nothing."""
    sea = irregular_sea(2, 8, spreading=3, components=500, stretching="wheeler")
    x = np.linspace(-100, 100, 2000)  # eight blocks
    whole = sea.velocity(x, 3.0, -0.5, 7.0)
    for i in (0, 261, 262, 1999):
        np.testing.assert_allclose(whole[i], sea.velocity(x[i], 3.0, -0.5, 7.0), rtol=1e-12)


def test_calm_water() -> None:
    still = calm(depth=20.0)
    assert still.significant_height == 0 and still.elevation(1, 2, 3) == 0
    points = (np.zeros(4), 0.0, -1.0, 2.0)
    for name in ("potential", "velocity", "acceleration", "gradient", "pressure"):
        assert not getattr(still, name)(*points).any()
    assert still.velocity(*points).shape == (4, 3)
    assert irregular_sea(0.0, None) == calm()
    assert irregular_sea(0.0, spectrum="pierson_moskowitz") == calm()


def test_phasors_give_elevation() -> None:
    sea = irregular_sea(2, 8, spreading=3, seed=2)
    x, y, t = np.array([1.0, -40.0]), np.array([3.0, 9.0]), 12.5
    zeta = (sea.phasors(x, y) * np.exp(-1j * sea.omega * t)).real.sum(axis=-1)
    np.testing.assert_allclose(sea.elevation(x, y, t), zeta, atol=1e-13)


@pytest.mark.parametrize("depth", [np.inf, 12.0])
def test_stretching(depth: float) -> None:
    """Constant: nothing grows above z = 0. Wheeler: the surface value sits on the surface."""
    fields = {
        s: regular_wave(3, 7, depth=depth, stretching=s) for s in ("constant", "wheeler", "none")
    }
    t = np.linspace(0, 7, 29)
    zeta = fields["none"].elevation(0, 0, t)
    for name in ("velocity", "acceleration", "gradient", "pressure", "potential"):
        level = getattr(fields["none"], name)(0, 0, 0, t)
        np.testing.assert_array_equal(getattr(fields["constant"], name)(0, 0, 1.5, t), level)
        np.testing.assert_allclose(
            getattr(fields["wheeler"], name)(0, 0, zeta, t), level, atol=1e-12 * np.abs(level).max()
        )
        below = getattr(fields["none"], name)(0, 0, -2, t)
        np.testing.assert_array_equal(getattr(fields["constant"], name)(0, 0, -2, t), below)
    assert fields["none"].velocity(0, 0, 1.5, 0)[0] > fields["none"].velocity(0, 0, 0, 0)[0]
    # total pressure is 0 on the surface with Wheeler; measured 2e-12 Pa
    total = fields["wheeler"].pressure(0, 0, zeta, t, 1025.0) - 1025.0 * 9.81 * zeta
    np.testing.assert_allclose(total, 0.0, atol=1e-8)
    # z' = (z - zeta) / (1 + zeta / h)
    z = (-2 - zeta) / (1 + zeta / depth)
    np.testing.assert_allclose(
        fields["wheeler"].velocity(0, 0, -2, t), fields["none"].velocity(0, 0, z, t), atol=1e-13
    )


@given(
    H_s=st.floats(0.05, 3.0),
    T_p=st.floats(6.5, 15.0),
    components=st.integers(1, 500),
    depth=st.one_of(st.just(np.inf), st.floats(15.0, 500.0)),
    seed=st.integers(0, 2**40),
)
@settings(max_examples=25, deadline=None)
def test_irregular_sea_keeps_all_variance(
    H_s: float, T_p: float, components: int, depth: float, seed: int
) -> None:
    options = {"components": components, "depth": depth, "seed": seed}
    low, half = np.pi / T_p, np.full(components, 0.5)
    _, _, narrow = energy_bins(jonswap(H_s, T_p), low, 20 * low, half)
    equal = np.linspace(low, 10 * low, components + 1)
    for sampling, edges in (("equal_energy", narrow), ("random_in_bin", equal)):
        sea = irregular_sea(H_s, T_p, sampling=sampling, **options)
        assert len(sea.omega) == components
        assert sea.significant_height == pytest.approx(H_s, rel=1e-12)  # measured 1e-15
        assert ((edges[:-1] <= sea.omega) & (sea.omega <= edges[1:])).all()  # one in each bin


def test_chosen_range_loses_the_rest() -> None:
    sea = irregular_sea(2.0, 8.0, frequency_range=(0.6, 1.2))
    lost = jonswap(2.0, 8.0).moment(0, 0.6, 1.2)
    assert sea.significant_height == pytest.approx(4 * np.sqrt(lost), rel=1e-12)


def test_midpoint_amplitudes_are_literal() -> None:
    sea = irregular_sea(2.0, 8.0, sampling="midpoint", components=20, frequency_range=(0.4, 2.4))
    np.testing.assert_allclose(sea.omega, 0.45 + 0.1 * np.arange(20), rtol=1e-12)
    expected = np.sqrt(2 * jonswap(2.0, 8.0)(sea.omega) * 0.1)
    np.testing.assert_allclose(sea.amplitude, expected, rtol=1e-12)


def test_sea_from_table() -> None:
    sea = irregular_sea(spectrum=tabulated([0.5, 1.0, 2.0], [0.0, 0.6, 0.0], H_s=1.0))
    assert sea.significant_height == pytest.approx(1.0, rel=1e-12)
    assert 0.5 <= sea.omega.min() and sea.omega.max() <= 2.0


def test_named_spectra() -> None:
    for name in ("jonswap", "pierson_moskowitz", "bretschneider"):
        sea = irregular_sea(2.0, 8.0, spectrum=name)
        assert sea.significant_height == pytest.approx(2.0, rel=1e-12)
    assert irregular_sea(2.0, 8.0, spectrum="docking_jonswap").significant_height == pytest.approx(
        2.0, rel=1e-3
    )
    assert irregular_sea(2.0, spectrum="pierson_moskowitz").significant_height == pytest.approx(2.0)


def test_directions_spread_about_the_mean() -> None:
    """Mean direction, and the spread sqrt(1 / (2 s + 2)) of sin(angle), over 100 seeds."""
    angles = np.concatenate(
        [irregular_sea(2, 8, direction=1.2, spreading=10, seed=s).direction for s in range(100)]
    )
    # standard error of 10,000 directions 0.0022 rad
    assert np.mean(angles) == pytest.approx(1.2, abs=0.0066)  # measured 1.2025
    spread = np.std(np.sin(angles - 1.2))
    assert spread == pytest.approx(np.sqrt(1 / 22), rel=0.02)  # measured ratio 1.001


def test_same_seed_same_sea() -> None:
    a, b = (irregular_sea(2, 8, spreading=5, seed=9) for _ in range(2))
    assert a == b and a != irregular_sea(2, 8, spreading=5, seed=10)
    assert a == irregular_sea(2, 8, spreading=5, seed=np.random.default_rng(9))
    assert a == irregular_sea(2, 8, spreading=5, seed=np.random.SeedSequence(9))
    # spreading changes directions only
    long = irregular_sea(2, 8, seed=9)
    assert np.array_equal(a.omega, long.omega) and np.array_equal(a.phase, long.phase)
    rng = np.random.default_rng(9)
    assert irregular_sea(2, 8, seed=rng) != irregular_sea(2, 8, seed=rng)


def test_frozen_and_copied() -> None:
    sea = irregular_sea(2, 8)
    with pytest.raises(dataclasses.FrozenInstanceError):
        sea.depth = 3.0
    for twin in (pickle.loads(pickle.dumps(sea)), copy.deepcopy(sea), copy.copy(sea)):
        assert twin == sea
        with pytest.raises(ValueError, match="read-only"):
            twin.omega[0] = 1.0
    assert sea != "sea"


def test_arrays_are_copied() -> None:
    omega = np.ones(1)
    wave = WaveField(omega, wavenumber(omega), ONE, ONE, ONE)
    omega[0] = 2.0
    assert wave.omega[0] == 1.0


def test_environment_adds_current(recwarn: pytest.WarningsRecorder) -> None:
    environment = Environment(waves=irregular_sea(1, 6))
    assert environment == Environment(waves=irregular_sea(1, 6))
    np.testing.assert_array_equal(
        environment.water_velocity(1, 2, -3, 4), environment.waves.velocity(1, 2, -3, 4)
    )
    np.testing.assert_array_equal(
        environment.water_acceleration(1, 2, -3, 4), environment.waves.acceleration(1, 2, -3, 4)
    )
    assert not recwarn.list


K1 = wavenumber(ONE)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: WaveField(ONE, ONE, ONE, ONE, np.ones(2)),
            "phase has shape (2,), allowed is (1,)",
        ),
        (lambda: WaveField(np.ones((1, 1)), ONE, ONE, ONE, ONE), "omega has shape (1, 1)"),
        (lambda: WaveField(0 * ONE, ONE, ONE, ONE, ONE), "omega is 0.0 rad/s, allowed is > 0"),
        (lambda: WaveField(ONE, ONE, ONE, ONE, ONE), "wavenumber[0] is 1 rad/m, allowed is 0.1019"),
        (
            lambda: WaveField(ONE, K1, ONE, -ONE, ONE),
            "amplitude has the value -1 m, allowed is >= 0",
        ),
        (lambda: WaveField(ONE, K1, np.nan * ONE, ONE, ONE), "direction[0] is nan rad"),
        (
            lambda: WaveField(ONE, K1, ONE, ONE, ONE, depth=0),
            "depth is 0 m, allowed is > 0, inf in",
        ),
        (lambda: WaveField(ONE, K1, ONE, ONE, ONE, gravity=-9.81), "gravity is -9.81 m/s2"),
        (
            lambda: WaveField(ONE, K1, ONE, ONE, ONE, stretching="linear"),
            "stretching is 'linear', allowed are constant, wheeler, none: choose one of these",
        ),
        (lambda: wavenumber([1.0, -2.0]), "omega is -2.0 rad/s, allowed is > 0, finite: give 2 pi"),
        (lambda: wavenumber(1.0, -5.0), "depth is -5.0 m, allowed is > 0, inf included: give the"),
        (lambda: group_speed(1.0, 5.0, 0.0), "gravity is 0.0 m/s2, allowed is > 0, finite: 9.81"),
        (lambda: regular_wave(-1, 8), "height is -1 m, allowed is >= 0, finite: give the crest"),
        (lambda: regular_wave(1, 0), "period is 0 s, allowed is > 0, finite: give the wave period"),
        (
            lambda: regular_wave(2, 3),
            "height is 2 m at period 3 s, allowed is < 2 m (wave length 14.1 m, it would break)",
        ),
        (lambda: regular_wave(1, 8, depth=0.8), "it would break): lower it or take a longer"),
        (lambda: irregular_sea(5, 4), "H_s is 5 m at T_p 4 s, allowed is < 3.55 m"),
        (lambda: irregular_sea(-2, 8), "H_s is -2 m, allowed is >= 0"),
        (lambda: irregular_sea(), "H_s is None, allowed is >= 0 m"),
        (
            lambda: irregular_sea(2),
            "T_p is None, allowed is > 0 s: give the peak period of jonswap",
        ),
        (
            lambda: irregular_sea(2, 8, spectrum="neumann"),
            "spectrum is 'neumann', allowed are jonswap, pierson_moskowitz, bretschneider, docking",
        ),
        (
            lambda: irregular_sea(2, 8, spectrum=jonswap(2, 8)),
            "H_s is 2, T_p is 8 beside a jonswap",
        ),
        (
            lambda: irregular_sea(2, 8, components=501),
            "components is 501, allowed are whole numbers",
        ),
        (lambda: irregular_sea(2, 8, components=0), "components is 0, allowed are whole numbers"),
        (lambda: irregular_sea(2, 8, components=2.5), "components is 2.5"),
        (lambda: irregular_sea(2, 8, frequency_range=(2, 1)), "frequency_range is (2, 1) rad/s"),
        (lambda: irregular_sea(2, 8, spreading=-1), "spreading is -1, allowed is > 0"),
        (
            lambda: irregular_sea(2, 8, direction=np.inf),
            "direction is inf rad, allowed is any value",
        ),
        (
            lambda: irregular_sea(2, 8, sampling="equal"),
            "sampling is 'equal', allowed are equal_energy, random_in_bin",
        ),
        (lambda: irregular_sea(2, 8, seed=None), "seed is None, allowed are integers >= 0"),
        (lambda: irregular_sea(2, 8, seed=-1), "seed is -1, allowed are integers >= 0"),
        (lambda: Environment(waves=None), "waves is a NoneType, allowed is WaveField"),
        (lambda: Environment(water_density=0), "water_density is 0 kg/m3, allowed is > 0"),
        (lambda: Environment(gravity=-1), "gravity is -1 m/s2, allowed is > 0"),
        (
            lambda: Environment(waves=regular_wave(1, 8), gravity=1.62),
            "gravity is 1.62 m/s2 but the waves were made with 9.81",
        ),
    ],
)
def test_refusals(call, message: str) -> None:
    with pytest.raises(SeaError, match=re.escape(message)):
        call()
