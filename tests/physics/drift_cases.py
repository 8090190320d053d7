"""Floating bodies with wave drift, and what the law says about it."""

import mujoco
import numpy as np
from conftest import numbers, one_body

import marine_mj
from marine_mj.environment import Environment, WaveField

FILE = "dus_v5750_box.nc"
RHO, G = 1025.0, 9.81
#: omega [rad/s], D_x, D_y [m], D_n [m2]
ROWS = np.array(
    [[0.4, 0.1, 0.3, 0.05], [1.0, 0.5, 2.0, -0.4], [1.7, 1.1, 3.5, 0.6], [3.0, 1.4, 4.6, 0.2]]
)


def expected_drift(omega, chi, rows=ROWS):
    """T (3, N) of the rows: linear in omega from (0, 0), held above; closed form in chi."""
    widths = [np.interp(omega, np.append(0, rows[:, 0]), np.append(0, c)) for c in rows.T[1:]]
    c, s = np.cos(chi), np.sin(chi)
    shape = [c * abs(c), s * abs(s), np.sin(2 * chi)]
    return 0.5 * RHO * G * np.array([w * f for w, f in zip(widths, shape, strict=True)])


def boat(waves, drift=None, rows=ROWS, **options):
    """A free body `a` whose drift stands in its file."""
    numerics = f'<numeric name="a.drift" data="{numbers(rows)}"/>' + options.pop("numerics", "")
    xml = one_body(numerics=numerics, gravity=0, **({"pos": "0 0 0"} | options))
    return marine_mj.load_xml(xml, Environment(waves=waves), {"a": {"drift": drift}})


def force(model, time=0.0, x=0.0, y=0.0, yaw=0.0, quat=None):
    """Wrench (6) of the waves on the body `a`, body axes."""
    data = mujoco.MjData(model)
    data.time = time
    data.qpos[:2] = x, y
    data.qpos[3:7] = (np.cos(yaw / 2), 0, 0, np.sin(yaw / 2)) if quat is None else quat
    mujoco.mj_forward(model, data)
    return marine_mj.wrenches(model, data)["a"]["waves"]


def forces(model, times):
    """Surge, sway, yaw (n, 3) at rest at the origin, by the raw loads of a body in zero gravity."""
    data = mujoco.MjData(model)
    found = []
    for time in times:
        data.time = time
        mujoco.mj_forward(model, data)
        found.append(data.qfrc_passive[[0, 1, 5]].copy())
    return np.array(found)


def waves_of(omega, amplitude, direction=0.0, phase=0.0):
    """Deep-water field of given components."""
    omega = np.asarray(omega, dtype=float)
    one = np.ones_like(omega)
    return WaveField(omega, omega**2 / G, direction * one, amplitude * one, phase * one)
