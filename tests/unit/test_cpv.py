"""Cascade of pose and velocity, acceleration of a carrier, on simple simulated vehicles."""

import numpy as np
import pytest
from marine_mj.controllers import (
    CPV_GAINS,
    Accelerometer,
    Cpv,
    CpvGains,
    Demand,
    Limits,
    PidGains,
    RigidState,
    VehicleModel,
    acceleration_at,
    cpv_gain_set,
)
from simple_vehicle import INERTIA, LAG, LIMITS, PERIOD, at

from marine_mj.errors import ScenarioError


def test_first_wrench_of_the_reference_by_hand():
    cpv = Cpv.from_gains(CPV_GAINS["reference"], LIMITS, PERIOD)
    body = at(0, 0, -2, velocity=[0.1, 0, 0, 0, 0, 0])
    target = at(0.2, 0, -1, velocity=[0, 0, 0.05, 0, 0, 0])
    wrench, _ = cpv.update(cpv.initial(), body, Demand(target))
    # Surge: 1.0 * 0.2 - 0.1 = 0.1 m/s; heave: 1.5 * 1 m limited to 0.5, plus 0.05 of the target.
    # 200 e and the first step of the integral.
    expected = [200 * 0.1 + 10 * 0.1 * PERIOD, 0, 68.0, 0, 0, 0]
    np.testing.assert_allclose(wrench, expected, atol=1e-12)


def test_speed_limit_holds_relative_to_a_moving_target():
    cpv = Cpv.from_gains(CPV_GAINS["reference"], Limits(np.full(6, -1e6), np.full(6, 1e6)), PERIOD)
    # The vehicle already does what the cascade wants: speed of the target plus the limit.
    body = at(0, 0, 0, velocity=[0.8, 0, 0, 0, 0, 0])
    target = at(100.0, 0, 0, velocity=[0.3, 0, 0, 0, 0, 0])
    wrench, _ = cpv.update(cpv.initial(), body, Demand(target))
    np.testing.assert_allclose(wrench, 0, atol=1e-9)


def follow(cpv, model_error=1.0, disturbance=None, seconds=20.0):
    """Largest heave error, m, of a vehicle with lag under a target heaving 4 cm at 2.4 rad/s."""
    state, z, w, thrust = cpv.initial(), 0.0, 0.0, 0.0
    omega, worst = 2.4, 0.0
    meter, motion = Accelerometer(PERIOD), Accelerometer(PERIOD).initial()
    for i in range(int(seconds / PERIOD)):
        t = i * PERIOD
        target = at(
            0, 0, 0.04 * np.sin(omega * t), velocity=[0, 0, 0.096 * np.cos(omega * t), 0, 0, 0]
        )
        acceleration, motion = meter.update(motion, target)
        body = at(0, 0, z, velocity=[0, 0, w, 0, 0, 0])
        wrench, state = cpv.update(state, body, Demand(target, acceleration=acceleration))
        state = cpv.applied(state, wrench)
        thrust += (wrench[2] - thrust) * -np.expm1(-PERIOD / LAG)
        force = thrust + (0.0 if disturbance is None else disturbance(t))
        w += PERIOD * force / (126.6 * model_error)
        z += PERIOD * w
        if t > 8.0:
            worst = max(worst, abs(target.position[2] - z))
    return worst


def test_model_follows_an_accelerating_target_through_the_lag():
    plain = follow(Cpv.from_gains(CPV_GAINS["extended"], LIMITS, PERIOD))
    model = VehicleModel(INERTIA, LAG)
    modelled = follow(Cpv.from_gains(CPV_GAINS["extended"], LIMITS, PERIOD, model=model))
    assert modelled < 0.4 * plain and modelled < 0.012


@pytest.mark.parametrize("mass", [0.8, 1.0, 1.25])
def test_observer_cancels_a_steady_force_and_bears_a_wrong_mass(mass):
    model = VehicleModel(INERTIA, LAG)
    cpv = Cpv.from_gains(CPV_GAINS["extended"], LIMITS, PERIOD, model=model)
    worst = follow(cpv, mass, lambda t: -25.0)
    # Without the observer 25 N would leave 25 / (320 * 1.0) = 0.08 m besides.
    assert worst < 0.03


