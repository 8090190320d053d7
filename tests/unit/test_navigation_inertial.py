"""Error-state filter, late measurements, link: against independent solutions."""

from dataclasses import replace

import numpy as np
import pytest
from marine_mj.controllers import RigidState
from marine_mj.controllers.kinematics import world_velocity
from marine_mj.controllers.navigation import (
    CarrierNavigation,
    Dvl,
    ErrorState,
    ErrorStateFilter,
    Gnss,
    Imu,
    Timing,
    Truth,
    chi_square_bounds,
)
from marine_mj.controllers.navigation import error_state as es
from marine_mj.controllers.navigation.clones import cloned, late
from scipy.integrate import solve_ivp

from marine_mj import frames, trees
from marine_mj.validation.navigation import CARRIER, VEHICLE, Motion, consistency, follow, inertial

T = 0.01


def scattered(n, seed=0, spread=1.0):
    """Random rigid states."""
    rng = np.random.default_rng(seed)
    q = frames.quaternion_from_rotation_vector(spread * rng.normal(size=(n, 3)))
    return RigidState(rng.normal(size=(n, 3)), q, rng.normal(size=(n, 6)))


def random_state(kalman, n=4, seed=0):
    """Filter states with random means and covariances."""
    rng = np.random.default_rng(seed)
    body = scattered(n, seed, 0.5)
    mean = 0.1 * rng.normal(size=(n, kalman.size + 1))
    mean[:, :3], mean[:, 3:6], mean[:, 6:10] = body.position, body.linear_velocity, body.quaternion
    A = rng.normal(size=(n, kalman.size, kalman.size))
    return ErrorState(mean, A @ A.mT, body.velocity[:, 3:])


def plus(state, error):
    """State with an error in its mean; its rate follows the gyro bias."""
    return replace(es._injected(state, error), rate=state.rate - error[..., es.RATE_BIAS])


def minus(a, b):
    """Error (..., n) of mean b seen from mean a: b = plus(a, error)."""
    turn = frames.quaternion_multiply(frames.quaternion_conjugate(a[..., 6:10]), b[..., 6:10])
    moved = b - a
    return np.concatenate([moved[..., :6], frames.rotation_vector(turn), moved[..., 10:]], axis=-1)


FILTER = ErrorStateFilter(Imu(), T, keep=np.array([0.9, 0.8, 0.7]), drive=np.array([0.1, 0.2, 0.3]))


def test_strapdown_follows_an_independent_integration():
    """Rigid-body kinematics by solve_ivp, with forces and rates given as functions of time."""

    def force(t):
        return np.array([np.sin(2 * t), 0.5 * np.cos(t), 9.81 + np.sin(3 * t)])

    def rate(t):
        return np.array([0.6 * np.sin(1.5 * t), 0.4 * np.cos(t), 0.5])

    def slope(t, y):
        q = y[6:10]
        turning = 0.5 * frames.quaternion_multiply(q, np.concatenate([[0.0], rate(t)]))
        R = frames.rotation_from_quaternion(q / np.linalg.norm(q))
        return np.concatenate([y[3:6], R @ force(t) - [0, 0, 9.81], turning])

    start = np.array([1.0, 2, 3, 0.1, 0.2, 0.3, 1, 0, 0, 0])
    exact = solve_ivp(slope, (0, 10), start, rtol=1e-11, atol=1e-12).y[:, -1]
    errors = []
    for steps in (500, 1000, 2000):
        dt = 10 / steps
        kalman = ErrorStateFilter(Imu(), dt)
        state = ErrorState(np.concatenate([start, np.zeros(6)]), np.eye(15), np.zeros(3))
        for k in range(steps):
            middle = (k + 0.5) * dt
            state = kalman.predict(state, np.concatenate([force(middle), rate(middle)]))
        errors.append(np.abs(state.mean[:10] - exact).max())
    assert errors[1] < 2.5e-3  # 1.8e-3 m after 10 s at 100 Hz
    np.testing.assert_allclose(
        np.divide(errors[:-1], errors[1:]), 4.0, rtol=0.05
    )  # 1e-5: second order


@pytest.mark.parametrize("spot", [0, 1, 2, 3])
def test_covariance_is_carried_by_the_derivative_of_the_mean(spot, rng):
    """To first order in the period: what is left out falls with its square."""
    sample, h = rng.normal(size=(4, 6))[spot], 1e-6
    left_out = []
    for period in (0.01, 0.005):
        kalman = replace(FILTER, period=period)
        state = trees.take(random_state(kalman), spot)
        n = kalman.size
        quiet = replace(state, covariance=np.zeros((n, n)))
        base = kalman.predict(quiet, sample)
        F = np.empty((n, n))
        for j in range(n):
            step = h * np.eye(n)[j]
            up, down = (kalman.predict(plus(quiet, s * step), sample).mean for s in (1, -1))
            F[:, j] = (minus(base.mean, up) - minus(base.mean, down)) / (2 * h)
        Q = base.covariance
        expected = F @ state.covariance @ F.T + Q
        found = kalman.predict(state, sample).covariance
        left_out.append(np.abs(found - expected).max() / np.abs(expected).max())
        np.testing.assert_allclose(np.diag(Q)[15:], kalman.drive)
        np.testing.assert_allclose(Q, np.diag(np.diag(Q)))
    assert left_out[0] < 1e-4  # 5e-5 to 7e-5
    assert left_out[0] / left_out[1] == pytest.approx(4.0, rel=0.1)  # 3.98 to 4.00


