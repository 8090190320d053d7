"""Runs that are done and written together, and how many are finished."""

import hashlib
from dataclasses import dataclass
from typing import Any

import pyarrow as pa
import pyarrow.compute as pc
import xarray as xr

from marine_mj.campaign import worker
from marine_mj.campaign.code import fingerprint
from marine_mj.campaign.folder import CampaignFolder, chunk_name
from marine_mj.campaign.plan import Plan, Run
from marine_mj.campaign.worker import Work
from marine_mj.scenario import Scenario


@dataclass(frozen=True)
class Progress:
    """How far a campaign is.

    Attributes:
        done: finished runs.
        total: runs of the whole campaign; 0 when that is not known before.
        successes: finished runs that fulfil all conditions.
        errors: finished runs that ended with an error.
        note: what is being done.
    """

    done: int
    total: int
    successes: int
    errors: int
    note: str = ""


@dataclass(frozen=True)
class Chunk:
    """Runs that are done and written together.

    Attributes:
        name: of its files.
        first: number of its first run.
        runs, scenarios: the runs, and the scenario of each (or why it is not valid).
        fingerprint: of code and models.
    """

    name: str
    first: int
    runs: list[Run]
    scenarios: list[Any]
    fingerprint: str

    def work(self, plan: Plan) -> Work:
        """The runs as work for a worker."""
        record = plan.campaign.record
        return Work(
            plan.base.to_toml(),
            tuple(run.variation for run in self.runs),
            tuple(record.signals),
            record.decimation,
            self.fingerprint,
        )

    def write(self, place: CampaignFolder, rows: pa.Table, signals: xr.Dataset | None) -> None:
        """Write the files of the finished chunk."""
        if signals is not None:
            signals = signals.assign_coords(run=signals["run"] + self.first)
        place.write_chunk(self.name, rows, signals)


def count(place: CampaignFolder, total: int) -> Progress:
    """Finished runs of a folder, from its files."""
    done = successes = errors = 0
    for file in place.chunk_files():
        found = place.read(file.stem, ["success", "error"])
        done += found.num_rows
        successes += pc.sum(found["success"]).as_py() or 0
        errors += found.num_rows - found["error"].null_count
    return Progress(done, total, successes, errors)


def make_chunk(plan: Plan, runs: list[Run]) -> Chunk:
    """Consecutive runs as a chunk whose name follows from their inputs."""
    scenarios = worker.varied(plan.base, [run.variation for run in runs])
    code = fingerprint([s for s in scenarios if isinstance(s, Scenario)])
    digest = hashlib.sha256(code.encode())
    for scenario in scenarios:
        text = scenario.to_toml() if isinstance(scenario, Scenario) else str(scenario)
        digest.update(text.encode() + b"\0")
    first = runs[0].number
    return Chunk(chunk_name(first, digest.hexdigest()), first, runs, scenarios, code)
