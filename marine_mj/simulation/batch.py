"""Running many variations of one scenario."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import xarray as xr

from marine_mj.errors import SimulationError
from marine_mj.scenario import Scenario
from marine_mj.simulation.runner import run


@dataclass(frozen=True)
class BatchResult:
    """Results of a batch.

    Attributes:
        rows: one per run, in order: the task's summary, `simulated_time`, `wall_time`, and `error`
            (None, or why the run ended early).
        signals: dims ("run", "time", ...); None when nothing is recorded. Shorter runs end in NaN.
    """

    rows: list[dict[str, Any]]
    signals: xr.Dataset | None


def run_batch(
    scenario: Scenario | str | Path,
    variations: Sequence[Mapping[str, Any]] | None = None,
    n: int | None = None,
    *,
    threads: int = 1,
    record: Sequence[str] = (),
    decimation: int = 1,
    progress: Callable[[int, int], None] | None = None,
) -> BatchResult:
    """Rows and signals of many runs, one after the other.

    Args:
        scenario: what all runs share.
        variations: changes by dotted key, one mapping per run.
        n: number of runs with seeds seed, seed + 1, ... instead of `variations`.
        threads: not used here.
        record: names of the signals to keep.
        decimation: keep every so manyth log entry.
        progress: called with the number of finished runs and of all runs.
    """
    if not isinstance(scenario, Scenario):
        scenario = Scenario.load(scenario)
    if variations is None:
        variations = [{"seed": scenario.seed + i} for i in range(n or 1)]
    rows, recorded = [], []
    for i, variation in enumerate(variations):
        row: dict[str, Any] = {"simulated_time": 0.0, "wall_time": 0.0, "error": None}
        log = None
        try:
            log = run(scenario.with_values(dict(variation)))
        except SimulationError as error:
            log, row["error"] = error.log, f"{type(error).__name__}: {error}"
        except Exception as error:
            row["error"] = f"{type(error).__name__}: {error}"
        if log is not None:
            row = log.summary | {"error": row["error"]}
        rows.append(row)
        if record:
            kept = xr.Dataset() if log is None else log.data[list(record)]
            recorded.append(kept.isel(time=slice(None, None, decimation)) if kept else kept)
        if progress is not None:
            progress(i + 1, len(variations))
    signals = xr.concat(recorded, "run", join="outer") if record and any(recorded) else None
    if signals is not None:
        signals.attrs = {}
    return BatchResult(rows, signals)
