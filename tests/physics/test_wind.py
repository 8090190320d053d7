"""Wind forces on a vehicle."""

import mujoco
import numpy as np
import pytest
from conftest import numbers, one_body

import marine_mj
from marine_mj.environment import Environment, steady_wind


@pytest.mark.parametrize("course", np.radians([0.0, 30, 90, 150, 180, 250, 330]))
def test_wind_force(course):
    """Fossen (2021), eq. 10.23-10.27 in the frame of the book (FRD, NED)."""
    area_x, area_y, length, height, c_x, c_y, c_n = 2.0, 6.0, 5.0, 0.5, 0.7, 0.9, 0.1
    speed, air = 12.0, 1.225
    data_ = numbers([area_x, area_y, length, height, c_x, c_y, c_n])
    model = marine_mj.load_xml(
        one_body(
            numerics=f'<numeric name="a.wind" data="{data_}"/>',
            added_mass=np.zeros(6),
            pos="0 0 0.2",
        ),
        Environment(wind=steady_wind(speed, course)),
    )
    data = mujoco.MjData(model)
    yaw = 0.4
    data.qpos[3:7] = np.cos(yaw / 2), 0, 0, np.sin(yaw / 2)
    surge, sway = 2.0, 0.5  # FRD
    c, s = np.cos(yaw), np.sin(yaw)
    data.qvel[:2] = c * surge + s * sway, s * surge - c * sway
    mujoco.mj_forward(model, data)
    force = marine_mj.wrenches(model, data)["a"]["wind"]
    # NED: direction of travel and yaw are clockwise
    u_w, v_w = speed * np.cos(-course + yaw), speed * np.sin(-course + yaw)
    u_r, v_r = surge - u_w, sway - v_w
    gamma = -np.arctan2(v_r, u_r)
    q = 0.5 * air * (u_r**2 + v_r**2)
    X = -q * c_x * np.cos(gamma) * area_x
    Y = q * c_y * np.sin(gamma) * area_y
    N = q * c_n * np.sin(2 * gamma) * area_y * length
    z = -height  # FRD: the lateral centroid lies above the origin
    frd = np.array([X, Y, 0, -z * Y, z * X, N])
    # measured 5e-14
    np.testing.assert_allclose(force, frd * [1, -1, -1, 1, -1, -1], atol=1e-11)


def test_still_air_brakes():
    model = marine_mj.load_xml(
        one_body(numerics='<numeric name="a.wind" data="2 6 5 .5 .7 .9 .1"/>', pos="0 0 0.2"),
        Environment(wind=steady_wind(1e-9, 0.0)),
    )
    data = mujoco.MjData(model)
    data.qvel[0] = 10.0
    mujoco.mj_forward(model, data)
    force = marine_mj.wrenches(model, data)["a"]["wind"]
    assert force[0] == pytest.approx(-0.5 * 1.225 * 0.7 * 2.0 * 100, rel=1e-6)


def test_still_air_brakes_without_any_wind():
    """`no_wind` promises that a moving vehicle still has air drag."""
    model = marine_mj.load_xml(
        one_body(numerics='<numeric name="a.wind" data="2 6 5 .5 .7 .9 .1"/>', pos="0 0 0.2")
    )
    data = mujoco.MjData(model)
    data.qvel[0] = 10.0
    mujoco.mj_forward(model, data)
    force = marine_mj.wrenches(model, data)["a"]["wind"]
    assert force[0] == pytest.approx(-0.5 * 1.225 * 0.7 * 2.0 * 100, rel=1e-12)
