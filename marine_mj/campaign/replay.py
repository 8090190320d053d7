"""Doing one run of a campaign again, with its full log."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq

from marine_mj.campaign.folder import CampaignFolder, first_run
from marine_mj.errors import CampaignError, SimulationError
from marine_mj.scenario import Scenario
from marine_mj.simulation import run

#: Results that a stored row and a log both have but that are measured, not computed.
_MEASURED = ("wall_time", "real_time_factor")


@dataclass(frozen=True)
class Replay:
    """A run done again.

    Attributes:
        log: file of the log.
        row: what the campaign stored, by column.
        summary: results of the replay.
        differences: keys whose values are not those that the campaign stored; empty when the
            replay is the same run.
        error: why the replay ended early; None if it did not.
    """

    log: Path
    row: dict[str, Any]
    summary: dict[str, Any]
    differences: list[str]
    error: str | None


def find_run(folder: str | Path, number: int) -> dict[str, Any]:
    """The stored row of a run, by column.

    Raises:
        CampaignError: no campaign in the folder, or this run is not finished.
    """
    place = CampaignFolder(folder)
    place.manifest()
    files = [file for file in place.chunk_files() if first_run(file) <= number]
    if files and number >= 0:
        rows = place.read(files[-1].stem, filters=[("run", "=", number)]).to_pylist()
        if rows:
            return rows[0]
    there = sum(pq.read_metadata(file).num_rows for file in place.chunk_files())
    raise CampaignError(
        f"run {number} is not among the {there} finished runs of {str(place.path)!r}; the column "
        "`run` of its Parquet files lists them"
    )


def replay(folder: str | Path, number: int, out: str | Path | None = None) -> Replay:
    """A run's exact scenario, done again by the single runner, with its log written.

    Args:
        folder: of the campaign.
        number: of the run.
        out: folder for log.nc; default: replays/run-NUMBER in the campaign's folder.

    Raises:
        CampaignError: there is no such finished run, or its factors gave no valid scenario.
        LogError: the log cannot be written.
    """
    row = find_run(folder, number)
    if row["scenario"] is None:
        raise CampaignError(f"run {number} has no scenario to replay: {row['error']}")
    out = Path(out) if out is not None else Path(folder) / "replays" / f"run-{number:08d}"
    scenario = Scenario.from_toml(row["scenario"], f"scenario of run {number}")
    error = None
    try:
        log = run(scenario)
    except SimulationError as failure:
        if failure.log is None:
            raise
        log, error = failure.log, str(failure)
    file = log.save(out / "log.nc")
    stored, found = json.loads(row["summary"]), json.loads(json.dumps(log.summary))
    differences = [
        key
        for key, value in stored.items()
        if key not in _MEASURED and key in found and found[key] != value
    ]
    if (error is None) != (row["error"] is None):
        differences.append("error")
    return Replay(file, row, found, differences, error)
