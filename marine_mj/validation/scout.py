"""The Scout against its published behaviour."""

from collections.abc import Iterator, Sequence

import mujoco
import numpy as np
from scipy.integrate import solve_ivp

from marine_mj.environment import (
    SEA_STATES,
    Environment,
    WaveField,
    irregular_sea,
    regular_wave,
)
from marine_mj.frames import Array, flip
from marine_mj.hydrodynamics.loader import load
from marine_mj.hydrodynamics.wrenches import wrenches
from marine_mj.validation.rows import Row, row

RHO, G = 1025.0, 9.81
DIGEST = "docking study"
#: The equations of the docking study: lumped drag, no Froude-Krylov force, constant buoyancy.
THESIS = {
    "strips": False,
    "froude_krylov": False,
    "convective": False,
    "constant_buoyancy": True,
}
SCOUT_BUOYANCY, SCOUT_WEIGHT = 0.061 * RHO * G, 61.5 * G


def scout(
    timestep: float = 0.005, environment: Environment | None = None
) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """Scout in still water as the docking study models it, at 50 m depth."""
    model = load("scout", environment, {"hull": THESIS}, timestep)
    data = mujoco.MjData(model)
    data.qpos[2] = -50
    return model, data


def _level(model: mujoco.MjModel, data: mujoco.MjData, neutral: float, righting: float) -> Array:
    """Generalized force (6) that takes net buoyancy [N] and pitch stiffness [N m/rad] away."""
    R = data.xmat[model.body("hull").id].reshape(3, 3)
    out = np.zeros(6)
    out[2] = -neutral
    out[3:] = righting * np.array([R[2, 1], -R[2, 0], 0.0])
    return out


def push(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    axis: int,
    force: float,
    seconds: float,
    neutral: float,
    righting: float = 0.0,
    hold: float = 0.0,
) -> Array:
    """Twist (steps, 6) of the body `hull` under a constant force along a body axis, FLU.

    Args:
        model: compiled model.
        data: its state, which is stepped.
        axis: 0 to 5.
        force: N or N m.
        seconds: how long.
        neutral: net buoyancy that is taken away, N.
        righting: pitch stiffness that is taken away, N m/rad.
        hold: stiffness of an attitude hold about the axes that are not pushed, N m/rad.
    """
    body, twists = model.body("hull").id, []
    for _ in range(round(seconds / model.opt.timestep)):
        R = data.xmat[body].reshape(3, 3)
        if not R.any():
            R = np.eye(3)
        wrench = np.zeros(6)
        wrench[axis] = force
        wrench[:3] = R @ wrench[:3]
        tilt = 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
        back = -hold * (tilt + 0.2 * data.qvel[3:6])
        if axis >= 3:
            back[axis - 3] = 0.0
        wrench[3:] += back
        data.qfrc_applied[:6] = wrench + _level(model, data, neutral, righting)
        mujoco.mj_step(model, data)
        R = data.xmat[body].reshape(3, 3)
        twists.append(np.r_[R.T @ data.qvel[:3], data.qvel[3:6]])
    return np.array(twists)


def scout_speeds() -> Iterator[Row]:
    """Scout: accelerations, terminal speeds and rise times (V9-V11, V16)."""
    net = SCOUT_BUOYANCY - SCOUT_WEIGHT
    righting = 0.01 * SCOUT_BUOYANCY
    cases = (
        ("surge", 0, 192.0, 2.136, 0.749, 2.853, "m/s"),
        ("backwards", 0, -152.0, -1.900, None, -2.259, "m/s"),
        ("heave", 2, 68.0, 0.368, 0.685, 0.537, "m/s"),
        ("pitch", 4, 20.0, 0.427, 0.558, 0.766, "rad/s"),
    )
    for name, axis, force, speed, tau, acceleration, unit in cases:
        model, data = scout()
        twist = push(model, data, axis, force, 5.0, net, righting if axis == 4 else 0.0)[:, axis]
        final, h = twist[-1], model.opt.timestep
        number = "V10" if axis else "V9"
        case = f"Scout, {name}: "
        yield row(f"{number} {case}terminal speed", final, speed, unit, DIGEST, percent=0.5)
        rate = twist[0] / h
        name = f"V16 {case}acceleration"
        yield row(name, rate, acceleration, unit + "2", DIGEST, percent=0.3)
        if tau:
            step = round(tau / h)
            measured = step * h / np.arctanh(twist[step - 1] / final)
            yield row(f"V11 {case}rise time", measured, tau, "s", "closed form tanh", percent=1)


