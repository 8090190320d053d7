"""Rare events of a campaign: what is searched for, and how close a run came to it."""

import math
from typing import Annotated, Literal

from pydantic import Field, model_validator

from marine_mj.settings import Settings

#: Columns that the rows of a search have besides those of other campaigns.
COLUMNS = ("level", "score", "distance")


class Rare(Settings):
    """Search for the probability of a rare event by subset simulation (Au, Beck 2001).

    The event is a run whose metric is beyond the threshold, or that is no success: it ended with
    an error or a condition of `success` does not hold.

    Attributes:
        metric: name of a metric, or dotted key of the results.
        threshold: in the metric's unit.
        side: which values are the event: "above" (>= threshold) or "below" (<= threshold).
        samples: runs of the first level, a multiple of 1/p0; each further one takes
            (1 - p0) samples.
        p0: share of runs that goes on to the next level, 1 / whole number.
        proposal: of the Markov chains, see `marine_mj.analysis.subset_simulation`.
        most_levels: levels after which a search gives up.
        repetitions: independent searches of each cell, pooled.
        sea: whether to search in the space of seas too: every run gets its own standard normals
            (`sea.normals`). Otherwise all runs of a repetition have the sea of its seed.
        missing: what a run without a value of the metric (no capture) is: "event" or "safe".
    """

    metric: str
    threshold: float
    side: Literal["above", "below"] = "above"
    samples: Annotated[int, Field(ge=2)] = 500
    p0: Annotated[float, Field(gt=0, le=0.5)] = 0.1
    proposal: Literal["elliptical", "metropolis"] = "elliptical"
    most_levels: Annotated[int, Field(ge=1, le=30)] = 10
    repetitions: Annotated[int, Field(ge=1)] = 1
    sea: bool = False
    missing: Literal["event", "safe"] = "event"

    @model_validator(mode="after")
    def _levels_fit(self) -> "Rare":
        """Refuse levels that do not divide into chains of equal length."""
        length = round(1 / self.p0)
        chains = round(self.samples * self.p0)
        if abs(self.p0 * length - 1) > 1e-9 or chains * length != self.samples or chains < 2:
            raise ValueError(
                f"p0 = {self.p0:g} with samples = {self.samples}: allowed are 1/p0 whole and "
                "samples a multiple of it, twice or more; 0.1 with 500 is usual"
            )
        return self

    @property
    def sign(self) -> float:
        """Factor from the metric to the score, which grows towards the event."""
        return 1.0 if self.side == "above" else -1.0

    def score(self, success: bool, value: float | None) -> float:
        """How close a run came to the event: `sign * metric`; inf for a run without success.

        Args:
            success: of the run.
            value: its metric; None if it has none.
        """
        if not success:
            return math.inf
        if value is None:
            return math.inf if self.missing == "event" else -math.inf
        return self.sign * value
