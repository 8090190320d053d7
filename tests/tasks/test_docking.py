"""Docking physics, task and runner."""

import copy
import pickle

import mujoco
import numpy as np
import pytest
from marine_mj.controllers import RigidState

from marine_mj import frames, hydrodynamics, suite
from marine_mj.errors import ModelError, ScenarioError, SimulationError
from marine_mj.scenario import Scenario
from marine_mj.scene import build_scene, compile_scene, scene_from_log
from marine_mj.simulation import Log, run, run_batch
from marine_mj.tasks import build_environment
from marine_mj.tasks.docking_physics import DockingPhysics

CALM = {"sea.spectrum": "none", "sea.sea_state": None, "sea.spreading": None}


def scenario(name="docking_demo", **changes):
    return Scenario.load(name).with_values(changes)


@pytest.fixture(scope="module")
def calm_env():
    return build_environment(scenario(**CALM), random=0)


def test_state_reader_agrees_with_mujoco(calm_env):
    calm_env.reset()
    physics = calm_env.physics
    physics.step(40)
    model, data = physics.model.ptr, physics.data.ptr
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_comVel(model, data)
    for instance in physics.vehicles:
        state, body = physics.vehicle_state(instance), physics.main_body(instance)
        np.testing.assert_allclose(state.position, data.xpos[body], atol=1e-12)
        np.testing.assert_allclose(
            frames.rotation_from_quaternion(state.quaternion).ravel(), data.xmat[body], atol=1e-12
        )
        velocity = np.zeros(6)
        mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_XBODY, body, velocity, 1)
        np.testing.assert_allclose(state.velocity, np.roll(velocity, 3), atol=1e-12)


def test_planar_vehicle_reads_and_writes_the_same_state():
    env = build_environment(scenario("docking_thesis"), random=0)
    physics = env.physics
    reader = physics.reader("auv")
    _, attitude = frames.pose_from_eta([0, 0, 0, 0, 0.3, 0])
    wanted = RigidState(np.array([3.0, 0.0, -2.0]), attitude, np.array([0.5, 0, 0.2, 0, 0.1, 0]))
    reader.write(physics.data.qpos, physics.data.qvel, wanted)
    state = physics.vehicle_state("auv")
    np.testing.assert_allclose(state.position, wanted.position, atol=1e-14)
    np.testing.assert_allclose(state.quaternion, wanted.quaternion, atol=1e-14)
    np.testing.assert_allclose(state.velocity, wanted.velocity, atol=1e-14)
    mujoco.mj_kinematics(physics.model.ptr, physics.data.ptr)
    np.testing.assert_allclose(physics.data.xpos[physics.main_body("auv")], wanted.position)


def test_dock_frames_of_the_reference(calm_env):
    dock = calm_env.physics.dock_frames
    np.testing.assert_allclose(dock.aperture, [0, 0, -1.0], atol=1e-12)
    np.testing.assert_allclose(dock.seat, [0, 0, -0.5], atol=1e-12)


def test_allocation_of_the_model_gives_the_wrench_mujoco_applies(calm_env):
    calm_env.reset()
    physics = calm_env.physics
    allocator = physics.allocator("auv")
    commands, achieved = allocator.allocate(np.array([20.0, 5.0, -10.0, 1.0, 2.0, -1.0]))
    np.testing.assert_allclose(achieved, [20.0, 5.0, -10.0, 1.0, 2.0, -1.0], atol=1e-4)
    physics.data.act[:8] = commands  # behind them: the radiation memory of the carrier
    physics.data.ctrl[:8] = commands
    mujoco.mj_forward(physics.model.ptr, physics.data.ptr)
    reader = physics.reader("auv")
    force = physics.data.qfrc_actuator[reader.qvel : reader.qvel + 6].copy()
    rotation = physics.vehicle_state("auv").rotation
    force[:3] = rotation.T @ force[:3]
    np.testing.assert_allclose(force, achieved, atol=1e-10)


def test_hydrostatics_of_the_scout(calm_env):
    statics = calm_env.physics.hydrostatics("auv", 1025.0)
    assert statics.weight == pytest.approx(603.3, abs=0.1)
    assert statics.buoyancy == pytest.approx(613.4, abs=0.1)
    np.testing.assert_allclose(statics.center_of_buoyancy, [0, 0, 0.01], atol=1e-12)


def test_copy_and_pickle_keep_everything(calm_env):
    calm_env.reset()
    physics = calm_env.physics
    physics.step(20)
    for other in (physics.copy(), copy.deepcopy(physics), pickle.loads(pickle.dumps(physics))):
        assert isinstance(other, DockingPhysics)
        np.testing.assert_array_equal(other.dock_error(), physics.dock_error())
        branch = physics.copy()
        other.step(10)
        branch.step(10)
        np.testing.assert_array_equal(other.get_state(), branch.get_state())


