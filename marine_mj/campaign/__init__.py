"""Campaigns: Monte Carlo studies and sweeps as files that survive being killed."""

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from marine_mj.campaign.chunks import Progress
    from marine_mj.campaign.plan import Plan
    from marine_mj.campaign.runner import evaluate, load_plan, run_campaign
    from marine_mj.campaign.settings import Campaign
    from marine_mj.campaign.together import run_together

_HOME = {
    "Campaign": "settings",
    "Plan": "plan",
    "Progress": "chunks",
    "evaluate": "runner",
    "load_plan": "runner",
    "run_campaign": "runner",
    "run_together": "together",
}

__all__ = [
    "Campaign",
    "Plan",
    "Progress",
    "evaluate",
    "load_plan",
    "run_campaign",
    "run_together",
]


def __getattr__(name: str) -> Any:
    """A public name, imported when it is first used: workers need none of the planning."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)
