"""Bins of an irregular sea: where its components stand, and how much energy each has."""

import numpy as np

from marine_mj.environment.spectra import Spectrum
from marine_mj.frames import Array

#: Widest bin of `energy_bins` up to FINE omega_p, in omega_p: a hull of few metres resonates there
#: with a damping of some per cent. Beyond, the width grows as omega^2, as the wavenumber does.
WIDEST, FINE = 0.15, 3.0
#: Default range of `energy_bins`, in omega_p. What is missing above changes T_z by 0.5 % (JONSWAP)
#: to 0.6 % (Pierson-Moskowitz); above 5 omega_p it would be 2.0 to 2.5 %.
ENERGY_RANGE = (0.5, 10.0)
#: Most of the components that the limit of the width may take from those of equal energy.
_MOST = 0.5
#: Points of the grid for each component, and at least.
_POINTS, _LEAST = 20, 2000


def energy_bins(
    source: Spectrum, low: float, high: float, jitter: Array
) -> tuple[Array, Array, Array]:
    """Frequencies, variances and edges of bins that are narrow where the energy is.

    The number of bins below omega is `G = F + (N - F_high) E`: E, the share of the energy below
    omega, makes bins of equal energy; F, the integral of one over the limit of the width, keeps
    them narrow everywhere. With N equal shares of the variance the kurtosis of the elevation is
    3 - 1.5 / N (fixed amplitudes, random phases); here about N - F_high bins count.

    Args:
        source: spectrum.
        low, high: range, rad/s.
        jitter: (N,) place of the frequency in each bin, 0 to 1.

    Returns:
        (N,) frequencies, rad/s; (N,) variances of the bins, m2; (N + 1,) edges, rad/s.
    """
    count = len(jitter)
    grid = np.linspace(low, high, _LEAST + _POINTS * count)
    peak = 2 * np.pi / source.T_p
    narrow = 1 / (WIDEST * np.maximum(peak, grid**2 / (FINE**2 * peak)))
    width, energy = _integral(grid, narrow), _integral(grid, source(grid))
    width *= min(1.0, _MOST * count / width[-1])
    rest = count - width[-1]
    # without energy in the range only the width counts
    bins = width + rest * energy / energy[-1] if energy[-1] > 0 else width * count / width[-1]
    edges = np.interp(np.arange(count + 1.0), bins, grid)
    edges[0], edges[-1] = low, high
    omega = np.interp(np.arange(count) + jitter, bins, grid)
    return omega, source.bin_moments(edges), edges


def equal_bins(
    source: Spectrum, low: float, high: float, jitter: Array
) -> tuple[Array, Array, Array]:
    """The same for bins of equal width."""
    count = len(jitter)
    edges = np.linspace(low, high, count + 1)
    width = (high - low) / count
    return edges[:-1] + width * jitter, source.bin_moments(edges), edges


def _integral(grid: Array, values: Array) -> Array:
    """Integral of values over the grid from its start, by trapezoids."""
    parts = 0.5 * (values[1:] + values[:-1]) * np.diff(grid)
    return np.concatenate([[0.0], np.cumsum(parts)])
