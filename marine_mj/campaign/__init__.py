"""Campaigns: Monte Carlo studies and sweeps as files that survive being killed."""

from marine_mj.campaign.plan import Plan
from marine_mj.campaign.runner import Progress, evaluate, load_plan, run_campaign
from marine_mj.campaign.settings import Campaign, packaged_campaigns

__all__ = [
    "Campaign",
    "Plan",
    "Progress",
    "evaluate",
    "load_plan",
    "packaged_campaigns",
    "run_campaign",
]
