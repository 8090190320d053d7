"""CPVA, LQR, sliding mode and MPC on simple simulated vehicles, against independent solutions."""

import time
from dataclasses import replace

import numpy as np
import pytest
from marine_mj.controllers import (
    CPV_GAINS,
    CPVA_GAINS,
    LQR_WEIGHTS,
    MPC_SETTINGS,
    SLIDING_GAINS,
    ArPredictor,
    Cpv,
    Cpva,
    CpvaGains,
    Demand,
    KinematicPredictor,
    Lqr,
    LqrWeights,
    Mpc,
    MpcSettings,
    PidGains,
    Preview,
    RigidState,
    SlidingGains,
    SlidingMode,
    VehicleModel,
    cpva_gain_set,
)
from marine_mj.controllers.kinematics import world_velocity
from marine_mj.controllers.lqr import lqr_gain, lqr_model
from marine_mj.controllers.mpc import Programme, solve
from scipy.optimize import minimize
from simple_vehicle import INERTIA, LAG, LEVEL, LIMITS, PERIOD, at

from marine_mj import trees
from marine_mj.errors import ScenarioError

DAMPING = np.diag([16.8, 201.0, 201.0, 0.3, 32.9, 32.9])
MODEL = VehicleModel(INERTIA, LAG, damping=DAMPING)


def cpv(model=MODEL):
    return Cpv.from_gains(CPV_GAINS["extended"], LIMITS, PERIOD, model=model)


def controllers():
    return {
        "cpva": Cpva.from_gains(CPVA_GAINS["extended"], LIMITS, PERIOD),
        "lqr": Lqr(LQR_WEIGHTS["extended"], LIMITS, PERIOD, MODEL),
        "sliding": SlidingMode(SLIDING_GAINS["extended"], LIMITS, PERIOD, MODEL),
        "mpc": Mpc(MPC_SETTINGS["extended"], cpv()),
    }


def test_first_wrenches_of_cpva_by_hand():
    cpva = Cpva.from_gains(CPVA_GAINS["reference"], LIMITS, PERIOD)
    body = at(0, 0, -2, velocity=[0.1, 0, 0, 0, 0, 0])
    target = at(0.2, 0, -1, velocity=[0, 0, 0.05, 0, 0, 0])
    wrench, state = cpva.update(
        cpva.initial(), body, Demand(target, acceleration=[0.2, 0, 0.1, 0, 0, 0])
    )
    # Surge: speed 1 * 0.2 - 0.1 = 0.1; 6 * 0.1 + 0.1 * 0.1 * 0.01 = 0.6001; + 0.2; times 60.
    # Heave: 1.5 * 1 m limited to 0.5, + 0.05; 6 * 0.55 limited to 0.55; + 0.1; times 80.
    np.testing.assert_allclose(wrench, [60 * 0.8001, 0, 80 * 0.65, 0, 0, 0], atol=1e-12)
    # One sample later it is 0.004 m/s faster: the acceleration of 0.4 m/s2 is fed back.
    faster = at(0, 0, -2, velocity=[0.104, 0, 0, 0, 0, 0])
    wrench, _ = cpva.update(state, faster, Demand(target))
    wanted = 6 * 0.096 + 0.1 * 0.01 * (0.1 + 0.096) + 0.05 * (0.096 - 0.1) / PERIOD
    assert wrench[0] == pytest.approx(60 * (wanted - 0.4), abs=1e-9)


def test_limits_of_cpva():
    gains = CPVA_GAINS["reference"]
    cpva = Cpva.from_gains(gains, LIMITS, PERIOD)
    for sign, surge in ((1, 2.9), (-1, -2.3)):
        wrench, _ = cpva.update(
            cpva.initial(), at(0, 0, 0), Demand(at(9.0 * sign, 9 * sign, 9 * sign))
        )
        np.testing.assert_allclose(wrench[:3], [60 * surge, 80 * 0.55 * sign, 80 * 0.55 * sign])
    # V16: limits of force over wet inertia, as the reference rounds them
    measured = np.array([192, 68, 20]) / np.array([67.3, 126.6, 26.12])
    np.testing.assert_allclose(measured, [2.853, 0.537, 0.766], rtol=3e-3)
    np.testing.assert_allclose(gains.acceleration_high[[0, 2, 4]], measured, rtol=0.03)
    # Whatever comes, the wrench stays within its limits.
    wrench, _ = cpva.update(
        cpva.initial(), at(0, 0, 0), Demand(at(9, 9, 9), acceleration=[99.0] * 6)
    )
    np.testing.assert_array_equal(wrench, LIMITS.high)