def test_latch_holds_the_pose_it_closed_in(calm_env):
    calm_env.reset()
    physics = calm_env.physics
    _, seat = physics.dock_states()
    # The throat of the surge guide has 1 cm of play.
    start = RigidState(seat.position + np.array([0.008, 0, -0.02]), seat.quaternion, np.zeros(6))
    physics.reader("auv").write(physics.data.qpos, physics.data.qvel, start)
    physics.close_latch()
    before = physics.dock_error()
    physics.step(400)
    assert physics.latched()
    # Measured 0.4 mm under 10 N of net buoyancy.
    np.testing.assert_allclose(physics.dock_error()[:3], before[:3], atol=2e-3)


def test_relative_energy_is_that_of_the_dry_mass(calm_env):
    calm_env.reset()
    physics = calm_env.physics
    carrier = physics.vehicle_state("usv")
    moving = RigidState(np.array([5.0, 0, -3]), carrier.quaternion, np.array([1.0, 0, 0, 0, 0, 0]))
    still = RigidState(carrier.position, carrier.quaternion, np.zeros(6))
    physics.reader("usv").write(physics.data.qpos, physics.data.qvel, still)
    physics.reader("auv").write(physics.data.qpos, physics.data.qvel, moving)
    assert physics.relative_energy() == pytest.approx(0.5 * 61.5)


def test_nan_control_says_which_actuator_and_when():
    env = build_environment(scenario("docking_demo", **{"task.name": "dock_open"} | CALM), random=0)
    env.reset()
    env.step(np.zeros(8))
    action = np.zeros(8)
    action[2] = np.nan
    with pytest.raises(
        SimulationError, match=r"'auv/thruster_3' is nan at t = 0\.010 s: the controller must give"
    ):
        env.step(action)


def test_failed_run_keeps_its_log():
    chosen = scenario(**{"task.name": "dock_open", "duration": 2.0} | CALM)

    def broken(step):
        return np.full(8, np.nan if step.observation["depth"][0] > 0 and broken.calls() else 0.0)

    count = iter(range(10**6))
    broken.calls = lambda: next(count) >= 50
    with pytest.raises(SimulationError, match=r"is nan at t = 0\.500 s") as caught:
        run(chosen, policy=broken)
    log = caught.value.log
    assert log.data.time.values[-1] == pytest.approx(0.48)
    assert "is nan" in log.summary["error"]


def test_run_is_reproducible_and_replayable(tmp_path):
    chosen = scenario(duration=0.5)
    first, second = run(chosen), run(chosen)
    np.testing.assert_array_equal(first.data.qpos, second.data.qpos)
    log = Log.load(first.save(tmp_path / "log.nc"))
    scene = scene_from_log(log)
    assert scene.model.nq == log.data.qpos.shape[1]
    np.testing.assert_array_equal(
        scene.environment.waves.phase, compile_scene(chosen).environment.waves.phase
    )
    assert log.data.eta_ned.attrs == {
        "units": "m, rad",
        "long_name": log.data.eta_ned.long_name,
        "frame": "NED",
    }
    assert list(log.data.vehicle.values) == ["usv", "auv"]
    np.testing.assert_allclose(log.data.eta_ned.sel(vehicle="auv")[0, :3], [3.0, 1.5, 4.0])
    other = run(chosen.with_values({"seed": 2}))
    assert not np.array_equal(first.data.qpos, other.data.qpos)


def test_thesis_mode_enters_the_dock():
    log = run("docking_thesis")
    capture = log.summary["capture"]
    # Limits of the reference (digest 3.7); measured 0.02 m, 0.001 rad, 7 J.
    assert abs(capture["surge_error"]) < 0.5 and abs(capture["sway_error"]) < 1e-9
    assert abs(capture["pitch_error"]) < np.deg2rad(15)
    assert capture["relative_kinetic_energy"] < 30
    assert log.data.eta_ned.sel(vehicle="auv", dof=["sway", "roll", "yaw"]).max() < 1e-9


def test_calm_water_docks_gently():
    log = run(scenario(**CALM))
    assert log.summary["docked"] and not log.summary["forbidden_contact"]
    end = log.data.dock_error.values[-1]
    assert np.linalg.norm(end[:3]) < 0.05 and np.linalg.norm(end[3:]) < np.deg2rad(3)
    # The latch never closes outside its limits.
    closed = np.flatnonzero(log.data.latched.values > 0.5)[0]
    assert np.linalg.norm(log.data.dock_error.values[closed][:3]) < 0.05
    assert np.linalg.norm(log.data.relative_velocity.values[closed][:3]) < 0.1


