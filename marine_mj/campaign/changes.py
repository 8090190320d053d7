"""What differs between a campaign as it was started and as it stands now."""

import tomllib
from pathlib import Path
from typing import Any

from marine_mj.campaign.settings import flat
from marine_mj.errors import CampaignError

#: Settings that decide no number.
_FREE = ("campaign.description", "campaign.scenario", "campaign.set", "campaign.runs")


def check_unchanged(
    before: dict[str, Any], now: dict[str, Any], folder: Path, extend: bool, hypercube: bool
) -> bool:
    """Whether the campaign is to be extended: only `runs` grew, and that is wanted.

    Args:
        before, now: manifests.
        folder: of the campaign, for the message.
        extend: whether a larger `runs` is wanted.
        hypercube: whether a factor is drawn from a Latin hypercube.

    Raises:
        CampaignError: something else changed, or `runs` did and this is not wanted or not
            possible; the message says what and how to go on.
    """
    changes = [
        f"{key}: {_shown(old)} -> {_shown(new)}"
        for key, old, new in _differences(_values(before), _values(now))
        if not key.startswith(_FREE)
    ]
    if before["code"] != now["code"]:
        what = [
            f"{name} {old} -> {now['versions'].get(name)}"
            for name, old in before["versions"].items()
            if now["versions"].get(name) != old
        ]
        changes.append(
            f"code: {', '.join(what) or 'sources or models'} ({before['code'][:12]} -> "
            f"{now['code'][:12]})"
        )
    old_runs, new_runs = before["campaign"]["runs"] or 0, now["campaign"]["runs"] or 0
    if changes or new_runs < old_runs:
        if new_runs != old_runs:
            changes.insert(0, f"campaign.runs: {old_runs} -> {new_runs}")
        raise CampaignError(
            f"the campaign in {str(folder)!r} was started with something else: "
            f"{'; '.join(changes)}. Its results stay as they are: undo the change, or start with "
            "a new --out"
        )
    if new_runs == old_runs:
        return False
    if hypercube:
        raise CampaignError(
            f"campaign.runs: {old_runs} -> {new_runs}, but a Latin hypercube is drawn for a "
            'number of runs: start with a new --out, or use sampling = "random"'
        )
    if not extend:
        raise CampaignError(
            f"campaign.runs: {old_runs} -> {new_runs} since the campaign in {str(folder)!r} was "
            "started: give --extend to add the new runs, or start with a new --out"
        )
    return True


def _values(manifest: dict[str, Any]) -> dict[str, Any]:
    """All settings of a manifest by dotted key."""
    return flat({"campaign": manifest["campaign"], "scenario": tomllib.loads(manifest["scenario"])})


def _differences(old: dict[str, Any], new: dict[str, Any]) -> list[tuple[str, Any, Any]]:
    """Keys whose values differ, with both."""
    keys = list(dict.fromkeys([*old, *new]))
    return [(k, old.get(k), new.get(k)) for k in keys if old.get(k) != new.get(k)]


def _shown(value: Any) -> str:
    return "nothing" if value is None else repr(value)
