"""Searches for the tests: an event of exactly known probability, and one of real runs."""

from campaign_helpers import Inline

from marine_mj.campaign import Campaign, Plan, run_campaign
from marine_mj.campaign.worker import Done
from marine_mj.scenario import Scenario
from marine_mj.weather import environment_of

#: A sea of four components; the USV is moved by its RAOs.
BASE = Scenario.load("docking_demo").with_values(
    {
        "sea": {"significant_wave_height": 2.0, "peak_period": 9.0, "components": 4},
        "vehicles.usv.motion": "rao",
        "duration": 0.01,
        "log_period": 0.01,
    }
)

#: Elevation at the origin plus a normal offset: normal with variance m0 + 0.3^2.
LINEAR = """
name = "linear"
scenario = "given"
seed = 11
chunk = 20
[factors.height]
key = "sea.significant_wave_height"
grid = [1.0, 2.0]
[factors.offset]
key = "current.direction_deg"
distribution = "normal"
parameters = { mean = 0.0, std = 0.3 }
[rare]
metric = "total"
threshold = 1.2
samples = 200
repetitions = 2
sea = true
"""

#: One cell of it.
HIGH = LINEAR.replace("grid = [1.0, 2.0]", "grid = [2.0]")

#: Settings of a quick search, for what does not depend on its accuracy.
SMALL = {"samples": 40, "threshold": 0.8}

#: A factor with a normal distribution that the runner's summary shows.
ECHO = """
name = "echo"
scenario = "given"
seed = 4
chunk = 10
[factors.height]
key = "sea.significant_wave_height"
distribution = "normal"
parameters = { mean = 2.0, std = 0.2 }
[metrics]
H_s = "sea_state.H_s"
[rare]
metric = "H_s"
threshold = 2.5
samples = 50
p0 = 0.2
"""


def plan(text: str = LINEAR, base: Scenario = BASE, **rare) -> Plan:
    """Plan of a campaign with settings of its table `rare` replaced."""
    campaign = Campaign.from_toml(text)
    assert campaign.rare is not None
    return Plan(campaign.changed(rare=campaign.rare.model_dump() | rare), base)


def elevate(work) -> Done:
    """Elevation at the origin at t = 0 plus the offset, from the scenario of each run."""
    base, rows = Scenario.from_toml(work.scenario), []
    for variation in work.variations:
        scenario = base.with_values(dict(variation))
        zeta = float(environment_of(scenario).waves.elevation(0.0, 0.0, 0.0))
        total = zeta + scenario.current.direction_deg
        row = {"total": total, "none": None, "simulated_time": 1.0, "wall_time": 0.0}
        rows.append(row | {"error": "sunk" if total > 1.8 else None})
    return Done(rows)


def searched(folder, made=None, resume=False, do=elevate):
    """Run a search in this process."""
    return run_campaign(made or plan(), folder, executor=Inline(), do=do, resume=resume)
