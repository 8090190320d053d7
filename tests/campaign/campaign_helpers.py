"""Campaigns for the tests: a cheap real one, and one whose runs are drawn instead of simulated."""

import json
import os
from concurrent.futures import Future
from pathlib import Path

import numpy as np
import pandas as pd

from marine_mj.campaign import Campaign, Plan, run_campaign
from marine_mj.campaign.worker import Done, Work

#: Calm water, 0.2 s: the start of the docking demonstration.
CALM = """
name = "calm"
scenario = "docking_demo"
runs = 4
chunk = 3
seed = 5
success = ["docked == false"]
[set]
duration = 0.2
log_period = 0.1
sea = { sea_state = 0, components = 1 }
[factors.depth]
key = "vehicles.auv.position_ned[2]"
grid = [3.0, 4.0]
[factors.north]
key = "vehicles.auv.position_ned[0]"
distribution = "normal"
parameters = { mean = 3.0, std = 0.2 }
[metrics]
force = "peak_contact_force"
pitch_deg = { key = "capture.pitch_error", transform = ["abs", "rad2deg"] }
[record]
signals = ["eta_ned", "nu_frd"]
"""

#: Outcomes drawn from the seed: probability 0.9 at level 0 and 0.5 at level 1.
DRAWN = CALM.replace("docked == false", "docked == true").replace(
    '[metrics]\nforce = "peak_contact_force"', '[metrics]\nforce = "force"'
)


def campaign(text: str = CALM, **values) -> Campaign:
    """Campaign of a text with values replaced."""
    return Campaign.from_toml(text).changed(**values)


def plan(text: str = CALM, **values) -> Plan:
    """Plan of a campaign with values replaced."""
    return Plan(campaign(text, **values))


def draw(work: Work) -> Done:
    """Rows drawn from the seeds, without a simulation."""
    rows = []
    for variation in work.variations:
        rng = np.random.default_rng(variation["seed"])
        deep = variation["vehicles.auv.position_ned"][2] > 3.5
        rows.append(
            {
                "docked": bool(rng.random() < (0.5 if deep else 0.9)),
                "force": float(rng.gamma(3.0, 200.0) + (500.0 if deep else 0.0)),
                "capture": {"pitch_error": float(rng.normal(0.0, 0.05))},
                "simulated_time": 1.0,
                "wall_time": float(np.random.default_rng().random()),
                "error": None,
            }
        )
    return Done(rows)


def die_at_run_2(work: Work) -> Done:
    """As `draw`, but one of the runs ends its process."""
    culprit = plan(DRAWN).run(2).seed
    if any(variation["seed"] == culprit for variation in work.variations):
        os._exit(9)
    return draw(work)


class Inline:
    """An executor that does everything in this process, at once."""

    def submit(self, function, *arguments):
        """Finished future."""
        future: Future = Future()
        try:
            future.set_result(function(*arguments))
        except BaseException as error:
            future.set_exception(error)
        return future


def drawn(folder, text=DRAWN, resume=False, extend=False, **values):
    """Run a campaign whose outcomes are drawn."""
    return run_campaign(
        plan(text, **values), folder, executor=Inline(), do=draw, resume=resume, extend=extend
    )


def read(folder: Path) -> pd.DataFrame:
    """All columns that are computed: neither the measured time nor where the code comes from."""
    return pd.read_parquet(Path(folder) / "runs").drop(columns=["wall_time", "git_revision"])


def report_of(folder: Path) -> dict:
    """The written report."""
    return json.loads((Path(folder) / "report" / "report.json").read_text())
