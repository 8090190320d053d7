"""A servo that holds the start heading of a vehicle that moves by its forces."""

import mujoco
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from marine_mj.errors import ModelError
from marine_mj.scenario import Scenario
from marine_mj.scene import compile_scene, main_bodies

STIFFNESS, DAMPING, LIMIT = 1800.0, 5000.0, 2000.0
CALM = {"sea.spectrum": "none", "sea.sea_state": None, "sea.spreading": None}


def scene(**changes):
    """USV of the rough sea in calm water, heading 30 deg; its yaw degree of freedom."""
    scenario = Scenario.load("docking_rough").with_values(
        CALM | {"vehicles.usv.heading_deg": 30.0} | changes
    )
    model = compile_scene(scenario, visual=False).model
    joint = model.body_jntadr[main_bodies(model)["usv"]]
    return model, model.jnt_qposadr[joint], model.jnt_dofadr[joint]


def turned(model, address, angle):
    data = mujoco.MjData(model)
    psi = np.deg2rad(-30.0) + angle  # NWU, counter-clockwise
    data.qpos[address + 3 : address + 7] = [np.cos(psi / 2), 0, 0, np.sin(psi / 2)]
    return data


@pytest.mark.parametrize(("angle", "rate"), [(0.0, 0.0), (0.3, 0.0), (-0.5, 0.1), (2.0, 0.0)])
def test_moment_is_a_spring_and_damper_within_its_limit(angle, rate):
    model, position, velocity = scene()
    data = turned(model, position, angle)
    data.qvel[velocity + 5] = rate
    mujoco.mj_forward(model, data)
    moment = np.clip(-STIFFNESS * angle - DAMPING * rate, -LIMIT, LIMIT)
    expected = [0, 0, 0, 0, 0, moment]
    np.testing.assert_allclose(data.qfrc_actuator[velocity : velocity + 6], expected, atol=1e-9)


def test_usv_turns_back_as_the_equation_of_yaw_says():
    """Independent: (I_z + A66) psi'' = N_control - D_L r - D_Q r abs(r), constant radiation."""
    model, position, _ = scene(**{"vehicles.usv.radiation": "constant"})
    data = turned(model, position, 0.4)

    def equation(_, state):
        psi, r = state
        control = np.clip(-STIFFNESS * psi - DAMPING * r, -LIMIT, LIMIT)
        return [r, (control - 150.0 * r - 3003.0 * r * abs(r)) / (5237.0 + 2020.0)]

    for end in (2.0, 5.0, 12.0):
        while data.time < end - 1e-9:
            mujoco.mj_step(model, data)
        w, z = data.qpos[position + 3], data.qpos[position + 6]
        angle = 2 * np.arctan2(z, w) + np.deg2rad(30.0)
        expected = solve_ivp(equation, (0, end), [0.4, 0.0], rtol=1e-9, atol=1e-9).y[0, -1]
        assert angle == pytest.approx(expected, abs=0.004)


def test_prescribed_motion_is_refused():
    with pytest.raises(ModelError, match=r"vehicles\.usv: heading_control.*motion = \"rao\""):
        scene(**{"vehicles.usv.motion": "rao"})
