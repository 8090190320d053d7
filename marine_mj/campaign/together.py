"""Campaigns whose runs share batches: many small ones cost little more than their runs."""

import contextlib
import itertools
from collections.abc import Iterator, Mapping
from pathlib import Path

from marine_mj.campaign.folder import CampaignFolder
from marine_mj.campaign.plan import Plan
from marine_mj.campaign.runner import CampaignState, started
from marine_mj.campaign.worker import Work, do_together
from marine_mj.errors import CampaignError
from marine_mj.simulation.batch import BLOCK

#: A campaign, the first run of a chunk of it, and that chunk.
_Job = tuple[CampaignState, int, Work]


def run_together(campaigns: Mapping[Path, Plan], *, extend: bool = False) -> None:
    """Do what is missing in several campaigns, in common batches, in this process.

    A batch has a cost of its own per control period, however few runs are in it; campaigns whose
    scenarios are alike (`run_batch`) share it. Folders and results are those of `run_campaign`, bit
    for bit: a campaign that is there already goes on, and may later be run alone or with others.

    Args:
        campaigns: plans by folder.
        extend: allow that `runs` of a campaign that is there grew.

    Raises:
        CampaignError: a campaign searches for rare events, stops by a rule or records signals; or
            one of the reasons of `run_campaign`.
        ScenarioError, ModelError: see `run_campaign`.
    """
    for path, plan in campaigns.items():
        asked = plan.campaign
        if asked.rare is not None or asked.stopping is not None or asked.record.signals:
            raise CampaignError(
                f"the campaign for {str(path)!r} has rare, stopping or record.signals, which do "
                "not go together with other campaigns: leave it out, or use run_campaign"
            )
    with contextlib.ExitStack() as stack:
        states = []
        for path, plan in campaigns.items():
            place = CampaignFolder(path)
            totals = stack.enter_context(started(plan, place, place.exists, extend))
            states.append(CampaignState(plan, place, totals))
        for batch in _batches(states):
            for (state, first, _), done in zip(
                batch, do_together([work for *_, work in batch]), strict=True
            ):
                state.take(first, done)
        for state in states:
            state.close()


def _batches(states: list[CampaignState]) -> Iterator[list[_Job]]:
    """Missing chunks of all campaigns, a first one of each, then a second one of each, ..."""
    waiting: list[_Job] = []
    rounds = itertools.zip_longest(*map(_jobs, states))
    for job in itertools.chain.from_iterable(rounds):
        if job is None:
            continue
        if waiting and sum(len(w.variations) for *_, w in [*waiting, job]) > BLOCK:
            yield waiting
            waiting = []
        waiting.append(job)
    if waiting:
        yield waiting


def _jobs(state: CampaignState) -> Iterator[_Job]:
    """Missing chunks of a campaign."""
    for first, work in state.missing():
        yield state, first, work
