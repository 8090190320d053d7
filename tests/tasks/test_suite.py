"""Contract of all tasks, after dm_control's own suite_test."""

import numpy as np
import pytest
from dm_control.rl import control

from marine_mj import suite
from marine_mj.errors import ScenarioError

#: One variant of each kind; all of them behind the marker.
VARIANTS = ("dock_cpva_ss5", "dock_open_ss2")
OTHERS = [pair for pair in suite.ALL_TASKS if pair not in suite.BASE_TASKS]


@pytest.fixture(
    scope="module", params=[*suite.BASE_TASKS, *(("docking", n) for n in VARIANTS)], ids="-".join
)
def task(request):
    return request.param


def load(task, seed=0, **environment_kwargs):
    return suite.load(
        *task, task_kwargs={"random": seed}, environment_kwargs=environment_kwargs or None
    )


def policy(env, seed=0):
    random, spec = np.random.RandomState(seed), env.action_spec()
    return lambda: random.uniform(spec.minimum, spec.maximum, spec.shape)


def steps(env, episodes=2, length=10, seed=0):
    act = policy(env, seed)
    for _ in range(episodes):
        step = env.reset()
        yield step
        for _ in range(length):
            if step.last():
                break
            step = env.step(act())
            yield step


def test_registry_is_consistent():
    assert len(suite.ALL_TASKS) == sum(len(t) for t in suite.TASKS_BY_DOMAIN.values())
    assert set(suite.BENCHMARKING) <= set(suite.ALL_TASKS)
    assert set(suite.CLOSED_LOOP).isdisjoint(suite.OPEN_LOOP)


def test_unknown_names_list_what_exists():
    with pytest.raises(ValueError, match="domain 'flying' does not exist; available: docking"):
        suite.load("flying", "dock")
    with pytest.raises(ValueError, match="available: dock, dock_pose_pid, dock_open"):
        suite.load("docking", "undock")
    with pytest.raises(ValueError, match="and 63 variants from dock_pose_pid_ss0 to dock_open_ss8"):
        suite.load("docking", "dock_cpva_ss9")
    with pytest.raises(ScenarioError, match="controller = 'pid'"):
        suite.load("docking", "dock", {"controller": "pid"})
    with pytest.raises(ValueError, match="no reward colours"):
        suite.load("docking", "dock", visualize_reward=True)


def test_variants_are_controllers_by_sea_states():
    names = {name for _, name in OTHERS}
    controllers = ("pose_pid", "cpv", "cpva", "lqr", "sliding", "mpc", "open")
    assert names == {f"dock_{c}_ss{n}" for c in controllers for n in range(9)}
    open_loop = {("docking", f"dock_open_ss{n}") for n in range(9)} | {("docking", "dock_open")}
    assert set(suite.OPEN_LOOP) == open_loop
    assert (
        set(suite.CLOSED_LOOP)
        == set(suite.ALL_TASKS) - open_loop
        == set(suite.BENCHMARKING) - open_loop
    )
    assert set(suite.TASKS_BY_DOMAIN["docking"]) == names | {"dock", "dock_pose_pid", "dock_open"}


def test_a_variant_is_its_task_with_keywords():
    """Same scenario, same observations; keywords given by the user come first."""
    one = suite.load("docking", "dock_lqr_ss3", {"random": 2})
    two = suite.load("docking", "dock", {"controller": "lqr", "sea_state": 3, "random": 2})
    assert one.task.scenario == two.task.scenario
    settings = one.task.settings
    assert (settings.controller, settings.gain_set, settings.goal_offset) == (
        "lqr",
        "extended",
        0.2,
    )
    assert one.task.scenario.sea.sea_state == 3
    first, second = one.reset().observation, two.reset().observation
    for name, value in first.items():
        np.testing.assert_array_equal(value, second[name])
    calm = suite.load("docking", "dock_lqr_ss3", {"sea_state": 0}).task.scenario
    assert calm.sea.sea_state == 0


def test_pose_pid_flies_on_its_ideal_wrench():
    env = suite.load("docking", "dock_pose_pid_ss2")
    assert env.task.settings.gain_set == "brute_force" and env.physics.model.nu == 8
    thrusters = suite.load(
        "docking", "dock", {"controller": "pose_pid", "gains": "extended", "actuation": "thrusters"}
    )
    assert thrusters.physics.model.nu == 10


def test_action_specs_by_mode():
    closed, opened = (
        load(("docking", name)).action_spec() for name in ("dock_cpv_ss1", "dock_open_ss1")
    )
    assert closed.shape == (3,) and closed.name == "goal_offset"
    assert opened.shape == (8,) and opened.name == "thrusters"


@pytest.mark.validation
@pytest.mark.parametrize("pair", OTHERS, ids="-".join)
def test_random_agent_on_every_variant(pair):
    test_conforms_to_its_specs(pair)
    test_is_deterministic(pair)


def test_conforms_to_its_specs(task):
    env = load(task)
    observation_spec, action_spec = env.observation_spec(), env.action_spec()
    if task in suite.BENCHMARKING:
        assert np.all(action_spec.minimum == -1) and np.all(action_spec.maximum == 1)
    for step in steps(env):
        assert set(step.observation) == set(observation_spec)
        for name, spec in observation_spec.items():
            value = step.observation[name]
            assert value.shape == spec.shape and value.dtype == spec.dtype
            assert np.all(np.isfinite(value)), name
        if step.first():
            assert step.reward is None and step.discount is None
        else:
            assert isinstance(step.reward, float) and isinstance(step.discount, float)
            assert 0 <= step.discount <= 1
            if task in suite.BENCHMARKING:
                assert 0 <= step.reward <= 1


def test_is_deterministic(task):
    for one, two in zip(steps(load(task, 3)), steps(load(task, 3)), strict=True):
        assert (one.step_type, one.reward, one.discount) == (
            two.step_type,
            two.reward,
            two.discount,
        )
        for name, value in one.observation.items():
            np.testing.assert_array_equal(value, two.observation[name], err_msg=name)


def test_initial_state_is_random(task):
    env = load(task, 42)
    one, two = env.reset().observation, env.reset().observation
    assert not all(np.all(one[name] == two[name]) for name in one)


def test_flat_observation(task):
    assert set(load(task, flat_observation=True).observation_spec()) == {
        control.FLAT_OBSERVATION_KEY
    }


def test_observations_share_no_memory(task):
    env = load(task)
    first = env.reset().observation
    second = env.step(np.zeros(env.action_spec().shape)).observation
    for name, value in first.items():
        assert not np.may_share_memory(value, second[name]), name


def test_observations_have_no_constant_elements(task):
    seen = [step.observation for step in steps(load(task), length=60)]
    for name in seen[0]:
        values = np.array([observation[name] for observation in seen])
        assert not np.any(np.all(values == values[0], axis=0)), name


def test_everything_in_the_model_has_a_name_or_is_a_geom(task):
    """Visual and collision geoms of vehicles may be anonymous; what is looked up may not."""
    model = load(task).physics.model
    for kind, count in (
        ("body", model.nbody),
        ("joint", model.njnt),
        ("site", model.nsite),
        ("camera", model.ncam),
        ("equality", model.neq),
        ("actuator", model.nu),
        ("numeric", model.nnumeric),
    ):
        for i in range(count):
            assert model.id2name(i, kind), f"{kind} {i}"


def test_has_at_least_two_cameras(task):
    assert load(task).physics.model.ncam >= 2


def test_time_limit(task):
    env = load(task, time_limit=0.05)
    assert [s.last() for s in steps(env, episodes=1)] == [False] * 5 + [True]
