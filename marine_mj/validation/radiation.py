"""Radiation memory: time domain against frequency domain, for the box of the docking study."""

from collections.abc import Iterator

import mujoco
import numpy as np

from marine_mj.environment import Environment, irregular_sea, regular_wave
from marine_mj.frames import Array
from marine_mj.hydrodynamics import load, read_coefficients, start_in_waves
from marine_mj.hydrodynamics.inertia import subtree_inertia
from marine_mj.hydrodynamics.memory_store import memory_report, read_radiation
from marine_mj.hydrodynamics.raos import database_path, read_responses, responses
from marine_mj.hydrodynamics.vector_fitting import Complex
from marine_mj.library import find_model
from marine_mj.validation.rows import Row, row

MODEL, DATABASE = "dus_v5750", "dus_v5750_box.nc"
SOURCE = "frequency domain (Capytaine)"
DOFS = ("surge", "sway", "heave", "roll", "pitch", "yaw")
#: Indices of the wave directions 0 and 45 deg of the database.
AHEAD, OBLIQUE = 0, 4
#: Degrees of freedom that waves move, by index of the wave direction.
DOFS_OF = {AHEAD: (0, 2, 4), OBLIQUE: (0, 1, 2, 3, 4, 5)}
#: Responses below this, of the wave or its slope, are not compared as ratios.
SMALL = 0.05
#: Indices of the ten frequencies, 0.8 to 4.5 rad/s (periods 1.4 to 7.9 s).
FREQUENCIES = (6, 10, 13, 16, 18, 20, 24, 30, 33, 36)


def _body() -> tuple[Array, Array, Array]:
    """Rigid inertia, restoring and hull friction (6, 6) of the vessel."""
    body = read_coefficients(mujoco.MjSpec.from_file(str(find_model(MODEL))))[0]
    model = load(MODEL)
    M = subtree_inertia(model, model.body(body.name).id)[2]
    G = np.zeros((6, 6)) if body.restoring is None else body.restoring
    return M, G, body.viscous_damping


def expected_response(index: int, column: int) -> Complex:
    """`[-w^2 (M + A) - i w (B + D) + G]^-1 F` (6,), m/m and rad/m, from the wave database.

    Its motion RAO with the friction D of the model in all degrees of freedom: the RAO has that of
    roll only.

    Args:
        index: of the frequency in the wave database.
        column: of the wave direction.
    """
    M, G, D = _body()
    data, _ = read_radiation(database_path(DATABASE))
    omega, _, force = read_responses(database_path(DATABASE), "force")
    w, A, B = omega[index], data["added_mass"][index], data["radiation_damping"][index]
    impedance = -(w**2) * (M + A) - 1j * w * (B + D) + G
    return np.asarray(np.linalg.solve(impedance, force[index, column]), dtype=complex)


def response(index: int, column: int, timestep: float = 0.005) -> Complex:
    """Simulated steady amplitude (6,), m/m and rad/m, in a low regular wave.

    Args:
        index: of the frequency in the wave database.
        column: of the wave direction.
        timestep: about, s; rounded so that a period is a whole number of steps.
    """
    omega, directions, _ = read_responses(database_path(DATABASE), "motion")
    w, amplitude = omega[index], 1e-3
    period = 2 * np.pi / w
    steps = round(period / timestep)
    sea = Environment(waves=regular_wave(2 * amplitude, period, directions[column]))
    model = load(MODEL, sea, timestep=period / steps)
    data = mujoco.MjData(model)
    start_in_waves(model, data)
    mujoco.mj_step(model, data, steps * round(25.0 / period))
    poses, times = np.zeros((steps, 6)), np.zeros(steps)
    for step in range(steps):
        mujoco.mj_step(model, data)
        poses[step] = *data.qpos[:3], *(2 * data.qpos[4:7])
        times[step] = data.time
    # drift within the period taken out of the harmonic
    basis = np.stack([np.cos(w * times), np.sin(w * times), np.ones(steps), times], axis=1)
    fit = np.linalg.lstsq(basis, poses, rcond=None)[0]
    return np.asarray((fit[0] + 1j * fit[1]) / amplitude, dtype=complex)


def regular_waves() -> Iterator[Row]:
    """Amplitude and phase in regular waves at ten frequencies, ahead and oblique."""
    omega = read_responses(database_path(DATABASE), "motion")[0][list(FREQUENCIES)]
    slope = omega[:, None] ** 2 / 9.81
    scale = np.where(np.arange(6) < 3, 1.0, slope)
    source = f"frequency domain with hull friction, worst of {len(FREQUENCIES)} frequencies"
    for column, name in ((AHEAD, "head"), (OBLIQUE, "45 deg")):
        got = np.array([response(index, column) for index in FREQUENCIES])
        wanted = np.array([expected_response(index, column) for index in FREQUENCIES])
        for dof in DOFS_OF[column]:
            # near its zeros the ratio says little: the difference stands in a row of its own
            seen = np.abs(wanted / scale)[:, dof] > SMALL
            ratio = got[seen, dof] / wanted[seen, dof]
            size, phase = np.abs(ratio), np.degrees(np.angle(ratio))
            label = f"radiation memory, {name} sea, {DOFS[dof]}"
            worst = size[np.abs(size - 1).argmax()]
            lag = phase[np.abs(phase).argmax()]
            yield row(f"{label}: amplitude ratio", worst, 1, "1", source, percent=2)
            yield row(f"{label}: phase difference", lag, 0, "deg", source, within=3)
        wrong = (np.abs(got - wanted) / scale)[:, list(DOFS_OF[column])].max()
        label = f"radiation memory, {name} sea, largest difference / wave or slope"
        yield row(label, wrong, 0, "1", source, within=0.02)


