"""Wave spectra S(omega), scaled numerically to the significant height, and wave spreading."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.polynomial.legendre import leggauss
from numpy.typing import ArrayLike
from scipy.special import betaincinv
from scipy.special import gamma as gamma_function

from marine_mj.environment._checks import array, number
from marine_mj.errors import SeaError
from marine_mj.frames import Array

_NODES, _WEIGHTS = leggauss(12)
#: omega / omega_p between which the analytic spectra are integrated panel by panel; 1 is an edge
#: because the width sigma of JONSWAP jumps there.
_PANELS = np.concatenate([np.linspace(0.2, 2.0, 73), np.geomspace(2.0, 40.0, 40)[1:]])


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Variance density S(omega) of the surface elevation, one-sided, in m2 s.

    Attributes:
        name: kind of spectrum, for messages.
        H_s: significant height it was made for, m. `4 sqrt(moment(0))` equals it, except for
            `docking_jonswap`.
        T_p: peak period, s.
        density: S, function of omega (rad/s, array) in m2 s.
        panels: (p,) frequencies, rad/s, between which S is smooth.
        tail: whether S goes on above the last panel as omega^-5.
    """

    name: str
    H_s: float
    T_p: float
    density: Callable[[Array], Array]
    panels: Array
    tail: bool = True

    def __call__(self, omega: ArrayLike) -> Array:
        """S(omega) [m2 s], 0 for omega <= 0; omega any shape, rad/s."""
        return self.density(np.asarray(omega, dtype=float))

    def bin_moments(self, edges: ArrayLike, order: int = 0) -> Array:
        """Integrals (b,) of `omega^order S` over the bins between `edges` (b + 1,), rad/s.

        Gauss-Legendre over the panels of the spectrum cut at the edges; the last edge may be inf.

        Raises:
            SeaError: the moment does not exist (order >= 4 up to inf).
        """
        edges = np.asarray(edges, dtype=float)
        finite = np.minimum(edges, max(self.panels[-1], *edges[np.isfinite(edges)]))
        cuts = np.unique(np.concatenate([self.panels, finite]))
        half = 0.5 * np.diff(cuts)[:, None]
        omega = 0.5 * (cuts[1:] + cuts[:-1])[:, None] + half * _NODES
        parts = (half * _WEIGHTS * omega**order * self(omega)).sum(axis=1)
        cumulative = np.concatenate([[0.0], np.cumsum(parts)])
        result = np.diff(cumulative[np.searchsorted(cuts, finite)])
        if np.isinf(edges[-1]) and self.tail:
            if order >= 4:
                raise SeaError(
                    f"moment {order} of a {self.name} spectrum is infinite (S falls as omega^-5), "
                    "allowed are orders <= 3: give a highest frequency"
                )
            # omega = 1/u turns the tail into a smooth integral over 0 < u < 1/last.
            half_u = 0.5 / finite[-1]
            u = half_u * (1 + _NODES)
            result[-1] += (half_u * _WEIGHTS * u ** (-order - 2) * self(1 / u)).sum()
        return result

    def moment(self, order: int, low: float = 0.0, high: float = np.inf) -> float:
        """Spectral moment `m_n = integral of omega^n S` from `low` to `high` (rad/s).

        Raises:
            SeaError: as `bin_moments`.
        """
        return float(self.bin_moments([low, high], order)[0])

    @property
    def significant_height(self) -> float:
        """`4 sqrt(m0)` [m]."""
        return 4 * np.sqrt(self.moment(0))

    @property
    def mean_period(self) -> float:
        """`T_1 = 2 pi m0 / m1` [s]."""
        return 2 * np.pi * self.moment(0) / self.moment(1)

    @property
    def zero_crossing_period(self) -> float:
        """`T_z = 2 pi sqrt(m0 / m2)` [s]."""
        return 2 * np.pi * np.sqrt(self.moment(0) / self.moment(2))


def jonswap(H_s: float, T_p: float, gamma: float = 3.3) -> Spectrum:
    """JONSWAP spectrum (Hasselmann 1973; DNV-RP-C205 3.5.5), scaled so that `4 sqrt(m0) = H_s`.

    `S ~ x^-5 exp(-5/4 x^-4) gamma^A`, `A = exp(-(x - 1)^2 / (2 sigma^2))`, x = omega / omega_p,
    sigma = 0.07 below the peak and 0.09 above. The scale is integrated numerically: the usual
    `1 - 0.287 ln(gamma)` is up to 0.9 % off.

    Args:
        H_s: significant wave height, m, >= 0.
        T_p: peak period, s, > 0.
        gamma: peak enhancement, 1 (Pierson-Moskowitz) to 7 (DNV); allowed 1 to 20.

    Raises:
        SeaError: an argument is out of range.
    """
    gamma = number("gamma", gamma, "", "3.3 is the JONSWAP mean", low=1, high=20)
    return _scaled("jonswap", H_s, T_p, partial(_jonswap_shape, gamma=gamma))


