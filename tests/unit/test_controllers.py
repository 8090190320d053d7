"""PID, pose PID and allocation against hand-computed values."""

import numpy as np
import pytest
from marine_mj.controllers import (
    Allocator,
    Demand,
    Hydrostatics,
    Limits,
    Pid,
    PidGains,
    PosePid,
    RigidState,
    gain_set,
    limits_from_frd,
    pose_error,
    relative_velocity,
)
from marine_mj.controllers.pose_pid import SCOUT_WRENCH_HIGH_FRD, SCOUT_WRENCH_LOW_FRD
from scipy.optimize import lsq_linear

from marine_mj import frames
from marine_mj.errors import ScenarioError

PERIOD = 0.01
WIDE = Limits(np.full(2, -1e9), np.full(2, 1e9))


def random_state(rng, shape=()):
    quaternion = rng.normal(size=(*shape, 4))
    quaternion /= np.linalg.norm(quaternion, axis=-1, keepdims=True)
    return RigidState(rng.normal(size=(*shape, 3)), quaternion, rng.normal(size=(*shape, 6)))


def test_pid_sequence_by_hand():
    pid = Pid(PidGains([2.0, 1.0], [10.0, 0.0], [0.1, 0.0]), WIDE, PERIOD)
    state = pid.initial()
    first, state = pid.update(state, np.array([1.0, -1.0]))
    # First call: no derivative; integral 10 * 1 * 0.01.
    np.testing.assert_allclose(first, [2.1, -1.0], rtol=0, atol=1e-14)
    second, state = pid.update(state, np.array([1.5, -1.0]))
    # 3 + (0.1 + 0.15) + 0.1 * 0.5 / 0.01
    np.testing.assert_allclose(second, [8.25, -1.0], rtol=0, atol=1e-12)


def test_pid_limits_and_anti_windup():
    limits = Limits(np.array([-4.0]), np.array([10.0]))
    pid = Pid(PidGains([0.0], [100.0], [0.0]), limits, PERIOD)
    state = pid.initial()
    for _ in range(100):
        output, state = pid.update(state, np.array([1.0]))
    assert output == 5.0  # the integral is held at half the upper limit
    for _ in range(100):
        output, state = pid.update(state, np.array([-1.0]))
    assert output == -2.0
    output, _ = pid.update(state, np.array([0.0]), feed_forward=100.0)
    assert output == 10.0  # feed-forward is added before the clip


def test_pid_is_vectorised_and_state_is_not_shared():
    rng = np.random.default_rng(0)
    pid = Pid(PidGains([2.0, 1.0], [10.0, 3.0], [0.1, 0.2]), WIDE, PERIOD)
    errors = rng.normal(size=(5, 7, 2))
    many = pid.initial((7,))
    single = [pid.initial() for _ in range(7)]
    for error in errors:
        before = many.integral.copy()
        kept = many
        output, many = pid.update(many, error)
        np.testing.assert_array_equal(kept.integral, before)
        for i in range(7):
            one, single[i] = pid.update(single[i], error[i])
            np.testing.assert_array_equal(one, output[i])


def test_pid_reset_of_some():
    pid = Pid(PidGains([1.0], [1.0], [1.0]), Limits(np.array([-9.0]), np.array([9.0])), PERIOD)
    _, state = pid.update(pid.initial((2,)), np.ones((2, 1)))
    state = state.reset(np.array([True, False]))
    assert np.isnan(state.previous[0, 0]) and state.integral[0, 0] == 0
    assert state.previous[1, 0] == 1 and state.integral[1, 0] == 0.01


def test_bad_settings_say_what_is_wrong():
    with pytest.raises(ScenarioError, match=r"gain I must be finite and >= 0"):
        PidGains([1.0], [-1.0], [0.0])
    with pytest.raises(ScenarioError, match="period must be > 0"):
        Pid(PidGains([1.0], [1.0], [0.0]), WIDE, 0.0)
    with pytest.raises(ScenarioError, match="low <= high"):
        Limits(np.array([1.0]), np.array([-1.0]))
    with pytest.raises(ScenarioError, match="available: manual, brute_force"):
        gain_set("ziegler")


