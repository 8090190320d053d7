"""The vehicles of the package (the Scout apart) against their published behaviour."""

from collections.abc import Callable, Iterator

import mujoco
import numpy as np

from marine_mj.environment import (
    SEA_STATES,
    Environment,
    WaveField,
    irregular_sea,
    regular_wave,
)
from marine_mj.frames import euler_from_quaternion, flip_quaternion
from marine_mj.hydrodynamics.loader import load
from marine_mj.hydrodynamics.raos import responses
from marine_mj.hydrodynamics.wrenches import wrenches
from marine_mj.validation.rows import Row, row
from marine_mj.validation.scout import push

RHO, G = 1025.0, 9.81
DIGEST = "docking study"


def usv_statics() -> Iterator[Row]:
    """USV: displacement, inertia, restoring (V18), natural periods."""
    model = load("dus_v5750", settings={"hull": {"radiation": "constant"}})
    data = mujoco.MjData(model)
    body = model.body("hull").id
    mass = float(model.body_subtreemass[body])
    yield row("V18 USV, mass", mass, RHO * 5 * 1.5 * 0.3, "kg", "rho L B T", percent=0.1)
    yield row(
        "V18 USV, pitch inertia", model.body_inertia[body][1], 5411, "kg m2", DIGEST, percent=0.1
    )
    for name, axis, expected, unit in (
        ("C33", 2, 75414, "N/m"),
        ("C44", 3, 10745, "N m/rad"),
        ("C55", 4, 153703, "N m/rad"),
    ):
        step = 1e-4
        mujoco.mj_resetData(model, data)
        if axis == 2:
            data.qpos[2] += step
        else:
            data.qpos[3] = np.cos(step / 2)
            data.qpos[axis + 1] = np.sin(step / 2)
        mujoco.mj_forward(model, data)
        forces = wrenches(model, data)["hull"]
        stiffness = -(forces["restoring"] + forces["gravity"])[axis] / step
        yield row(f"V18 USV, {name}", stiffness, expected, unit, DIGEST, percent=0.1)
    M = np.zeros((model.nv, model.nv))
    mujoco.mj_resetData(model, data)
    mujoco.mj_forward(model, data)
    mujoco.mju_sparse2dense(M, data.M, model.M_rownnz, model.M_rowadr, model.M_colind)
    damping = {2: 6774.0, 3: 670.0, 4: 9478.0}
    for name, axis, C in (("heave", 2, 75414), ("roll", 3, 10745), ("pitch", 4, 153703)):
        mujoco.mj_resetData(model, data)
        data.qvel[axis] = 1e-3
        crossings, before, h = [], 1e-3, model.opt.timestep
        for _ in range(round(12 / h)):
            mujoco.mj_step(model, data)
            now = float(data.qvel[axis])
            if before < 0 <= now:
                crossings.append(data.time - h * now / (now - before))
            before = now
        inertia = M[axis, axis]
        rate = np.sqrt(C / inertia - (damping[axis] / (2 * inertia)) ** 2)
        source = "2 pi / sqrt(C/M - (D/2M)^2)"
        period = float(np.diff(crossings).mean())
        yield row(
            f"USV, period of the {name} decay", period, 2 * np.pi / rate, "s", source, percent=1
        )


def usv_raos() -> Iterator[Row]:
    """USV: long-wave limits of the motion RAOs (V19)."""
    wave = regular_wave(0.02, 12.0)
    rao = responses("dus_v5750_box.nc", "motion", wave, 0.0)[:, 0] / 0.01
    k = float(wave.wavenumber[0])
    for name, value, phase in (
        ("surge", rao[0], 90.0),
        ("heave", rao[2], 0.0),
        ("pitch / k", rao[4] / k, -90.0),
    ):
        title = f"V19 USV, {name}, T 12 s"
        yield row(title, abs(value), 1, "1", DIGEST, percent=1)
        lag = np.degrees(np.angle(value))  # Re(X exp(-i omega t)): the lag is the angle
        yield row(f"{title}, lag", lag, phase, "deg", DIGEST, within=1)


def _in_waves(sea: WaveField, seconds: float, use: Callable[[mujoco.MjData], None]) -> None:
    """Play back the USV's motion RAOs at the world's origin; `use(data)` after every step."""
    settings = {"hull": {"motion": "rao"}}
    model = load("dus_v5750", Environment(waves=sea), settings, timestep=0.01)
    data = mujoco.MjData(model)
    for _ in range(round(seconds / 0.01)):
        mujoco.mj_step(model, data)
        if data.time > 0.1:
            use(data)


def usv_motion() -> Iterator[Row]:
    """USV in waves: largest pitch in regular waves (V20), heave with the surface (V23)."""
    table = [4.7, 5.3, 5.3, 6.1, 7.4, 9.0, 9.4, 9.0, 9.2, 9.6, 10.0, 10.8]
    for state, expected in zip(SEA_STATES[1:], table, strict=True):
        sea = regular_wave(state.H_s, state.mean_period)
        pitch: list[float] = []

        def note(data: mujoco.MjData, pitch: list[float] = pitch) -> None:
            angles = euler_from_quaternion(flip_quaternion(data.qpos[3:7]))
            pitch.append(abs(float(angles[1])))

        _in_waves(sea, 1.1 * state.mean_period, note)
        measured = np.degrees(max(pitch))
        name = f"V20 USV, largest pitch, sea state {state.ss_bft}"
        yield row(name, measured, expected, "deg", f"{DIGEST}, Table 5.3", percent=4)
    long = (2 * np.pi / 30, 2 * np.pi / 12)
    sea = irregular_sea(1.0, 18.0, components=40, seed=4, frequency_range=long)
    gap: list[float] = []

    def compare(data: mujoco.MjData) -> None:
        gap.append(abs(float(data.qpos[2] - sea.elevation(0, 0, data.time))))

    _in_waves(sea, 100, compare)
    source = "surface elevation at its place"
    yield row(
        "V23 USV, heave in long irregular waves, largest gap", max(gap), 0, "m", source, within=0.01
    )


def bluerov2() -> Iterator[Row]:
    """BlueROV2: terminal speeds under constant force."""
    linear = (4.03, 6.22, 5.18, 0.07, 0.07, 0.07)
    quadratic = (18.18, 21.66, 36.99, 1.55, 1.55, 1.55)
    net = 114.8 - 11.5 * G
    for name, axis, force in (
        ("surge", 0, 40.0),
        ("sway", 1, 40.0),
        ("heave", 2, 40.0),
        ("yaw", 5, 5.0),
    ):
        model = load("bluerov2", settings={"hull": {"constant_buoyancy": True}})
        data = mujoco.MjData(model)
        data.qpos[2] = -100
        # straight ahead is unstable (Munk moment above the righting one): the attitude is held
        hold = 0.0 if axis == 5 else 100.0
        twist = push(model, data, axis, force, 40.0, net, hold=hold)
        speed = float(twist[-400:, axis].mean())
        a, b = quadratic[axis], linear[axis]
        expected = (-b + np.sqrt(b * b + 4 * a * force)) / (2 * a)
        unit = "m/s" if axis < 3 else "rad/s"
        source = "D_l v + D_q v |v| = F"
        yield row(f"BlueROV2, terminal {name} speed", speed, expected, unit, source, percent=0.5)


CASES = (
    usv_statics,
    usv_raos,
    usv_motion,
    bluerov2,
)
