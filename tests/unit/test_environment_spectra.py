"""Wave spectra: scale, moments, tables, spreading, refusals."""

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from marine_mj.environment import (
    bretschneider,
    docking_jonswap,
    jonswap,
    period_ratios,
    pierson_moskowitz,
    spreading_density,
    tabulated,
)
from marine_mj.environment.spectra import spreading_quantile
from marine_mj.errors import SeaError


@given(H_s=st.floats(0.01, 15), T_p=st.floats(0.5, 30), gamma=st.floats(1, 20))
@settings(max_examples=60, deadline=None)
def test_height_is_exact(H_s: float, T_p: float, gamma: float) -> None:
    spectrum = jonswap(H_s, T_p, gamma)
    assert spectrum.significant_height == pytest.approx(H_s, rel=1e-12)  # measured 4e-16
    omega = np.linspace(0.0, 60.0 / T_p, 400)
    assert (spectrum(omega) >= 0).all() and spectrum(0.0) == 0 == spectrum(-1.0)


def test_gamma_one_is_bretschneider() -> None:
    omega = np.linspace(0.1, 4.0, 100)
    np.testing.assert_allclose(
        jonswap(3, 9, 1.0)(omega), bretschneider(3, 9)(omega), rtol=1e-12, atol=1e-300
    )


def test_bretschneider_closed_form() -> None:
    """S = (5/16) H_s^2 w_p^4 w^-5 exp(-5/4 (w_p/w)^4) and its moments."""
    H_s, T_p = 2.0, 8.0
    omega_p = 2 * np.pi / T_p
    omega = np.linspace(0.4, 5, 50)
    shape = np.exp(-1.25 * (omega_p / omega) ** 4) / omega**5
    spectrum = bretschneider(H_s, T_p)
    np.testing.assert_allclose(spectrum(omega), 5 / 16 * H_s**2 * omega_p**4 * shape, rtol=1e-12)
    # m2 = (5/16) H_s^2 w_p^2 sqrt(pi / 1.25) / 4; measured 1e-15
    m2 = 5 / 16 * H_s**2 * omega_p**2 * np.sqrt(np.pi / 1.25) / 4
    assert spectrum.moment(2) == pytest.approx(m2, rel=1e-12)
    # variance up to w: (H_s^2 / 16) exp(-5/4 (w_p/w)^4)
    part = H_s**2 / 16 * np.exp(-1.25 * (omega_p / 1.3) ** 4)
    assert spectrum.moment(0, 0.0, 1.3) == pytest.approx(part, rel=1e-11)
    assert spectrum.moment(0, 1.3) == pytest.approx(H_s**2 / 16 - part, rel=1e-11)
    assert spectrum.moment(0, 200.0) == pytest.approx(5 / 64 * H_s**2 * (omega_p / 200) ** 4, 1e-6)
    assert spectrum.mean_period / T_p == pytest.approx(0.7718, abs=5e-5)  # 0.77177


def test_fully_developed_sea() -> None:
    """w_p = 0.401 sqrt(g / H_s); Phillips' tail 0.0081 g^2 w^-5."""
    spectrum = pierson_moskowitz(4.0)
    assert 2 * np.pi / spectrum.T_p == pytest.approx(0.401 * np.sqrt(9.81 / 4), rel=1e-3)
    assert spectrum(20.0) * 20.0**5 == pytest.approx(0.0081 * 9.81**2, rel=1e-4)
    assert pierson_moskowitz(4.0, 8.0)(0.9) == bretschneider(4.0, 8.0)(0.9)


def test_bins_add_up() -> None:
    spectrum = jonswap(2.0, 8.0)
    edges = np.linspace(0.3, 4.0, 37)
    bins = spectrum.bin_moments(edges)
    assert bins.sum() == pytest.approx(spectrum.moment(0, 0.3, 4.0), rel=1e-13)
    fine = np.linspace(edges[9], edges[10], 20001)
    assert bins[9] == pytest.approx(np.trapezoid(spectrum(fine), fine), rel=1e-6)  # 1e-9
    assert spectrum.bin_moments([1.0, 3.0, np.inf]).sum() == pytest.approx(spectrum.moment(0, 1.0))


