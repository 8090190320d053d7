"""What it takes to follow a floating carrier in heave."""

import numpy as np
import pytest

from marine_mj.analysis.following import heave_demand
from marine_mj.environment import irregular_sea
from marine_mj.errors import AnalysisError

SEA = irregular_sea(3.6, 6.7, components=200, seed=4)
MASS, DRAG, LIMIT = 126.6, 502.4, 68.0


def test_a_carrier_that_moves_like_the_water_asks_for_nothing():
    demand = heave_demand(SEA, np.exp(-3.0 * SEA.wavenumber), 3.0, MASS, DRAG, LIMIT)
    assert demand.speed == demand.acceleration == demand.beyond == 0.0


@pytest.mark.parametrize("depth", [2.0, 4.0])
def test_share_of_time_is_that_of_a_time_series(depth):
    """Independent: the force of one long realisation, carrier on the surface (H = 1)."""
    demand = heave_demand(SEA, np.ones_like(SEA.omega), depth, MASS, DRAG, LIMIT)
    time = np.arange(0.0, 20000.0, 0.5)
    phase = SEA.omega * time[:, None] + SEA.phase
    height = (1 - np.exp(-SEA.wavenumber * depth)) * SEA.amplitude
    speed = -np.sin(phase) @ (height * SEA.omega)
    acceleration = -np.cos(phase) @ (height * SEA.omega**2)
    force = MASS * acceleration + DRAG * speed * np.abs(speed)
    assert demand.speed == pytest.approx(speed.std(), rel=0.01)
    assert demand.acceleration == pytest.approx(acceleration.std(), rel=0.01)
    assert demand.beyond == pytest.approx(np.mean(np.abs(force) > LIMIT), abs=0.01)


def test_a_negative_limit_is_refused():
    with pytest.raises(AnalysisError, match="limit is -1"):
        heave_demand(SEA, np.ones_like(SEA.omega), 2.0, MASS, DRAG, -1.0)