def models(rng):
    """Every measurement: state -> (residual, H), with fixed measured values."""
    z3, z7 = rng.normal(size=(4, 3)), rng.normal(size=(4, 7))
    six = ErrorStateFilter(Imu(), T, keep=np.ones(6), drive=np.zeros(6))
    carrier, point, mount = scattered(4, 9, 0.5), (1.0, 0.3, -0.5), (0.2, 0.1, 0.3)

    def relative(s):
        turn = frames.quaternion_from_rotation_vector(s.extra[..., 3:])
        there = RigidState(
            carrier.position + s.extra[..., :3],
            frames.quaternion_multiply(turn, carrier.quaternion),
            carrier.velocity,
        )
        expected, H = es.point_in_body(six, s, there, point, mount, 15)
        return es.Linear(-expected, H, np.eye(3))

    return {
        "dvl": (
            FILTER,
            lambda s: es.over_ground(FILTER, s, z3, mount, lambda v: 0.1 + 0 * v[..., 0]),
        ),
        "pressure": (FILTER, lambda s: es.height(FILTER, s, z3[:, :1], mount, 0.1)),
        "compass": (FILTER, lambda s: es.heading(FILTER, s, 0.1 * z3[:, :1], 0.1)),
        "gnss": (FILTER, lambda s: es.satellite(FILTER, s, 0.1 * z7, np.ones(7))),
        "relative": (six, relative),
    }


@pytest.mark.parametrize("name", ["dvl", "pressure", "compass", "gnss", "relative"])
def test_measurement_matrices_are_derivatives(name, rng):
    kalman, model = models(rng)[name]
    state, h = random_state(kalman), 1e-6
    if name == "relative":
        state.mean[:, 19:] = 0.0  # the carrier's turn is linearised where it has been taken out
    H = model(state).H
    for j in range(kalman.size):
        step = h * np.eye(kalman.size)[j]
        up, down = (model(plus(state, s * step)).residual for s in (1, -1))
        np.testing.assert_allclose(H[..., j], -(up - down) / (2 * h), atol=1e-8)  # 5e-10


def test_a_late_measurement_gives_the_batch_solution(rng):
    """Cloned at step 0, corrected at step 2, data at step 4: against one joint Gaussian."""
    kalman = ErrorStateFilter(Imu(), T, keep=np.ones(3), drive=np.zeros(3))
    n, core = kalman.size, slice(0, 15)
    state = random_state(kalman, 1, 5)
    state.covariance[:, 15:, :] = state.covariance[:, :, 15:] = 0.0
    H = np.zeros((1, 3, n))
    H[..., :15] = rng.normal(size=(1, 3, 15))
    prompt = np.zeros((1, 2, n))
    prompt[..., :15] = rng.normal(size=(1, 2, 15))
    R, R2 = 0.5 * np.eye(3), 0.3 * np.eye(2)
    z, z2 = rng.normal(size=(1, 3)), rng.normal(size=(1, 2))
    P0 = state.covariance[0, core, core].copy()
    state = cloned(state, H, 15)
    start = state
    samples = rng.normal(size=(4, 1, 6))
    F, Q, total = [], [], np.zeros((1, n))
    for k in range(4):
        basis = []
        for j in range(15):  # F by the filter's own covariance of unit vectors
            unit = np.zeros((1, n, n))
            unit[0, j, j] = 1.0
            with_, without = (
                kalman.predict(replace(state, covariance=c), samples[k]).covariance[0, core, core]
                for c in (unit, 0 * unit)
            )
            column = (with_ - without)[:, j] / np.sqrt((with_ - without)[j, j])
            basis.append(column)
        F.append(np.array(basis).T)
        Q.append(without)
        state = kalman.predict(state, samples[k])
        if k == 1:
            before = state
            state, _ = kalman.correct(state, es.Linear(z2, prompt, R2))
            total = total + minus(before.mean, state.mean)
            frozen = state.covariance
    before = state
    measured = late(kalman, state, z, R, 15)
    state, _ = kalman.correct(state, measured)
    # Joint Gaussian of errors x0 and noises w1..w4; x4 = A x0 + ...
    phi = [np.hstack([np.eye(15), np.zeros((15, 60))])]
    for k in range(4):
        following = F[k] @ phi[-1]
        following[:, 15 * (k + 1) : 15 * (k + 2)] += np.eye(15)
        phi.append(following)
    prior = np.zeros((75, 75))
    prior[:15, :15] = P0
    for k in range(4):
        prior[15 * (k + 1) : 15 * (k + 2), 15 * (k + 1) : 15 * (k + 2)] = Q[k]
    rows = np.vstack([H[0, :, core] @ phi[0], prompt[0, :, core] @ phi[2]])
    S = rows @ prior @ rows.T + np.diag([0.5] * 3 + [0.3] * 2)
    K = prior @ rows.T @ np.linalg.inv(S)
    joint = prior - K @ S @ K.T
    expected = phi[4] @ joint @ phi[4].T
    np.testing.assert_allclose(state.covariance[0, core, core], expected, atol=1e-9)  # 2e-14
    # Means: both corrections, carried to step 4.
    found = minus(before.mean, state.mean)[0, core]
    found = found + F[3] @ F[2] @ total[0, core]
    together = phi[4] @ K @ np.concatenate([z[0], z2[0]])
    np.testing.assert_allclose(found, together, atol=1e-9)  # 4e-16
    assert not np.allclose(frozen, start.covariance)