def test_docking_form_is_literal() -> None:
    H_s, T_p, omega = 1.1, 5.5154, 1.3
    x = omega * T_p / (2 * np.pi)
    A = np.exp(-(((x - 1) / (0.09 * np.sqrt(2))) ** 2))
    S = 320 * H_s**2 / (T_p**4 * omega**5) * np.exp(-1950 / (T_p**4 * omega**4)) * 3.3**A
    assert docking_jonswap(H_s, T_p)(omega) == pytest.approx(S, rel=1e-13)


def test_table() -> None:
    omega, S = [0.5, 1.0, 2.0], [0.0, 0.6, 0.0]
    table = tabulated(omega, S)
    assert table.moment(0) == pytest.approx(0.45, rel=1e-12)  # two triangles
    assert table.moment(1, 0.0, 9.0) == pytest.approx(0.525, rel=1e-12)
    assert table.significant_height == pytest.approx(table.H_s)
    assert table.T_p == pytest.approx(2 * np.pi)
    assert table(3.0) == 0 and table(0.75) == pytest.approx(0.3)
    assert tabulated(omega, S, H_s=1.5).significant_height == pytest.approx(1.5, rel=1e-12)


@pytest.mark.parametrize("s", [0.5, 1.0, 2.0, 7.5, 15.0, 60.0])
def test_spreading(s: float) -> None:
    angle = np.linspace(-np.pi, np.pi, 40001)
    density = spreading_density(angle, s)
    assert np.trapezoid(density, angle) == pytest.approx(1, abs=1e-7)  # measured 2e-9 at s = 0.5
    assert density[np.abs(angle) > np.pi / 2].max() == 0
    # the quantile inverts the integral
    cumulative = np.cumsum(density) * (angle[1] - angle[0])
    for probability in (0.03, 0.5, 0.9):
        numeric = np.interp(probability, cumulative, angle)
        assert spreading_quantile(probability, s) == pytest.approx(numeric, abs=2e-4)  # 8e-5


def test_spreading_constant() -> None:
    assert spreading_density(0.0, 2) == pytest.approx(0.8488, abs=5e-5)  # 8 / (3 pi)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: jonswap(-1, 8), "H_s is -1 m, allowed is >= 0 and <= 1000, finite: give 4 sqrt"),
        (lambda: jonswap(np.nan, 8), "H_s is nan m, allowed is >= 0"),
        (lambda: jonswap("two", 8), "H_s is 'two' m, allowed is >= 0"),
        (lambda: jonswap(1, 0), "T_p is 0 s, allowed is > 0, finite: give the peak period"),
        (lambda: jonswap(1, 8, 0.5), "gamma is 0.5, allowed is >= 1 and <= 20, finite: 3.3 is"),
        (lambda: bretschneider(1, np.inf), "T_p is inf s, allowed is > 0, finite"),
        (lambda: docking_jonswap(1, -3), "T_p is -3 s, allowed is > 0"),
        (lambda: pierson_moskowitz(0), "H_s is 0 m, allowed is > 0, finite: a fully developed"),
        (lambda: jonswap(1, 8).moment(4), "moment 4 of a jonswap spectrum is infinite"),
        (lambda: tabulated([1, 2], [1, 1, 1]), "density has shape (3,), allowed is (2,)"),
        (lambda: tabulated([2, 1], [1, 1]), "omega has 2 values from [2.] rad/s"),
        (lambda: tabulated([1.0], [1.0]), "allowed are 2 or more, >= 0, strictly ascending"),
        (lambda: tabulated([1, 2], [1, -1]), "density has minimum -1"),
        (lambda: tabulated([1, 2], [0, 0]), "values >= 0 that are not all 0"),
        (lambda: tabulated([1, 2], [0, np.nan]), "density[1] is nan m2 s, allowed are finite"),
        (lambda: tabulated([1, 2], ["a", "b"]), "density is not an array of numbers"),
        (lambda: tabulated([1, 2], [0, 1], H_s=-1), "H_s is -1 m, allowed is >= 0"),
        (lambda: period_ratios(9), "gamma is 9, allowed is >= 1 and <= 7"),
        (lambda: spreading_density(0, 0), "spreading is 0, allowed is > 0, finite: use 5 to 15"),
    ],
)
def test_refusals(call, message: str) -> None:
    with pytest.raises(SeaError, match=re.escape(message)):
        call()