def simulate(controller, seconds=30.0, amplitude=0.25, force=-25.0, preview=False):
    """Largest error, m, of a heaving target, in the second half; vehicle with lag and drag."""
    waves = ((1.0, 1.3), (0.3, 2.1))  # share of the amplitude, rad/s: beats like a sea
    state, z, w, thrust, worst, fallbacks = controller.initial(), -0.5, 0.0, 0.0, 0.0, 0
    look = ArPredictor(PERIOD)
    memory = look.initial()
    for i in range(round(seconds / PERIOD)):
        t = i * PERIOD
        place, speed, change = (
            amplitude * sum(a * o**k * np.sin(o * t + k * np.pi / 2) for a, o in waves)
            for k in range(3)
        )
        target = at(0, 0, place, velocity=[0, 0, speed, 0, 0, 0])
        rate = np.array([0, 0, change, 0, 0, 0])
        body = at(0, 0, z, velocity=[0, 0, w, 0, 0, 0])
        demand = Demand(target, acceleration=rate)
        memory = look.update(memory, target)
        if preview and controller.plans_now(state):
            future = look.ahead(memory, target, controller.times)
            away = replace(future, position=future.position + np.array([0, 0, 1e3]))
            found = Preview(future, away, np.full(2, 1e3), np.array(True))
            demand = replace(demand, preview=found)
        wrench, state = controller.update(state, body, demand)
        state = controller.applied(state, wrench)
        assert np.all(wrench <= LIMITS.high) and np.all(wrench >= LIMITS.low)
        thrust += (wrench[2] - thrust) * -np.expm1(-PERIOD / LAG)
        w += PERIOD * (thrust + force - 502.4 * w * abs(w)) / 126.6
        z += PERIOD * w
        fallbacks += int(np.asarray(getattr(state, "fallback", 0)))
        if t > 0.5 * seconds:
            worst = max(worst, abs(place - z))
    return worst, fallbacks


@pytest.mark.parametrize("name", ["cpva", "lqr", "sliding"])
def test_baselines_follow_a_heaving_target_under_a_steady_force(name):
    worst, _ = simulate(controllers()[name], amplitude=0.1)
    # measured 0.055, 0.028, 0.017 m
    assert worst < {"cpva": 0.06, "lqr": 0.032, "sliding": 0.02}[name]


def test_mpc_with_a_preview_beats_the_cascade():
    """Heave of up to 0.2 m with two waves, predicted by an AR model that learned them so far."""
    cascade, _ = simulate(cpv(), amplitude=0.15, force=0.0)
    mpc, fallbacks = simulate(controllers()["mpc"], amplitude=0.15, force=0.0, preview=True)
    # measured 0.044 and 0.023 m
    assert mpc < 0.6 * cascade and mpc < 0.025
    assert fallbacks == 0


def test_mpc_has_no_offset_under_a_steady_force():
    worst, _ = simulate(controllers()["mpc"], amplitude=0.0, force=-25.0)
    assert worst < 1e-3  # measured 1.4e-4


def test_lqr_gain_solves_the_riccati_equation_and_is_optimal():
    gain = lqr_gain(MODEL, LQR_WEIGHTS["extended"], PERIOD)
    a, b = lqr_model(MODEL, PERIOD)
    weights = LQR_WEIGHTS["extended"]
    worst = np.concatenate([weights.integral, weights.pose, weights.velocity])
    Q = np.diag(np.concatenate([1 / worst**2, np.zeros(6)]))
    R = np.diag(1 / np.asarray(weights.wrench) ** 2)
    # Value iteration by doubling (Anderson 1978): an independent solution.
    A, G, P = a.copy(), b @ np.linalg.solve(R, b.T), Q.copy()
    for _ in range(30):
        W = np.linalg.inv(np.eye(24) + G @ P)
        A, G, P = A @ W @ A, G + A @ W @ G @ A.T, P + A.T @ P @ W @ A
    expected = np.linalg.solve(R + b.T @ P @ b, b.T @ P @ a)
    np.testing.assert_allclose(gain, expected, rtol=1e-6, atol=1e-6)
    closed = np.abs(np.linalg.eigvals(a - b @ gain))
    assert closed.max() < 1
    # without lag the thrust is no state
    bare = lqr_gain(replace(MODEL, lag=0.0), weights, PERIOD)
    assert np.all(bare[:, 18:] == 0) and np.all(np.diag(bare[:, 12:18]) > 0)