def test_scale_lets_an_axis_go_and_cpv_is_vectorised():
    model = VehicleModel(INERTIA, LAG)
    cpv = Cpv.from_gains(CPV_GAINS["extended"], LIMITS, PERIOD, model=model)
    rng = np.random.default_rng(0)
    shape = (5,)
    many, single = cpv.initial(shape), [cpv.initial() for _ in range(5)]
    scale = np.array([1.0, 0.0, 1.0, 1.0, 1.0, 1.0])
    for _ in range(4):
        quaternion = rng.normal(size=(2, 5, 4))
        quaternion /= np.linalg.norm(quaternion, axis=-1, keepdims=True)
        place, speed = rng.normal(size=(2, 5, 3)), 0.1 * rng.normal(size=(2, 5, 6))
        acceleration = 0.1 * rng.normal(size=(5, 6))
        contact = rng.random(5) > 0.5
        body, target = (RigidState(place[i], quaternion[i], speed[i]) for i in range(2))
        wrench, many = cpv.update(many, body, Demand(target, scale, 3.0, acceleration, contact))
        for i in range(5):
            b, t = (RigidState(place[j, i], quaternion[j, i], speed[j, i]) for j in range(2))
            one, single[i] = cpv.update(
                single[i], b, Demand(t, scale, 3.0, acceleration[i], contact[i])
            )
            np.testing.assert_allclose(one, wrench[i], atol=1e-10)
    reference = Cpv.from_gains(CPV_GAINS["reference"], LIMITS, PERIOD)
    free, _ = reference.update(
        reference.initial(), at(0, 0, 0), Demand(at(0, 5, 0, velocity=[0, 1, 0, 0, 0, 0]), scale)
    )
    np.testing.assert_array_equal(free, 0)


def test_acceleration_of_a_point_on_a_turning_body():
    # Rotation about y with 0.5 cos(2 t) rad/s: finite differences of the point's velocity.
    def body(t):
        angle = 0.25 * np.sin(2 * t)
        attitude = np.array([np.cos(angle / 2), 0, np.sin(angle / 2), 0])
        state = RigidState(np.zeros(3), attitude, np.array([0, 0, 0, 0, 0.5 * np.cos(2 * t), 0]))
        lifted = 0.3 * np.sin(t)
        velocity = np.array([0, 0, 0.3 * np.cos(t)])
        nu = np.concatenate([state.rotation.T @ velocity, state.velocity[3:]])
        return RigidState(np.array([0, 0, lifted]), attitude, nu)

    t, h, arm = 0.7, 1e-5, [0.4, 0.0, -1.0]
    before, after = (body(t + s * h).attached(arm) for s in (-1, 1))
    exact = (after.linear_velocity - before.linear_velocity) / (2 * h)
    carrier = np.array([0, 0, -0.3 * np.sin(t), 0, -1.0 * np.sin(2 * t), 0])
    found = acceleration_at(body(t), carrier, body(t).attached(arm).position)
    np.testing.assert_allclose(found[:3], exact, atol=1e-6)


def test_accelerometer_needs_two_samples_and_looks_ahead():
    meter = Accelerometer(PERIOD, smoothing=0.1, lead=0.2)
    state = meter.initial()
    errors = []
    for i in range(1000):
        t = i * PERIOD
        moving = at(0, 0, 0, velocity=[np.sin(2 * t), 0, 0, 0, 0, 0])
        found, state = meter.update(state, moving)
        if i == 0:
            np.testing.assert_array_equal(found, 0)
        if i > 200:
            errors.append(found[0] - 2 * np.cos(2 * (t + 0.1)))
    assert np.abs(errors).max() < 0.15


def test_refusals():
    with pytest.raises(ScenarioError, match="available: reference, extended"):
        cpv_gain_set("best")
    with pytest.raises(ScenarioError, match="speed limits must be > 0"):
        CpvGains(PidGains(*np.ones((3, 6))), np.zeros(6), PidGains(*np.ones((3, 6))))
    with pytest.raises(ScenarioError, match="lag must be >= 0"):
        VehicleModel(INERTIA, -1.0)
