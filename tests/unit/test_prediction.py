"""Predictors: exact on the signals they assume, the same bits alone and in a batch."""

import numpy as np
import pytest
from marine_mj.controllers.ar_prediction import ArPredictor
from marine_mj.controllers.kinematics import RigidState, pose_error, unrotate, world_velocity
from marine_mj.controllers.polynomial_prediction import PolynomialPredictor
from marine_mj.controllers.prediction import (
    KinematicPredictor,
    displaced,
    turn_quaternion,
)

from marine_mj import frames
from marine_mj.errors import ScenarioError

PERIOD = 0.01
AXIS = np.array([0.6, 0.0, 0.8])  # a fixed axis: rotation vectors are exact then


def moving(path, speed, t, tilt=(0.9, 0.1, -0.3, 0.2)):
    """Body with position path(t)[:3] and rotation path(t)[3] about AXIS, after a fixed tilt."""
    q = np.array(tilt) / np.linalg.norm(tilt)
    x, v = path(t), speed(t)
    attitude = frames.quaternion_multiply(turn_quaternion(x[3] * AXIS), q)
    rotation = frames.rotation_from_quaternion(attitude)
    twist = [unrotate(rotation, v[:3]), unrotate(rotation, v[3] * AXIS)]
    return RigidState(x[:3], attitude, np.concatenate(twist))


def worst(predictor, path, speed, ahead, until, start=0.0):
    """Largest error of pose (m, rad) and velocity of predictions from `start` to `until`."""
    state, errors = predictor.initial(), [0.0]
    for i in range(round(until / PERIOD)):
        body = moving(path, speed, i * PERIOD)
        state = predictor.update(state, body)
        if i * PERIOD >= start and i % 7 == 0:
            found = predictor.ahead(state, body, ahead)
            truth = moving(path, speed, i * PERIOD + ahead)
            errors.append(np.abs(pose_error(truth, found)).max())
            errors.append(np.abs(world_velocity(found) - world_velocity(truth)).max())
    return max(errors)


SLOPE = np.array([0.5, -0.2, 0.1, 0.3])
CURVE = np.array([0.2, 0.1, -0.3, 0.1])
SIZE = np.array([0.5, 0.3, -0.4, 0.1])
LAG = np.array([0.1, 1.0, 2.0, 0.7])


def line(t):
    return np.array([7.0, 0, -4, 0.2]) + SLOPE * t


def parabola(t):
    return line(t) + 0.5 * CURVE * t**2


def wave(t):
    return np.array([7.0, 0, -4, 0]) + SIZE * np.sin(1.37 * t + LAG)


def two_waves(t):
    return wave(t) + 0.4 * SIZE * np.sin(2.1 * t - LAG)


SIGNALS = {
    line: lambda t: SLOPE,
    parabola: lambda t: SLOPE + CURVE * t,
    wave: lambda t: 1.37 * SIZE * np.cos(1.37 * t + LAG),
    two_waves: lambda t: 1.37 * SIZE * np.cos(1.37 * t + LAG) + 0.84 * SIZE * np.cos(2.1 * t - LAG),
}


@pytest.mark.parametrize(
    ("predictor", "signal", "start", "tolerance"),
    [
        (KinematicPredictor(PERIOD), line, 0.0, 1e-12),  # measured 2e-15
        (KinematicPredictor(PERIOD, "constant"), parabola, 0.02, 1e-11),  # 5e-13
        (KinematicPredictor(PERIOD, "harmonic"), wave, 0.7, 1e-11),  # 8e-14
        (PolynomialPredictor(PERIOD, 1, 0.03), line, 0.0, 1e-11),  # 8e-14
        (PolynomialPredictor(PERIOD, 2, 0.04), parabola, 0.05, 1e-9),  # 2e-11
        # AR: cubic interpolation between the strides leaves (w s)^4 / 384 of the amplitude
        (ArPredictor(PERIOD, order=2), wave, 8.0, 4e-4),  # 1.1e-4
        (ArPredictor(PERIOD, order=4), two_waves, 8.0, 1e-3),  # 4.7e-4
    ],
)
def test_exact_on_what_it_assumes(predictor, signal, start, tolerance):
    error = worst(predictor, signal, SIGNALS[signal], 0.8, 12.0, start)
    assert error < tolerance


def test_wrong_assumptions_are_seen():
    """The same test fails for a signal that a predictor does not assume."""
    assert worst(KinematicPredictor(PERIOD), wave, SIGNALS[wave], 0.8, 3.0) > 0.1
    assert worst(PolynomialPredictor(PERIOD, 1), wave, SIGNALS[wave], 0.8, 3.0) > 0.1
    assert worst(ArPredictor(PERIOD, order=2), two_waves, SIGNALS[two_waves], 0.8, 12.0, 8.0) > 0.02


def test_ar_is_exact_at_its_strides():
    predictor = ArPredictor(PERIOD, order=4)
    state = predictor.initial()
    for i in range(1001):
        body = moving(two_waves, SIGNALS[two_waves], i * PERIOD)
        state = predictor.update(state, body)
    found = predictor.ahead(state, body, 1.0)
    truth = moving(two_waves, SIGNALS[two_waves], 10.0 + 1.0)
    error = np.abs(pose_error(truth, found)).max()
    assert error < 1e-7  # measured 1e-9


