"""Small scenes and seas for tests of pictures and figures."""

from types import SimpleNamespace

import mujoco
import numpy as np
import xarray as xr

from marine_mj.replay import States
from marine_mj.water import add_scenery

SIZE = (160, 90)
XML = """
<mujoco><worldbody>
  <body name="usv/hull"><freejoint/>
    <geom type="box" size="2.5 .75 .4" rgba=".9 .45 .1 1" mass="2300"/>
    <body name="usv/dock/cradle" pos="0 0 -.5">
      <geom type="box" size="1 .02 .15" pos="0 .2 -.2" mass="1"/>
      <site name="usv/dock/aperture" pos="0 0 -.5"/>
    </body>
    <camera name="usv/deck" pos="-2 0 1.2" xyaxes="0 -1 0 .2 0 1" fovy="60"/>
  </body>
  <body name="auv/hull" pos="-1 0 -2.3"><freejoint/>
    <geom type="capsule" fromto="-.85 0 0 .85 0 0" size=".1" rgba="1 .85 .1 1" mass="61"/>
  </body>
</worldbody></mujoco>
"""


def sea(height: float = 1.1, count: int = 40, seed: int = 0) -> SimpleNamespace:
    """Directional sea with the arrays of a wave field."""
    rng = np.random.default_rng(seed)
    omega = np.linspace(0.6, 3.0, count)
    spectrum = omega**-5 * np.exp(-1.25 / omega**4)
    amplitude = np.sqrt(spectrum * height**2 / 8 / spectrum.sum())
    return SimpleNamespace(
        omega=omega,
        wavenumber=omega**2 / 9.81,
        direction=rng.normal(0.4, 0.4, count),
        amplitude=amplitude,
        phase=rng.uniform(0, 2 * np.pi, count),
    )


def scene() -> mujoco.MjModel:
    """Compiled scene with two vehicles, a dock and scenery."""
    spec = mujoco.MjSpec.from_string(XML)
    add_scenery(spec, size=(960, 540))
    return spec.compile()


def run(duration: float = 4.0, step: float = 0.1) -> States:
    """States of a slow docking manoeuvre."""
    time = np.arange(0, duration + step / 2, step)
    qpos = np.zeros((len(time), 14))
    qpos[:, [3, 10]] = 1
    qpos[:, 2] = 0.1 * np.sin(time)
    qpos[:, 7] = -1 + time / duration
    qpos[:, 9] = -3 + time / duration
    return States(time, qpos, np.zeros((len(time), 0)), np.zeros((len(time), 0)))


def dataset(docking: bool = True) -> xr.Dataset:
    """Log dataset by the contract of docs/architecture.md."""
    states = run()
    n = len(states)
    eta = np.zeros((n, 2, 6))
    eta[:, 0, 2], eta[:, 1, 2] = -states.qpos[:, 2], -states.qpos[:, 9]
    dof = ["surge", "sway", "heave", "roll", "pitch", "yaw"]
    variables = {
        "qpos": (("time", "position"), states.qpos),
        "eta_ned": (("time", "vehicle", "dof"), eta),
        "nu_frd": (("time", "vehicle", "dof"), np.gradient(eta, states.time, axis=0)),
    }
    if docking:
        wrench = np.ones((n, 2, 3, 6)) * np.array([600, 590, 20])[:, None]
        phase = np.digitize(states.time, [1.0, 2.0, 3.0]).astype(float)
        text = "0 approach 1 under 2 wait 3 enter"
        variables |= {
            "wrench": (("time", "vehicle", "cause", "dof"), wrench),
            "contact_force": (("time",), np.where(states.time > 3.2, 50.0, 0.0)),
            "dock_error": (("time", "dof"), eta[:, 1] - eta[:, 0]),
            "relative_velocity": (("time", "dof"), np.gradient(eta[:, 1], states.time, axis=0)),
            "phase": (("time",), phase, {"long_name": text}),
            "latched": (("time",), (states.time > 3.6).astype(float)),
        }
    coordinates = {"time": states.time, "vehicle": ["usv", "auv"], "dof": dof}
    if docking:
        coordinates["cause"] = ["gravity", "buoyancy", "drag"]
    return xr.Dataset(variables, coordinates, {"title": "docking", "seed": 3})
