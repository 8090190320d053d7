"""Brute-force tuning of the docking pose PID (docking digest 6.2 and 7.1).

Every gain triple of a grid is flown in the tuning scenario, the same triple on all axes at once:
the axes are nearly independent, so each axis picks its own best triple of the same runs.
"""

import csv
import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from marine_mj.controllers import GAINS, PidGains
from marine_mj.errors import ScenarioError
from marine_mj.frames import Array
from marine_mj.scenario import Scenario
from marine_mj.simulation.batch import BatchResult, run_batch

#: Axes of the errors and what each score is a sum of, in this order, NED.
AXES = ("surge", "sway", "heave", "roll", "pitch", "yaw")
#: Signals that the scores come from.
MISSES = ("target_error", "target_rate")
#: Grid of the reference's size, 10 x 10 x 10; it does not give the ranges, these are ours.
GRID_P = np.logspace(1, 4, 10)
GRID_I = np.concatenate([[0.0], np.logspace(0, 2, 9)])
GRID_D = np.concatenate([[0.0], np.logspace(1, 3.5, 9)])
# An axis that a planar vehicle does not have takes the gains of its twin.
_TWINS = {"sway": "heave", "yaw": "pitch"}


@dataclass(frozen=True)
class Tuning:
    """Scores of gain triples.

    Attributes:
        triples: (n, 3) P, I, D; the same on all axes.
        errors: (n, 2, 6) root mean square of pose error (m, rad) and velocity error (m/s, rad/s)
            by axis, NED; inf for a run that failed.
    """

    triples: Array
    errors: Array

    @property
    def scores(self) -> Array:
        """Objective (n, 6) of each axis: rms of its pose error plus that of its velocity error."""
        return self.errors.sum(axis=1)

    def best(self) -> PidGains:
        """Gains with the best triple of each axis.

        An axis without errors (planar vehicles) takes those of its twin by symmetry, roll the
        published ones.
        """
        scores = self.scores
        chosen = {}
        for i, axis in enumerate(AXES):
            moved = scores[:, i][np.isfinite(scores[:, i])]
            if moved.size and moved.max() > 1e-9:
                chosen[axis] = self.triples[np.argmin(scores[:, i])]
        known = GAINS["brute_force"]
        published = np.stack([np.asarray(v) for v in (known.P, known.I, known.D)])  # (3, 6)
        rows = [
            chosen.get(axis, chosen.get(_TWINS.get(axis, ""), published[:, i]))
            for i, axis in enumerate(AXES)
        ]
        P, I, D = np.array(rows).T  # noqa: E741
        return PidGains(P, I, D)

    def write(self, path: str | Path) -> Path:
        """Path of a CSV with one line per triple: P, I, D and the rms of every error."""
        path = Path(path)
        path.parent.mkdir(parents=True, exist_ok=True)
        names = [f"{axis}_{kind}" for kind in ("pose", "velocity") for axis in AXES]
        with path.open("w", newline="", encoding="utf-8") as file:
            table = csv.writer(file)
            table.writerow(["P", "I", "D", *names])
            for triple, errors in zip(self.triples, self.errors, strict=True):
                table.writerow([f"{v:.6g}" for v in (*triple, *errors.ravel())])
        return path


def station_errors(
    scenario: Scenario | str,
    variations: Sequence[Mapping[str, Any]],
    *,
    threads: int = 1,
    progress: Callable[[int, int], None] | None = None,
) -> Array:
    """Root mean square (n, 2, 6) of pose and velocity error of runs that keep station, NED.

    Args:
        scenario: with `task.settings.station`, or its name or path.
        variations: changes of each run, as in `run_batch`.
        threads: as in `run_batch`.
        progress: called with the number of finished runs and of all runs.

    Raises:
        ScenarioError: the scenario docks instead of keeping station.
    """
    base = scenario if isinstance(scenario, Scenario) else Scenario.load(scenario)
    if base.task.settings.get("station") is None:
        raise ScenarioError(
            f"scenario {base.name!r} has no task.settings.station: tuning needs a vehicle that "
            "keeps station, see docking_tuning"
        )
    result = run_batch(base, variations, threads=threads, record=MISSES, progress=progress)
    return rms_errors(result)


def rms_errors(result: BatchResult) -> Array:
    """Root mean square (n, 2, 6) of pose and velocity error of runs that recorded `MISSES`, NED.

    Runs with an error have inf.
    """
    assert result.signals is not None
    # The first entry is from before the first command.
    samples = np.stack([result.signals[name].values[:, 1:] for name in MISSES], axis=1)
    errors = np.sqrt(np.mean(samples**2, axis=2))
    failed = np.array([row["error"] is not None for row in result.rows])
    return np.where(failed[:, None, None] | np.isnan(errors), np.inf, errors)


def tune_docking(
    scenario: Scenario | str = "docking_tuning",
    P: Sequence[float] | Array = GRID_P,
    I: Sequence[float] | Array = GRID_I,  # noqa: E741
    D: Sequence[float] | Array = GRID_D,
    *,
    threads: int = 1,
    progress: Callable[[int, int], None] | None = None,
) -> Tuning:
    """Scores of all triples of a grid of pose-PID gains in a scenario that keeps station.

    Args:
        scenario: tuning scenario.
        P, I, D: values of each gain, in the units of every axis (N/m or N m/rad, ...).
        threads: native threads that step the physics.
        progress: called with the number of finished runs and of all runs.

    Raises:
        ScenarioError: a gain is negative, or the scenario docks instead of keeping station.
    """
    triples = np.array(list(itertools.product(P, I, D)), dtype=float)
    variations = [
        {
            "task.settings.controller": "pose_pid",
            "task.settings.gains": None,
            "task.settings.gain_values": gain_values(*np.repeat(triple, 6).reshape(3, 6)),
        }
        for triple in triples
    ]
    errors = station_errors(scenario, variations, threads=threads, progress=progress)
    return Tuning(triples, errors)


def gain_values(P: Array, I: Array, D: Array) -> dict[str, list[float]]:  # noqa: E741
    """Table `task.settings.gain_values` of gains (6,) each."""
    return {name: np.asarray(v).tolist() for name, v in zip("PID", (P, I, D), strict=True)}