def _frequency_response(omega: Array, dof: int) -> Complex:
    """Transform (n,) of the free motion in one degree of freedom after a unit start velocity.

    With A and B of the database, cubic between its frequencies; above, A - A(inf) and B fall with
    omega^-2, below B vanishes.
    """
    from scipy.interpolate import CubicSpline

    M, G, D = _body()
    data, _ = read_radiation(database_path(DATABASE))
    inside = np.clip(omega, data["omega"][0], data["omega"][-1])
    tail = ((inside / omega) ** 2)[:, None, None]
    tail = np.where((omega > inside)[:, None, None], tail, 1.0)
    infinite = data["infinite"]
    A = infinite + tail * (CubicSpline(data["omega"], data["added_mass"])(inside) - infinite)
    B = tail * CubicSpline(data["omega"], data["radiation_damping"])(inside)
    w = omega[:, None, None]
    impedance = -(w**2) * (M + A) + 1j * w * (B + D) + G
    kick = (M + infinite)[:, dof]
    return np.asarray(np.linalg.solve(impedance, kick[:, None])[:, dof, 0], dtype=complex)


def decay(dof: int, integrator: str = "implicitfast", speed: float = 1e-4) -> tuple[Array, Array]:
    """Free motion (n,) after a start velocity, simulated and from the frequency domain, 12 s.

    The second is the inverse Fourier transform of the response with the A(omega) and B(omega) of
    the database: it knows nothing of the fit.
    """
    model = load(MODEL)
    model.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator.upper()}")
    data = mujoco.MjData(model)
    data.qvel[dof] = speed
    # qvel of the semi-implicit integrators stands half a step before the position
    early = 0.0 if integrator == "RK4" else 0.5 * model.opt.timestep
    got, times = [], []
    for _ in range(round(12.0 / model.opt.timestep)):
        mujoco.mj_step(model, data)
        pose = [*data.qpos[:3], *(2 * data.qpos[4:7])]
        got.append(pose[dof] / speed)
        times.append(data.time + early)
    step = 0.01
    omega = np.asarray((np.arange(30_000) + 0.5) * step, dtype=float)
    X = _frequency_response(omega, dof).real
    every = 10
    t = np.array(times[::every])
    expected = 2 / np.pi * step * (np.cos(np.outer(t, omega)) @ X)
    return np.array(got[::every]), expected


def _period_and_decrement(x: Array, step: float) -> tuple[float, float]:
    """Period [s] and logarithmic decrement from the first three extremes of a decaying motion."""
    inner = np.flatnonzero((x[1:-1] - x[:-2]) * (x[2:] - x[1:-1]) < 0)[:3] + 1
    peaks, places = [], []
    for i in inner:  # parabola through three points
        a, b, c = x[i - 1], x[i], x[i + 1]
        shift = 0.5 * (a - c) / (a - 2 * b + c)
        places.append((i + shift) * step)
        peaks.append(b - 0.25 * (a - c) * shift)
    return places[2] - places[0], float(np.log(abs(peaks[0] / peaks[2])))


def free_decay() -> Iterator[Row]:
    """Decay of heave, roll and pitch in calm water."""
    for dof in (2, 3, 4):
        got, expected = decay(dof)
        error = np.abs(got - expected).max() / np.abs(expected).max()
        label = f"radiation memory, {DOFS[dof]} decay"
        source = "inverse Fourier transform of the response"
        yield row(f"{label}: error / largest", error, 0, "1", source, within=0.02)
        ours, theirs = (_period_and_decrement(x, 0.05) for x in (got, expected))
        yield row(f"{label}: period", ours[0], theirs[0], "s", source, percent=1)
        yield row(f"{label}: logarithmic decrement", ours[1], theirs[1], "1", source, percent=4)


def irregular_waves() -> Iterator[Row]:
    """Standard deviations in a low irregular head sea, 20 minutes."""
    waves = irregular_sea(0.05, 4.0, components=100, seed=3)
    model = load(MODEL, Environment(waves=waves), timestep=0.01)
    data = mujoco.MjData(model)
    start_in_waves(model, data)
    poses, times = [], []
    for _ in range(24_000):
        mujoco.mj_step(model, data, 5)
        poses.append([data.qpos[2], 2 * data.qpos[5]])
        times.append(data.time)
    X = responses(DATABASE, "motion", waves, 0.0) * np.exp(1j * waves.phase)
    turn = np.exp(-1j * np.outer(waves.omega, np.array(times)))
    for column, dof in enumerate((2, 4)):
        std = np.std([pose[column] for pose in poses])
        label = f"radiation memory, irregular head sea, {DOFS[dof]}: standard deviation"
        record = np.std((X[dof] @ turn).real)
        source = "RAO times the same components"
        yield row(f"{label}, record", std / record, 1, "1", source, percent=2)
        spectrum = np.sqrt(0.5 * (np.abs(X[dof]) ** 2).sum())
        source = "integral of |RAO|^2 S; tolerance: sampling error of 20 minutes"
        yield row(f"{label}, ensemble", std / spectrum, 1, "1", source, percent=6)


def fit() -> Iterator[Row]:
    """Fit of the state-space model to the wave database."""
    for pair in memory_report(DATABASE):
        label = f"radiation memory, fit of {pair.name}, order {pair.order}: error"
        yield row(label, 100 * pair.error, 0, "%", SOURCE, within=2)


CASES = (fit, regular_waves, free_decay, irregular_waves)
