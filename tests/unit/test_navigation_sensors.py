"""Sensors: what they measure, their noise, where they see nothing."""

from dataclasses import replace

import numpy as np
import pytest
from marine_mj.controllers import RigidState
from marine_mj.controllers.kinematics import world_velocity
from marine_mj.controllers.navigation import (
    Camera,
    Compass,
    Dvl,
    GaussMarkov,
    Imu,
    NoiseStream,
    Pressure,
    Timing,
    Usbl,
)
from marine_mj.controllers.navigation.relative_sensors import crossed

from marine_mj import frames
from marine_mj.errors import ScenarioError
from marine_mj.validation.navigation import CARRIER, VEHICLE

NOW = Timing(1)
T = 0.01


def test_gauss_markov_statistics(rng):
    process = GaussMarkov(0.3, 5.0)
    x = process.initial(rng.normal(size=(20000, 3)))
    y = process.update(x, rng.normal(size=x.shape), 2.0)
    assert x.std() == pytest.approx(0.3, rel=0.01)  # 0.2 %
    assert y.std() == pytest.approx(0.3, rel=0.01)
    assert np.corrcoef(x.ravel(), y.ravel())[0, 1] == pytest.approx(np.exp(-0.4), abs=0.01)
    # Two half steps are one whole step.
    assert process.keep(1.0) ** 2 == pytest.approx(process.keep(2.0))
    assert process.drive(2.0) == pytest.approx(process.drive(1.0) * (1 + process.keep(1.0) ** 2))


def test_imu_measures_the_middle_of_the_period():
    imu = Imu(0.0, 0.0)
    for t in (0.3, 1.7):
        before, body, middle = VEHICLE.at(t - T), VEHICLE.at(t), VEHICLE.at(t - T / 2)
        gained = (world_velocity(body) - world_velocity(before)) / T
        bias = np.arange(6) * 1e-3
        found = imu.measure(body, gained, bias, np.zeros(6), T, 9.81)
        h = 1e-5
        exact = (world_velocity(VEHICLE.at(t - T / 2 + h))
                 - world_velocity(VEHICLE.at(t - T / 2 - h))) / (2 * h)  # fmt: skip
        force = middle.rotation.T @ (exact[:3] + np.array([0, 0, 9.81]))
        np.testing.assert_allclose(found - bias, np.concatenate([force, middle.velocity[3:]]),
                                   atol=1e-4)  # fmt: skip  # 4e-6


def test_sensor_noise_has_the_claimed_size(rng):
    n = 20000
    body = RigidState(*(np.broadcast_to(x, (n, x.size)) for x in _parts(VEHICLE.at(1.0))))
    dock = RigidState(*(np.broadcast_to(x, (n, x.size)) for x in _parts(CARRIER.at(1.0))))
    dvl = Dvl(NOW)
    z, seen = dvl.measure(body, rng.normal(size=(n, 3)))
    speed = np.linalg.norm(z.mean(axis=0))
    np.testing.assert_allclose(z.std(axis=0), 0.00084 + 0.038 * np.sqrt(speed), rtol=0.02)
    assert seen.all()
    for sensor, sizes in ((Usbl(NOW), (0.66, 0.01, 0.174, 0.087)),
                          (Camera(NOW), (0.2, 0.0046, 0.087, 0.087))):  # fmt: skip
        true = sensor.measure(body, dock, np.zeros((n, 6))[:, : 3 if sizes[0] > 0.5 else 6])[0][0]
        z = sensor.measure(body, dock, rng.normal(size=(n, 3 if sizes[0] > 0.5 else 6)))[0]
        r = np.linalg.norm(true)
        u = true / r
        across = np.cross([0, 0, 1.0], u) / np.linalg.norm(np.cross([0, 0, 1.0], u))
        error = z - true
        if sizes[0] > 0.5:
            along = np.hypot(sizes[0], sizes[1] * r)
        else:
            along = sizes[0] + sizes[1] * r + 0.0122 * r**2
        np.testing.assert_allclose((error @ u).std(), along, rtol=0.02)
        np.testing.assert_allclose((error @ np.cross(u, across)).std(), sizes[2] * r, rtol=0.02)
        np.testing.assert_allclose((error @ across).std(), sizes[3] * r, rtol=0.02)
        np.testing.assert_allclose(
            np.cov(error.T), sensor.noise.factor(true, (0, 0, 1)) @ sensor.noise.factor(
                true, (0, 0, 1)).T, atol=0.03 * along**2)  # fmt: skip