def test_dropouts_and_delays_are_those_asked_for():
    timing = Timing.of(0.2, 0.1, 0.3, 0.01)
    assert (timing.every, timing.delay) == (20, 10)
    assert [k for k in range(60) if timing.samples(k)] == [0, 20, 40]
    assert [k for k in range(60) if timing.arrives(k)] == [10, 30, 50]
    navigator = inertial(
        camera=None, usbl=None, compass=None, dvl=Dvl(Timing(1, 0, 0.3)), pressure=None
    )
    *_, (_, _, known) = follow(navigator, 40, 1.0, 100)
    share = known.state.used[:, 0].mean() / 100
    assert share == pytest.approx(0.7, abs=4 * np.sqrt(0.21 / 4000))  # 0.70


def test_carrier_is_predicted_from_the_last_message():
    """Harmonic motion goes on exactly, however long no message has come."""
    omega = 1.25
    motion = Motion(np.zeros(3), np.array([0.3, 0.0, 0.4, 0.0, 0.1, 0.0]), np.full(6, omega),
                    np.array([0, 0, 1.0, 0, 2.0, 0]))  # fmt: skip
    link = CarrierNavigation(0.01, Timing(20), Gnss(Timing(20)), frequency=omega)
    state = link.initial(motion.at(0.0), np.zeros((), dtype=np.uint64), ())
    h = 1e-5
    change = (world_velocity(motion.at(h)) - world_velocity(motion.at(-h))) / (2 * h)
    q, v = motion.at(0.0), world_velocity(motion.at(0.0))
    message = np.concatenate([q.position, q.quaternion, v, change])
    # x'' = -w^2 x about the mean: position of the message seen from the centre of the motion
    for steps in (0, 40, 300):
        body, acceleration, age = link.now(
            replace(state, message=message, age=np.array(float(steps)))
        )
        t = 0.01 * steps
        true = motion.at(t)
        assert age == pytest.approx(t)
        np.testing.assert_allclose(body.position, true.position, atol=1e-9)
        np.testing.assert_allclose(body.linear_velocity, true.linear_velocity, atol=1e-9)
        assert frames.euler_from_quaternion(body.quaternion)[1] == pytest.approx(
            frames.euler_from_quaternion(true.quaternion)[1], abs=1e-9
        )
        exact = (world_velocity(motion.at(t + h)) - world_velocity(motion.at(t - h))) / (2 * h)
        np.testing.assert_allclose(acceleration, exact, atol=1e-7)
    straight = replace(link, frequency=0.0)
    body, acceleration, _ = straight.now(replace(state, message=message, age=np.array(50.0)))
    np.testing.assert_allclose(body.position, q.position + 0.5 * v[:3] + 0.125 * change[:3])


def test_messages_age_as_the_link_loses_them():
    ages = {}
    for dropout in (0.0, 0.5, 1.0):
        carrier = CarrierNavigation(0.01, Timing.of(0.2, 0.1, dropout, 0.01), Gnss(Timing(20)))
        navigator = inertial(carrier=carrier, camera=None, usbl=None)
        looks = [k.state.carrier.age for *_, k in follow(navigator, 60, 2.0, 1)]
        ages[dropout] = np.array(looks)
    assert np.array_equal(ages[1.0][:, 0], np.arange(201))
    assert set(np.unique(ages[0.0][30:])) == set(range(10, 30))
    # Mean age: (delay + half a period) plus a period for every message that is lost before.
    assert ages[0.5][100:].mean() == pytest.approx(19.5 + 20.0, rel=0.15)  # 37.9


