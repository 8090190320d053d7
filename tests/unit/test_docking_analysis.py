"""Evaluation of docking runs: entry distributions, limits, uptime, agreement."""

import numpy as np
import pytest
from scipy import stats

from marine_mj.analysis import docking as d
from marine_mj.errors import AnalysisError


def entries(n=2000, surge=0.1, pitch=3.0, energy=6.0, seed=0, docked=None):
    rng = np.random.default_rng(seed)
    return d.Entries(
        rng.normal(0.02, surge, n),
        np.deg2rad(rng.normal(0.0, pitch, n)),
        rng.gamma(2.0, energy / 2.0, n),
        docked,
    )


def test_intervals_are_those_of_the_distributions_the_values_were_drawn_from():
    found = entries(200_000)
    # two-sided 99.7 %: 2.968 standard deviations (reference 6.3); measured within 0.3 %
    low, high = d.interval(found, "surge")
    assert (low, high) == pytest.approx((0.02 - 0.2968, 0.02 + 0.2968), rel=6e-3)
    assert d.interval(found, "pitch")[1] == pytest.approx(np.deg2rad(3.0) * 2.968, rel=6e-3)
    # one-sided for the energy; measured within 0.2 %
    assert d.interval(found, "energy") == pytest.approx(
        (0.0, stats.gamma.ppf(0.997, 2.0, scale=3.0)), rel=1e-2
    )


def test_all_three_limits_together_mean_at_most_nine_failures_in_a_thousand():
    assert pytest.approx(0.991, abs=1e-4) == d.COVERAGE**3  # V26


def test_a_sea_state_is_operable_when_all_intervals_lie_inside():
    assert d.operable(entries()) == {"surge": True, "pitch": True, "energy": True, "total": True}
    wide = d.operable(entries(surge=0.2))
    assert wide == {"surge": False, "pitch": True, "energy": True, "total": False}
    assert not d.operable(entries(energy=12.0))["energy"]
    assert not d.operable(entries(pitch=6.0))["pitch"]
    assert d.operable(entries(surge=0.2), d.CaptureLimits(surge=0.7))["total"]


def test_calm_water_has_no_spread_and_is_its_own_interval():
    same = d.Entries(np.full(60, 0.1), np.zeros(60), np.full(60, 2.0))
    assert d.interval(same, "surge") == (0.1, 0.1)
    assert d.interval(same, "energy") == (0.0, 2.0)
    close = d.Entries(np.full(60, 0.1), np.zeros(60), 2.0 * (1 + 1e-7 * np.arange(60)))
    assert d.interval(close, "energy") == (0.0, close.energy.max())
    assert d.operable(same)["total"]


def test_maximum_sea_state_contiguous_or_not():
    good = {0: True, 1: True, 2: False, 3: True}
    assert d.maximum_sea_state(good) == 1
    assert d.maximum_sea_state(good, contiguous=False) == 3
    assert d.maximum_sea_state({0: False, 1: True}) is None


def test_limits_of_a_campaign_and_their_scatter():
    campaign = {state: entries(300, surge=0.02 + 0.02 * state, seed=state) for state in range(9)}
    # the interval of 2.968 s + 0.02 reaches 0.5 m at s = 0.162: between states 7 and 8
    found = d.limits_of(campaign)
    assert found == {"surge": 7, "pitch": 8, "energy": 8, "total": 7}
    scatter = d.bootstrap_limits(campaign, resamples=50)["total"]
    assert set(scatter) <= {6, 7, 8} and scatter.count(7) > 25
    incomplete = d.Entries(np.array([0.0, np.nan]), np.zeros(2), np.ones(2))
    assert d.limits_of({**campaign, 4: incomplete})["total"] == 3


def test_uptime_goes_through_the_points_of_the_reference():
    # Table 7.1, V29
    for state, percent in ((1, 7.9), (4, 36.7), (5, 59.4), (6, 82.7), (7, 93.6), (8, 98.3)):
        assert 100 * d.uptime(state) == pytest.approx(percent, abs=1e-9)
    assert d.uptime(None) == 0.0 and d.uptime(0) == 0.0
    heights = np.linspace(0, 12, 400)
    shares = d.uptime_of_height(heights)
    assert (np.diff(shares) >= 0).all() and shares[-1] == 1.0


def test_agreement_of_both_methods_counts_runs():
    docked = np.array([True] * 90 + [False] * 10)
    surge = np.zeros(100)
    surge[85:95] = 0.6  # ten outside: five of them docked all the same
    found = d.agreement(d.Entries(surge, np.zeros(100), np.ones(100), docked))
    assert found.inside[0] == 0.9 and found.docked[0] == 0.9
    assert found.docked_if_inside[0] == pytest.approx(85 / 90)
    assert found.docked_if_outside[0] == pytest.approx(5 / 10)
    assert found.agreement == pytest.approx(0.9)
    assert found.docked[1:] == pytest.approx((0.8256, 0.9448), abs=1e-4)  # Wilson, 90 of 100


def test_rows_of_a_batch_become_entries():
    rows = [
        {
            "docked": True,
            "forbidden_contact": False,
            "peak_contact_force": 3e3,
            "capture": {"surge_error": 0.1, "pitch_error": 0.02, "relative_kinetic_energy": 5.0},
        },
        {"docked": True, "forbidden_contact": True, "capture": None},
        {"error": "diverged"},
    ]
    found = d.Entries.of(rows)
    assert found.surge[0] == 0.1 and np.isnan(found.surge[1:]).all()
    assert found.docked.tolist() == [True, False, False]
    assert not found.complete


def test_sub_samples_of_60_are_like_the_whole():
    x = np.random.default_rng(4).normal(size=200)
    study = d.sample_size_study(x)
    assert set(study) == {"random", "regular", "first"}
    assert max(map(abs, study.values())) < 0.3
    shifted = np.concatenate([x[:60] + 2.0, x[60:]])
    assert d.sample_size_study(shifted)["first"] > 0.8


def test_dock_size_holds_its_own_runs():
    found = entries(300, surge=0.2)
    size = d.dock_size(found)
    assert d.operable(found, size)["total"]
    assert size.surge > 0.5


def test_refusals():
    with pytest.raises(AnalysisError, match="metric 'sway' does not exist; there are surge"):
        d.interval(entries(), "sway")
    bad = d.Entries(np.array([0.0, np.nan]), np.zeros(2), np.ones(2))
    with pytest.raises(AnalysisError, match="1 of 2 runs never crossed the aperture"):
        d.interval(bad, "surge")
    with pytest.raises(AnalysisError, match="capture limit pitch is 0, allowed is > 0"):
        d.CaptureLimits(pitch=0)
    with pytest.raises(AnalysisError, match="no contact phase"):
        d.agreement(entries())
    with pytest.raises(AnalysisError, match="50 runs hold no sub-sample of 60"):
        d.sample_size_study(np.arange(50.0))