def test_sliding_mode_by_hand():
    sliding = SlidingMode(SLIDING_GAINS["extended"], LIMITS, PERIOD, VehicleModel(INERTIA, 0.0))
    body, target = at(0, 0, 0, velocity=[0.1, 0, 0, 0, 0, 0]), at(0.2, 0, 0.1)
    wrench, _ = sliding.update(sliding.initial(), body, Demand(target))
    # Surge: wanted 1.0 * 0.2, slip 0.1, s = 0.1: (-1.0 * 0.1 + 1.5 * 0.1 / 0.5) * 67.3.
    # Heave: wanted 0.1, s = 0.1 of 0.16: 0.4 * 0.1 / 0.16 * 126.6.
    np.testing.assert_allclose(wrench[[0, 2]], [67.3 * 0.2, 126.6 * 0.25], atol=1e-12)
    # Outside the layer the pull is the reach.
    wrench, _ = sliding.update(sliding.initial(), at(0, 0, 0), Demand(at(0, 0, 9.0)))
    assert wrench[2] == pytest.approx(0.4 * 126.6)


def test_programme_against_an_independent_solver():
    rng = np.random.default_rng(1)
    for _ in range(3):
        n, m = 8, 6
        B = rng.normal(size=(n, n))
        H, f, A = B @ B.T + np.eye(n), 3 * rng.normal(size=n), rng.normal(size=(m, n))
        low, high = -np.full(n + m, 0.4), np.full(n + m, 0.5)
        x = solve(Programme(H, f, A, low, high))
        both = np.vstack([np.eye(n), A])
        limits = [
            {"type": "ineq", "fun": lambda x, both=both, high=high: high - both @ x},
            {"type": "ineq", "fun": lambda x, both=both, low=low: both @ x - low},
        ]
        found = minimize(
            lambda x, H=H, f=f: 0.5 * x @ H @ x + f @ x, np.zeros(n), constraints=limits,
            options={"ftol": 1e-14, "maxiter": 500},
        )  # fmt: skip
        np.testing.assert_allclose(x, found.x, atol=1e-5)  # SLSQP stops at about 1e-6
        assert np.all(both @ x < high + 1e-7) and np.all(both @ x > low - 1e-7)
    assert solve(Programme(H, f, A, np.full(n + m, 0.2), np.r_[high[:n], -np.ones(m)])) is None


def coming(mpc, target, aperture, entering, corridor=(0.3, 0.2)):
    """Preview of a target and an aperture that rest."""
    count = len(mpc.times)

    def many(state):
        return RigidState(
            *(np.repeat(v[None], count, 0) for v in (state.position, state.quaternion)),
            np.repeat(state.velocity[None], count, 0),
        )

    return Preview(many(target), many(aperture), np.array(corridor), np.array(entering))


def planned_path(mpc, state, velocity):
    """Positions (N, 3) of the plan in `state`, from a vehicle at the origin."""
    x = np.concatenate([np.zeros(6), velocity, np.zeros(6)])
    y = mpc.free @ x + mpc.by_move @ state.planned + mpc.by_disturbance @ (DAMPING @ velocity)
    return y.reshape(-1, 12)[:, :3]


