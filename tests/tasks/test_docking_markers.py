"""The marked goal is the aperture, wherever the carrier is believed to be."""

import mujoco
import numpy as np
import pytest
import xarray as xr

from marine_mj import frames
from marine_mj.markers import docking_markers
from marine_mj.scenario import Scenario
from marine_mj.scene import compile_scene


@pytest.mark.parametrize(
    ("name", "bearer"),
    [("docking_demo", "usv/hull"), ("docking_suspended", "usv/dock/cradle")],
)
def test_goal_stands_at_the_aperture(name, bearer):
    model = compile_scene(Scenario.load(name)).model
    data = mujoco.MjData(model)
    rng = np.random.default_rng(1)
    for joint in range(model.njnt):
        start = model.jnt_qposadr[joint]
        if model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_FREE:
            data.qpos[start : start + 3] = rng.normal(size=3)
            turn = rng.normal(size=4)
            data.qpos[start + 3 : start + 7] = turn / np.linalg.norm(turn)
        else:
            data.qpos[start] += 0.1
    mujoco.mj_kinematics(model, data)
    body = data.body(bearer)
    eta = np.tile(frames.eta_ned(body.xpos, body.xquat), (2, 1))
    log = xr.Dataset(
        {
            "target_ned": (("time", "axis"), np.zeros((2, 3))),
            "estimated_eta_ned": (("time", "dof"), np.zeros((2, 6))),
            "estimated_carrier_eta_ned": (("time", "dof"), eta),
        },
        {"time": [0.0, 1.0]},
    )
    *_, goal = docking_markers(model, log, np.array([0.5]))
    aperture = data.site("usv/dock/aperture")
    assert goal.name == "goal"
    # Measured 2e-16.
    np.testing.assert_allclose(goal.position[0], aperture.xpos, atol=1e-9)
    np.testing.assert_allclose(goal.rotation[0].ravel(), aperture.xmat, atol=1e-9)