@pytest.fixture(scope="module")
def flights():
    """Fifty runs of 15 s with every sensor: states, truth and innovations."""
    return list(follow(inertial(), 50, 15.0, every=50))


def test_filters_are_consistent(flights):
    values = [consistency(known, true, dock) for true, dock, known in flights]
    for size, nees in zip((15, 18), zip(*values, strict=True), strict=True):
        mean = np.mean(nees, axis=1)
        low, high = chi_square_bounds(size, 50, 0.9999)
        assert np.all((low < mean) & (mean < high))  # 13.7 to 16.7 of 15; 16.9 to 19.9 of 18
        low, high = chi_square_bounds(size, 50, 0.95)
        assert low < np.mean(mean) < high  # 15.0; 18.2


def test_innovations_are_consistent(flights):
    nis = np.array([known.state.nis for *_, known in flights[2:]])
    refused = sum(known.state.refused for *_, known in flights[-1:])
    for aid, size in enumerate((3, 1, 1, 3, 6)):
        values = nis[:, :, aid][~np.isnan(nis[:, :, aid])]
        low, high = chi_square_bounds(size, len(values), 0.999)
        # Camera and USBL noise is evaluated at the estimate: mean NIS up to 3 % off.
        assert 0.95 * low < values.mean() < 1.05 * high
    assert refused.sum() <= 3


def test_a_relative_sensor_gives_the_relative_pose_better_than_the_absolute_one(flights):
    true, dock, known = flights[-1]
    absolute = known.vehicle.position - true.position
    relative = known.carrier.position - known.vehicle.position - dock.position + true.position
    assert np.sqrt(np.mean(absolute[:, :2] ** 2)) > 0.2  # 0.32 m, satellite bias 0.5 m
    assert np.sqrt(np.mean(relative**2)) < 0.1  # 0.06 m


def test_biases_are_observed_when_the_vehicle_moves_and_the_level_ones_hide_when_it_does_not():
    still = Motion(VEHICLE.centre, np.zeros(6), np.zeros(6), np.zeros(6))
    deviations = {}
    for name, motion in (("moving", VEHICLE), ("still", still)):
        *_, (_, _, known) = follow(inertial(), 1, 10.0, 1000, vehicle=motion)
        deviations[name] = np.sqrt(np.diagonal(known.state.kalman.covariance[0]))[9:15]
    prior = np.array([0.02] * 3 + [5e-4] * 3)
    moving, still_ = deviations["moving"] / prior, deviations["still"] / prior
    # Tilt and level accelerometer bias look alike to a body that stays level.
    assert np.all(still_[:2] > 0.95)  # 0.98
    assert np.all(moving[:2] < still_[:2] - 0.1)  # 0.79, 0.83
    assert moving[2] < 0.4 and still_[2] < 0.4  # 0.26, 0.24
    assert np.all(moving[3:5] < 0.7)  # 0.53, 0.54


def test_an_outlier_is_refused(flights):
    state = flights[-1][2].state.kalman
    kalman = inertial().kalman
    z = state.mean[:, 2:3] + 3.0
    measured = es.height(kalman, state, z, (0.0, 0.0, 0.0), 0.05)
    after, nis = kalman.correct(state, measured, gate=24.0)
    assert np.all(nis > 24.0)
    np.testing.assert_allclose(after.mean, state.mean, atol=1e-15)  # a quaternion's norm
    np.testing.assert_array_equal(after.covariance, state.covariance)


def test_inertial_navigation_gives_the_same_bits_alone():
    *_, (_, _, together) = follow(inertial(), 3, 1.2, 120)
    *_, (_, _, alone) = follow(inertial(), 1, 1.2, 120)
    np.testing.assert_array_equal(alone.state.kalman.mean[0], together.state.kalman.mean[0])
    one, three = alone.state.kalman.covariance[0], together.state.kalman.covariance[0]
    np.testing.assert_array_equal(one, three)
    np.testing.assert_array_equal(alone.carrier.position[0], together.carrier.position[0])
    # No leading shape at all, as in the dm_control task.
    bodies = VEHICLE.at(0.0), CARRIER.at(0.0)
    state = inertial().initial(Truth(*bodies, np.zeros(6), np.zeros(6)), np.uint64(0))
    for step in range(121):
        before, bodies = bodies, (VEHICLE.at(step * T), CARRIER.at(step * T))
        pairs = zip(before, bodies, strict=True)
        gained = [(world_velocity(b) - world_velocity(a)) / T for a, b in pairs]
        state = inertial().update(state, Truth(*bodies, *gained), step).state
    np.testing.assert_array_equal(state.kalman.mean, alone.state.kalman.mean[0])
    np.testing.assert_array_equal(state.kalman.covariance, one)
