"""Seas as realised wave fields: calm water, a regular wave, irregular and Gaussian seas."""

from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from marine_mj.environment import spectra
from marine_mj.environment._checks import Seed, array, generator, number, one_of
from marine_mj.environment.bins import ENERGY_RANGE, energy_bins, equal_bins
from marine_mj.environment.dispersion import wavenumber
from marine_mj.environment.spectra import Spectrum
from marine_mj.environment.waves import Stretching, WaveField
from marine_mj.errors import SeaError
from marine_mj.frames import Array

Sampling = Literal["equal_energy", "random_in_bin", "midpoint"]

#: Largest number of wave components of an irregular sea.
MAX_COMPONENTS = 500
#: Frequency range of the docking study, rad/s: periods from 30 s to 1 s.
DOCKING_RANGE = (2 * np.pi / 30, 2 * np.pi / 1)


def calm(depth: float = np.inf, gravity: float = 9.81) -> WaveField:
    """Still water: a wave field without components.

    Raises:
        SeaError: depth or gravity (m, m/s2) is not > 0.
    """
    none = np.empty(0)
    return WaveField(none, none, none, none, none, depth, gravity)


def regular_wave(
    height: float,
    period: float,
    direction: float = 0.0,
    *,
    phase: float = 0.0,
    depth: float = np.inf,
    gravity: float = 9.81,
    stretching: Stretching = "constant",
) -> WaveField:
    """One linear wave of crest-to-trough `height`.

    Args:
        height: H = 2 a, m, >= 0, below breaking: `H < 0.142 L tanh(k h)` (Miche 1944).
        period: T, s.
        direction: direction of travel, rad, NWU (counter-clockwise from north).
        phase: rad; 0 puts a crest on the origin at t = 0.
        depth: water depth, m; inf for deep water.
        gravity: g, m/s2.
        stretching: see `WaveField`.

    Raises:
        SeaError: an argument is out of range, or a wave this steep breaks.
    """
    height = number("height", height, "m", "give the crest-to-trough height", low=0)
    period = number("period", period, "s", "give the wave period", above=0)
    omega = 2 * np.pi / period
    k = float(wavenumber(omega, depth, gravity))
    _check_steepness("height", height, "period", period, k, depth)
    return WaveField(
        np.array([omega]),
        np.array([k]),
        np.array([direction]),
        np.array([0.5 * height]),
        np.array([phase]),
        depth,
        gravity,
        stretching,
    )


def irregular_sea(
    H_s: float | None = None,
    T_p: float | None = None,
    *,
    direction: float = 0.0,
    spectrum: str | Spectrum = "jonswap",
    gamma: float = 3.3,
    components: int | None = None,
    seed: Seed = 0,
    sampling: Sampling | None = None,
    frequency_range: tuple[float, float] | None = None,
    spreading: float | None = None,
    depth: float = np.inf,
    gravity: float = 9.81,
    stretching: Stretching = "constant",
) -> WaveField:
    """Random-phase realisation of a wave spectrum with deterministic amplitudes.

    The range is cut into bins, one component each, at a random frequency inside the bin and with
    the variance of the whole bin, `a^2 / 2 = integral of S`: the sea does not repeat. The bins of
    "equal_energy" are narrow where the energy is and nowhere wider than 0.15 omega_p up to
    3 omega_p (from 62 components on; see `bins.energy_bins`): with 100 of them crests and extremes
    are those of a Gaussian sea within 2 %. Those of "random_in_bin" are equally wide; near the peak
    they are so few that extremes are too low. "midpoint" is the grid of the docking study,
    `a = sqrt(2 S(omega_m) d_omega)` at the centres of equal bins; it repeats after
    `2 pi / d_omega` (51.7 s on its default grid).

    Frequencies, phases and directions are drawn in this order, so a short-crested sea has the
    frequencies and phases of the long-crested one with the same seed.

    Args:
        H_s: significant wave height, m, >= 0; 0 gives calm water.
        T_p: peak period, s; may be left out for "pierson_moskowitz" (fully developed sea).
        direction: mean direction of travel, rad, NWU (counter-clockwise from north).
        spectrum: one of `SPECTRA`, or a `Spectrum` (then leave `H_s` and `T_p` out).
        gamma: peak enhancement, used by "jonswap".
        components: number of components, 1 to 500; default 100 (50 for "midpoint").
        seed: integer >= 0, SeedSequence, or a Generator to draw from.
        sampling: "equal_energy", "random_in_bin" or "midpoint"; None: "equal_energy", for the
            spectrum "docking_jonswap" "random_in_bin".
        frequency_range: lowest and highest frequency, rad/s; the energy outside is lost. Default:
            0.5 to 10 times the peak frequency ("random_in_bin": to 5 times), or the whole table,
            scaled by less than 0.1 % to keep all of m0; for "midpoint" 2 pi / 30 s to 2 pi / 1 s,
            not scaled.
        spreading: exponent s of cos^{2s}, drawn once per component; None for long crests.
        depth: water depth, m; inf for deep water.
        gravity: g, m/s2.
        stretching: see `WaveField`.

    Raises:
        SeaError: an argument is out of range, or the sea is steeper than breaking.
    """
    source = _spectrum(spectrum, H_s, T_p, gamma, gravity)
    sampling = _sampling(sampling, source)
    count = _components(components, 50 if sampling == "midpoint" else 100)
    parts = _realise(
        source, direction, count, seed, sampling, frequency_range, spreading, depth, gravity
    )
    if parts is None:
        return calm(depth, gravity)
    omega, k, angle, variance, phase = parts
    return WaveField(omega, k, angle, np.sqrt(2 * variance), phase, depth, gravity, stretching)


