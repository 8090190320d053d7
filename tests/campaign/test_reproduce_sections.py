"""The docking study's other tables and figures: choice, keeping, report, and their arithmetic."""

import json
import sys
from dataclasses import replace

import matplotlib
import numpy as np
import pytest
from marine_mj.controllers import RigidState
from marine_mj.controllers.navigation import Truth
from marine_mj.controllers.navigation.planar import (
    PlanarNavigation,
    PlanarNoise,
    planar_scenario,
)
from scipy import stats

from marine_mj.campaign.pools import Here
from marine_mj.environment import wavenumber
from marine_mj.errors import AnalysisError, CampaignError
from marine_mj.reproduce import TABLES, choose, run_sections, write_report
from marine_mj.reproduce.filter_theory import riccati, surge_error
from marine_mj.reproduce.sections import SECTIONS, multibody
from marine_mj.reproduce.sections import runner as sections_runner
from marine_mj.reproduce.sections.base import Job, Outcome, compare
from marine_mj.reproduce.sections.distributions import density
from marine_mj.reproduce.sections.waypoints import WAYPOINTS, Waypoint, _judge
from marine_mj.validation.navigation import steady


def test_choice_splits_tables_and_sections_in_the_studys_order():
    assert choose(["8.9", "raos", " 7.12", "7.8"]) == (["7.12", "8.9"], ["raos", "7.8"])
    assert choose() == (list(TABLES), list(SECTIONS))
    assert not set(TABLES) & set(SECTIONS)


@pytest.mark.parametrize("names", [[], ["7.12", "fig"]])
def test_unknown_names_are_refused_with_all_that_exist(names):
    with pytest.raises(AnalysisError, match=r"there are 7\.12, .*and the sections waves, .*8\.8"):
        choose(names)


def test_compare_and_row_of_the_report():
    near, far = (compare("a", 2.0, ours, "m", 0.5, "why", (1.0, 3.0)) for ours in (2.5, 2.6))
    assert (near.verdict, far.verdict) == ("agrees", "differs")
    assert near.row("table 1") == {
        "quantity": "table 1: a", "published": 2.0, "ours": 2.5, "unit": "m", "verdict": "agrees",
        "note": "why", "interval": [1.0, 3.0],
    }  # fmt: skip


def test_a_finished_section_is_read_and_another_setting_does_it_again(tmp_path, monkeypatch):
    calls = []

    def run(job):
        calls.append((job.runs, job.full))
        figure = matplotlib.figure.Figure()
        return Outcome([compare("x", 1.0, 1.2, "m", 0.5, interval=(1.0, 2.0))],
                       [job.save(figure, "picture")], "words")  # fmt: skip

    monkeypatch.setitem(SECTIONS, "7.8", replace(SECTIONS["7.8"], run=run))
    monkeypatch.setitem(SECTIONS, "waves", replace(SECTIONS["waves"], run=run))
    seen = []

    def do(runs, **changes):
        names = ["waves", "7.8"]
        return run_sections(names, tmp_path, runs, executor=Here(), **changes)

    first = do(2)
    assert do(2) == first and len(calls) == 2
    do(3)  # only the section that depends on it
    do(3, full=True, progress=lambda *now: seen.append(now))
    assert calls == [(2, False), (2, False), (3, False), (3, True)]
    assert seen[0] == (1, 2) and seen[-1] == (2, 2)
    # A picture that is gone, or half a file, is no finished section.
    (tmp_path / "sections/waves/picture.png").unlink()
    (tmp_path / "sections/7.8/section.json").write_text('{"key": ')
    do(3, full=True)
    assert len(calls) == 6
    monkeypatch.setattr(sections_runner, "fingerprint", lambda _: "other code")
    do(3, full=True)
    assert len(calls) == 8

    write_report([], {}, tmp_path, sections=first)
    page, rows = (tmp_path / "report.md").read_text(), json.loads(
        (tmp_path / "report.json").read_text()
    )  # fmt: skip
    assert "![picture.png](sections/7.8/picture.png)" in page
    assert "| x | 1 | 1.2 [1, 2] | m | agrees |" in page
    assert rows[0]["quantity"] == "JONSWAP sampling (figure 3.4): x" and len(rows) == 2


def test_a_section_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "sections").write_text("")
    with pytest.raises(CampaignError, match=r"cannot write section 'waves' to .*same command"):
        run_sections(["waves"], tmp_path, executor=Here())


@pytest.mark.parametrize("name", ["waves", "7.1"])
def test_cheap_sections_draw_and_agree(tmp_path, name):
    outcome = SECTIONS[name].run(Job(tmp_path))
    assert all((tmp_path / f).stat().st_size > 20_000 for f in outcome.figures)
    # Lognormal law: at most 1.9 % off.
    assert all(f.verdict == "agrees" for f in outcome.findings)


def test_two_bodies_without_capytaine_draw_the_usv_alone(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "capytaine", None)
    outcome = SECTIONS["multibody"].run(Job(tmp_path))
    assert outcome.figures == ["usv_with_scout.png"] and not outcome.findings
    assert (tmp_path / "usv_with_scout.png").stat().st_size > 20_000
    assert 'pip install "marine-mj[bem]"' in outcome.text


