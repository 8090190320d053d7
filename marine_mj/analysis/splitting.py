"""Importance splitting in time: rare events of Markov simulations that can be restarted."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from marine_mj.analysis import _checks as check
from marine_mj.analysis.rare import RareEventEstimate
from marine_mj.errors import AnalysisError
from marine_mj.frames import Array

#: One step of m trajectories: (states (m, ...), generator) -> (new states, scores (m,)).
Advance = Callable[[Array, np.random.Generator], tuple[Array, ArrayLike]]


def multilevel_splitting(
    advance: Advance,
    initial: ArrayLike,
    levels: ArrayLike,
    steps: int,
    *,
    samples: int = 1000,
    seed: int = 0,
) -> RareEventEstimate:
    """Probability that a score reaches `levels[-1]` within `steps` steps of a random process.

    Fixed-effort splitting (Garvels 2000): `samples` trajectories run from the start until they
    reach the first level or the time is over; those that reach it leave their state and time, from
    which `samples` new trajectories are drawn with replacement, and so on. The product of the
    shares is unbiased for any levels; it is accurate with shares of 0.1 to 0.5 and a score that
    tells how likely the event has become. cov comes from the family trees (Lee, Whiteley 2018):
    `cov^2 = 1 - (n / (n - 1))^J (1 - sum (n_i / N)^2)`, with n_i of the N events descending from
    trajectory i of the first of J levels.

    The process has to be Markov in its state, and a step must draw all its randomness from the
    generator: gusts and noise split, a sea drawn once at the start does not (its randomness is
    used up: search seas with `subset_simulation`). Time, where it matters, is part of the state.

    Args:
        advance: one step of m trajectories, `(states (m, ...), rng) -> (states, scores (m,))`. The
            score is that of the step (its end, or the largest within it); m varies, trajectories
            that are over are left out.
        initial: (k, ...) start states; each trajectory starts from one of them, taken in turn.
        levels: (J,) ascending scores, the event last.
        steps: number of steps of a trajectory, >= 1.
        samples: n, trajectories of each level, >= 2.
        seed: integer >= 0; level j draws from a generator seeded by (seed, j).

    Returns:
        estimate with probability 0 if a level was never reached; `events` are the states at which
        the event was reached, `evaluations` counts the steps of single trajectories.

    Raises:
        AnalysisError: an argument is out of range, or `advance` gives wrong shapes or NaN scores.
    """
    states = np.array(initial)
    if states.ndim < 1 or len(states) == 0:
        raise AnalysisError(
            f"initial has shape {states.shape}, allowed is (k, ...) with k >= 1: one row a state"
        )
    bounds = check.sample("levels", levels, 1, ndim=1)
    if (np.diff(bounds) <= 0).any():
        raise AnalysisError(f"levels are {bounds}, allowed are ascending values: sort them")
    steps = check.whole("steps", steps, 1, "give the length of a trajectory")
    n = check.whole("samples", samples, 2, "1000 is a good start")
    seed = check.whole("seed", seed, 0, "give one, so that the result can be repeated")

    states = states[np.arange(n) % len(states)]
    left = np.full(n, steps)
    score = np.full(n, -np.inf)  # of the last step
    ancestor = np.arange(n)
    shares: list[float] = []
    evaluations = 0
    for j, bound in enumerate(bounds):
        rng = np.random.default_rng([seed, j])
        if j:
            pick = rng.integers(len(states), size=n)
            states, left, score, ancestor = states[pick], left[pick], score[pick], ancestor[pick]
        states = states.copy()
        while True:
            running = np.flatnonzero((score < bound) & (left > 0))
            if not len(running):
                break
            after = advance(states[running], rng)
            states[running], score[running] = _checked(*after, states[running].shape)
            left[running] -= 1
            evaluations += len(running)
        hit = score >= bound
        shares.append(float(hit.mean()))
        states, left, score, ancestor = states[hit], left[hit], score[hit], ancestor[hit]
        if not len(states):
            break
    probabilities = np.zeros(len(bounds))
    probabilities[: len(shares)] = np.cumprod(shares)
    p = float(probabilities[-1])
    cov = np.inf
    if p:
        tree = 1 - ((np.bincount(ancestor) / len(ancestor)) ** 2).sum()
        cov = float(np.sqrt(max(1 - (n / (n - 1)) ** len(bounds) * tree, 0.0)))
    counts = (len(states), n) if len(bounds) == 1 else None
    return RareEventEstimate(p, cov, evaluations, bounds, probabilities, states, counts)


def _checked(new: Array, score: ArrayLike, shape: tuple[int, ...]) -> tuple[Array, Array]:
    """New states and scores of one step."""
    new, values = np.asarray(new), np.asarray(score, dtype=float)
    if new.shape != shape or values.shape != shape[:1]:
        raise AnalysisError(
            f"advance gave states {new.shape} and scores {values.shape}, allowed are {shape} and "
            f"{shape[:1]}: one row and one number for each trajectory"
        )
    if np.isnan(values).any():
        raise AnalysisError(
            f"advance gave {int(np.isnan(values).sum())} NaN scores of {len(values)}, allowed are "
            "numbers, +inf and -inf: give a diverged run +inf if it counts as the event"
        )
    return new, values
