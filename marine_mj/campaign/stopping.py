"""Stopping when the answer is sharp enough, at a run that no timing can change."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

from scipy import stats

from marine_mj.analysis.statistics import wilson_interval
from marine_mj.campaign.settings import Campaign


@dataclass
class Estimate:
    """Running mean and spread of one cell (Welford 1962), in the order of the runs."""

    n: int = 0
    mean: float = 0.0
    squares: float = 0.0
    ones: int = 0
    proportion: bool = True

    def add(self, value: float) -> None:
        """Take in one value; NaN is none."""
        if math.isnan(value):
            return
        self.n += 1
        delta = value - self.mean
        self.mean += delta / self.n
        self.squares += delta * (value - self.mean)
        self.ones += value == 1.0
        self.proportion &= value in (0.0, 1.0)

    def interval(self, confidence: float) -> tuple[float, float]:
        """Wilson interval as long as all values are 0 or 1, else Student's for the mean."""
        if self.proportion:
            return wilson_interval(self.ones, self.n, confidence)
        if self.n < 2:
            return -math.inf, math.inf
        spread = math.sqrt(self.squares / (self.n - 1) / self.n)
        half = float(stats.t.ppf(0.5 + confidence / 2, self.n - 1)) * spread
        return self.mean - half, self.mean + half


class StoppingMonitor:
    """Watches finished chunks, which may come in any order, and looks at them in run order.

    Attributes:
        stopped_at: number of runs after which the rule was fulfilled; None: not yet.
    """

    def __init__(self, campaign: Campaign, cells: int) -> None:
        self.rule = campaign.stopping
        self.stopped_at: int | None = None
        self._every = campaign.chunk
        if self.rule is not None:
            self._every = self.rule.every or campaign.chunk
        self._waiting: dict[int, list[tuple[int, float]]] = {}
        self._next = 0
        self._cells = [Estimate() for _ in range(cells)]

    def add(self, first: int, values: Iterable[tuple[int, float]]) -> None:
        """Take in a finished chunk.

        Args:
            first: number of its first run.
            values: cell and value (NaN: none) of each of its runs, in order.
        """
        if self.rule is None or self.stopped_at is not None:
            return
        self._waiting[first] = list(values)
        while self.stopped_at is None and self._next in self._waiting:
            for cell, value in self._waiting.pop(self._next):
                self._cells[cell].add(value)
                self._next += 1
            if self._next % self._every == 0 and self._narrow():
                self.stopped_at = self._next
                self._waiting.clear()

    def _narrow(self) -> bool:
        """Whether every cell's interval is as narrow as asked."""
        assert self.rule is not None
        return self.width() <= self.rule.width and all(
            cell.n >= self.rule.minimum for cell in self._cells
        )

    def width(self) -> float:
        """Widest interval over the cells."""
        assert self.rule is not None
        ends = [cell.interval(self.rule.confidence) for cell in self._cells]
        return max(high - low for low, high in ends)
