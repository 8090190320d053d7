"""Horizontal docking by guidance laws; a dock fixed in space."""

import numpy as np
import pytest

from marine_mj.campaign import Campaign
from marine_mj.errors import MarineMjError
from marine_mj.scenario import Scenario
from marine_mj.scene import compile_scene
from marine_mj.simulation import run, run_batch

FUNNEL = Scenario.load("docking_funnel")


def test_same_bits_alone_and_in_a_batch():
    base = FUNNEL.with_values({"duration": 0.2, "sea.sea_state": 4})
    laws = ("proportional_navigation", "sliding_path", "cross_track")
    variations = [{"task.settings.guidance": law, "seed": s} for law in laws for s in (1, 2)]
    result = run_batch(base, variations, record=("qpos",))
    for i in (1, 2, 5):
        log = run(base.with_values(variations[i]))
        np.testing.assert_array_equal(log.data["qpos"], result.signals["qpos"][i])


def test_fixed_carrier_stays_where_it_is():
    base = FUNNEL.with_values({"vehicles.usv.motion": "fixed", "sea.sea_state": 6, "duration": 1.0})
    log = run(base)
    eta = log.data.eta_ned.sel(vehicle="usv").values
    # measured 1.3e-10 m or rad, 5e-11 m/s
    np.testing.assert_allclose(eta, np.tile(eta[0], (len(eta), 1)), atol=1e-8)
    np.testing.assert_allclose(log.data.nu_frd.sel(vehicle="usv").values, 0.0, atol=1e-8)
    with pytest.raises(MarineMjError, match="with motion 'fixed': prescribed motion gives way"):
        compile_scene(base.with_values({"vehicles.usv.drift": "mean"}), visual=False)
    with pytest.raises(MarineMjError, match='motion = "fixed" and planar = true'):
        compile_scene(base.with_values({"vehicles.usv.planar": True}), visual=False)


def test_campaign_of_the_comparison_is_sound():
    campaign = Campaign.load(Campaign.packaged()["docking_horizontal"])
    assert campaign.runs == 60
