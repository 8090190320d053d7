"""What the searches of a campaign have found so far, from the states in its folder."""

from dataclasses import dataclass, replace

import numpy as np

from marine_mj.analysis import RareEventEstimate, SubsetState, pool
from marine_mj.campaign.folder import CampaignFolder
from marine_mj.campaign.plan import Plan
from marine_mj.campaign.search import search_name, searches
from marine_mj.frames import Array


@dataclass(frozen=True)
class Search:
    """One search for a rare event.

    Attributes:
        cell, repetition: which one.
        state: after its last finished level.
        estimate: of the probability; None as long as the event was not reached.
        metrics: (j,) values of the metric at the levels passed; the threshold last once reached.
        probabilities: (j,) that a run is beyond each.
    """

    cell: int
    repetition: int
    state: SubsetState
    estimate: RareEventEstimate | None
    metrics: Array
    probabilities: Array


def read_searches(plan: Plan, place: CampaignFolder) -> list[Search]:
    """The searches that have finished a level, in the order in which they are done."""
    rare = plan.campaign.rare
    assert rare is not None
    found = []
    levels: Array
    passed: Array
    for cell, repetition in searches(plan):
        state = place.read_state(search_name(cell, repetition))
        if state is None:
            continue
        estimate = state.estimate() if state.finished else None
        levels, passed = state.levels, np.cumprod(state.factors, dtype=np.float64)
        if estimate is not None:
            levels, passed = estimate.levels, estimate.level_probabilities
        found.append(Search(cell, repetition, state, estimate, rare.sign * levels, passed))
    return found


def pooled(searches: list[Search]) -> RareEventEstimate | None:
    """Estimate of a cell from its repetitions; None if one has not reached the event.

    Its coefficient of variation is the larger of what the repetitions know of themselves
    (`marine_mj.analysis.pool`) and of their scatter, `s / (mean sqrt(R))`: the seed of a
    repetition draws what is not searched (wave directions, gusts, navigation).
    """
    estimates = [s.estimate for s in searches if s.estimate is not None]
    if not estimates or len(estimates) < len(searches):
        return None
    whole = pool(estimates)
    if len(estimates) == 1 or whole.counts is not None or not whole.probability:
        return whole
    p = np.array([e.probability for e in estimates])
    scatter = float(p.std(ddof=1) / (p.mean() * np.sqrt(len(p))))
    return replace(whole, cov=max(whole.cov, scatter))


def at_most(searches: list[Search]) -> float:
    """Mean over the repetitions of the probability at the last level: what is known so far."""
    last = [s.probabilities[-1] if len(s.probabilities) else 1.0 for s in searches]
    return float(np.mean(last)) if last else 1.0
