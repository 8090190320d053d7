"""Navigation in the docking task: what is believed steers, what is true judges."""

import numpy as np
import pytest
from marine_mj.controllers.navigation import InertialNavigation, PlanarNavigation

from marine_mj import frames
from marine_mj.errors import ModelError, ScenarioError
from marine_mj.scenario import Scenario
from marine_mj.simulation import run
from marine_mj.tasks import build_environment
from marine_mj.tasks.navigation_settings import NavigationSettings

DEMO = Scenario.load("docking_demo").with_values({"duration": 1.0})
THESIS = Scenario.load("docking_thesis").with_values({"duration": 1.0})
KEY = "task.settings.navigation"


def test_thesis_and_inertial_navigation_steer_and_are_logged():
    for base, kind in ((THESIS, "thesis"), (DEMO, "inertial")):
        base = base.with_values({"duration": 0.5, "log_period": 0.01})
        log = run(base.with_values({KEY: {"kind": kind}}))
        data = log.data
        assert log.summary["navigation"] == kind
        # The first entry stands before the first look; later ones are of the look before.
        assert np.isnan(data["navigation_error"][0]).all()
        wrong = data["navigation_error"].values[1:]
        assert np.isfinite(wrong).all() and np.abs(wrong[:, 0]).max() > 0.01
        perfect = run(base).data
        assert not np.array_equal(data["ctrl"], perfect["ctrl"])
        # Errors and poses tell the same: the error turned into the world.
        true = data["eta_ned"].sel(vehicle="auv").values[:-1]
        moved = data["estimated_eta_ned"].values[1:, :3] - true[:, :3]
        q = frames.flip_quaternion(frames.quaternion_from_euler(true[:, 3:]))
        turned = frames.apply(frames.rotation_from_quaternion(q), wrong[:, :3])
        np.testing.assert_allclose(frames.flip(turned), moved, atol=1e-9)  # 1e-14


def test_rmse_is_that_of_the_logged_errors():
    base = THESIS.with_values({KEY: {"kind": "thesis"}, "log_period": 0.01, "duration": 0.5})
    log = run(base)
    wrong = log.data["navigation_error"].values[1:, :3]
    found = log.summary["navigation_rmse"]["vehicle"]["position"]
    assert found == pytest.approx(np.sqrt((wrong**2).sum(axis=1).mean()), rel=1e-5)
    relative = log.data["relative_navigation_error"].values[1:]
    found = log.summary["navigation_rmse"]["relative_position"]
    assert found == pytest.approx(np.sqrt((relative**2).sum(axis=1).mean()), rel=1e-5)


def test_perfect_navigation_believes_the_truth():
    log = run(DEMO.with_values({"duration": 0.2, "log_period": 0.01}))
    assert log.summary["navigation_rmse"] is None
    believed = log.data["estimated_eta_ned"].values[1:]
    true = log.data["eta_ned"].sel(vehicle="auv").values[:-1]
    np.testing.assert_array_equal(believed, true)


def test_episodes_of_one_environment_differ_and_seeds_repeat():
    scenario = THESIS.with_values({KEY: {"kind": "thesis"}})

    def errors(environment):
        environment.reset()
        environment.step(np.zeros(0))
        return environment.task.signals(environment.physics)["navigation_error"]

    first, again = (build_environment(scenario, random=3) for _ in range(2))
    one, two = errors(first), errors(first)
    assert not np.array_equal(one, two)
    np.testing.assert_array_equal(errors(again), one)
    np.testing.assert_array_equal(errors(again), two)


def test_settings_make_the_navigator_they_name():
    seat = np.array([0.0, 0.0, -0.5])
    settings = NavigationSettings.parse(
        {"kind": "thesis", "scenario": "fix_best", "fix_period": 0.5, "acceleration": [0, 0, 0]}
    )
    planar = settings.navigator(0.01, 9.81, seat)
    assert isinstance(planar, PlanarNavigation)
    assert planar.every == 50 and planar.fix[0] == 0.05 and not planar.acceleration.any()
    settings = NavigationSettings.parse(
        {
            "kind": "inertial",
            "camera": {"delay": 0.05, "half_angle_deg": 30.0, "marker_height": 0.2},
            "compass": {"enabled": False},
            "gnss": {"bias": 0.0},
        }
    )
    navigator = settings.navigator(0.01, 9.8, seat)
    assert isinstance(navigator, InertialNavigation)
    assert navigator.compass is None and navigator.dvl is not None
    assert navigator.camera.timing.delay == 5 and navigator.gravity == 9.8
    np.testing.assert_allclose(navigator.camera.marker, [0, 0, -0.3])
    assert navigator.camera.half_angle == pytest.approx(np.pi / 6)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"kind": "gps"}, "kind"),
        ({"kind": "thesis", "scenario": "best"}, "'best' does not exist; available: base, "),
        ({"scenario": "fix_best"}, "kind = 'perfect' has no scenario: leave it out"),
        ({"kind": "thesis", "dvl": {"period": 0.2}}, "kind = 'thesis' has no dvl"),
        ({"kind": "inertial", "link": {"enabled": False}}, "link.enabled = false: the carrier"),
        ({"kind": "thesis", "fix_period": 0.123}, "fix_period = 0.123 s must be a whole multiple"),
        ({"kind": "inertial", "camera": {"delay": 0.1}}, "one sample is under way at a time"),
        ({"kind": "inertial", "dvl": {"dropout": 1.5}}, "dvl.dropout = 1.5"),
    ],
)
def test_settings_that_are_refused(settings, message):
    scenario = THESIS.with_values({KEY: settings})
    with pytest.raises(ScenarioError, match=message):
        run(scenario)


def test_planar_navigation_wants_a_planar_vehicle():
    with pytest.raises((ScenarioError, ModelError), match="set planar = true for vehicle 'auv'"):
        run(DEMO.with_values({KEY: {"kind": "thesis"}}))