def test_ar_learns_a_random_process():
    """Coefficients of a stable AR(2) process driven by noise, beside the true ones."""
    rng = np.random.default_rng(2)
    a, c = np.array([1.5, -0.75]), 0.3
    predictor = ArPredictor(PERIOD, order=2, stride=PERIOD, memory=1e4, horizon=0.03)
    state = predictor.initial()
    y = np.zeros(12000)
    for k in range(2, len(y)):
        y[k] = c + a @ y[k - 1 : k - 3 if k > 2 else None : -1][:2] + rng.normal()
        twist = np.array([y[k], 0, 0, 0, 0, 0])
        state = predictor.update(state, RigidState(np.zeros(3), np.array([1.0, 0, 0, 0]), twist))
    expected = c + a @ [y[-1], y[-2]]
    body = RigidState(np.zeros(3), np.array([1.0, 0, 0, 0]), twist)
    found = predictor.ahead(state, body, PERIOD).velocity[0]
    # standard error of a coefficient sqrt((1 - a2^2) / n) = 0.006, of the mean process 0.01
    assert abs(found - expected) < 0.02 * max(abs(y[-1]), abs(y[-2]), 1.0)


def test_a_screw_motion_when_the_velocity_turns_with_the_body():
    """Against many small steps of the process model of the reference (digest 5.3)."""
    body = RigidState(
        np.zeros(3), np.array([1.0, 0, 0, 0]), np.array([1.0, 0.2, -0.1, 0.1, 0.3, 0.5])
    )
    predictor = KinematicPredictor(PERIOD, turning=True)
    found = predictor.ahead(predictor.update(predictor.initial(), body), body, 2.0)
    small = body
    n = 20000
    for _ in range(n):
        small = displaced(small, 2.0 / n * world_velocity(small), world_velocity(small))
        small = RigidState(small.position, small.quaternion, body.velocity)
    np.testing.assert_allclose(found.position, small.position, atol=1e-4)  # measured 5e-5
    np.testing.assert_allclose(found.quaternion, small.quaternion, atol=1e-10)
    np.testing.assert_allclose(found.velocity, body.velocity, atol=1e-14)


PREDICTORS = [
    KinematicPredictor(PERIOD, turning=True),
    KinematicPredictor(PERIOD, "constant", smoothing=0.1),
    KinematicPredictor(PERIOD, "harmonic", stride=0.02),
    PolynomialPredictor(PERIOD, 2, 0.05),
    ArPredictor(PERIOD, order=2, stride=0.02, horizon=0.5),
]


@pytest.mark.parametrize("predictor", PREDICTORS, ids=lambda p: type(p).__name__)
def test_the_same_bits_alone_and_in_a_batch(predictor):
    rng = np.random.default_rng(0)
    n = 7
    many, single = predictor.initial((n,)), [predictor.initial() for _ in range(n)]
    ahead = rng.uniform(0, 0.5, (3, n))
    for _ in range(40):
        q = rng.normal(size=(n, 4))
        q /= np.linalg.norm(q, axis=-1, keepdims=True)
        body = RigidState(rng.normal(size=(n, 3)), q, rng.normal(size=(n, 6)))
        many = predictor.update(many, body)
        found = predictor.ahead(many, body, ahead)
        assert found.velocity.shape == (3, n, 6)
        for i in range(n):
            one = RigidState(body.position[i], q[i], body.velocity[i])
            single[i] = predictor.update(single[i], one)
            for j in range(3):
                alone = predictor.ahead(single[i], one, ahead[j, i])
                for name in ("position", "quaternion", "velocity"):
                    assert getattr(alone, name).tobytes() == getattr(found, name)[j, i].tobytes()


@pytest.mark.parametrize("predictor", PREDICTORS, ids=lambda p: type(p).__name__)
def test_a_body_at_rest_stays(predictor):
    body = RigidState(np.array([1.0, 2, -3]), np.array([1.0, 0, 0, 0]), np.zeros(6))
    state = predictor.initial()
    for _ in range(60):
        state = predictor.update(state, body)
    found = predictor.ahead(state, body, 0.4)
    np.testing.assert_allclose(found.position, body.position, rtol=0, atol=1e-14)
    np.testing.assert_array_equal(found.velocity, 0.0)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: KinematicPredictor(PERIOD, "linear"), "'linear' does not exist; available: zero"),
        (lambda: KinematicPredictor(PERIOD, stride=0.001), "0 < period <= stride < memory"),
        (lambda: PolynomialPredictor(PERIOD, 3), "order must be 1 or 2, got 3"),
        (lambda: PolynomialPredictor(PERIOD, 2, 0.02), r"needs t_past >= 0.03 s \(3 samples\)"),
        (lambda: ArPredictor(PERIOD, order=0), "order must be 1 to 20, got 0"),
        (lambda: ArPredictor(PERIOD, horizon=0.0), "horizon > 0"),
    ],
)
def test_refusals(make, message):
    with pytest.raises(ScenarioError, match=message):
        make()