def pierson_moskowitz(H_s: float, T_p: float | None = None, gravity: float = 9.81) -> Spectrum:
    """Pierson-Moskowitz spectrum (1964), scaled so that `4 sqrt(m0) = H_s`.

    `S ~ x^-5 exp(-5/4 x^-4)`. Without `T_p` the sea is fully developed: Phillips' constant
    0.0081 gives `omega_p = (16 * 0.0081 g^2 / (5 H_s^2))^(1/4) = 0.401 sqrt(g / H_s)`.

    Args:
        H_s: significant wave height, m, >= 0 (> 0 without `T_p`).
        T_p: peak period, s, > 0, or None.
        gravity: g, m/s2.

    Raises:
        SeaError: an argument is out of range.
    """
    if T_p is None:
        fix = "a fully developed sea needs it for its peak period"
        number("H_s", H_s, "m", fix, above=0)
        T_p = 2 * np.pi / (16 * 0.0081 * gravity**2 / (5 * H_s**2)) ** 0.25
    return _scaled("pierson_moskowitz", H_s, T_p, _pierson_moskowitz_shape)


def bretschneider(H_s: float, T_p: float) -> Spectrum:
    """Bretschneider (1959) = ITTC (1978) two-parameter spectrum, `4 sqrt(m0) = H_s`.

    `S = (5/16) H_s^2 omega_p^4 omega^-5 exp(-(5/4) (omega_p/omega)^4)`; in the ITTC form with the
    mean period, T_p = T_1 / 0.7718 (`T_1` = 2 pi m0 / m1).

    Args:
        H_s: significant wave height, m, >= 0.
        T_p: peak period, s, > 0.

    Raises:
        SeaError: an argument is out of range.
    """
    return _scaled("bretschneider", H_s, T_p, _pierson_moskowitz_shape)


def docking_jonswap(H_s: float, T_p: float) -> Spectrum:
    """JONSWAP with the literal constants of the docking study, not scaled numerically.

    `S = 320 H_s^2 / (T_p^4 omega^5) exp(-1950 / (T_p omega)^4) 3.3^A` with A as in `jonswap`:
    the source prints A without dividing by omega_p, which misses H_s by -6 to +13 %; divided, as
    here, `4 sqrt(m0) = 1.0005 H_s`.

    Args:
        H_s: significant wave height, m, >= 0.
        T_p: peak period, s, > 0; the source takes 1.199 T_1.

    Raises:
        SeaError: an argument is out of range.
    """
    H_s, T_p = _height_and_period(H_s, T_p)
    density = partial(_docking_density, H_s=H_s, T_p=T_p)
    return Spectrum("docking_jonswap", H_s, T_p, density, _PANELS * 2 * np.pi / T_p)


def tabulated(omega: ArrayLike, density: ArrayLike, H_s: float | None = None) -> Spectrum:
    """Spectrum from a table: linear between its frequencies, 0 outside.

    Args:
        omega: (n,) ascending frequencies, rad/s, >= 0, n >= 2.
        density: (n,) S, m2 s, >= 0.
        H_s: scale the table so that `4 sqrt(m0)` is this height, m; None keeps its own.

    Raises:
        SeaError: the arrays do not fit, frequencies do not ascend, or S is negative or all 0.
    """
    omega = array("omega", omega, ("n",), "rad/s")
    S = array("density", density, (len(omega),), "m2 s")
    if len(omega) < 2 or omega[0] < 0 or (np.diff(omega) <= 0).any():
        raise SeaError(
            f"omega has {len(omega)} values from {omega[:1]} rad/s, allowed are 2 or more, >= 0, "
            "strictly ascending: sort the table and remove duplicates"
        )
    if (S < 0).any() or not S.any():
        raise SeaError(
            f"density has minimum {S.min():g} and maximum {S.max():g} m2 s, allowed are values "
            ">= 0 that are not all 0: correct the table"
        )
    T_p = 2 * np.pi / max(omega[np.argmax(S)], 1e-12)
    raw = Spectrum("table", np.nan, T_p, partial(_table_density, nodes=omega, S=S), omega, False)
    if H_s is None:
        return Spectrum("table", raw.significant_height, T_p, raw.density, omega, False)
    H_s = number("H_s", H_s, "m", "give 4 sqrt(m0), or None to keep the table", low=0)
    S = S * (H_s / raw.significant_height) ** 2
    return Spectrum("table", H_s, T_p, partial(_table_density, nodes=omega, S=S), omega, False)


