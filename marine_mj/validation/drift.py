"""Wave drift: Newman's approximation against closed forms, and the drift of the USV's box."""

from collections.abc import Iterator

import mujoco
import numpy as np
from scipy.integrate import trapezoid

from marine_mj.environment import Environment, WaveField, irregular_sea
from marine_mj.environment.spectra import jonswap
from marine_mj.frames import Array
from marine_mj.hydrodynamics import compile_spec, read_coefficients, write_environment
from marine_mj.hydrodynamics.drift import mean_drift
from marine_mj.hydrodynamics.estimates import plate_reflection, reflected_drift
from marine_mj.library import find_model
from marine_mj.validation.rows import Row, row

RHO, G = 1025.0, 9.81
NEWMAN = "Newman (1974), arithmetic mean"
#: A hull whose beam-sea drift is 1/2 rho g D, D from 1 m at 0.4 rad/s to 5 m at 2.4 rad/s.
LINEAR = "0.4 0 1 0 2.4 0 5 0"


def _hull(drift: str) -> mujoco.MjSpec:
    """Body `a` at rest without gravity: the load on it is the drift alone."""
    return mujoco.MjSpec.from_string(
        f"""<mujoco><option gravity="0 0 0"/>
        <custom><numeric name="a.drift" data="{drift}"/></custom>
        <worldbody><body name="a"><freejoint/><inertial pos="0 0 0" mass="9" diaginertia="1 1 1"/>
        </body></worldbody></mujoco>"""
    )


def _linear(omega: Array) -> Array:
    """T of `LINEAR` in beam seas."""
    return 0.5 * RHO * G * np.interp(omega, [0, 0.4, 2.4], [0, 1, 5])


def _sway(model: mujoco.MjModel, times: Array) -> Array:
    """Sway force (n,) at the origin."""
    data = mujoco.MjData(model)
    force = np.zeros(len(times))
    for i, time in enumerate(times):
        data.time = time
        mujoco.mj_forward(model, data)
        force[i] = data.qfrc_passive[1]
    return force


def groups() -> Iterator[Row]:
    """Drift in one wave and in a wave group."""
    one = np.ones(2)
    omega, a = np.array([1.1, 1.6]), np.array([0.5, 0.3])
    T = _linear(omega)
    beam = 0.5 * np.pi * one
    pair = WaveField(omega, omega**2 / G, beam, a, 0 * one)
    single = WaveField(omega[:1], pair.wavenumber[:1], beam[:1], a[:1], np.ones(1))
    times = np.arange(200) / 200 * 2 * np.pi / 0.5
    force = _sway(compile_spec(_hull(LINEAR), Environment(waves=single)), times)
    worst = force[np.abs(force - a[0] ** 2 * T[0]).argmax()]
    yield row("drift in a regular wave, worst", worst, a[0] ** 2 * T[0], "N", "a^2 T", percent=1e-9)
    force = _sway(compile_spec(_hull(LINEAR), Environment(waves=pair)), times)
    beat = 2 * np.abs(np.fft.rfft(force)[1]) / len(times)
    expected = a[0] * a[1] * T.sum()
    yield row("drift of a wave pair, mean", force.mean(), T @ a**2, "N", NEWMAN, percent=1e-9)
    name = "drift of a wave pair, difference frequency"
    yield row(name, beat, expected, "N", NEWMAN, percent=1e-9)


def spectrum() -> Iterator[Row]:
    """Mean and spectrum of the slow drift in an irregular sea, 48 seeds."""
    source, low, high, count, seeds, samples = jonswap(1.5, 7.0), 0.4, 2.4, 100, 48, 256
    step = (high - low) / count

    def sea(seed: int) -> Environment:
        waves = irregular_sea(
            spectrum=source,
            direction=np.pi / 2,
            components=count,
            sampling="midpoint",
            frequency_range=(low, high),
            seed=seed,
        )
        return Environment(waves=waves)

    spec = _hull(LINEAR)
    bodies, model = read_coefficients(spec), compile_spec(spec, sea(0))
    times = np.arange(samples) / samples * 2 * np.pi / step  # one period of the record
    density = np.zeros(samples // 2)
    mean = 0.0
    for seed in range(seeds):
        write_environment(model, bodies, sea(seed))
        force = _sway(model, times)
        density += 2 * np.abs(np.fft.rfft(force)[: samples // 2] / samples) ** 2 / step / seeds
        mean += float(force.mean()) / seeds
    omega = np.linspace(low, high, 20001)
    expected = 2 * trapezoid(source(omega) * _linear(omega), omega)
    theory = "2 int S T d omega, Pinkster (1980)"
    yield row("mean drift, JONSWAP H_s 1.5 m", mean, expected, "N", theory, percent=0.02)
    # scatter of one record, by random phases: neighbouring lines of a narrow sea go together
    for first, last, scatter in ((1, 11, 0.40), (11, 31, 0.25)):
        total = 0.0
        for line in range(first, last):
            omega = np.linspace(low, high - line * step, 2001)
            mu, T = line * step, _linear(omega + 0.5 * line * step)
            total += 8 * float(trapezoid(source(omega + mu) * source(omega) * T**2, omega))
        interval = 1.96 * scatter / np.sqrt(seeds)
        name = f"slow drift, energy from {first * step:.2f} to {last * step:.2f} rad/s"
        source_ = "8 int S S T^2 d omega, Pinkster (1980); tolerance: 95 % interval"
        yield row(name, density[first:last].sum() / total, 1, "1", source_, within=interval)


def reflection() -> Iterator[Row]:
    """A hull that reflects like a plate, 7.2 x 2.02 m, draft 0.76 m."""
    rows = reflected_drift(np.linspace(0.03, 3.75, 125), 7.2, 2.02, 0.76)
    text = " ".join(repr(float(v)) for v in rows.ravel())
    omega = np.array([1.37])
    waves = WaveField(omega, omega**2 / G, np.full(1, np.pi / 2), np.full(1, 0.3), np.zeros(1))
    force = _sway(compile_spec(_hull(text), Environment(waves=waves)), np.zeros(1))[0]
    R = float(plate_reflection(omega[0] ** 2 / G, 0.76))
    expected = 0.5 * RHO * G * 0.09 * R**2 * 7.2
    law = "1/2 rho g a^2 R^2 L; tolerance: linear between rows 0.03 rad/s apart"
    yield row("drift of a reflecting hull", force, expected, "N", law, percent=0.5)


def box() -> Iterator[Row]:
    """Mean drift of the USV's box: symmetry and short waves."""
    spec = mujoco.MjSpec.from_file(str(find_model("dus_v5750")))
    body = read_coefficients(spec)[0]
    omega = np.array([2 * np.pi])
    head, beam = (
        mean_drift(body, Environment(waves=WaveField(omega, omega**2 / G, b, b**0, 0 * b)), 0.0)
        for b in (np.zeros(1), np.full(1, np.pi / 2))
    )
    wall = "1/2 rho g L of a wall; tolerance: finite length"
    across = {"head seas, sway": head[1] / head[0], "beam seas, surge": beam[0] / beam[1]}
    for name, ratio in across.items():
        yield row(f"box, {name} drift", ratio[0], 0, "1", "symmetry", within=1e-6)
    push = 0.5 * RHO * G
    yield row("box, head seas of 1 s, drift", head[0, 0] / (push * 1.5), 1, "1", wall, within=0.15)
    yield row("box, beam seas of 1 s, drift", beam[1, 0] / (push * 5), 1, "1", wall, within=0.15)


CASES = (groups, spectrum, reflection, box)
