"""The docking study's benchmark: same physics as the study, and its limits held."""

import mujoco
import numpy as np
import pytest
from marine_mj.controllers import RigidState

from marine_mj.analysis.docking import Entries, interval, operable
from marine_mj.campaign import Campaign, Plan
from marine_mj.errors import ScenarioError
from marine_mj.scenario import Scenario
from marine_mj.scene import compile_scene
from marine_mj.simulation import run, run_batch
from marine_mj.tasks.docking import mission
from marine_mj.tasks.docking_settings import DockingSettings
from marine_mj.weather import environment_of

BENCHMARK = Scenario.load("docking_benchmark")
APERTURE = "task.settings.plan.aperture"
NAVIGATION = {"sea.sea_state": 7, "task.settings.navigation.kind": "thesis"}


def test_only_the_controller_differs_from_the_study():
    study = Scenario.load("docking_thesis")
    settings = study.task.settings
    assert settings["controller"] == "pose_pid"
    same = {"name": study.name, "description": study.description, "duration": 120.0}
    back = BENCHMARK.with_values({**same, "sea.sea_state": 4, "task.settings": settings})
    assert back == study


def test_vehicle_moves_as_the_equations_of_the_study():
    """Digest 3.2 in component form, integrated apart from the simulator with its commands."""
    chosen = BENCHMARK.with_values({"duration": 1.5, "log_period": 0.01, "seed": 3})
    data = run(chosen).data.sel(vehicle="auv")
    states = np.concatenate(
        [data.eta_ned.values[:, [0, 2, 4]], data.nu_frd.values[:, [0, 2, 4]]], 1
    )
    # Command k acts from sample k - 1 to sample k.
    wrench = data.wrench_command.values[:, [0, 2, 4]] * [1.0, -1.0, -1.0]
    waves = environment_of(chosen).waves

    def rates(t, y, tau):
        x, z, theta, u, w, q = y
        s, c = np.sin(theta), np.cos(theta)
        turn = np.array([[c, -s], [s, c]])
        at = (x, 0.0, -max(z, 0.0), t)
        v, a = waves.velocity(*at)[[0, 2]] * [1, -1], waves.acceleration(*at)[[0, 2]] * [1, -1]
        (uw, ww), (duw, dww) = turn @ v, turn @ a + q * np.array([[-s, -c], [c, -s]]) @ v
        ur, wr, net = u - uw, w - ww, 613.4 - 603.3
        du = tau[0] + 5.8 * duw - 61.5 * q * w - 65.1 * wr * q - 42.1 * ur * abs(ur) + net * s
        dw = tau[1] + 65.1 * dww + 61.5 * q * u + 5.8 * ur * q - 502.4 * wr * abs(wr) - net * c
        dq = tau[2] + 59.3 * ur * wr - 109.5 * q * abs(q) - 0.01 * 613.4 * s
        return np.array([c * u + s * w, -s * u + c * w, q, du / 67.3, dw / 126.6, dq / 26.12])

    y, h = states[0], 0.01
    for k in range(len(states) - 1):
        t, tau = k * h, wrench[k + 1]
        k1 = rates(t, y, tau)
        k2 = rates(t + h / 2, y + h / 2 * k1, tau)
        k3 = rates(t + h / 2, y + h / 2 * k2, tau)
        y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + rates(t + h, y + h * k3, tau))
    # The simulator's steps of 5 ms are of first order: 4.2e-3.
    np.testing.assert_allclose(states[-1], y, atol=0.01)
    assert np.abs(states[-1] - states[0]).max() > 0.5


@pytest.mark.parametrize(("aperture", "counts"), [([0.5, 0.4], False), ([100.0, 100.0], True)])
def test_a_crossing_beside_the_aperture_counts_where_the_settings_say_so(aperture, counts):
    """Raised past the aperture 0.8 m ahead of it, once waypoint 2 has been reached."""
    chosen = BENCHMARK.with_values({APERTURE: aperture, "sea.sea_state": 0})
    model = compile_scene(chosen, visual=False).model
    judge = mission(chosen, model)
    reader = judge.geometry.vehicle_reader
    state, data = judge.initial(0.0), mujoco.MjData(model)
    judge.place(chosen, model, data, np.random.RandomState(0))
    goal = judge.view(data.qpos, data.qvel).dock[0].position
    level, still, contacts = np.array([1.0, 0, 0, 0]), np.zeros(6), np.zeros((1, 4))
    # Waypoint 1, waypoint 2, then up.
    for place in ([-1, 0, -3], [0, 0, -1], [0.8, 0, -0.2], [0.8, 0, 0.1]):
        reader.write(data.qpos, data.qvel, RigidState(goal + place, level, still))
        view = judge.view(data.qpos.copy(), data.qvel.copy())
        _, state = judge.command(state, view, np.asarray(False))
        state, _ = judge.observe(state, view, 1.0, np.asarray(False), contacts)
    assert bool(judge.finished(state, 1.0, np.asarray(False))) is counts
    if counts:
        assert state.capture[1] == pytest.approx(0.8, abs=1e-9)


def test_aperture_must_be_positive():
    with pytest.raises(ScenarioError, match=r"plan\.aperture\.0 = -0\.5: .*greater than 0"):
        DockingSettings.parse({"plan": {"aperture": [-0.5, 0.4]}}, "task.settings")


def test_campaign_has_both_targets():
    plan = Plan(Campaign.load("docking_benchmark"))
    cells = [BENCHMARK.with_values(plan.campaign.factors["case"].changes(i)) for i in (0, 1)]
    assert [cell.sea.sea_state for cell in cells] == [8, 7]
    kinds = [DockingSettings.parse(c.task.settings, "").navigation for c in cells]
    assert [k.kind for k in kinds] == ["perfect", "thesis"] and kinds[1].scenario == "base"
    assert plan.campaign.runs == 1000


def held(changes, seeds):
    """Which intervals lie inside the limits, and all entries, of runs with these seeds."""
    rows = run_batch(BENCHMARK.with_values(changes), [{"seed": seed} for seed in seeds]).rows
    entries = Entries.of(rows)
    assert entries.complete and not any(row["error"] for row in rows)
    return operable(entries), entries


@pytest.mark.validation
@pytest.mark.parametrize("changes", [{}, NAVIGATION])
def test_benchmark_holds(changes):
    good, entries = held(changes, range(40_000, 40_060))
    assert good["total"], {m: interval(entries, m) for m in ("surge", "pitch", "energy")}


@pytest.mark.validation
def test_controller_of_the_study_does_not_hold():
    published = {"controller": "pose_pid", "gains": "brute_force"}
    changes = {f"task.settings.{name}": value for name, value in published.items()}
    assert not held(changes, range(40_000, 40_060))[0]["total"]
