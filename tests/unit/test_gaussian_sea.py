"""Gaussian seas: variance, normal elevation, Rayleigh envelope, what stays when u varies."""

import re

import numpy as np
import pytest
from scipy import stats

from marine_mj.analysis import pool, subset_simulation
from marine_mj.environment import calm, gaussian_sea, irregular_sea, jonswap
from marine_mj.errors import SeaError

SPECTRUM = jonswap(2.0, 8.0)
M0 = 0.25  # (H_s / 4)^2


def linear_map(n, point, **options):
    """Elevation phasor (2 n,) of each unit vector: the sea is linear in u."""
    seas = [gaussian_sea(row, spectrum=SPECTRUM, **options) for row in np.eye(2 * n)]
    x, y, t = point
    return np.array([(s.phasors(x, y) * np.exp(-1j * s.omega * t)).sum() for s in seas])


@pytest.mark.parametrize("options", [{}, {"spreading": 4.0}, {"sampling": "midpoint"}])
@pytest.mark.parametrize("point", [(0.0, 0.0, 0.0), (80.0, -30.0, 25.0)])
def test_variance_is_m0_everywhere(options, point):
    phasor = linear_map(12, point, **options)
    amplitude = irregular_sea(spectrum=SPECTRUM, components=12, **options).amplitude
    m0 = 0.5 * (amplitude**2).sum()
    if "sampling" not in options:  # 12 midpoints are too coarse to hold m0
        assert m0 == pytest.approx(M0, rel=1e-12)
    assert (phasor.real**2).sum() == pytest.approx(m0, rel=1e-12)  # 4e-16
    # the same for the Hilbert transform, and both are uncorrelated: a Rayleigh envelope
    assert (phasor.imag**2).sum() == pytest.approx(m0, rel=1e-12)
    assert abs((phasor.real * phasor.imag).sum()) < 1e-15


def test_is_linear_in_u(rng):
    u = rng.standard_normal(24)
    sea = gaussian_sea(u, spectrum=SPECTRUM)
    assert sea.elevation(80, -30, 25) == pytest.approx(linear_map(12, (80, -30, 25)).real @ u)
    amplitude = np.hypot(u[:12], u[12:]) * irregular_sea(spectrum=SPECTRUM, components=12).amplitude
    np.testing.assert_allclose(sea.amplitude, amplitude / np.sqrt(2), rtol=1e-12)


def test_frequencies_are_those_of_the_irregular_sea(rng):
    options = {"seed": 5, "spreading": 3.0, "direction": 0.4, "depth": 30.0}
    fixed = irregular_sea(2, 8, components=9, **options)
    for _ in range(2):
        sea = gaussian_sea(rng.standard_normal(18), 2, 8, **options)
        for name in ("omega", "wavenumber", "direction", "depth"):
            np.testing.assert_array_equal(getattr(sea, name), getattr(fixed, name))
    assert gaussian_sea(np.ones(18), 0.0) == calm()


def test_significant_height_scatters_about_that_of_the_spectrum(rng):
    m0 = np.array([gaussian_sea(u, spectrum=SPECTRUM).significant_height ** 2 / 16
                   for u in rng.standard_normal((300, 60))])  # fmt: skip
    variance = irregular_sea(spectrum=SPECTRUM, components=30).amplitude ** 2 / 2
    cov = np.sqrt((variance**2).sum()) / M0  # 0.464
    assert m0.mean() == pytest.approx(M0, rel=4 * cov / np.sqrt(300))  # 0.2486
    assert m0.std() / M0 == pytest.approx(cov, rel=0.25)  # 0.454


def test_rare_crests_of_a_narrow_band():
    """Subset simulation in the space of seas: normal elevation and Rayleigh envelope, exactly."""
    # 20 components between 0.9 and 1.1 omega_p carry the narrow band's own m0
    peak = 2 * np.pi / 8
    phasor = linear_map(20, (0.0, 0.0, 0.0), frequency_range=(0.9 * peak, 1.1 * peak))
    sigma = np.linalg.norm(phasor.real)
    assert sigma**2 == pytest.approx(SPECTRUM.moment(0, 0.9 * peak, 1.1 * peak), rel=1e-12)
    for score, a, exact in (
        (lambda u: u @ phasor.real, 4.0 * sigma, stats.norm.sf(4.0)),  # 3.17e-5
        (lambda u: np.abs(u @ phasor), 4.6 * sigma, np.exp(-(4.6**2) / 2)),  # 2.54e-5
    ):
        found = pool([subset_simulation(score, 40, a, seed=i) for i in range(30)])
        # 3.19e-5 and 2.56e-5
        assert found.probability == pytest.approx(exact, rel=4 * found.cov)
        assert found.cov < 0.07


def test_event_is_searched_among_wave_fields():
    """The same with the wave field itself in the score, one small run."""
    a = 3.0 * np.sqrt(M0)

    def score(u):
        return [gaussian_sea(row, spectrum=SPECTRUM).elevation(10.0, 0.0, 5.0) for row in u]

    found = subset_simulation(score, 20, a, samples=200)
    low, high = found.interval(0.997)
    assert low < stats.norm.sf(3.0) < high  # 1.35e-3; 1.25e-3
    sea = gaussian_sea(found.events[0], spectrum=SPECTRUM)
    assert sea.elevation(10.0, 0.0, 5.0) >= a


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: gaussian_sea(np.ones(3), 1, 5), "u has 3 values, allowed are even numbers: two"),
        (
            lambda: gaussian_sea([], 1, 5),
            "components is 0, allowed are whole numbers from 1 to 500",
        ),
        (lambda: gaussian_sea([1, np.nan], 1, 5), "u[1] is nan"),
        (lambda: gaussian_sea(np.ones((2, 2)), 1, 5), "u has shape (2, 2), allowed is (2 N,)"),
        (lambda: gaussian_sea(np.ones(4), 9, 3), "H_s is 9 m at T_p 3 s, allowed is <"),
        (lambda: gaussian_sea(np.ones(4), 1, 5, sampling="x"), "sampling is 'x', allowed are"),
        (lambda: gaussian_sea(np.ones(4), 1, 5, seed=None), "seed is None, allowed are integers"),
    ],
)
def test_refusals(call, message):
    with pytest.raises(SeaError, match=re.escape(message)):
        call()
