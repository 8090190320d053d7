"""Waypoint manager and latch on scripted motions."""

from dataclasses import fields, is_dataclass, replace

import numpy as np
import pytest
from marine_mj.controllers import DockingGuidance, DockingPlan, Latch, Phase, RigidState

from marine_mj import trees
from marine_mj.errors import ScenarioError
from marine_mj.frames import quaternion_from_euler

LEVEL = np.array([1.0, 0, 0, 0])
PERIOD = 0.01


def at(*position, velocity=(0.0,) * 6):
    return RigidState(np.array(position, dtype=float), LEVEL, np.array(velocity))


CARRIER = at(10, 0, 0)
APERTURE = CARRIER.attached([0, 0, -1.0])
SEAT = CARRIER.attached([0, 0, -0.5])


def update(guidance, state, vehicle, latched=False):
    return guidance.update(state, vehicle, CARRIER, APERTURE, SEAT, np.asarray(latched), PERIOD)


def test_waypoints_of_the_reference_in_order():
    guidance = DockingGuidance()
    command, state = update(guidance, guidance.initial(), at(7, 0, -4))
    assert state.phase == Phase.APPROACH
    np.testing.assert_allclose(command.target.position, [9, 0, -4])
    command, state = update(guidance, state, at(8.8, 0, -4))
    assert state.phase == Phase.UNDER
    np.testing.assert_allclose(command.target.position, [10, 0, -2])
    command, state = update(guidance, state, at(10, 0.2, -2))
    assert state.phase == Phase.WAIT
    np.testing.assert_allclose(command.target.position, [10, 0, -2])
    command, state = update(guidance, state, at(10, 0.2, -2))
    assert state.phase == Phase.ENTER
    np.testing.assert_allclose(command.target.position, [10, 0, -0.95])
    command, state = update(guidance, state, at(10.1, 0, -1.01))
    assert not command.entered
    command, state = update(guidance, state, at(10.1, 0, -0.99))
    assert command.entered and state.phase == Phase.CONTACT and state.attempts == 1
    np.testing.assert_allclose(command.push, [0, 0, 20])
    for _ in range(400):
        command, state = update(guidance, state, at(10, 0, -0.9))
    np.testing.assert_allclose(command.target.position, SEAT.position)
    command, state = update(guidance, state, at(10, 0, -0.5), latched=True)
    assert state.phase == Phase.LATCHED
    np.testing.assert_allclose(command.push, 0)


def test_goal_bias_moves_the_goal_in_the_axes_of_the_dock_and_nothing_else():
    """Axes of the dock: 0.1 m forward is 0.1 m north only where the dock is level and north."""
    turned = RigidState(CARRIER.position, quaternion_from_euler([0, 0.3, 0.5 * np.pi]), np.zeros(6))
    aperture, seat = (turned.attached([0, 0, z]) for z in (-1.0, -0.5))
    biased = DockingGuidance(DockingPlan(goal_bias=(0.1, 0.05, 0.02, 0.0, 0.2, 0.0)))
    for phase in Phase:
        plain, other = (
            g.target(replace(g.initial(), phase=np.array(phase)), turned, aperture, seat)
            for g in (DockingGuidance(), biased)
        )
        shift = other.position - plain.position
        if phase != Phase.ENTER:
            np.testing.assert_array_equal(shift, 0)
            continue
        # yawed by 90 deg, then pitched by 0.3: forward, port and up of the dock in the world
        c, s = np.cos(0.3), np.sin(0.3)
        axes = np.array([[0, c, -s], [-1, 0, 0], [0, s, c]])
        np.testing.assert_allclose(shift, [0.1, 0.05, 0.02] @ axes, atol=1e-12)
        attitude = quaternion_from_euler([0, 0.5, 0.5 * np.pi])
        np.testing.assert_allclose(other.quaternion, attitude, atol=1e-12)


def test_crossing_before_waypoint_2_or_outside_the_aperture_does_not_count():
    guidance = DockingGuidance()
    state = guidance.initial()
    for z in (-1.2, -0.8):
        command, state = update(guidance, state, at(10, 0, z))
    assert not command.entered and state.phase < Phase.CONTACT
    for z in (-1.9, -2.0, -2.0):
        command, state = update(guidance, state, at(10, 0, z))
    # Drive it to the goal phase, then cross beside the aperture.
    _, state = update(guidance, state, at(9, 0, -4))
    for z in (-2.0, -2.0, -1.2):
        _, state = update(guidance, state, at(10, 0, z))
    command, state = update(guidance, state, at(10.6, 0, -0.8))
    assert state.phase == Phase.ENTER and not command.entered