def scout_free() -> Iterator[Row]:
    """Scout: coast-down, free ascent, pitch stiffness and period, weight (V12-V15, V25)."""
    net = SCOUT_BUOYANCY - SCOUT_WEIGHT
    model, data = scout()
    data.qvel[0] = 1.0
    speed = push(model, data, 0, 0.0, 3.0, net)[-1, 0]
    yield row("V12 Scout, speed 3 s after 1 m/s", speed, 0.348, "m/s", DIGEST, percent=1)
    model, data = scout()
    mujoco.mj_step(model, data, 4000)
    name = "V13 Scout, free ascent"
    yield row(name, data.qvel[2], 0.1415, "m/s", DIGEST, percent=0.5)
    model, data = scout(0.002)
    angle = 1e-3
    data.qpos[3:7] = np.cos(angle / 2), 0, np.sin(angle / 2), 0
    mujoco.mj_forward(model, data)
    stiffness = -wrenches(model, data)["hull"]["restoring"][4] / np.sin(angle)
    name = "V14 Scout, pitch stiffness"
    yield row(name, stiffness, 6.13, "N m/rad", DIGEST, percent=1)
    crossings, before = [], 0.0
    for _ in range(round(40 / 0.002)):
        data.qfrc_applied[2] = -net
        mujoco.mj_step(model, data)
        now = float(data.qvel[4])
        if before < 0 <= now:
            crossings.append(data.time - 0.002 * now / (now - before))
        before = now
    period = np.diff(crossings).mean()
    yield row("V14 Scout, pitch period", period, 12.97, "s", DIGEST, percent=1)
    mass = float(model.body_subtreemass[model.body("hull").id])
    yield row("V15 Scout, weight", mass * G, 603.3, "N", DIGEST, percent=0.1)
    data.qpos[3:7] = 1, 0, 0, 0
    mujoco.mj_forward(model, data)
    lift = wrenches(model, data)["hull"]["restoring"][2]
    yield row("V15 Scout, buoyancy", lift, 613.4, "N", DIGEST, percent=0.1)
    ratio = mass * G / lift
    yield row("V15 Scout, weight / buoyancy", ratio, 0.9836, "1", DIGEST, percent=0.1)
    energy = 0.5 * mass * 0.7**2
    yield row("V25 Scout, energy at 0.7 m/s", energy, 15.07, "J", DIGEST, within=0.005)
    yield row("V25 Scout, speed for 30 J", np.sqrt(60 / mass), 0.988, "m/s", DIGEST, within=5e-4)