def test_mpc_keeps_corridor_clearance_rates_and_limits():
    mpc = controllers()["mpc"]
    slope = np.tan(np.deg2rad(20))
    body = at(0, 0, -0.6, velocity=[0.25, 0, 0.2, 0, 0, 0])
    # Entering: the target pulls out of the corridor, the plan stays inside.
    preview = coming(mpc, at(1.0, 0, 0.0), at(0, 0, 0), True)
    _, state = mpc.update(mpc.initial(), body, Demand(at(1.0, 0, 0), preview=preview))
    assert not state.fallback
    path = planned_path(mpc, state, body.velocity)
    at_looks = path[4::5]
    edge = 0.3 - slope * (at_looks[:, 2] - 0.6)
    assert np.all(at_looks[:, 0] <= edge + 1e-6)
    free = coming(mpc, at(1.0, 0, 0.0), at(0, 0, 9.0), True, (9, 9))
    _, loose = mpc.update(mpc.initial(), body, Demand(at(1.0, 0, 0), preview=free))
    assert np.any(planned_path(mpc, loose, body.velocity)[4::5, 0] > edge + 0.01)  # it did bind
    # Waiting: below the aperture plane by the clearance of 0.3 m.
    preview = coming(mpc, at(0, 0, 0.5), at(0, 0, 0), False)
    _, state = mpc.update(mpc.initial(), body, Demand(at(0, 0, 0.5), preview=preview))
    heights = planned_path(mpc, state, body.velocity)[4::5, 2] - 0.6
    assert not state.fallback and heights.max() < -0.3 + 1e-6 and heights.max() > -0.31
    moves = state.planned.reshape(-1, 6)
    assert np.all(moves * mpc.scale <= LIMITS.high + 1e-6)
    assert np.all(moves * mpc.scale >= LIMITS.low - 1e-6)
    most = 2 * 0.1 / 0.3  # share of the half span in 0.1 s
    assert np.abs(np.diff(moves, axis=0, prepend=0)).max() < most + 1e-6


def test_mpc_falls_back_on_the_cascade_when_nothing_is_feasible():
    mpc = controllers()["mpc"]
    body = at(0, 0, 0.5)  # far above the plane it should be below: no plan gets it down in 0.5 s
    preview = coming(mpc, at(0, 0, -1), at(0, 0, 0), False)
    wrench, state = mpc.update(mpc.initial(), body, Demand(at(0, 0, -1), preview=preview))
    assert state.fallback and state.failures == 1
    expected, _ = cpv().update(cpv().initial(), body, Demand(at(0, 0, -1)))
    np.testing.assert_array_equal(wrench, expected)
    # In contact the cascade steers too, without a failed plan.
    wrench, state = mpc.update(
        mpc.initial(), body, Demand(at(0, 0, -1), contact=True, preview=preview)
    )
    np.testing.assert_array_equal(wrench, expected)
    assert not state.fallback and state.failures == 0


@pytest.mark.parametrize("name", ["cpva", "lqr", "sliding", "mpc"])
def test_the_same_bits_alone_and_in_a_batch(name):
    controller = controllers()[name]
    rng = np.random.default_rng(0)
    n, steps = 5, 25
    many, single = controller.initial((n,)), [controller.initial() for _ in range(n)]
    for k in range(steps):
        q = np.array([1.0, 0, 0, 0]) + 0.1 * rng.normal(size=(2, n, 4))
        q /= np.linalg.norm(q, axis=-1, keepdims=True)
        place, speed = 0.3 * rng.normal(size=(2, n, 3)), 0.1 * rng.normal(size=(2, n, 6))
        rate, contact = 0.1 * rng.normal(size=(n, 6)), rng.random(n) > 0.8
        body, target = (RigidState(place[i], q[i], speed[i]) for i in range(2))
        wrench, many = controller.update(many, body, Demand(target, 1.0, 3.0, rate, contact))
        for i in range(n):
            b, t = (RigidState(place[j, i], q[j, i], speed[j, i]) for j in range(2))
            one, single[i] = controller.update(
                single[i], b, Demand(t, 1.0, 3.0, rate[i], contact[i])
            )
            assert one.tobytes() == wrench[i].tobytes()
        if k == 12:  # runs end: the others go on with the same bits
            many, single, n = trees.take(many, np.arange(3)), single[:3], 3