def test_missed_vehicle_waits_again():
    guidance = DockingGuidance()
    initial = guidance.initial()
    state = type(initial)(np.array(4), np.array(0.1), np.array(1.0), np.array(1))
    _, state = update(guidance, state, at(10, 0, -1.4))
    assert state.phase == Phase.WAIT and state.progress == 0


def test_vehicle_that_is_not_latched_in_time_tries_again():
    """Pushing 0.1 m off the seat: back below the aperture after `contact_time`, and in again."""
    for limit, phase in ((np.inf, Phase.CONTACT), (2.0, Phase.WAIT)):
        guidance = DockingGuidance(DockingPlan(contact_time=limit))
        entering = type(guidance.initial())(
            np.array(3), np.array(-0.1), np.array(0.0), np.array(0), pushed=np.array(0.0)
        )
        _, state = update(guidance, entering, at(10, 0.1, -0.9))
        for _ in range(198):  # to 1.98 s
            _, state = update(guidance, state, at(10, 0.1, -0.6))
        assert state.phase == Phase.CONTACT
        for _ in range(3):
            _, state = update(guidance, state, at(10, 0.1, -0.6))
        assert state.phase == phase
    for z in (-2.0, -1.1, -0.9):
        _, state = update(guidance, state, at(10, 0, z))
    assert state.phase == Phase.CONTACT and state.attempts == 2 and state.pushed == 0


def test_waiting_for_low_relative_speed_and_abort():
    guidance = DockingGuidance(DockingPlan(wait_speed=0.5))
    initial = guidance.initial()
    state = type(initial)(np.array(2), np.array(-1.0), np.array(0.0), np.array(0))
    fast = at(10, 0, -2, velocity=np.array([0.8, 0, 0, 0, 0, 0]))
    _, state = update(guidance, state, fast)
    assert state.phase == Phase.WAIT
    _, state = update(guidance, state, at(10, 0, -2))
    assert state.phase == Phase.ENTER
    _, state = update(guidance, state, fast)
    assert state.phase == Phase.WAIT


def test_corridor_sends_a_vehicle_back_down():
    guidance = DockingGuidance(DockingPlan(corridor=(0.35, 0.25)))
    initial = guidance.initial()
    rising = type(initial)(np.array(3), np.array(-0.5), np.array(0.0), np.array(0))
    # 0.5 m below the aperture the corridor is 0.18 m wider on each side.
    _, state = update(guidance, rising, at(10.5, 0.4, -1.5))
    assert state.phase == Phase.ENTER
    for place in ((10.6, 0, -1.5), (10, 0.5, -1.5), (10.4, 0, -1.05)):
        command, state = update(guidance, rising, at(*place))
        assert state.phase == Phase.WAIT
        np.testing.assert_allclose(command.target.position, [10, 0, -2])
    # Above the aperture the forks guide.
    above = type(initial)(np.array(4), np.array(0.1), np.array(0.0), np.array(1))
    _, state = update(guidance, above, at(10.4, 0, -0.9))
    assert state.phase == Phase.CONTACT


def test_entry_waits_for_a_quiet_dock_but_not_for_ever():
    plan = DockingPlan(quiet_rate=0.3, patience=10.0, wait_time=0.5)
    guidance = DockingGuidance(plan)
    below = at(10, 0, -2)

    def waiting(rate, seconds):
        pitching = at(10, 0, 0, velocity=[0, 0, 0, 0, rate, 0])
        aperture, seat = pitching.attached([0, 0, -1.0]), pitching.attached([0, 0, -0.5])
        state = type(guidance.initial())(
            np.array(2), np.array(-1.0), np.array(0.0), np.array(0), turning=np.array(rate**2)
        )
        for _ in range(int(seconds / PERIOD)):
            arguments = (below, pitching, aperture, seat, np.asarray(False), PERIOD)
            _, state = guidance.update(state, *arguments)
        return state.phase

    assert waiting(0.25, 0.45) == Phase.WAIT
    assert waiting(0.25, 0.6) == Phase.ENTER
    assert waiting(0.5, 9.0) == Phase.WAIT
    assert waiting(0.5, 11.0) == Phase.ENTER


