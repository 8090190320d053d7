"""Wave cases: dispersion, kinematics, spectra, statistics, phases."""

from collections.abc import Iterator

import numpy as np

from marine_mj.environment import (
    SEA_STATES,
    docking_jonswap,
    irregular_sea,
    regular_wave,
    sea_state,
    wavenumber,
)
from marine_mj.validation.rows import Row, row

G = 9.81
THEORY = "linear wave theory"
DIGEST = "docking study"


def dispersion() -> Iterator[Row]:
    """Dispersion relation, deep and finite depth."""
    omega = np.linspace(0.05, 12, 400)
    for depth in (np.inf, 30.0, 2.0):
        k = np.asarray(wavenumber(omega, depth))
        tanh = 1.0 if np.isinf(depth) else np.tanh(k * depth)
        error = np.abs(G * k * tanh / omega**2 - 1).max()
        yield row(f"dispersion, depth {depth:g} m", error, 0, "1", THEORY, within=1e-10)


def kinematics() -> Iterator[Row]:
    """Velocity, acceleration and pressure from the potential; published values."""
    sea = irregular_sea(1.5, 6.0, components=50, depth=25.0, seed=1, stretching="none")
    rng = np.random.default_rng(1)
    worst = np.zeros(3)
    for _ in range(50):
        point = rng.uniform([-50, -50, -20, 0], [50, 50, -1, 100])
        step = 1e-3

        def slope(f, axis, point=point, step=step):
            """Fourth-order difference of f along one of x, y, z, t."""
            d = np.zeros(4)
            d[axis] = step
            near = f(*(point + d)) - f(*(point - d))
            far = f(*(point + 2 * d)) - f(*(point - 2 * d))
            return (8 * near - far) / (12 * step)

        gradient = [slope(sea.potential, axis) for axis in range(3)]
        change = slope(sea.velocity, 3)
        pressure = -1025 * slope(sea.potential, 3)
        worst = np.maximum(
            worst,
            [
                np.abs(sea.velocity(*point) - gradient).max(),
                np.abs(sea.acceleration(*point) - change).max(),
                abs(sea.pressure(*point) - pressure),
            ],
        )
    yield row("velocity = gradient of potential", worst[0], 0, "m/s", THEORY, within=1e-9)
    yield row("acceleration = dv/dt", worst[1], 0, "m/s2", THEORY, within=1e-9)
    yield row("pressure = -rho dphi/dt", worst[2], 0, "Pa", THEORY, within=1e-5)
    wave = regular_wave(2.0, 8.0)
    table = "published table, a 1 m, T 8 s"
    surface, deep = wave.velocity(0, 0, 0, 0)[0], wave.velocity(0, 0, -10, 0)[0]
    yield row("speed at the surface", surface, 0.78540, "m/s", table, within=1e-5)
    yield row("speed at 10 m", deep, 0.41880, "m/s", table, within=1e-5)
    fall = -wave.acceleration(0, 0, -10, 0)[2]
    yield row("acceleration at 10 m", fall, 0.32892, "m/s2", table, within=1e-5)
    yield row("pressure at 10 m", wave.pressure(0, 0, -10, 0), 5361.79, "Pa", table, within=0.01)


