"""Figure 7.17: the fitted distributions of the pose PID by sea state, with the limits."""

import numpy as np
from scipy import stats

from marine_mj.analysis.distributions import fit_gamma, fit_normal
from marine_mj.analysis.docking import METRICS, CaptureLimits, interval
from marine_mj.campaign.pools import Here
from marine_mj.frames import Array
from marine_mj.reproduce.docking import rows_of
from marine_mj.reproduce.judgement import scaled
from marine_mj.reproduce.runner import run_configurations
from marine_mj.reproduce.sections.base import Job, Outcome, panels

_LABELS = {"surge": "surge error [m]", "pitch": "pitch error [deg]", "energy": "energy [J]"}
#: How far the axes reach, in limits.
_REACH = {"surge": 3.0, "pitch": 3.0, "energy": 2.5}


def distributions(job: Job) -> Outcome:
    """Densities above, intervals of 99.7 % below the line of each sea state (manual gains)."""
    row = next(r for r in rows_of(["7.12"]) if r.configuration == "manual")
    place = job.folder if job.campaigns is None else job.campaigns
    cells = run_configurations([row], place, job.runs, highest=job.highest, executor=Here())
    entries = {
        state: e
        for state, e in cells["manual"].entries.items()
        if e.complete and row.first <= state <= row.last
    }
    figure, axes = panels(1, 3, (14, 8), sharey=True)
    for ax, metric in zip(axes[0], METRICS, strict=True):
        limit = scaled(getattr(CaptureLimits(), metric), metric)
        reach = _REACH[metric] * limit
        grid = np.linspace(0 if metric == "energy" else -reach, reach, 600)
        for state, e in entries.items():
            values = scaled(1.0, metric) * np.asarray(getattr(e, metric))
            curve = density(values, metric, grid)
            low, high = (scaled(end, metric) for end in interval(e, metric))
            inside = low >= -limit - 1e-12 and high <= limit
            color = "C0" if inside else "C3"
            top = state + 0.62 * curve / curve.max()
            ax.fill_between(grid, state, top, color=color, alpha=0.5, lw=0)
            ax.plot(values, np.full(len(values), state + 0.03), "|", color="k", ms=4, alpha=0.4)
            ax.fill_between([max(low, grid[0]), min(high, grid[-1])], state - 0.16, state,
                            color=color, alpha=0.9, lw=0)  # fmt: skip
            ax.axhline(state, color="0.6", lw=0.5)
        for end in (limit,) if metric == "energy" else (-limit, limit):
            ax.axvline(end, color="k", ls="--", lw=1.2)
        ax.set(xlabel=_LABELS[metric], xlim=(grid[0], grid[-1]))
    axes[0, 0].set(ylabel="sea state", yticks=sorted(entries), ylim=(min(entries) - 0.4, None))
    figure.suptitle(
        "densities (peaks alike), runs as ticks, bars: 99.7 %; dashed: capture limits; "
        "blue within them, red not",
        fontsize="medium",
    )
    text = (
        f"Pose PID with manual gains, perfect navigation, {job.runs} runs per sea state, up to the "
        "last one in which every run entered. Axes end at three times the limits (energy 2.5)."
    )
    return Outcome([], [job.save(figure, "distributions")], text)


def density(values: Array, metric: str, grid: Array) -> Array:
    """Density (m,) at `grid` (m,) of the distribution fitted to a metric: gamma or normal."""
    if metric == "energy":
        gamma = fit_gamma(np.maximum(values, 1e-12))
        return stats.gamma.pdf(np.maximum(grid, 1e-6), gamma.shape, scale=gamma.scale)
    normal = fit_normal(values)
    return stats.norm.pdf(grid, normal.mean, normal.std)