def test_vehicle_waits_deeper_while_the_dock_is_not_quiet():
    guidance = DockingGuidance(DockingPlan(quiet_rate=0.3, retreat=0.7))
    for turning, depth in ((0.5**2, 2.7), (0.1**2, 2.0)):
        state = type(guidance.initial())(
            np.array(2), np.array(-1.0), np.array(0.0), np.array(0), turning=np.array(turning)
        )
        command, state = update(guidance, state, at(10, 0, -2.4))
        assert state.phase == Phase.WAIT
        np.testing.assert_allclose(command.target.position, [10, 0, -depth])
        np.testing.assert_allclose(command.follow, [1] * 3 + [0] * 3)  # in either case


def test_an_entry_is_given_up_below_the_aperture_when_the_dock_gets_rough():
    guidance = DockingGuidance(DockingPlan(quiet_rate=0.3))
    for height, turning, phase in (
        (-0.5, 0.35, Phase.ENTER),  # not quiet enough to start, quiet enough to go on
        (-0.5, 0.45, Phase.WAIT),
        (0.1, 0.45, Phase.CONTACT),  # in the forks: the way in is the way out of harm
    ):
        inside = np.array(4 if height > 0 else 3)
        state = type(guidance.initial())(
            inside, np.array(height), np.array(0.0), np.array(1), turning=np.array(turning**2)
        )
        _, state = update(guidance, state, at(10, 0, -1 + height))
        assert state.phase == phase


def test_no_entry_is_given_up_close_to_the_aperture():
    for commit, phase in ((-np.inf, Phase.WAIT), (0.4, Phase.WAIT), (0.6, Phase.ENTER)):
        guidance = DockingGuidance(DockingPlan(quiet_rate=0.3, commit=commit))
        rough = replace(
            guidance.initial(), phase=np.array(3), height=np.array(-0.5), turning=np.array(0.45**2)
        )
        _, state = update(guidance, rough, at(10, 0, -1.5))
        assert state.phase == phase
        _, state = update(guidance, rough, at(10, 0.45, -1.5))  # beside the aperture
        assert state.phase == Phase.WAIT


@pytest.mark.parametrize("phase", [Phase.APPROACH, Phase.UNDER, Phase.WAIT, Phase.AWAY])
def test_riding_waypoints_move_with_the_carrier_but_do_not_turn_with_it(phase):
    """Rolled by 30 deg, 1.5 m up, rolling on: the aperture swings, the waypoints do not."""
    roll = RigidState(
        np.array([10, 0, 1.5]),
        np.array([np.cos(np.pi / 12), np.sin(np.pi / 12), 0, 0]),
        np.array([0.3, 0.8, -0.6, 0.5, 0, 0]),
    )
    aperture, seat = (roll.attached([0, 0, z]) for z in (-1.0, -0.5))
    guidance = DockingGuidance(DockingPlan(ride=True))
    there = replace(guidance.initial(), phase=np.array(int(phase)))
    arguments = (at(0, 0, -9), roll, aperture, seat, np.asarray(False), PERIOD)
    command, _ = guidance.update(there, *arguments)
    expected = {Phase.UNDER: [10, 0, -0.5], Phase.WAIT: [10, 0, -0.5]}
    np.testing.assert_allclose(command.target.position, expected.get(phase, [9, 0, -2.5]))
    np.testing.assert_allclose(command.target.linear_velocity, roll.linear_velocity)
    np.testing.assert_allclose(command.target.velocity[3:], 0)
    np.testing.assert_allclose(command.follow, [1] * 3 + [0] * 3)
    assert command.riding


def test_waypoints_on_the_way_may_be_passed_at_a_distance():
    for passing, phase in ((None, Phase.UNDER), (1.0, Phase.WAIT)):
        guidance = DockingGuidance(DockingPlan(passing=passing))
        under = type(guidance.initial())(np.array(1), np.array(-1.0), np.array(0.0), np.array(0))
        _, state = update(guidance, under, at(10, 0.8, -2))
        assert state.phase == phase
        # The point below the aperture still has to be met closely.
        _, state = update(guidance, replace(under, phase=np.array(2)), at(10, 0.8, -2))
        assert state.phase == Phase.WAIT


def test_guidance_is_vectorised():
    guidance = DockingGuidance()
    rng = np.random.default_rng(0)
    positions = np.array([10, 0, -1.5]) + rng.normal(size=(40, 6, 3)) * [1.0, 0.2, 0.8]
    many = guidance.initial((6,))
    single = [guidance.initial() for _ in range(6)]

    def spread(body):
        return RigidState(
            np.tile(body.position, (6, 1)), np.tile(LEVEL, (6, 1)), np.tile(body.velocity, (6, 1))
        )

    for step in positions:
        vehicles = RigidState(step, np.tile(LEVEL, (6, 1)), np.zeros((6, 6)))
        command, many = guidance.update(
            many, vehicles, spread(CARRIER), spread(APERTURE), spread(SEAT), np.zeros(6, bool), 0.01
        )
        for i in range(6):
            one, single[i] = update(guidance, single[i], at(*step[i]))
            assert single[i].phase == many.phase[i]
            np.testing.assert_allclose(one.target.position, command.target.position[i])