def docking_waves() -> Iterator[Row]:
    """Docking study V1-V6, V8, V21."""
    k = float(wavenumber(2 * np.pi / 4.6))
    yield row("V1 wave length at T 4.6 s", 2 * np.pi / k, 33.04, "m", DIGEST, percent=0.1)
    yield row("V1 least depth for deep water", np.pi / k, 16.5, "m", DIGEST, percent=0.2)
    lengths = [19.13, 22.55, 27.54, 33.04, 40.61, 50.73, 70.09, 97.44, 120.9, 140.9, 156.1, 172.1]
    slopes = [4.71, 5.19, 5.23, 5.99, 7.31, 8.87, 9.25, 8.96, 9.08, 9.52, 10.03, 10.72]
    for state, length, slope in zip(SEA_STATES[1:], lengths, slopes, strict=True):
        k = float(wavenumber(2 * np.pi / state.mean_period))
        name = f"sea state {state.ss_bft}"
        yield row(f"V2 wave length, {name}", 2 * np.pi / k, length, "m", DIGEST, percent=0.5)
        angle = np.degrees(0.5 * k * state.H_s)
        yield row(f"V21 wave slope, {name}", angle, slope, "deg", DIGEST, percent=0.2)
    speed = regular_wave(1.1, np.sqrt(2 * np.pi * 33.0 / G)).velocity(0, 0, 0, 0)[0]
    yield row("V3 particle speed, H 1.1 m", speed, 0.752, "m/s", DIGEST, percent=0.5)
    spectra = [docking_jonswap(s.H_s, s.T_p) for s in SEA_STATES[1:]]
    pairs = list(zip(spectra, SEA_STATES[1:], strict=True))
    heights = max((p.significant_height / s.H_s for p, s in pairs), key=lambda v: abs(v - 1))
    periods = max((p.mean_period / s.mean_period for p, s in pairs), key=lambda v: abs(v - 1))
    yield row("V4 4 sqrt(m0) / H_s, worst", heights, 1, "1", DIGEST, percent=0.3)
    yield row("V4 2 pi m0 / (m1 T_1), worst", periods, 1, "1", DIGEST, percent=0.3)
    low, high = spectra[0], spectra[-1]
    for T, share in ((1.0, 0.264), (2.5, 9.56)):
        measured = 100 * low.moment(0, 2 * np.pi / T) / low.moment(0)
        yield row(f"V5 energy below T {T:g} s, SS1", measured, share, "%", DIGEST, percent=2)
    share = 100 * high.moment(0, 0.0, 2 * np.pi / 30) / high.moment(0)
    yield row("V5 energy above T 30 s, SS12", share, 0, "%", DIGEST, within=1e-4)
    for number, ratio in ((1, 1.000), (4, 1.004), (8, 1.002), (12, 1.069)):
        state = sea_state(number)
        sea = irregular_sea(state.H_s, state.T_p, spectrum="docking_jonswap", sampling="midpoint")
        measured = sea.significant_height / state.H_s
        yield row(f"V6 H_s of 50 bins, SS{number}", measured, ratio, "1", DIGEST, percent=0.3)
    wave = regular_wave(1.1, 4.6)
    omega, k = float(wave.omega[0]), float(wave.wavenumber[0])
    t = np.arange(64) * 4.6 / 64
    radius = np.linalg.norm(wave.velocity(0, 0, -3, t), axis=-1) / omega
    worst = radius[np.abs(radius / (0.55 * np.exp(-3 * k)) - 1).argmax()]
    yield row("V8 orbit radius at 3 m", worst, 0.55 * np.exp(-3 * k), "m", THEORY, percent=1e-4)


def height_statistics() -> Iterator[Row]:
    """Docking study V7: 4 sqrt(m0) of 100 simulated records against H_s."""
    t = np.arange(0, 900.0, 0.5)
    heights = [
        4 * irregular_sea(2.0, 8.0, seed=seed).elevation(0, 0, t).std() for seed in range(100)
    ]
    interval = 1.96 * np.std(heights, ddof=1) / 10
    source = "theory; tolerance: 95 % interval of the mean of 100 seeds"
    yield row("V7 4 sqrt(m0), H_s 2 m", np.mean(heights), 2.0, "m", source, within=interval)


def phases() -> Iterator[Row]:
    """Docking study V33: relative motion of two water particles of one field."""
    wave = regular_wave(1.1, 4.6)
    omega = float(wave.omega[0])
    t = np.arange(400) * 4.6 / 400

    def apart(a: tuple[float, float, float], b: tuple[float, float, float]) -> float:
        """Amplitude of the relative displacement along the larger axis."""
        relative = (wave.velocity(*a, t) - wave.velocity(*b, t)) / omega
        return float(np.abs(relative).max())

    cases = (
        ("V33 1 m above 2 m depth", (0, 0, -1), (0, 0, -2), 0.0788),
        ("V33 1 m apart at 1 m depth", (0, 0, -1), (1, 0, -1), 0.0864),
        ("V33 5 m apart at 1 m depth", (0, 0, -1), (5, 0, -1), 0.416),
    )
    for name, a, b, expected in cases:
        yield row(name, apart(a, b), expected, "m", DIGEST, percent=0.5)


CASES = (dispersion, kinematics, docking_waves, height_statistics, phases)
