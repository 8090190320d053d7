"""From a scenario's sea, wind and current to the environment: compass directions, profile."""

import numpy as np
import pytest

from marine_mj.scenario import Scenario
from marine_mj.weather import environment_of

#: East and half-way to it, clockwise from north; unit vectors in NWU (west is y).
DIRECTIONS = [(90.0, (0.0, -1.0)), (30.0, (np.cos(np.pi / 6), -0.5)), (-45.0, (0.5**0.5, 0.5**0.5))]


@pytest.mark.parametrize(("degrees", "along"), DIRECTIONS)
def test_directions_are_clockwise_from_north(degrees, along):
    changes = {
        "sea": {"spectrum": "regular", "height": 0.2, "period": 4.0, "direction_deg": degrees},
        "wind": {"speed": 8.0, "direction_deg": degrees, "gusts": False},
        "current": {"speed": 0.5, "direction_deg": degrees},
    }
    found = environment_of(Scenario.load("docking_demo").with_values(changes))
    b = found.waves.direction[0]
    np.testing.assert_allclose([np.cos(b), np.sin(b)], along, atol=1e-12)
    np.testing.assert_allclose(found.wind.velocity_at(0.0)[:2] / 8, along, atol=1e-12)
    np.testing.assert_allclose(found.current.velocity_at(0.0, 0.0)[:2] / 0.5, along, atol=1e-12)


@pytest.mark.parametrize("gusts", [False, True])
def test_wind_profile_of_a_scenario(gusts):
    wind = {"speed": 8.0, "height_exponent": 0.2, "gusts": gusts}
    scenario = Scenario.load("docking_demo").with_values({"wind": wind})
    assert environment_of(scenario).wind.height_exponent == 0.2
