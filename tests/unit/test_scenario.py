"""Scenario files: round trip and the messages of what is refused."""

import pytest

from marine_mj.errors import ScenarioError
from marine_mj.scenario import Scenario

BASE = """
name = "test"
[vehicles.auv]
model = "scout"
[task]
domain = "docking"
name = "dock"
"""


@pytest.mark.parametrize("name", Scenario.packaged())
def test_packaged_scenarios_are_valid_and_survive_the_round_trip(name):
    scenario = Scenario.load(name)
    assert Scenario.from_toml(scenario.to_toml()) == scenario


@pytest.mark.parametrize(
    ("addition", "message"),
    [
        ("[sea]\nsea_stat = 4", r"sea\.sea_stat = 4: unknown key .*Did you mean 'sea_state'\?"),
        ("[sea]\nsea_stat = 4", r"Allowed here: components, depth"),
        (
            "[sea]\nsignificant_wave_height = -1.0\npeak_period = 5.0",
            r"sea\.significant_wave_height = -1\.0: .*greater than or equal to 0",
        ),
        ('[sea]\nspectrum = "gauss"', r"sea\.spectrum = 'gauss': .*'jonswap'"),
        ("[sea]\nsea_state = 13", r"sea\.sea_state = 13: .*less than or equal to 12"),
        ("[sea]\nsea_state = 3\nsignificant_wave_height = 1.0", "not both"),
        ("[sea]\ncomponents = 40", r"needs sea_state \(0 to 12\)"),
        ('[sea]\nspectrum = "regular"', "needs height and period"),
        ('[sea]\nspectrum = "none"\nsea_state = 3', "calm water"),
        ("[wind]\nspeed = nan", r"wind\.speed = nan: .*finite"),
        ("[sae]\nx = 1", r"unknown key 'sae'. Did you mean 'sea'"),
        (
            '[vehicles.usv]\nmodel = "a"\nmotio = "rao"',
            r"vehicles\.usv\.motio .*Did you mean 'motion'",
        ),
        ('[vehicles.usv]\nmotion = "rao"', r"vehicles\.usv\.model is missing"),
        ('[vehicles."a/b"]\nmodel = "x"', "'a/b' is not allowed"),
    ],
)
def test_bad_scenarios_say_what_is_wrong(addition, message):
    with pytest.raises(ScenarioError, match=message):
        Scenario.from_toml(BASE + addition)


def test_bad_periods_files_and_syntax():
    with pytest.raises(ScenarioError, match=r"control_period = 0\.012 must be a whole multiple"):
        Scenario.from_toml("control_period = 0.012\n" + BASE)
    with pytest.raises(ScenarioError, match=r"packaged: docking_demo"):
        Scenario.load("dokcing")
    with pytest.raises(ScenarioError, match="not valid TOML"):
        Scenario.from_toml("name = ")


def test_with_values_by_dotted_keys():
    scenario = Scenario.from_toml(BASE).with_values({"sea.spectrum": "jonswap", "sea.sea_state": 2})
    assert scenario.sea.sea_state == 2
    with pytest.raises(ScenarioError, match="unknown key"):
        scenario.with_values({"sea.sea_statt": 2})
    with pytest.raises(ScenarioError, match="is a value, not a table"):
        scenario.with_values({"name.x": 2})
