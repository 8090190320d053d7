"""Scenario files: round trip and the messages of what is refused."""

import numpy as np
import pytest

from marine_mj.errors import ScenarioError
from marine_mj.scenario import Scenario
from marine_mj.weather import environment_of

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
        (
            "[sea]\nsea_state = 3\ncomponents = 2\nnormals = [1.0, 2.0, 3.0]",
            r"sea: normals has 3 numbers, allowed are 4: two for each of components = 2",
        ),
        (
            '[sea]\nspectrum = "none"\ncomponents = 1\nnormals = [1.0, 2.0]',
            r'normals make an irregular sea, but spectrum = "none": leave them out',
        ),
        (
            '[sea]\nspectrum = "regular"\nheight = 1.0\nperiod = 6.0\nnormals = [1.0, 2.0]',
            r'but spectrum = "regular"',
        ),
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
    with pytest.raises(ScenarioError, match=r"packaged: .*docking_demo"):
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


@pytest.mark.parametrize(
    "sea",
    [
        {"sea_state": 4, "spreading": 8.0},
        {"sea_state": 5, "spectrum": "docking_jonswap", "frequency_sampling": "midpoint"},
        {"significant_wave_height": 1.5, "spectrum": "pierson_moskowitz"},
    ],
)
def test_normals_of_a_sea_are_those_of_the_gaussian_sea(sea):
    scenario = Scenario.from_toml(BASE).with_values({"sea": sea | {"components": 7}, "seed": 9})
    u = np.random.default_rng(2).standard_normal(14)
    with_normals = Scenario.from_toml(scenario.with_values({"sea.normals": list(u)}).to_toml())
    assert with_normals.sea.normals == tuple(u)
    found = environment_of(with_normals).waves
    usual = environment_of(scenario).waves
    # Frequencies and directions are those of the seed, amplitude and phase those of the normals.
    assert np.array_equal(found.omega, usual.omega)
    assert np.array_equal(found.direction, usual.direction)
    phasor = usual.amplitude / np.sqrt(2.0) * (u[:7] + 1j * u[7:])
    # Measured 2e-16 relative: rounding.
    np.testing.assert_allclose(found.amplitude * np.exp(1j * found.phase), phasor, rtol=1e-14)


def test_calm_water_stays_calm_with_normals():
    sea = {"sea_state": 0, "components": 1, "normals": [1.0, 2.0]}
    assert environment_of(Scenario.from_toml(BASE).with_values({"sea": sea})).waves.omega.size == 0
