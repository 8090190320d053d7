"""Whether a dock works at a sea state: entry distributions, limits, uptime (docking digest 6, 7.0).

A docking run gives the surge error (m), pitch error (rad) and relative kinetic energy (J) at which
the vehicle crossed the capture aperture, NaN where it never did. Surge and pitch are fitted by a
normal distribution, the energy by a gamma distribution; a sea state is operable when the intervals
of all three lie inside the capture limits. The method of the reference; the binary result of the
contact phase stands beside it, so that their agreement can be seen.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import PchipInterpolator

from marine_mj.analysis.distributions import fit_gamma, fit_normal
from marine_mj.analysis.proportions import wilson_interval
from marine_mj.analysis.statistics import cohens_d
from marine_mj.contact_success import FORCE_LIMIT, contact_success
from marine_mj.environment.sea_states import SEA_STATES
from marine_mj.errors import AnalysisError
from marine_mj.frames import Array

Flags = NDArray[np.bool_]

#: What is measured at the aperture, in this order.
METRICS = ("surge", "pitch", "energy")
#: Coverage of the intervals (reference 6.3): 0.997 ** 3 = 0.991 for all three.
COVERAGE = 0.997
#: Seas beyond this height are as good as never seen, m and share of time (digest 7.7).
_HIGHEST = (6.1, 0.999)


@dataclass(frozen=True)
class CaptureLimits:
    """What the dock can take: half the surge aperture (m), pitch (rad), kinetic energy (J)."""

    surge: float = 0.5
    pitch: float = float(np.deg2rad(15.0))
    energy: float = 30.0

    def __post_init__(self) -> None:
        """Raise AnalysisError for a limit that is not positive."""
        for name in METRICS:
            if not getattr(self, name) > 0:
                raise AnalysisError(
                    f"capture limit {name} is {getattr(self, name)}, allowed is > 0 (m, rad, J)"
                )


@dataclass(frozen=True)
class Entries:
    """Entries into the aperture of all runs at one sea state, and what became of them.

    Attributes:
        surge: (n,) surge error at the crossing, m; NaN where there was none.
        pitch: (n,) pitch error, rad.
        energy: (n,) relative kinetic energy, J.
        docked: (n,) bool, contact success (`contact_success`); None: no contact phase was run.
    """

    surge: Array
    pitch: Array
    energy: Array
    docked: Flags | None = None

    @classmethod
    def of(cls, rows: Sequence[Mapping], force_limit: float = FORCE_LIMIT) -> "Entries":
        """Entries of the rows of a batch or a campaign.

        Args:
            rows: with `capture` and what `contact_success` reads.
            force_limit: of `contact_success`, N.
        """

        def column(name: str) -> Array:
            found = [(row.get("capture") or {}).get(name, np.nan) for row in rows]
            return np.array(found, dtype=float)

        docked = [contact_success(row, force_limit) for row in rows]
        return cls(
            column("surge_error"),
            column("pitch_error"),
            column("relative_kinetic_energy"),
            np.array(docked),
        )

    def __len__(self) -> int:
        """Number of runs."""
        return len(self.surge)

    def take(self, rows: ArrayLike) -> "Entries":
        """The chosen runs."""
        rows = np.asarray(rows)
        docked = None if self.docked is None else self.docked[rows]
        return Entries(self.surge[rows], self.pitch[rows], self.energy[rows], docked)

    @property
    def complete(self) -> bool:
        """Whether every run crossed the aperture; else a sea state is not evaluated (7.0)."""
        return bool(len(self) and np.isfinite(self.surge).all())

    def inside(self, limits: CaptureLimits) -> Flags:
        """Which runs (n,) crossed the aperture within all limits."""
        surge, pitch = np.abs(self.surge), np.abs(self.pitch)
        within = (surge <= limits.surge) & (pitch <= limits.pitch)
        return np.asarray(within & (self.energy <= limits.energy), dtype=bool)


def interval(entries: Entries, metric: str, coverage: float = COVERAGE) -> tuple[float, float]:
    """Interval (low, high) that holds `coverage` of the fitted distribution of a metric.

    Normal and two-sided for surge and pitch; gamma and one-sided from 0 for the energy (the
    reference does not say which; digest 7.0). A metric without spread, as in calm water, is its
    own interval.

    Raises:
        AnalysisError: the metric does not exist, or a run did not cross the aperture.
    """
    if metric not in METRICS:
        raise AnalysisError(f"metric {metric!r} does not exist; there are {', '.join(METRICS)}")
    values: Array = getattr(entries, metric)
    missing = int((~np.isfinite(values)).sum())
    if missing or not len(values):
        raise AnalysisError(
            f"{missing} of {len(values)} runs never crossed the aperture: {metric} has no "
            "distribution; look at `Entries.complete` first"
        )
    if np.ptp(values) <= 1e-9 * max(1.0, float(np.abs(values).max())):
        low, high = float(values.min()), float(values.max())
        return (0.0, high) if metric == "energy" else (low, high)
    if metric == "energy":
        positive = np.maximum(values, 1e-12)
        try:
            return 0.0, float(fit_gamma(positive).quantile(coverage))
        except AnalysisError:  # too little spread, relative to the mean, for a gamma distribution
            return 0.0, float(positive.max())
    low, high = fit_normal(values).interval(coverage)
    return float(low), float(high)


def operable(
    entries: Entries, limits: CaptureLimits = CaptureLimits(), coverage: float = COVERAGE
) -> dict[str, bool]:
    """Whether the interval of each metric, and of all (`total`), lies inside the limits."""
    if not entries.complete:
        return dict.fromkeys((*METRICS, "total"), False)
    found = {}
    for metric in METRICS:
        low, high = interval(entries, metric, coverage)
        limit = getattr(limits, metric)
        found[metric] = bool(low >= -limit and high <= limit)
    return found | {"total": all(found.values())}


def maximum_sea_state(good: Mapping[int, bool], contiguous: bool = True) -> int | None:
    """Highest operable sea state; None when not even the lowest is.

    Args:
        good: operable or not, by sea state.
        contiguous: every lower one must be operable, too; False: the highest that is (the
            reference is not clear about it, digest 7.0).
    """
    best = None
    for state in sorted(good):
        if good[state]:
            best = state
        elif contiguous:
            break
    return best


def limits_of(
    campaign: Mapping[int, Entries],
    limits: CaptureLimits = CaptureLimits(),
    contiguous: bool = True,
    coverage: float = COVERAGE,
) -> dict[str, int | None]:
    """Maximum operational sea state by metric and of all (`total`).

    Args:
        campaign: entries by sea state. The first one with a run that never crossed the aperture
            ends the evaluation (digest 7.0).
    """
    good: dict[str, dict[int, bool]] = {name: {} for name in (*METRICS, "total")}
    for state in sorted(campaign):
        if not campaign[state].complete:
            break
        for name, ok in operable(campaign[state], limits, coverage).items():
            good[name][state] = ok
    return {name: maximum_sea_state(states, contiguous) for name, states in good.items()}


def bootstrap_limits(
    campaign: Mapping[int, Entries],
    limits: CaptureLimits = CaptureLimits(),
    resamples: int = 200,
    seed: int = 0,
) -> dict[str, list[int | None]]:
    """Maximum operational sea states of resampled campaigns, by metric: their scatter."""
    rng = np.random.default_rng(seed)
    found: dict[str, list[int | None]] = {name: [] for name in (*METRICS, "total")}
    for _ in range(resamples):
        drawn = {
            state: entries.take(rng.integers(0, len(entries), len(entries)))
            for state, entries in campaign.items()
        }
        for name, state in limits_of(drawn, limits).items():
            found[name].append(state)
    return found


def uptime(sea_state: int | None) -> float:
    """Share of time (0 to 1) with waves up to those of a sea state; 0 for None (digest 7.7)."""
    if sea_state is None:
        return 0.0
    return float(uptime_of_height(SEA_STATES[sea_state].H_s))


def uptime_of_height(H_s: ArrayLike) -> Array:
    """Share of time (0 to 1) with a significant wave height up to `H_s` (m), North Sea 2017.

    Monotone cubic interpolation through the points the reference gives (digest 7.7).
    """
    points = [(s.H_s, s.uptime_percent / 100) for s in SEA_STATES if s.H_s < _HIGHEST[0]]
    points = sorted({(0.0, 0.0), *(p for p in points if p[0] > 0), _HIGHEST})
    heights, shares = np.array(points).T
    inside = PchipInterpolator(heights, shares)(np.clip(H_s, 0.0, heights[-1]))
    return np.where(np.asarray(H_s) > heights[-1], 1.0, inside)


@dataclass(frozen=True)
class Agreement:
    """The method of distributions against what the contact phase did, run by run.

    Attributes:
        inside: share of runs that entered within the limits, with its Wilson interval.
        docked: share of contact successes, with its Wilson interval.
        docked_if_inside: share of successes among the entries within the limits (the reference took
            it for 1), with its Wilson interval.
        docked_if_outside: share of successes among the others.
        agreement: share of runs in which both methods say the same.
    """

    inside: tuple[float, float, float]
    docked: tuple[float, float, float]
    docked_if_inside: tuple[float, float, float]
    docked_if_outside: tuple[float, float, float]
    agreement: float


def agreement(entries: Entries, limits: CaptureLimits = CaptureLimits()) -> Agreement:
    """How far entry within the limits and a contact-based success go together.

    Raises:
        AnalysisError: no contact phase was run.
    """
    if entries.docked is None or not len(entries):
        raise AnalysisError("these runs have no contact phase: `docked` is needed for an agreement")
    inside, docked = entries.inside(limits), np.asarray(entries.docked, dtype=bool)

    def share(good: Flags, of: Flags) -> tuple[float, float, float]:
        count, total = int((good & of).sum()), int(of.sum())
        if total == 0:
            return float("nan"), 0.0, 1.0
        low, high = wilson_interval(count, total)
        return count / total, float(low), float(high)

    everything = np.ones(len(entries), dtype=bool)
    return Agreement(
        share(inside, everything),
        share(docked, everything),
        share(docked, inside),
        share(docked, ~inside),
        float((inside == docked).mean()),
    )


def sample_size_study(values: ArrayLike, size: int = 60, seed: int = 0) -> dict[str, float]:
    """Cohen's d of sub-samples against the whole sample: random, regular and first (6.3, 6.7).

    Args:
        values: (n,) a metric of n runs.
        size: of the sub-samples.

    Raises:
        AnalysisError: the sample is not larger than the sub-samples.
    """
    x = np.asarray(values, dtype=float)
    if len(x) <= size:
        raise AnalysisError(
            f"{len(x)} runs hold no sub-sample of {size}: allowed are more than {size} runs"
        )
    chosen = np.random.default_rng(seed).choice(len(x), size, replace=False)
    regular = np.linspace(0, len(x) - 1, size).round().astype(int)
    picks = {"random": chosen, "regular": regular, "first": np.arange(size)}
    return {name: float(cohens_d(x[rows], x).d) for name, rows in picks.items()}


def dock_size(entries: Entries, coverage: float = COVERAGE, margin: float = 1.0) -> CaptureLimits:
    """Smallest capture limits that hold `coverage` of each metric, times a margin (digest 7.0).

    Raises:
        AnalysisError: a run did not cross the aperture.
    """
    sizes = {}
    for metric in METRICS:
        low, high = interval(entries, metric, coverage)
        sizes[metric] = margin * max(abs(low), abs(high), 1e-12)
    return CaptureLimits(**sizes)