def test_limits_from_frd():
    limits = limits_from_frd(SCOUT_WRENCH_LOW_FRD, np.array([192.0, 60, 68, 5, 20, 20]))
    np.testing.assert_array_equal(limits.low, [-152, -60, -68, -5, -20, -20])
    np.testing.assert_array_equal(limits.high, [192, 68, 68, 5, 20, 20])


def test_pose_error_moves_the_body_onto_the_target():
    rng = np.random.default_rng(1)
    body, target = random_state(rng, (20,)), random_state(rng, (20,))
    error = pose_error(target, body)
    moved = body.position + np.einsum("...ij,...j->...i", body.rotation, error[..., :3])
    np.testing.assert_allclose(moved, target.position, atol=1e-14)
    angle = np.linalg.norm(error[..., 3:], axis=-1, keepdims=True)
    turn = np.concatenate([np.cos(angle / 2), np.sin(angle / 2) * error[..., 3:] / angle], axis=-1)
    reached = frames.rotation_from_quaternion(frames.quaternion_multiply(body.quaternion, turn))
    np.testing.assert_allclose(reached, target.rotation, atol=1e-12)


def test_attached_frame_moves_as_its_carrier():
    rng = np.random.default_rng(2)
    body = random_state(rng)
    point = body.attached([1.0, 2.0, 3.0], frames.quaternion_from_euler([0.1, -0.4, 2.0]))
    # Same rigid body: no relative velocity in rotation, and finite differences agree.
    np.testing.assert_allclose(relative_velocity(point, body)[3:], 0, atol=1e-14)
    h = 1e-6
    spin = body.velocity[3:] * h
    turn = np.concatenate([[1.0], spin / 2])
    turn /= np.linalg.norm(turn)
    later = RigidState(
        body.position + h * body.linear_velocity,
        frames.quaternion_multiply(body.quaternion, turn),
        body.velocity,
    ).attached([1.0, 2.0, 3.0])
    np.testing.assert_allclose(
        (later.position - point.position) / h, point.linear_velocity, atol=1e-5
    )


def test_hydrostatic_feed_forward_of_the_reference():
    """Digest 6.1: X = -(B-W) sin, Z = (B-W) cos, M = 0.01 B sin, in FRD with bow-up pitch."""
    weight, buoyancy, theta = 603.3, 613.3, 0.3
    statics = Hydrostatics(weight, buoyancy, np.zeros(3), np.array([0.0, 0.0, 0.01]))
    _, quaternion = frames.pose_from_eta([0, 0, 5, 0, theta, 0])
    wrench = frames.flip(statics.feed_forward(frames.rotation_from_quaternion(quaternion)))
    expected = [-10 * np.sin(theta), 0, 10 * np.cos(theta), 0, 0.01 * buoyancy * np.sin(theta), 0]
    np.testing.assert_allclose(wrench, expected, atol=1e-12)


def test_pose_pid_surge_and_heave_signs():
    limits = limits_from_frd(SCOUT_WRENCH_LOW_FRD, SCOUT_WRENCH_HIGH_FRD)
    controller = PosePid.from_name("manual", limits, PERIOD)
    level = np.array([1.0, 0, 0, 0])
    body = RigidState(np.zeros(3), level, np.zeros(6))
    target = RigidState(np.array([0.1, 0.0, 0.2]), level, np.zeros(6))
    wrench, _ = controller.update(controller.initial(), body, Demand(target))
    # 200 * 0.1 + 3 * 0.1 * 0.01 and 150 * 0.2 + 15 * 0.2 * 0.01
    np.testing.assert_allclose(wrench, [20.003, 0, 30.03, 0, 0, 0], atol=1e-12)
    pushed, _ = controller.update(
        controller.initial(), body, Demand(target, scale=np.zeros(6), push=np.array([0, 0, 20.0]))
    )
    np.testing.assert_allclose(pushed, [0, 0, 20, 0, 0, 0], atol=1e-12)