def gaussian_sea(
    u: ArrayLike,
    H_s: float | None = None,
    T_p: float | None = None,
    *,
    direction: float = 0.0,
    spectrum: str | Spectrum = "jonswap",
    gamma: float = 3.3,
    seed: Seed = 0,
    sampling: Sampling | None = None,
    frequency_range: tuple[float, float] | None = None,
    spreading: float | None = None,
    depth: float = np.inf,
    gravity: float = 9.81,
    stretching: Stretching = "constant",
) -> WaveField:
    """Gaussian sea with the standard normals `u` as its randomness: N components from 2 N numbers.

    The phasor of component i at the origin is `a_i exp(j phase_i) = s_i (u_i + j u_{N+i})`, s_i^2
    the variance of its bin: amplitudes are Rayleigh distributed, phases uniform (Rice 1944; Tucker
    et al. 1984). With standard normal u every elevation is exactly normal with variance m0, for any
    N, which the fixed amplitudes of `irregular_sea` give for N -> inf only. The sea depends
    smoothly on u, so that rare events can be searched in the space of seas
    (`marine_mj.analysis.subset_simulation` with 2 N dimensions).

    Frequencies and directions do not belong to u: they are those of `irregular_sea` with the same
    `seed` and N components, and stay when u varies.

    Args:
        u: (2 N,) standard normals, N from 1 to 500.
        H_s: significant wave height of the spectrum, m, >= 0; 0 gives calm water. The m0 of a
            single sea scatters about that of the spectrum, with the cov sqrt(sum s_i^4) / m0.
        seed: of the frequencies and directions: integer >= 0, SeedSequence or Generator (a
            Generator gives other frequencies at each call).
        T_p, direction, spectrum, gamma, sampling, frequency_range, spreading, depth, gravity,
            stretching: as `irregular_sea`.

    Raises:
        SeaError: u has an odd length or a value that is not finite, an argument is out of range,
            or a sea of this height and period would break.
    """
    numbers = array("u", u, ("2 N",), "")
    if len(numbers) % 2:
        raise SeaError(
            f"u has {len(numbers)} values, allowed are even numbers: two for each component"
        )
    count = _components(len(numbers) // 2, 0)
    source = _spectrum(spectrum, H_s, T_p, gamma, gravity)
    sampling = _sampling(sampling, source)
    parts = _realise(
        source, direction, count, seed, sampling, frequency_range, spreading, depth, gravity
    )
    if parts is None:
        return calm(depth, gravity)
    omega, k, angle, variance, _ = parts
    phasor = np.sqrt(variance) * (numbers[:count] + 1j * numbers[count:])
    return WaveField(omega, k, angle, np.abs(phasor), np.angle(phasor), depth, gravity, stretching)


def _realise(
    source: Spectrum,
    direction: float,
    count: int,
    seed: Seed,
    sampling: Sampling,
    frequency_range: tuple[float, float] | None,
    spreading: float | None,
    depth: float,
    gravity: float,
) -> tuple[Array, Array, Array, Array, Array] | None:
    """omega, k, direction, variance and phase (N,) of the components, None for calm water."""
    direction = number("direction", direction, "rad", "give the direction of travel, NWU")
    if spreading is not None:
        number("spreading", spreading, "", "5 to 15 for wind sea, None for long crests", above=0)
    rng = generator(seed)
    low, high = _range(source, sampling, frequency_range)
    if source.H_s == 0:
        return None
    peak_k = float(wavenumber(2 * np.pi / source.T_p, depth, gravity))
    _check_steepness("H_s", source.H_s, "T_p", source.T_p, peak_k, depth)

    jitter = rng.uniform(size=count)
    if sampling == "midpoint":
        edges = np.linspace(low, high, count + 1)
        omega = 0.5 * (edges[1:] + edges[:-1])
        variance = source(omega) * ((high - low) / count)
    else:
        bins = energy_bins if sampling == "equal_energy" else equal_bins
        # keeps omega > 0 if low is 0
        omega, variance, _ = bins(source, low, high, np.maximum(jitter, 1e-9))
        if frequency_range is None:
            variance = variance * source.moment(0) / variance.sum()
    phase = rng.uniform(0.0, 2 * np.pi, size=count)
    angle: Array = np.full(count, direction)
    if spreading is not None:
        angle = angle + spectra.spreading_quantile(rng.uniform(size=count), spreading)
    return omega, wavenumber(omega, depth, gravity), angle, variance, phase


def _spectrum(
    spectrum: str | Spectrum, H_s: float | None, T_p: float | None, gamma: float, gravity: float
) -> Spectrum:
    """The spectrum object that the arguments of `irregular_sea` mean."""
    if isinstance(spectrum, Spectrum):
        if H_s is not None or T_p is not None:
            raise SeaError(
                f"H_s is {H_s}, T_p is {T_p} beside a {spectrum.name} spectrum, allowed is None: "
                "set them where the spectrum is made"
            )
        return spectrum
    name = one_of("spectrum", spectrum, spectra.SPECTRA)
    if H_s is None:
        raise SeaError("H_s is None, allowed is >= 0 m: give the significant wave height")
    if name == "pierson_moskowitz" and (T_p is not None or H_s != 0):
        return spectra.pierson_moskowitz(H_s, T_p, gravity)
    if T_p is None:
        if H_s != 0:
            raise SeaError(f"T_p is None, allowed is > 0 s: give the peak period of {name}")
        T_p = 1.0  # calm water has no period
    if name == "jonswap":
        return spectra.jonswap(H_s, T_p, gamma)
    if name == "docking_jonswap":
        return spectra.docking_jonswap(H_s, T_p)
    return spectra.bretschneider(H_s, T_p)


def _sampling(sampling: Sampling | None, source: Spectrum) -> Sampling:
    """The sampling that the argument means, checked."""
    if sampling is None:  # the docking study's spectrum keeps its own equal bins
        return "random_in_bin" if source.name == "docking_jonswap" else "equal_energy"
    one_of("sampling", sampling, get_args(Sampling))
    return sampling


def _components(components: int | None, default: int) -> int:
    """Number of components, checked."""
    if components is None:
        return default
    whole = isinstance(components, int | np.integer) and not isinstance(components, bool)
    if not whole or not 1 <= components <= MAX_COMPONENTS:
        raise SeaError(
            f"components is {components!r}, allowed are whole numbers from 1 to {MAX_COMPONENTS}: "
            "100 is enough for one hour"
        )
    return int(components)


def _range(
    source: Spectrum, sampling: str, frequency_range: tuple[float, float] | None
) -> tuple[float, float]:
    """Lowest and highest frequency of the components, rad/s."""
    if frequency_range is not None:
        low, high = (float(f) for f in frequency_range)
        if not (0 <= low < high < np.inf):
            raise SeaError(
                f"frequency_range is ({low:g}, {high:g}) rad/s, allowed is 0 <= low < high, "
                "finite: give the lowest frequency first"
            )
        return low, high
    if sampling == "midpoint":
        return DOCKING_RANGE
    if not source.tail:
        return float(source.panels[0]), float(source.panels[-1])
    peak = 2 * np.pi / source.T_p
    if sampling == "equal_energy":
        return ENERGY_RANGE[0] * peak, ENERGY_RANGE[1] * peak
    return 0.5 * peak, 5 * peak


def _check_steepness(
    name: str, height: float, period_name: str, period: float, k: float, depth: float
) -> None:
    """SeaError if a wave of this height and wavenumber would break (Miche 1944)."""
    limit = 0.142 * 2 * np.pi / k * float(np.tanh(k * depth))
    if height >= limit:
        raise SeaError(
            f"{name} is {height:g} m at {period_name} {period:g} s, allowed is < {limit:.3g} m "
            f"(wave length {2 * np.pi / k:.3g} m, it would break): lower it or take a longer period"
        )