#: [x, z, theta, u, w, q] (NED, FRD) at t = 1, 3, 10 s from the state in the first row.
PASSIVE = (
    (
        (0, 5, 0, 0, 0, 0),
        (0, 4.962, 0, 0, -0.072, 0),
        (0, 4.742, 0, 0, -0.132, 0),
        (0, 3.760, 0, 0, -0.141, 0),
    ),
    (
        (1, 4, 1, 0, 0, 0),
        (1.017, 3.938, 0.912, 0.115, -0.046, -0.157),
        (1.165, 3.570, 0.515, 0.202, -0.129, -0.209),
        (1.715, 2.460, -0.177, -0.040, -0.141, 0.058),
    ),
    (
        (1, 4, np.pi / 2, 0, 0, 0),
        (1.002, 3.927, 1.469, 0.144, -0.008, -0.180),
        (1.079, 3.435, 1.016, 0.307, -0.094, -0.247),
        (1.999, 1.954, -0.222, 0.021, -0.143, -0.039),
    ),
    (
        (0, 5, 0, 1, 0, 0),
        (0.776, 4.964, -0.022, 0.612, -0.079, -0.060),
        (1.658, 4.805, -0.252, 0.279, -0.152, -0.125),
        (2.306, 3.997, -0.006, 0.011, -0.141, 0.078),
    ),
    (
        (0, 5, 0, 0, 1, 0),
        (0, 5.385, 0, 0, 0.167, 0),
        (0, 5.487, 0, 0, -0.035, 0),
        (0, 4.616, 0, 0, -0.141, 0),
    ),
    (
        (0, 5, 0, 0, 0, 1),
        (0.010, 4.959, 0.380, 0.054, -0.067, 0.161),
        (0.138, 4.673, 0.405, 0.162, -0.127, -0.112),
        (0.613, 3.604, -0.161, -0.041, -0.141, 0.059),
    ),
)


def passive_response(
    start: tuple[float, ...], times: Sequence[float], timestep: float = 0.002
) -> Array:
    """States (n, 6) of the Scout without control in still water, x, z, theta, u, w, q (NED, FRD).

    Args:
        start: (6,) state at t = 0.
        times: (n,) when, rising, s.
        timestep: of the RK4 integration, s.
    """
    model, data = scout(timestep)
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    x, z, theta, u, w, q = start
    data.qpos[:3] = x, 0, -z
    # pitch up is negative about the port axis
    data.qpos[3:7] = np.cos(theta / 2), 0, -np.sin(theta / 2), 0
    c, s = np.cos(theta), np.sin(theta)
    data.qvel[:3] = c * u + s * w, 0, s * u - c * w
    data.qvel[3:6] = 0, -q, 0
    states, done = [], 0
    for time in times:
        steps = round(time / timestep)
        mujoco.mj_step(model, data, steps - done)
        done = steps
        mujoco.mj_forward(model, data)
        R = data.xmat[1].reshape(3, 3)
        velocity = flip(R.T @ data.qvel[:3])
        pitch = float(np.arctan2(R[2, 0], R[0, 0]))
        states.append([data.qpos[0], -data.qpos[2], pitch, velocity[0], velocity[2], -data.qvel[4]])
    return np.array(states)


def scout_passive() -> Iterator[Row]:
    """Scout: passive motion in still water against the docking study's own integration (V24)."""
    for start, *anchors in PASSIVE:
        times = (1.0, 3.0, 10.0)
        states = passive_response(start, times)
        for t, state, anchor in zip(times, states, anchors, strict=True):
            if not any(start[2:]):
                name = f"V24 Scout, depth {t:g} s after rest at 5 m"
                yield row(name, state[1], anchor[1], "m", DIGEST, percent=1)
        label = ", ".join(f"{v:.3g}" for v in start)
        name = f"Scout, passive from ({label}), largest deviation"
        worst = float(np.abs(states - np.array(anchors)).max())
        source = f"{DIGEST}, three decimals"
        yield row(name, worst, 0, "m, rad, m/s, rad/s", source, within=6e-4)


