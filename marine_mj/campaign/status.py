"""How far a campaign is, from its files alone."""

import json
from dataclasses import dataclass, field
from pathlib import Path

from marine_mj.analysis.statistics import wilson_interval
from marine_mj.campaign.chunks import Progress, count
from marine_mj.campaign.folder import CampaignFolder
from marine_mj.campaign.levels import Search, read_searches
from marine_mj.campaign.runner import load_plan


@dataclass(frozen=True)
class Status:
    """State of a campaign.

    Attributes:
        name: of the campaign.
        state: what it does or why it does nothing, in words.
        progress: finished runs.
        interval: Wilson interval of the success probability over all finished runs, 95 %, (0, 1)
            without any; runs of a search are no fair sample, so that it says nothing there.
        searches: of a search for rare events, those that have finished a level.
    """

    name: str
    state: str
    progress: Progress
    interval: tuple[float, float]
    searches: list[Search] = field(default_factory=list)


def status(folder: str | Path) -> Status:
    """State of the campaign in a folder; a running campaign is not disturbed.

    Raises:
        CampaignError: there is none.
    """
    place = CampaignFolder(folder)
    plan = load_plan(folder)
    holder = place.locked()
    progress = count(place, plan.total)
    done = progress.done
    interval = wilson_interval(progress.successes, done) if done else (0.0, 1.0)
    searches = [] if plan.campaign.rare is None else read_searches(plan, place)
    state = _state(place, holder, progress)
    return Status(plan.campaign.name, state, progress, interval, searches)


def _state(place: CampaignFolder, holder: str | None, progress: Progress) -> str:
    """The state in words."""
    if holder is not None:
        return f"running, {holder}"
    file = place.path / "state.json"
    if file.is_file():
        about = json.loads(file.read_text(encoding="utf-8"))
        if about["stopped"]:
            stop = about["stopped"]
            return f"stopped by its rule: {stop['metric']} known within {stop['width']:.4g}"
        # The total of a search is not known before; it says itself when it is over.
        if about["runs"] == (progress.total or progress.done):
            return "complete"
    return "interrupted: go on with `marine-mj campaign resume`"