def period_ratios(gamma: float) -> tuple[float, float]:
    """(T_1 / T_p, T_z / T_p) of JONSWAP with peak enhancement `gamma`, 1 to 7.

    Polynomial fits of DNV-RP-C205 (3.5.5.4-5); within 0.3 % of the integrals.

    Raises:
        SeaError: `gamma` is out of the range of the fits.
    """
    number("gamma", gamma, "", "use Spectrum.mean_period beyond the fits", low=1, high=7)
    mean = 0.7303 + 0.04936 * gamma - 0.006556 * gamma**2 + 0.0003610 * gamma**3
    zero = 0.6673 + 0.05037 * gamma - 0.006230 * gamma**2 + 0.0003341 * gamma**3
    return mean, zero


def spreading_density(angle: ArrayLike, s: float) -> Array:
    """Directional density `D = C cos^{2s}(angle)` [1/rad] within +-pi/2 of the mean, 0 outside.

    `C = Gamma(s + 1) / (sqrt(pi) Gamma(s + 1/2))` makes it integrate to 1.

    Args:
        angle: direction minus mean direction, any shape, rad.
        s: exponent, > 0; wind sea 5 to 15.

    Raises:
        SeaError: `s` is not > 0.
    """
    s = number("spreading", s, "", "use 5 to 15 for wind sea, None for long crests", above=0)
    angle = (np.asarray(angle, dtype=float) + np.pi) % (2 * np.pi) - np.pi
    scale = gamma_function(s + 1) / (np.sqrt(np.pi) * gamma_function(s + 0.5))
    return np.where(np.abs(angle) < np.pi / 2, scale * np.abs(np.cos(angle)) ** (2 * s), 0.0)


def spreading_quantile(probability: ArrayLike, s: float) -> Array:
    """Angle [rad] from the mean direction below which waves lie with `probability` (0 to 1).

    Inverse of the integral of `spreading_density`: `sin^2(angle)` has a Beta(1/2, s + 1/2) law.

    Raises:
        SeaError: `s` is not > 0.
    """
    s = number("spreading", s, "", "use 5 to 15 for wind sea, None for long crests", above=0)
    signed = 2 * np.asarray(probability, dtype=float) - 1
    return np.sign(signed) * np.arcsin(np.sqrt(betaincinv(0.5, s + 0.5, np.abs(signed))))


def _height_and_period(H_s: float, T_p: float) -> tuple[float, float]:
    """The two parameters, checked."""
    return (
        number("H_s", H_s, "m", "give 4 sqrt(m0) in metres", low=0, high=1000),
        number("T_p", T_p, "s", "give the peak period", above=0),
    )


def _scaled(name: str, H_s: float, T_p: float, shape: Callable[[Array], Array]) -> Spectrum:
    """Spectrum of a dimensionless shape in omega / omega_p, scaled to H_s."""
    H_s, T_p = _height_and_period(H_s, T_p)
    area = Spectrum(name, 1.0, 2 * np.pi, shape, _PANELS).moment(0)
    omega_p = 2 * np.pi / T_p
    scale = H_s**2 / (16 * area * omega_p)
    density = partial(_shape_density, shape=shape, scale=scale, omega_p=omega_p)
    return Spectrum(name, H_s, T_p, density, _PANELS * omega_p)


def _shape_density(
    omega: Array, shape: Callable[[Array], Array], scale: float, omega_p: float
) -> Array:
    """S from its dimensionless shape."""
    return scale * shape(omega / omega_p)


def _pierson_moskowitz_shape(x: Array) -> Array:
    """`x^-5 exp(-5/4 x^-4)`, 0 where it underflows anyway (x < 0.1)."""
    safe = np.maximum(x, 0.1)
    return np.where(x < 0.1, 0.0, safe**-5 * np.exp(-1.25 * safe**-4))


def _peak_exponent(x: Array) -> Array:
    """Exponent A of gamma."""
    sigma = np.where(x < 1, 0.07, 0.09)
    return np.exp(-0.5 * ((x - 1) / sigma) ** 2)


def _jonswap_shape(x: Array, gamma: float) -> Array:
    """Pierson-Moskowitz shape with the peak enhanced."""
    return _pierson_moskowitz_shape(x) * gamma ** _peak_exponent(x)


def _docking_density(omega: Array, H_s: float, T_p: float) -> Array:
    """Printed JONSWAP of the docking study, 0 where it underflows."""
    x = omega * T_p / (2 * np.pi)
    safe = np.maximum(x, 0.1) * 2 * np.pi / T_p
    S = 320 * H_s**2 / (T_p**4 * safe**5) * np.exp(-1950 / (T_p * safe) ** 4)
    return np.where(x < 0.1, 0.0, S * 3.3 ** _peak_exponent(x))


def _table_density(omega: Array, nodes: Array, S: Array) -> Array:
    """Linear interpolation in the table, 0 outside."""
    return np.interp(omega, nodes, S, left=0.0, right=0.0)


#: Spectra that a scenario can name; each takes (H_s, T_p).
SPECTRA = ("jonswap", "pierson_moskowitz", "bretschneider", "docking_jonswap")
