"""States of actuators: tanks and lags with rate limits."""

import mujoco
import numpy as np
import pytest
from conftest import one_body

import marine_mj
from marine_mj.frames import rotation_from_quaternion

PUMP = '<general name="pump" site="s" gear="0 0 0 0 0 0" dyntype="integrator"/></actuator>'


def ballasted(tank, content=0.004):
    """End state (13) of a tumbling body with `content` m3 in a tank, or as a solid point mass."""
    common = {
        "added_mass": np.diag([4.0, 9, 12, 0.5, 1, 2]) + 0.1,
        "center": "0.02 0.01 -0.05",
        "integrator": "RK4",
        "timestep": 0.002,
        "extra": '<site name="a.center_of_buoyancy" pos="0 0 .03"/>',
    }
    numerics = (
        '<numeric name="a.displaced_volume" data="0.0135"/>'
        '<numeric name="a.quadratic_damping_flu" data="9 20 20 1 1 1"/>'
    )
    if tank:
        numerics += '<numeric name="a.tank.pump" data="-0.4 0.1 0.2 1025"/>'
    else:  # FRD in the numeric, FLU in the MJCF
        common["extra"] += (
            f'<body name="water" pos="-0.4 -0.1 -0.2"><inertial pos="0 0 0" '
            f'mass="{content * 1025!r}" diaginertia="1e-12 1e-12 1e-12"/></body>'
        )
    model = marine_mj.load_xml(one_body(numerics=numerics, **common).replace("</actuator>", PUMP))
    data = mujoco.MjData(model)
    data.qvel[:] = [0.5, -0.3, 0.2, 0.4, -0.6, 0.7]
    data.act[0] = content
    data.ctrl[0] = 4.0
    mujoco.mj_step(model, data, 2000)
    return np.concatenate([data.qpos, data.qvel])


def test_tank_is_a_point_mass():
    # measured 5e-13 after 4 s
    np.testing.assert_allclose(ballasted(True), ballasted(False), atol=1e-10)


def test_pumping_trims_and_sinks():
    xml = one_body(
        added_mass=[9, 9, 9, 0.5, 1, 2],  # no Munk moment
        center="0 0 0",
        numerics='<numeric name="a.buoyancy" data="98.1"/>'
        '<numeric name="a.tank.pump" data="0.5 0 0 1000"/>'
        '<numeric name="a.linear_damping_flu" data="20 20 20 5 5 5"/>',
        extra='<site name="a.center_of_buoyancy" pos="0 0 .1"/>',
    ).replace("</actuator>", PUMP)
    model = marine_mj.load_xml(xml)
    data = mujoco.MjData(model)
    data.ctrl[1] = 1e-5  # m3/s
    mujoco.mj_step(model, data, 4000)
    data.ctrl[1] = 0.0
    assert data.act[0] == pytest.approx(2e-4, rel=1e-9)
    mujoco.mj_step(model, data, 20000)
    # bow down by the moment balance of 0.2 kg at 0.5 m against 98.1 N at 0.1 m
    R = rotation_from_quaternion(data.qpos[3:7])
    pitch = np.arctan2(R[0, 2], R[2, 2])
    assert np.tan(pitch) == pytest.approx(0.2 * 9.81 * 0.5 / (98.1 * 0.1), rel=1e-3)
    assert data.qvel[2] < 0


@pytest.mark.parametrize("integrator", ["implicitfast", "RK4"])
def test_rate_limited_lag(integrator):
    """dyntype "user", law 1: constant rate until the lag takes over, then exponential."""
    tau, fall, rise, goal = 0.3, -100.0, 60.0, 40.0
    xml = one_body(added_mass=np.ones(6), gravity=0, timestep=0.001, integrator=integrator).replace(
        "</actuator>",
        f'<general name="u" site="s" gear="0 1 0 0 0 0" dyntype="user" '
        f'dynprm="1 {tau} {fall} {rise}"/></actuator>',
    )
    model = marine_mj.load_xml(xml)
    data = mujoco.MjData(model)
    data.ctrl[1] = goal
    switch = (goal - rise * tau) / rise  # s: from here on (goal - act) / tau < rise
    worst = 0.0
    for _ in range(1500):
        mujoco.mj_step(model, data)
        t = data.time
        if t < switch:
            expected = rise * t
        else:
            expected = goal - rise * tau * np.exp(-(t - switch) / tau)
        worst = max(worst, abs(data.act[0] - expected))
    # first order in h for the semi-implicit ones: measured 1.1e-2 N and 4e-9 N (RK4)
    assert worst < (1e-7 if integrator == "RK4" else 0.02)
    data.ctrl[1] = -1e6
    before = data.act[0]
    mujoco.mj_step(model, data, 100)
    assert data.act[0] - before == pytest.approx(fall * 0.1, rel=1e-9)
