"""Effects of factors on the results."""

from typing import Any

import numpy as np
import pandas as pd
from scipy import stats

from marine_mj.campaign.settings import Campaign


def effects(campaign: Campaign, data: pd.DataFrame) -> list[dict[str, Any]]:
    """One entry per factor and output (`success` and the metrics).

    Crossed factors and choices: mean of the output at each level, its main effect (level mean minus
    grand mean) and `share`, the part of the output's variance that the levels explain (correlation
    ratio eta^2 = SS_between / SS_total, Fisher 1925). Factors with numbers drawn from a
    distribution: Spearman's rank correlation with its p-value.

    Args:
        campaign: settings.
        data: finished runs.
    """
    found = []
    for name, factor in campaign.factors.items():
        for output in ("success", *campaign.metrics):
            part = data[[name, output]].dropna()
            x, y = part[name], part[output].to_numpy(float)
            entry: dict[str, Any] = {"factor": name, "output": output, "n": len(part)}
            if factor.crossed or factor.distribution == "choice":
                entry |= _levels(x, y)
            else:
                entry |= _rank(x.to_numpy(float), y)
            found.append(entry)
    return found


def _levels(x: pd.Series, y: np.ndarray) -> dict[str, Any]:
    """Main effects of levels."""
    if not len(y):
        return {"levels": [], "share": None}
    levels, between, grand = [], 0.0, float(y.mean())
    for level in pd.unique(x):
        part = y[(x == level).to_numpy()]
        mean = float(part.mean())
        between += len(part) * (mean - grand) ** 2
        plain = level.item() if isinstance(level, np.generic) else level
        levels.append({"level": plain, "n": len(part), "mean": mean, "effect": mean - grand})
    total = float(((y - grand) ** 2).sum())
    return {"levels": levels, "share": between / total if np.ptp(y) > 0 else None}


def _rank(x: np.ndarray, y: np.ndarray) -> dict[str, Any]:
    """Rank correlation; None where one side does not vary."""
    if len(y) < 3 or np.ptp(x) == 0 or np.ptp(y) == 0:
        return {"correlation": None, "p_value": None}
    result = stats.spearmanr(x, y)
    return {"correlation": float(result.statistic), "p_value": float(result.pvalue)}