def scout_thrusters():
    """Thruster matrix of digest 3.4 (FLU): 4 forward, 2 lateral, 2 vertical."""
    columns, low, high = [], [], []
    for y, z in ((0.2, 0.1), (-0.2, 0.1), (0.2, -0.1), (-0.2, -0.1)):
        columns.append([1, 0, 0, 0, z, -y])
        low.append(-38.0)
        high.append(48.0)
    for x in (0.294, -0.294):
        columns.append([0, 1, 0, -0.05 * np.sign(x), 0, x])
        columns.append([0, 0, 1, 0, -x, 0])
        low += [-34.0, -34.0]
        high += [34.0, 34.0]
    return np.array(columns, dtype=float).T, Limits(np.array(low), np.array(high))


def test_allocation_reaches_what_is_reachable():
    matrix, limits = scout_thrusters()
    allocator = Allocator(matrix, limits)
    rng = np.random.default_rng(3)
    commands = rng.uniform(-0.4, 0.4, size=(50, 8)) * np.minimum(-limits.low, limits.high)
    wrench = commands @ matrix.T
    found, achieved = allocator.allocate(wrench)
    np.testing.assert_allclose(achieved, wrench, atol=1e-5)  # measured 5e-7
    assert np.all(found >= limits.low) and np.all(found <= limits.high)


def test_allocation_keeps_asymmetric_limits_and_redistributes():
    matrix, limits = scout_thrusters()
    allocator = Allocator(matrix, limits)
    wrench = np.array([[192.0, 0, 0, 0, 0, 0], [-152.0, 0, 0, 0, 0, 0], [1e4, 0, 0, 0, 0, 0]])
    _, achieved = allocator.allocate(wrench)
    np.testing.assert_allclose(achieved[:, 0], [192, -152, 192], rtol=1e-4)
    # One weak thruster: the others take over.
    weak = Allocator(matrix, Limits(limits.low, np.where(np.arange(8) == 0, 5.0, limits.high)))
    _, achieved = weak.allocate(np.array([80.0, 0, 0, 0, 0, 0]))
    assert achieved[0] == pytest.approx(80.0, rel=0.02)
    single, _ = allocator.allocate(wrench[0])
    np.testing.assert_array_equal(single, allocator.allocate(wrench)[0][0])


def test_allocation_is_the_bounded_least_squares_solution():
    matrix, limits = scout_thrusters()
    weight = np.array([1.0, 1.0, 3.0, 3.3, 3.3, 3.3])
    allocator = Allocator(matrix, limits, weight)
    rng = np.random.default_rng(4)
    wanted = rng.normal(size=(100, 6)) * [150, 70, 70, 4, 20, 20]
    _, achieved = allocator.allocate(wanted)
    for wrench, found in zip(wanted, achieved, strict=True):
        best = lsq_linear(
            weight[:, None] * matrix, weight * wrench, (limits.low, limits.high), method="bvls"
        )
        assert np.sum((weight * (found - wrench)) ** 2) <= 2 * best.cost + 1e-5


def test_allocation_does_not_give_up_surge_for_a_moment_out_of_reach():
    allocator = Allocator(*scout_thrusters())
    _, achieved = allocator.allocate(np.array([-60.0, 0, 68.0, 0, 20.0, 0]))
    # The clipped pseudo-inverse gave +20 N.
    assert achieved[0] < -50
    assert abs(achieved[3]) < 0.1


def test_allocation_refuses_wrong_shapes():
    matrix, limits = scout_thrusters()
    with pytest.raises(ScenarioError, match=r"shape \(6, m\)"):
        Allocator(matrix.T, limits)
    with pytest.raises(ScenarioError, match="8 thrusters need 8 limits"):
        Allocator(matrix, Limits(limits.low[:3], limits.high[:3]))
    with pytest.raises(ScenarioError, match="contain zero"):
        Allocator(matrix, Limits(limits.high, limits.high))