@pytest.mark.validation
@pytest.mark.parametrize(("sea_state", "seed"), [(3, 1), (3, 2), (3, 5), (4, 1), (4, 3)])
def test_demo_settings_dock_in_a_seaway(sea_state, seed):
    log = run(scenario(seed=seed, duration=90.0, **{"sea.sea_state": sea_state}))
    summary = log.summary
    assert summary["docked"] and not summary["forbidden_contact"]
    assert summary["peak_contact_force"] < 6000
    # The forks were not needed to find the way: entered on the centre line.
    assert abs(summary["capture"]["surge_error"]) < 0.2
    assert abs(summary["capture"]["sway_error"]) < 0.1


@pytest.mark.parametrize(
    ("changes", "error", "message"),
    [
        ({"task.domain": "flying"}, ScenarioError, "'flying' does not exist; available: docking"),
        ({"task.name": "undock"}, ScenarioError, "available: dock, dock_pose_pid, dock_open"),
        ({"task.settings.gain": 1}, ScenarioError, r"task\.settings: gain = 1.*Did you mean 'gai"),
        ({"task.settings.gains": "manual"}, ScenarioError, "'cpv'; available: reference, ext"),
        ({"task.settings.vehicle": "rov"}, ModelError, "needs vehicle 'rov'; the scenario has"),
        ({"vehicles.auv.model": "titanic"}, ModelError, "titanic"),
        ({"vehicles.auv.model": "cradle"}, ModelError, "has no free joint"),
        ({"vehicles.usv.dock": None}, ModelError, "has no latch"),
        ({"vehicles.usv.model": "scout"}, ModelError, "no site 'dock_mount'"),
    ],
)
def test_bad_settings_are_refused_before_the_run(changes, error, message):
    with pytest.raises(error, match=message):
        build_environment(scenario(**changes), random=0)


def test_wrench_actuation_replaces_the_thrusters():
    spec = build_scene(scenario("docking_thesis"))
    names = [a.name for a in spec.actuators]
    assert names == [f"auv/{a}" for a in ("surge", "sway", "heave", "roll", "pitch", "yaw")]
    np.testing.assert_array_equal(spec.actuators[0].ctrlrange, [-152, 192])


def test_goal_offset_shifts_the_target():
    env = suite.load("docking", "dock", task_kwargs={"random": 0, "start_spread": 0.0})
    env.reset()
    env.step(np.zeros(3))
    before = env.task.signals(env.physics)["target_ned"]
    env.step(np.array([0.0, 1.0, 0.0]))
    moved = env.task.signals(env.physics)["target_ned"] - before
    assert 0.15 < np.linalg.norm(moved) < 0.25


def test_goal_bias_shifts_the_entry_with_its_sign():
    """In calm water, FRD as the errors at the capture: forward and bow up, backward and down."""
    base = Scenario.load("docking_thesis").with_values({"sea.sea_state": 0, "duration": 15.0})
    bias = np.array([0.2, 0, 0, 0, 0.1, 0])
    key = "task.settings.plan.goal_bias"
    rows = run_batch(base, [{}, {key: bias.tolist()}, {key: (-bias).tolist()}]).rows
    alone = run_batch(base, [{key: bias.tolist()}]).rows[0]
    assert alone["capture"] == rows[1]["capture"]  # the same bits in a stacked plan
    for name, expected in (("surge_error", 0.2), ("pitch_error", 0.1)):
        plain, forward, backward = (row["capture"][name] for row in rows)
        # The way to a goal 5 cm beyond the aperture: measured 0.205 m and 0.100 rad.
        assert forward - plain == pytest.approx(expected, rel=0.05)
        assert backward - plain == pytest.approx(-expected, rel=0.05)


def test_what_is_only_seen_does_not_move_anything():
    ends = []
    for visual in (True, False):
        model = compile_scene(scenario(), visual=visual).model
        data = mujoco.MjData(model)
        hydrodynamics.start_in_waves(model, data)
        mujoco.mj_step(model, data, 400)
        ends.append(data.qpos.copy())
    assert (ends[0] == ends[1]).all()


def test_reference_pose_pid_docks():
    """Brute-force gains on the ideal wrench, as published: latched in sea state 2."""
    env = suite.load("docking", "dock_pose_pid")
    assert env.task.settings.controller == "pose_pid" and env.physics.model.nu == 8
    changes = {"sea.sea_state": 2, "seed": 1, "vehicles.auv.actuation": "wrench"}
    chosen = {"task.settings.controller": "pose_pid", "task.settings.gains": "brute_force"}
    summary = run(scenario(**changes, **chosen)).summary
    # measured: latched at 15.4 s, 5.1 kN
    assert summary["docked"] and not summary["forbidden_contact"]