def _thesis(sea: WaveField, depth: float, seconds: float) -> Array:
    """State [x, z, theta, u, w, q] (n, 6) every 10 ms by the equations of the docking study.

    Section 4.2 of the study, integrated here on its own; neutral (B = W), from rest at `depth`.
    """

    def rate(t: float, y: Array) -> Array:
        x, z, theta, u, w, q = y
        c, s = np.cos(theta), np.sin(theta)
        v, a = (f(x, 0.0, -z, t)[[0, 2]] * [1, -1] for f in (sea.velocity, sea.acceleration))
        to_body = np.array([[c, -s], [s, c]])
        v_w = to_body @ v
        a_w = to_body @ a + q * np.array([[-s, -c], [c, -s]]) @ v
        u_r, w_r = np.array([u, w]) - v_w
        du = 5.8 * a_w[0] - 61.5 * q * w - 65.1 * w_r * q - 42.1 * u_r * abs(u_r)
        dw = 65.1 * a_w[1] + 61.5 * q * u + 5.8 * u_r * q - 502.4 * w_r * abs(w_r)
        dq = (65.1 - 5.8) * u_r * w_r - 109.5 * q * abs(q) - 0.01 * SCOUT_BUOYANCY * s
        return np.array(
            [c * u + s * w, -s * u + c * w, q, du / 67.3, dw / 126.6, dq / (14.22 + 11.9)]
        )

    t = np.arange(round(seconds / 0.01) + 1) * 0.01
    start = [0.0, depth, 0.0, 0.0, 0.0, 0.0]
    path = solve_ivp(rate, (0, seconds), start, t_eval=t, rtol=1e-9, atol=1e-10, max_step=0.05)
    return path.y.T


def _amplitude(t: Array, omega: float, path: Array) -> Array:
    """Amplitudes of an oscillation beside a slow drift."""
    basis = np.stack([np.cos(omega * t), np.sin(omega * t), np.ones_like(t), t, t**2], axis=1)
    fit = np.linalg.lstsq(basis, path, rcond=None)[0]
    return np.hypot(fit[0], fit[1])


def scout_orbit() -> Iterator[Row]:
    """Scout, neutral, carried by waves: orbit (V36) and the study's own equations (V35)."""
    sea = regular_wave(1.1, 4.6)
    omega, k = float(sea.omega[0]), float(sea.wavenumber[0])
    particle = 0.55 * np.exp(-8 * k)

    def sail(model: mujoco.MjModel, depth: float, seconds: float) -> Array:
        """Path (n, 2) of x and depth every 10 ms, from rest."""
        data, path = mujoco.MjData(model), [[0.0, depth]]
        data.qpos[2] = -depth
        data.qfrc_applied[2] = SCOUT_WEIGHT - SCOUT_BUOYANCY
        for _ in range(round(seconds / 0.01)):
            mujoco.mj_step(model, data, round(0.01 / model.opt.timestep))
            path.append([data.qpos[0], -data.qpos[2]])
        return np.array(path)

    t = np.linspace(0.0, 100.0, 10001)
    end = t > 100 - 2 * 4.6
    environment = Environment(waves=sea)
    path = sail(load("scout", environment), 8, 100)
    ratio = _amplitude(t[end], omega, path[end]) / particle
    for name, value in zip(("surge", "heave"), ratio, strict=True):
        title = f"V36 Scout, {name} / water at 8 m"
        yield row(title, value, 1.03, "1", f"{DIGEST}: 1.00 to 1.06", percent=10)
    model, _ = scout(0.005, environment)
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    path, own = sail(model, 8, 100), _thesis(sea, 8, 100)[:, :2]
    ours, theirs = (_amplitude(t[end], omega, p[end]) / particle for p in (path, own))
    for name, a, b in zip(("surge", "heave"), ours, theirs, strict=True):
        title = f"V36 Scout, {name} / water, without Froude-Krylov force"
        yield row(title, a, b, "1", "solve_ivp of the study's equations", percent=1)
    state = SEA_STATES[4]
    irregular = irregular_sea(state.H_s, state.T_p, components=50, seed=4)
    model, _ = scout(0.005, Environment(waves=irregular))
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    gap = np.abs(sail(model, 4, 60) - _thesis(irregular, 4, 60)[:, :2]).max()
    title = "V35 Scout in irregular waves for 60 s, largest distance between the paths"
    yield row(title, gap, 0, "m", "solve_ivp of the study's equations", within=0.01)


CASES = (scout_speeds, scout_free, scout_passive, scout_orbit)
