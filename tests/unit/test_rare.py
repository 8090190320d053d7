"""Rare events against closed forms; states that go on bit for bit; refusals."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from marine_mj.analysis import (
    RareEventEstimate,
    SubsetState,
    crude_monte_carlo,
    multilevel_splitting,
    pool,
    subset_simulation,
    wilson_interval,
)
from marine_mj.errors import AnalysisError


def plane(u):
    """Linear limit state: P(score >= beta) = Phi(-beta) in any dimension."""
    return u.sum(axis=1) / np.sqrt(u.shape[1])


def repeated(score, d, threshold, runs, **options):
    """Probabilities and reported covs of independent repetitions."""
    found = [subset_simulation(score, d, threshold, seed=i, **options) for i in range(runs)]
    return found, np.array([e.probability for e in found]), np.array([e.cov for e in found])


@pytest.mark.parametrize(
    ("proposal", "d", "runs"),
    [  # measured: mean / p, scatter, reported cov, coverage
        ("elliptical", 2, 100),  # 0.944, 0.275, 0.269, 0.90; of 1500 runs 0.994 +- 0.007
        ("elliptical", 20, 100),  # 1.011, 0.264, 0.269, 0.98
        ("elliptical", 200, 50),  # 0.997, 0.264, 0.271, 0.96
        ("metropolis", 20, 100),  # 1.037, 0.335, 0.306, 0.94
    ],
)
def test_linear_limit_state(proposal, d, runs):
    exact = stats.norm.sf(3.5)  # 2.33e-4
    found, p, cov = repeated(plane, d, 3.5, runs, proposal=proposal)
    spread = p.std(ddof=1) / exact
    reported = np.sqrt((cov**2).mean())
    assert p.mean() == pytest.approx(exact, rel=4 * spread / np.sqrt(runs))
    # the scatter of a scatter: 4 / sqrt(2 runs), and the skewness of the lognormal on top
    assert reported == pytest.approx(spread, rel=0.35)
    ends = np.array([e.interval() for e in found])
    assert ((ends[:, 0] < exact) & (exact < ends[:, 1])).mean() >= 0.85
    assert found[0].evaluations == 3700


@pytest.mark.parametrize(
    ("score", "d", "threshold", "exact"),
    [
        # measured: mean / p, scatter, reported cov
        # sphere: |u|^2 is chi-squared; 4.5e-5: 0.983, 0.525, 0.431; 1.7e-5: 0.996, 0.514, 0.464
        (lambda u: (u**2).sum(axis=1), 2, 20.0, stats.chi2.sf(20, 2)),
        (lambda u: (u**2).sum(axis=1), 10, 40.0, stats.chi2.sf(40, 10)),
        # series system of four planes, two opposite pairs; 9.3e-4: 0.920, 0.355, 0.341
        (lambda u: np.abs(u[:, :2]).max(axis=1), 10, 3.5, 1 - (1 - 2 * stats.norm.sf(3.5)) ** 2),
        # limit state -g with threshold 0: parallel system, both of two; 1.8e-5: 0.983, 0.568, 0.488
        (lambda u: -np.maximum(2.63 - u[:, 0], 2.63 - u[:, 1]), 5, 0.0, stats.norm.sf(2.63) ** 2),
    ],
)  # fmt: skip
def test_other_limit_states(score, d, threshold, exact):
    runs = 60
    _, p, cov = repeated(score, d, threshold, runs, samples=500)
    spread = p.std(ddof=1) / exact
    assert p.mean() == pytest.approx(exact, rel=4 * spread / np.sqrt(runs))
    assert np.sqrt((cov**2).mean()) == pytest.approx(spread, rel=0.4)


def test_exceedance_curve_and_events():
    found = subset_simulation(plane, 5, 4.0, samples=4000)
    exact = stats.norm.sf(found.levels)
    assert (np.diff(found.levels) > 0).all() and found.levels[-1] == 4.0
    np.testing.assert_allclose(found.level_probabilities, exact, rtol=0.35)  # 0.076
    assert found.level_probabilities[-1] == found.probability
    assert len(found.events) and (plane(found.events) >= 4.0).all()


def test_frequent_event_is_a_plain_share():
    found = subset_simulation(plane, 3, 0.5, samples=1000)
    crude = crude_monte_carlo(plane, 3, 0.5, 1000)
    assert found.probability == crude.probability and found.counts == crude.counts
    assert found.cov == pytest.approx(crude.cov, rel=1e-12)
    assert found.interval() == wilson_interval(*crude.counts)
    assert crude.probability == pytest.approx(stats.norm.sf(0.5), abs=4 * 0.0146)  # 0.287


def test_yes_or_no_on_top_of_a_distance():
    """Scores with steps: ties fall with their level, and the estimate stays right."""
    score, exact = (lambda u: np.floor(2 * plane(u)) / 2), stats.norm.sf(3.5)
    _, p, _ = repeated(score, 8, 3.5, 60)  # mean / p = 1.031, scatter 0.379
    assert p.mean() == pytest.approx(exact, rel=4 * p.std() / exact / np.sqrt(60))


def test_crude_monte_carlo():
    found = crude_monte_carlo(plane, 4, 2.0, 20000, batch=700)
    assert found.probability == pytest.approx(stats.norm.sf(2.0), rel=4 * found.cov)  # 0.02225
    assert found.cov == pytest.approx(np.sqrt((1 - found.probability) / 20000 / found.probability))
    whole = crude_monte_carlo(plane, 4, 2.0, 20000, batch=20000)
    np.testing.assert_array_equal(whole.events, found.events)
    none = crude_monte_carlo(plane, 4, 9.0, 100)
    assert (none.probability, none.cov) == (0.0, np.inf)
    assert none.interval() == wilson_interval(0, 100)


def test_pool():
    found, p, cov = repeated(plane, 6, 3.5, 20, samples=500)
    together = pool(found)
    assert together.probability == pytest.approx(p.mean(), rel=1e-12)
    assert together.cov == pytest.approx(np.sqrt(((p * cov) ** 2).sum()) / p.sum(), rel=1e-12)
    assert together.evaluations == sum(e.evaluations for e in found)
    crude = pool([crude_monte_carlo(plane, 2, 1.0, n, seed=n) for n in (100, 300)])
    assert crude.counts[1] == 400 and crude.probability == crude.counts[0] / 400
    assert pool([RareEventEstimate(0.0, np.inf, 7)]).cov == np.inf


def test_goes_on_bit_for_bit(tmp_path):
    """A run that is killed between levels ends as one that is not."""
    path = tmp_path / "study.npz"
    whole = subset_simulation(plane, 7, 3.5, samples=200, seed=3)
    calls = []

    def dying(u):
        calls.append(len(u))
        if len(calls) == 10 + 9 + 4:  # the first level, the second, and half of the third
            raise KeyboardInterrupt
        return plane(u)

    with pytest.raises(KeyboardInterrupt):
        subset_simulation(dying, 7, 3.5, samples=200, seed=3, checkpoint=path)
    assert set(calls) == {20}
    kept = SubsetState.load(path)
    assert len(kept.levels) == 1 and kept.evaluations == 380
    rest = subset_simulation(plane, 7, 3.5, samples=200, seed=3, checkpoint=path)
    for name in ("probability", "cov", "evaluations"):
        assert getattr(rest, name) == getattr(whole, name)
    np.testing.assert_array_equal(rest.events, whole.events)
    assert [p.name for p in tmp_path.iterdir()] == ["study.npz"]
    # and once more from the finished state, without a single evaluation
    assert subset_simulation(dying, 7, 3.5, samples=200, seed=3, checkpoint=path).cov == whole.cov


def test_state_by_hand():
    state = SubsetState.start(plane, 4, 3.0, samples=100)
    while not state.finished:
        below = state.score.min()
        state = state.advance(plane)
        assert (state.score > state.levels[-1]).all() and state.score.min() > below
        np.testing.assert_array_equal(plane(state.u), state.score)
    assert state.estimate().probability == subset_simulation(plane, 4, 3.0, samples=100).probability
    assert 0 < state.acceptance.min() and state.acceptance.max() < 1


def test_infinite_scores_count():
    """Runs that diverge are the event, runs that never came close are -inf."""

    def score(u):
        x = plane(u)
        return np.where(x > 3, np.inf, np.where(x < 0, -np.inf, x))

    _, p, _ = repeated(score, 3, 1e9, 40, samples=400)  # mean / p = 0.903, scatter 0.364
    assert p.mean() == pytest.approx(stats.norm.sf(3), rel=4 * p.std() / p.mean() / np.sqrt(40))


def walk(states, rng):
    """Simple symmetric random walk."""
    states = states + 2 * rng.integers(0, 2, states.shape) - 1
    return states, states[:, 0]


WALK_LEVELS = [14, 22, 28, 34, 40]


def test_splitting_of_a_random_walk():
    """P(max S >= b) = P(S_n >= b) + P(S_n > b), reflection principle."""
    n, b, runs = 100, 40, 100
    exact = stats.binom.sf((n + b) // 2 - 1, n, 0.5) + stats.binom.sf((n + b) // 2, n, 0.5)
    found = [multilevel_splitting(walk, np.zeros((1, 1), int), WALK_LEVELS, n, samples=300, seed=i)
             for i in range(runs)]  # fmt: skip
    p, cov = (np.array([getattr(e, a) for e in found]) for a in ("probability", "cov"))
    spread = p.std() / exact
    # 5.53e-5: mean / p = 1.039, scatter 0.621, reported 0.552; of 1500 runs 0.989 +- 0.020
    assert p.mean() == pytest.approx(exact, rel=4 * spread / np.sqrt(runs))
    assert np.sqrt((cov[p > 0] ** 2).mean()) == pytest.approx(spread, rel=0.4)
    assert all((e.events[:, 0] == b).all() for e in found)


def test_splitting_of_brownian_motion():
    """P(max B >= b) = 2 Phi(-b / sqrt T), with the exact maximum of the bridge in each step."""
    dt, steps, b = 0.05, 20, 4.0

    def advance(x, rng):
        new = x + np.sqrt(dt) * rng.standard_normal(x.shape)
        log = np.log(rng.uniform(size=x.shape))
        highest = 0.5 * (x + new + np.sqrt((new - x) ** 2 - 2 * dt * log))
        return new, highest[:, 0]

    exact = 2 * stats.norm.sf(b)  # 6.33e-5; 6.12e-5, cov 0.073
    levels = [1.2, 2.0, 2.7, 3.4, b]
    found = pool([multilevel_splitting(advance, np.zeros((3, 1)), levels, steps, seed=i)
                  for i in range(30)])  # fmt: skip
    assert found.probability == pytest.approx(exact, rel=4 * found.cov)


def test_splitting_of_an_ornstein_uhlenbeck_process():
    """Largest of 40 correlated values, against the recursion of its density by quadrature."""
    a, steps, b = 0.8, 40, 4.0
    noise = np.sqrt(1 - a**2)
    x, w = np.polynomial.legendre.leggauss(200)
    lowest = -7.0
    x, w = 0.5 * (b - lowest) * (x + 1) + lowest, 0.5 * (b - lowest) * w
    kernel = stats.norm.pdf((x[:, None] - a * x) / noise) / noise  # from x_j to x_i
    survived = stats.norm.pdf(x / noise) / noise  # after one step from 0
    for _ in range(steps - 1):
        survived = kernel @ (w * survived)
    exact = 1 - w @ survived  # 8.902e-4 (same with 300 nodes); 8.15e-4, cov 0.082

    def advance(state, rng):
        state = a * state + noise * rng.standard_normal(state.shape)
        return state, state[:, 0]

    found = pool([multilevel_splitting(advance, [[0.0]], [2, 3, 3.6, b], steps, seed=i)
                  for i in range(20)])  # fmt: skip
    assert found.probability == pytest.approx(exact, rel=4 * found.cov)


def test_splitting_repeats_and_gives_up():
    one, two = (multilevel_splitting(walk, [[0]], WALK_LEVELS, 100, seed=8) for _ in range(2))
    assert (one.probability, one.cov, one.evaluations) == (two.probability, two.cov,
                                                           two.evaluations)  # fmt: skip
    never = multilevel_splitting(walk, [[0]], [5, 200], 50, samples=20)
    assert (never.probability, never.cov, len(never.events)) == (0.0, np.inf, 0)
    share = multilevel_splitting(walk, [[0]], [5], 50, samples=50)
    assert share.counts is not None and share.interval() == wilson_interval(*share.counts)
    n = share.counts[0]
    assert share.cov**2 == pytest.approx((1 - n / 50) / n * 50 / 49, rel=1e-9)


def other_seed(path):
    """Checkpoint of another seed."""
    SubsetState.start(plane, 2, 1.0, samples=20, seed=1).save(path)
    subset_simulation(plane, 2, 1.0, samples=20, seed=2, checkpoint=path)


def no_state(path):
    """A file that is something else."""
    path.write_text("x")
    SubsetState.load(path)


def start(**options):
    """State with few samples."""
    return SubsetState.start(**{"score": plane, "dimension": 2, "threshold": 5.0, "samples": 20}
                             | options)  # fmt: skip


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda _: start(p0=0.15), "p0 is 0.15 with samples 20, allowed are 1/p0 whole"),
        (lambda _: start(samples=10), "p0 is 0.1 with samples 10, allowed are 1/p0 whole"),
        (lambda _: start(dimension=0), "dimension is 0, allowed are whole numbers >= 1: count"),
        (lambda _: start(threshold=np.nan), "threshold is nan, allowed are finite numbers"),
        (lambda _: start(seed=None), "seed is None, allowed are whole numbers >= 0: give one"),
        (lambda _: start(proposal="x"), "proposal is 'x', allowed are elliptical, metropolis"),
        (lambda _: start(score=lambda u: u), "score gave the shape (2, 2), allowed is (2,)"),
        (lambda _: start(score=lambda u: u[:, 0] * np.nan), "score is NaN for 2 of 2 inputs"),
        (lambda _: start().estimate(), "call advance"),
        (lambda _: start(threshold=-9.0).advance(plane), "reached after 0 levels, allowed are"),
        (lambda _: start(score=lambda u: 0 * u[:, 0]).advance(plane),
         "score is 0 for the best 20 of 20 samples, allowed is a score that grows"),
        (lambda _: subset_simulation(lambda u: np.tanh(plane(u)), 2, 1.5, samples=40, p0=0.5),
         "after 30 levels, allowed is the threshold 1.5: the event is impossible or rarer than"),
        (other_seed, "seed is 2, allowed is 1 as in"),
        (no_state, "is not a saved subset simulation ("),
        (lambda _: crude_monte_carlo(plane, 2, 1.0, 0), "samples is 0, allowed are whole numbers"),
        (lambda _: pool([]), "estimates is empty, allowed is one or more"),
        (lambda _: replace(start(threshold=-9.0).estimate(), counts=None).interval(2),
         "confidence is 2, allowed is > 0 and < 1"),
        (lambda _: multilevel_splitting(walk, np.zeros((0, 1)), [1], 5), "initial has shape (0,"),
        (lambda _: multilevel_splitting(walk, [[0]], [2, 1], 5), "allowed are ascending values"),
        (lambda _: multilevel_splitting(walk, [[0]], [1], 0), "steps is 0, allowed are whole"),
        (lambda _: multilevel_splitting(lambda s, r: (s, s), [[0]], [1], 5),
         "advance gave states (1000, 1) and scores (1000, 1), allowed are (1000, 1) and (1000,)"),
        (lambda _: multilevel_splitting(lambda s, r: (s, s[:, 0] * np.nan), [[0.0]], [1], 5),
         "advance gave 1000 NaN scores of 1000"),
    ],
)  # fmt: skip
def test_refusals(call, message, tmp_path):
    with pytest.raises(AnalysisError, match=re.escape(message)):
        call(tmp_path / "state.npz")


def test_missing_file(tmp_path):
    with pytest.raises(FileNotFoundError):
        SubsetState.load(tmp_path / "none.npz")


def test_failed_save_keeps_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "state.npz"
    start().save(path)
    before = path.read_bytes()

    def full(*_args, **_kwargs):
        raise OSError("disk full")

    monkeypatch.setattr(np, "savez", full)
    with pytest.raises(OSError, match="disk full"):
        start(seed=1).save(path)
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["state.npz"]