def _parts(body):
    return body.position, body.quaternion, body.velocity


def level(position, pitch=0.0):
    """A level body at rest."""
    q = frames.quaternion_from_euler([0.0, pitch, 0.0])
    return RigidState(np.asarray(position, dtype=float), q, np.zeros(6))


def test_sensors_see_no_farther_than_they_do():
    camera = Camera(NOW, marker=(0.0, 0.0, 0.0), mount=(0.0, 0.0, 0.0))
    dock = level([0.0, 0.0, 0.0])
    assert camera.visible(level([0, 0, -3.0]), dock)
    assert camera.visible(level([2.99, 0, -3.0]), dock)  # half angle 45 deg
    assert not camera.visible(level([3.01, 0, -3.0]), dock)
    assert not camera.visible(level([0, 0, 3.0]), dock)  # above the marker
    assert not camera.visible(level([0, 0, -8.01]), dock)
    assert not camera.visible(level([0, 0, -0.09]), dock)
    # Turned carrier: the light shines away (lobe 75 deg).
    assert camera.visible(level([0, 0, -3.0]), level([0, 0, 0.0], np.deg2rad(74.9)))
    assert not camera.visible(level([0, 0, -3.0]), level([0, 0, 0.0], np.deg2rad(75.1)))
    wall = np.array([[[-0.1, -1.0, -2.0], [0.1, 1.0, -1.0]]])
    hidden = replace(camera, boxes=wall)
    assert not hidden.visible(level([0.0, 0.5, -3.0]), dock)
    assert hidden.visible(level([2.0, 0.5, -3.0]), dock)
    dvl = Dvl(NOW, seabed=20.0, highest=10.0, lowest=1.0)
    heights = [(-9.9, False), (-10.1, True), (-18.9, True), (-19.1, False)]
    for z, seen in heights:
        assert dvl.measure(level([0, 0, z]), np.zeros(3))[1] == seen
    pressure = Pressure(NOW, mount=(1.0, 0.0, 0.0))
    z, wet = pressure.measure(level([0, 0, -2.0], np.deg2rad(-30)), np.ones(1))
    assert z[0] == pytest.approx(-1.5 + 0.05) and wet
    assert not pressure.measure(level([0, 0, 0.1]), np.ones(1))[1]
    assert not Usbl(NOW, reach=5.0).measure(level([9, 0, 0]), dock, np.zeros(3))[1]


def test_occlusion_agrees_with_points_along_the_line(rng):
    box = np.array([[-0.4, -0.3, -0.2], [0.5, 0.6, 0.7]])
    start = np.array([1.5, 0.0, 0.0])
    lines = 3 * rng.normal(size=(800, 3))
    lines[:20, 1] = 0.0
    points = start + np.linspace(0, 1, 2001)[:, None, None] * lines
    brute = np.all((points >= box[0]) & (points <= box[1]), axis=-1).any(axis=0)
    found = crossed(start, lines, box[None])
    assert 30 < brute.sum() < 400
    assert np.all(found[brute]) and (found != brute).sum() <= 2  # corners cut by some millimetres


def test_compass_measures_the_heading():
    yaw = np.array([-3.0, -1.0, 0.0, 0.5, 2.9])
    euler = np.stack([0.2 * np.cos(yaw), 0.3 * np.sin(yaw), yaw], axis=-1)
    body = RigidState(np.zeros((5, 3)), frames.quaternion_from_euler(euler), np.zeros((5, 6)))
    z, seen = Compass(NOW, 0.02).measure(body, np.full((5, 1), 2.0))
    np.testing.assert_allclose(z[:, 0] - 0.04, yaw)
    assert seen.all() and NoiseStream(np.arange(5), 1).rows(0).shape == (5, 1)


def test_refusals():
    with pytest.raises(ScenarioError, match=r"every = 10, delay = 10 updates; allowed are"):
        Timing(10, 10)
    with pytest.raises(ScenarioError, match=r"dropout = 1.5: allowed is a share"):
        Timing(1, 0, 1.5)
    with pytest.raises(ScenarioError, match=r"sensor delay = 0.005 s must be a whole multiple"):
        Timing.of(0.1, 0.005, 0.0, 0.01)
    with pytest.raises(ScenarioError, match=r"sigma = -1.0 must be >= 0"):
        GaussMarkov(-1.0, 3.0)