def test_latch_needs_all_limits_for_the_whole_dwell():
    latch = Latch(dwell=1.0)
    good, still = np.full(6, 0.01), np.zeros(6)
    state = latch.initial()
    for _ in range(100):
        state = latch.update(state, good, still, PERIOD)
    assert not state.closed
    assert latch.update(state, good, still, PERIOD).closed
    # One sample outside starts the dwell again.
    for bad_error, bad_velocity in (
        (np.array([0.06, 0, 0, 0, 0, 0]), still),
        (np.array([0, 0, 0, 0, 0.06, 0]), still),
        (good, np.array([0, 0, 0.11, 0, 0, 0])),
        (good, np.array([0, 0, 0, 0, 0, 0.2])),
    ):
        after = latch.update(state, bad_error, bad_velocity, PERIOD)
        assert after.dwell == 0 and not after.closed


def test_latch_stays_closed_and_is_vectorised():
    latch = Latch(dwell=0.02)
    state = latch.initial((2,))
    error = np.array([[0.0] * 6, [1.0] * 6])
    for _ in range(3):
        state = latch.update(state, error, np.zeros((2, 6)), PERIOD)
    np.testing.assert_array_equal(state.closed, [True, False])
    state = latch.update(state, np.ones((2, 6)), np.zeros((2, 6)), PERIOD)
    np.testing.assert_array_equal(state.closed, [True, False])


def test_refusals():
    with pytest.raises(ScenarioError, match="latch speed limit must be > 0"):
        Latch(speed=0)
    with pytest.raises(ScenarioError, match="acceptance must be > 0"):
        DockingPlan(acceptance=-1)
    with pytest.raises(ScenarioError, match="6 factors"):
        DockingPlan(contact_scale=(1.0,))
    with pytest.raises(ScenarioError, match=r"goal_bias needs 6 values, got \(0\.1, 0\.2\)"):
        DockingPlan(goal_bias=(0.1, 0.2))


def test_guidance_of_stacked_plans_is_that_of_each():
    """Random states in every phase: plans that differ in numbers decide in one call as alone."""
    plans = [
        DockingPlan(),
        DockingPlan(
            wait_speed=0.5, wait_time=0.02, corridor=(0.3, 0.2), retreat=1.0, quiet_rate=0.1
        ),
        DockingPlan(
            acceptance=0.6, wait_depth=0.4, aperture=(0.2, 0.2), quiet_rate=0.1, commit=0.5
        ),
    ]
    n = 300
    rng = np.random.default_rng(5)
    rows = rng.integers(len(plans), size=n)

    def body(spread):
        euler = quaternion_from_euler(rng.normal(0, 0.2, (n, 3)))
        return RigidState(rng.normal(0, spread, (n, 3)), euler, rng.normal(0, 0.4, (n, 6)))

    carrier, vehicle = body(0.2), body(0.6)
    vehicle.position[:, 2] -= 1.0
    aperture, seat = (carrier.attached([0, 0, z]) for z in (-1.0, -0.5))
    state = replace(
        DockingGuidance().initial((n,)),
        phase=rng.integers(len(Phase), size=n),
        height=rng.normal(0, 0.3, n),
        progress=rng.uniform(-1, 1, n),
        waited=rng.uniform(0, 40, n),
        turning=rng.uniform(0, 0.03, n),
    )
    latched = rng.random(n) < 0.05

    def flown(plan, i):
        parts = (trees.take(part, i) for part in (state, vehicle, carrier, aperture, seat, latched))
        return DockingGuidance(plan).update(*parts, PERIOD)

    together = flown(trees.stack(plans, rows), slice(None))
    for i, row in enumerate(rows):
        for one, many in zip(flown(plans[row], i), together, strict=True):
            for a, b in zip(leaves(one), leaves(trees.take(many, i)), strict=True):
                np.testing.assert_array_equal(a, b)
    assert len(np.unique(together[1].phase)) == len(Phase)


def leaves(tree):
    """All numbers and arrays of a dataclass."""
    if not is_dataclass(tree):
        return [tree]
    return [leaf for field in fields(tree) for leaf in leaves(getattr(tree, field.name))]