def test_two_bodies_are_judged_by_their_gains_and_the_phase_of_pitch():
    """A Scout that heaves 0.1 less in waves below 2.5 s only; a USV whose pitch turns by 10 deg."""
    omega = 2 * np.pi / multibody._PERIODS
    own = np.zeros((len(omega), 6), dtype=complex)
    own[:, 0], own[:, 2], own[:, 4] = 0.5j, 0.8, -0.9j * wavenumber(omega)
    other = own.copy()
    other[multibody._PERIODS < 2.5, 2] -= 0.1
    found = multibody._scout_findings(1.0, own, other)
    differing = [f for f in found if f.verdict == "differs"]
    assert len(found) == 6 and len(differing) == 1
    assert "heave at 1 m" in differing[0].quantity and "below 2.5 s" in differing[0].quantity
    assert differing[0].ours == pytest.approx(0.1)
    other = own.copy()
    other[3, 4] *= 1.06 * np.exp(1j * np.deg2rad(10))
    pitch, phase = multibody._usv_findings(2.0, own, other)[-2:]
    assert pitch.ours == pytest.approx(0.06 * 0.9) and pitch.verdict == "differs"
    assert phase.ours == pytest.approx(10) and phase.verdict == "agrees"


@pytest.mark.parametrize("period", [0.1, 0.2])
def test_steady_deviations_of_the_filter_solve_the_riccati_equation(period):
    exact = riccati(PlanarNoise(fix_period=period))
    for ours, covariance in zip(steady(period), exact, strict=True):
        np.testing.assert_allclose(ours, np.sqrt(np.diag(covariance)), rtol=2e-3)  # measured: 5e-4


@pytest.mark.parametrize("scenario", ["base", "acceleration_worst", "period_0.04", "fix_worst"])
def test_surge_error_of_theory_is_that_of_the_filters(scenario):
    """300 pairs of resting bodies, 60 s each; the last 40 s count."""
    noise, shape = planar_scenario(scenario), (300,)
    body, still = RigidState.at_rest(shape), np.zeros((*shape, 6))
    navigator = PlanarNavigation.of(noise, 0.01)
    truth = Truth(body, body, still, still)
    state = navigator.initial(truth, np.arange(1, 301, dtype=np.uint64), shape)
    squares = []
    for step in range(6000):
        estimate = navigator.update(state, truth, step)
        state = estimate.state
        if step >= 2000 and step % 7 == 0:  # 7 does not divide the steps between two fixes
            x = (estimate.carrier.position - estimate.vehicle.position)[:, 0]
            squares.append(np.mean(x**2))
    found = np.sqrt(np.mean(squares))
    np.testing.assert_allclose(found, surge_error(noise), rtol=0.05)


def test_densities_are_those_of_the_fits():
    rng = np.random.default_rng(1)
    grid = np.linspace(-4, 4, 2001)
    normal = density(rng.normal(0.3, 0.5, 4000), "surge", grid)
    gamma = density(rng.gamma(4.0, 0.25, 4000), "energy", grid)
    for curve in (normal, gamma):
        assert np.trapezoid(curve, grid) == pytest.approx(1, abs=1e-3)
    # measured: 0.011 and 0.02 of the peak
    assert np.abs(normal - stats.norm.pdf(grid, 0.3, 0.5)).max() < 0.03 * normal.max()
    assert np.abs(gamma - stats.gamma.pdf(grid, 4, scale=0.25)).max() < 0.05 * gamma.max()


def test_waypoints_are_those_of_the_table():
    assert len(WAYPOINTS) == 22 and sum(w.still for w in WAYPOINTS) == 16
    assert WAYPOINTS[15].pose == pytest.approx((2, 5, 4 * np.pi))
    assert WAYPOINTS[-1].acceleration == (0.0, 0.0, 0.1)


def test_judgement_of_waypoints():
    time = np.linspace(0, 36, 361)
    still = Waypoint("a", (1.0, 2.0, 0.0))
    near, closing = np.full((361, 3), 0.05), np.zeros((361, 3))
    assert _judge("x", still, time, near, closing).ours == "reached"
    assert _judge("x", still, time, near + np.array([0.3, 0, 0]), closing).ours == "missed"
    # Swinging about the waypoint has a mean of zero but does not reach it.
    swing = np.stack([np.sin(9 * time), 0 * time, 0 * time], axis=1)
    assert _judge("x", still, time, swing, closing).verdict == "differs"
    moving = Waypoint("b", (0.0, 0.0, 0.0), (1.0, 0.0, 0.0))
    assert _judge("x", moving, time, near, closing).ours == "pursued"
    slow = closing + np.array([0.4, 0, 0])
    assert _judge("x", moving, time, near, slow).ours == "lost"
    # Faster than the Scout can turn: what it could do counts, until it is half a turn behind.
    turning = Waypoint("c", (0.0, 0.0, 0.0), (0.0, 0.0, 0.5))
    behind = np.stack([0 * time, 0 * time, 0.25 * time], axis=1)
    after = np.where((time < 12)[:, None], [0, 0, 0.1], [0, 0, 0.9])
    found = _judge("x", turning, time, behind, after)
    assert found.ours == "pursued" and "up to 12 s" in found.note
