"""Probabilities of rare events: the estimate, crude Monte Carlo, pooling of repetitions.

An event is `score(u) >= threshold` for a vector u of d independent standard normals: the score is
a load, a distance beyond a limit, a peak. A limit state function g with failure at g <= 0 is the
score -g with threshold 0.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from marine_mj.analysis import _checks as check
from marine_mj.analysis.proportions import wilson_interval
from marine_mj.errors import AnalysisError
from marine_mj.frames import Array

#: Score (n,) of the rows of u (n, d), higher is closer to the event; +-inf is allowed, NaN is not.
Score = Callable[[Array], ArrayLike]


@dataclass(frozen=True, eq=False)
class RareEventEstimate:
    """Probability of a rare event and how well it is known.

    Attributes:
        probability: estimate; 0 if no event was seen.
        cov: its coefficient of variation, standard deviation / probability; inf for 0.
        evaluations: scores evaluated (steps of one trajectory, for `multilevel_splitting`).
        levels: (j,) ascending score levels passed on the way, the threshold last.
        level_probabilities: (j,) probability of each level: an exceedance curve of the score.
        events: (m, ...) the inputs or states that made the event, for a closer look.
        counts: (events, runs) if the estimate is a plain share, else None.
    """

    probability: float
    cov: float
    evaluations: int
    levels: Array = field(default_factory=lambda: np.empty(0))
    level_probabilities: Array = field(default_factory=lambda: np.empty(0))
    events: Array = field(default_factory=lambda: np.empty((0, 0)))
    counts: tuple[int, int] | None = None

    def interval(self, confidence: float = 0.95) -> tuple[float, float]:
        """(low, high) of the probability: Wilson for a plain share, else lognormal with `cov`.

        Raises:
            AnalysisError: confidence outside (0, 1).
        """
        if self.counts is not None:
            return wilson_interval(*self.counts, confidence)
        z = special.ndtri(0.5 * (1 + check.level("confidence", confidence)))
        spread = float(np.exp(z * np.sqrt(np.log1p(self.cov**2))))
        return self.probability / spread, min(self.probability * spread, 1.0)


def crude_monte_carlo(
    score: Score,
    dimension: int,
    threshold: float,
    samples: int,
    *,
    batch: int = 1000,
    seed: check.Seed = 0,
) -> RareEventEstimate:
    """Share of `samples` independent inputs that make the event; cov = sqrt((1 - p) / (n p)).

    For 10 % of cov it takes 100 / p samples. The result does not depend on `batch`.

    Args:
        score: (n,) scores of (n, dimension) standard normals.
        dimension: d, >= 1.
        threshold: the event is score >= threshold; finite.
        samples: n, >= 1.
        batch: rows given to `score` at a time, >= 1; the last call gets what is left.
        seed: integer >= 0 or Generator.

    Raises:
        AnalysisError: an argument is out of range, or `score` gives NaN or a wrong shape.
    """
    d = check.whole("dimension", dimension, 1, "count the standard normals of one run")
    n = check.whole("samples", samples, 1, "100 / p give 10 % accuracy")
    step = check.whole("batch", batch, 1, "give the rows of one call")
    threshold = check_threshold(threshold)
    rng = check.generator(seed)
    events = []
    for start in range(0, n, step):
        u = rng.standard_normal((min(step, n - start), d))
        events.append(u[evaluate(score, u) >= threshold])
    found = np.concatenate(events)
    p = len(found) / n
    return RareEventEstimate(
        p,
        float(np.sqrt((1 - p) / (n * p))) if p else np.inf,
        n,
        np.array([threshold]),
        np.array([p]),
        found,
        (len(found), n),
    )


def pool(estimates: Sequence[RareEventEstimate]) -> RareEventEstimate:
    """Mean of independent repetitions (other seeds, equal settings) as one estimate.

    `cov^2 = sum (p_i cov_i)^2 / (sum p_i)^2`. Plain shares are added up instead.

    Raises:
        AnalysisError: there is none.
    """
    if not estimates:
        raise AnalysisError("estimates is empty, allowed is one or more: run something")
    evaluations = sum(e.evaluations for e in estimates)
    events = np.concatenate([e.events for e in estimates])
    p = np.array([e.probability for e in estimates])
    counts = [e.counts for e in estimates if e.counts is not None]
    if len(counts) == len(estimates):
        found, n = (sum(c) for c in zip(*counts, strict=True))
        share = found / n
        cov = float(np.sqrt((1 - share) / (n * share))) if found else np.inf
        return RareEventEstimate(share, cov, evaluations, events=events, counts=(found, n))
    if not p.any():
        return RareEventEstimate(0.0, np.inf, evaluations, events=events)
    variance = sum((e.probability * e.cov) ** 2 for e in estimates if e.probability)
    cov = float(np.sqrt(variance) / p.sum())
    return RareEventEstimate(float(p.mean()), cov, evaluations, events=events)


def check_threshold(threshold: Any) -> float:
    """The threshold as a finite float."""
    value = float(threshold)
    if not np.isfinite(value):
        raise AnalysisError(f"threshold is {value}, allowed are finite numbers: give the limit")
    return value


def evaluate(score: Score, u: Array) -> Array:
    """Scores (n,) of the rows of u, checked."""
    values = np.asarray(score(u), dtype=float)
    if values.shape != (len(u),):
        raise AnalysisError(
            f"score gave the shape {values.shape}, allowed is ({len(u)},): one number for each row"
        )
    bad = int(np.isnan(values).sum())
    if bad:
        raise AnalysisError(
            f"score is NaN for {bad} of {len(u)} inputs, allowed are numbers, +inf and -inf: "
            "give a diverged run +inf if it counts as a failure"
        )
    return values