@pytest.mark.parametrize("name", ["cpva", "lqr", "sliding"])
def test_stacked_parameters_are_those_of_each_run(name):
    controller = controllers()[name]
    if name == "cpva":
        pose = replace(controller.pose, gains=PidGains(*(0.5 * np.ones((3, 6)))))
        other = replace(controller, pose=pose)
    elif name == "lqr":
        other = Lqr(replace(controller.weights, pose=np.full(6, 0.5)), LIMITS, PERIOD, MODEL)
    else:
        other = replace(controller, gains=replace(controller.gains, rate=np.full(6, 0.4)))
    pair = [controller, other]
    both = trees.stack(pair)
    body = RigidState(np.zeros((2, 3)), np.tile(LEVEL, (2, 1)), 0.1 * np.ones((2, 6)))
    target = RigidState(0.05 * np.ones((2, 3)), np.tile(LEVEL, (2, 1)), np.zeros((2, 6)))
    wrench, _ = both.update(both.initial((2,)), body, Demand(target))
    alone = [
        c.update(c.initial(), at(0, 0, 0, velocity=[0.1] * 6), Demand(at(0.05, 0.05, 0.05)))[0]
        for c in pair
    ]
    np.testing.assert_array_equal(wrench, alone)
    assert not np.array_equal(*alone)


def test_updates_are_fast_enough():
    """500 vehicles: bars 2 ms (PID family) and 1 ms (predictors), tripled for a busy machine.

    Measured 0.3 ms (cpva, lqr, sliding), 0.25 ms (harmonic; AR between strides), 5 ms a plan.
    """
    n = 500
    rng = np.random.default_rng(0)
    q = rng.normal(size=(n, 4))
    q /= np.linalg.norm(q, axis=-1, keepdims=True)
    body = RigidState(rng.normal(size=(n, 3)), q, rng.normal(size=(n, 6)))
    target = at(0, 0, 0)

    def best(call, repeats=12):
        times = []
        for _ in range(repeats):
            start = time.perf_counter()
            call(RigidState(body.position, body.quaternion, body.velocity))
            times.append(time.perf_counter() - start)
        return min(times)

    for name, controller in controllers().items():
        if name == "mpc":
            continue
        state = controller.initial((n,))
        took = best(lambda b, c=controller, s=state: c.update(s, b, Demand(target)))
        assert took < 6e-3
    for predictor in (KinematicPredictor(PERIOD, "harmonic"), ArPredictor(PERIOD)):
        state = predictor.update(predictor.initial((n,)), body)
        took = best(lambda b, p=predictor, s=state: p.ahead(p.update(s, b), b, 0.5))
        assert took < 3e-3
    assert world_velocity(body).shape == (n, 6)
    mpc = controllers()["mpc"]
    one = at(0.1, 0.1, -0.5)
    start = time.perf_counter()
    for _ in range(10):
        mpc.update(mpc.initial(), one, Demand(target))
    plan = (time.perf_counter() - start) / 10
    assert plan < 0.1  # a plan every 0.1 s in real time


def test_refusals():
    with pytest.raises(ScenarioError, match="not exist for cpva; available: reference, extended"):
        cpva_gain_set("best")
    ones, gains = np.ones(6), PidGains(*np.ones((3, 6)))
    with pytest.raises(ScenarioError, match="CPVA speed limits must be > 0"):
        CpvaGains(gains, 0 * ones, gains, -ones, ones, gains)
    with pytest.raises(ScenarioError, match="acceleration limits must be < 0 and > 0"):
        CpvaGains(gains, ones, gains, ones, ones, gains)
    with pytest.raises(ScenarioError, match="LQR weights: wrench must be > 0"):
        LqrWeights(ones, ones, ones, 0 * ones, ones)
    with pytest.raises(ScenarioError, match="sliding mode: layer must be > 0"):
        SlidingGains(ones, ones, ones, 0 * ones)
    with pytest.raises(ScenarioError, match="MPC: moves must be whole numbers >= 1"):
        MpcSettings(ones, ones, ones, ones, moves=(1, 0))
    with pytest.raises(ScenarioError, match="MPC: change must be > 0"):
        MpcSettings(ones, ones, ones, -ones)
    with pytest.raises(ScenarioError, match="MPC: sweep must be > 0"):
        MpcSettings(ones, ones, ones, ones, sweep=0.0)
    with pytest.raises(ScenarioError, match="MPC needs a cascade with a vehicle model"):
        Mpc(MPC_SETTINGS["extended"], cpv(None))
    with pytest.raises(ScenarioError, match=r"step = 0.015 s must be a whole multiple"):
        Mpc(replace(MPC_SETTINGS["extended"], step=0.015), cpv())
