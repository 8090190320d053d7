"""Periodic functions of the wave direction, sampled at a few directions: exact between them.

A wave load as a function of the direction chi is a sum of harmonics `c_m exp(i m chi)`. On a hull
whose points lie within R of the origin, waves of wavenumber k excite harmonics up to about k R and
hardly any beyond: `exp(i k r cos a) = sum i^m J_m(k r) exp(i m a)` (Abramowitz & Stegun 1964, eq.
9.1.41, 9.1.44-47). Equally spaced directions, two for each harmonic, hence hold the whole function,
where a straight line between them loses most of a long hull's load.
"""

from dataclasses import fields

import numpy as np
from numpy.typing import NDArray

from marine_mj.frames import Array
from marine_mj.hydrodynamics.wave_file import Circle

Complex = NDArray[np.complex128]

#: Numbers of equally spaced headings that `lagrange_count` chooses from.
HEADING_COUNTS = (24, 36, 48, 72, 96, 144, 192, 288, 384, 576, 720)
#: Steps of the direction that are advised, deg.
STEPS = (45, 30, 22.5, 15, 11.25, 10, 7.5, 5, 4.5, 3.75, 3, 2.5, 2, 1.5, 1, 0.5)
#: Fewest points around the circle on which interpolation is judged.
_FEWEST = 192
#: Harmonics below this share of the largest are dropped from splines: their tails never end.
_NOTHING = 1e-7


def orders(coefficients: NDArray) -> NDArray[np.intp]:
    """Orders m (-M ... M) of coefficients (n, 2 M + 1, entries)."""
    most = coefficients.shape[1] // 2
    return np.arange(-most, most + 1)


def harmonics(circle: Circle, table: NDArray) -> Complex:
    """Coefficients c (n, 2 M + 1, entries), orders -M ... M, of a table (n, directions, entries).

    Equally spaced directions: the trigonometric polynomial through them. Others: that of the
    periodic cubic spline through them, which needs about twice as many.
    """
    count, start = len(circle.angle), float(circle.angle[0])
    if not circle.even:
        count, start = max(512, 8 * count), 0.0
        table = _spline(circle, table, 2 * np.pi * np.arange(count) / count)
    spectrum = np.fft.fft(table, axis=1) / count
    most = count // 2
    m = np.arange(-most, most + 1)
    found = spectrum[:, m] * np.exp(-1j * m * start)[:, None]
    if count % 2 == 0:  # the highest one goes with cos(m (chi - start)): half to each side
        found[:, [0, -1]] *= 0.5
    if not circle.even:
        size = np.abs(found).max(axis=(0, 2))
        last = int(np.abs(m[size > _NOTHING * size.max()]).max(initial=0))
        found = found[:, most - last : most + last + 1]
    return np.asarray(found, dtype=complex)


def _spline(circle: Circle, table: NDArray, wanted: Array) -> NDArray:
    """Table (n, wanted, entries) at other directions, by a periodic cubic spline."""
    from scipy.interpolate import CubicSpline  # here: it takes a quarter of a second

    knots = np.append(circle.angle, circle.angle[0] + 2 * np.pi)
    around = np.concatenate([table, table[:, :1]], axis=1)
    spline = CubicSpline(knots, around, axis=1, bc_type="periodic")
    return np.asarray(spline(knots[0] + np.mod(wanted - knots[0], 2 * np.pi)))


def _around(coefficients: Complex) -> Complex:
    """Values (n, points, entries) at equally spaced points around the circle."""
    points = max(_FEWEST, 4 * coefficients.shape[1])
    spectrum = np.zeros((len(coefficients), points, coefficients.shape[2]), dtype=complex)
    spectrum[:, orders(coefficients)] = coefficients
    return np.asarray(np.fft.ifft(spectrum, axis=1) * points, dtype=complex)


def largest(coefficients: Complex, together: bool = False) -> Array:
    """Largest absolute value (entries,) over all rows and directions; of all entries together."""
    found = np.maximum(np.abs(_around(coefficients)).max(axis=(0, 1)), 1e-300)
    return np.full_like(found, found.max()) if together else np.asarray(found)


def lagrange_error(coefficients: Complex, count: int, together: bool = False) -> float:
    """Largest error of cubic Lagrange interpolation between `count` equally spaced nodes.

    Through the four nodes around the place, in the worst place between and for nodes anywhere, as
    a share of the largest value of its entry (or of all, see `largest`).
    """
    m = orders(coefficients)
    step = 2 * np.pi / count
    at, t = np.array([-1.0, 0.0, 1.0, 2.0]), 0.5  # the error is largest in the middle
    weight = np.array([np.prod([(t - b) / (a - b) for b in at if b != a]) for a in at])
    wrong = np.exp(1j * np.outer(m, at) * step) @ weight - np.exp(1j * m * t * step)
    error = np.abs(_around(coefficients * wrong[:, None])).max(axis=(0, 1))
    return float((error / largest(coefficients, together)).max())


def lagrange_count(coefficients: Complex, allowed: float, together: bool = False) -> int:
    """Smallest of HEADING_COUNTS whose `lagrange_error` is allowed; the largest if none is."""
    for count in HEADING_COUNTS[:-1]:
        if lagrange_error(coefficients, count, together) <= allowed:
            return count
    return HEADING_COUNTS[-1]


def unresolved(circle: Circle, table: NDArray, together: bool = False) -> Array:
    """Estimated error (n,) between the directions, as a share of the largest value (`largest`).

    Of equally spaced directions: what the sampling cuts off is at most about as large as the
    highest harmonics that it holds, those of the last three orders (every kind of symmetry has one
    of them). Of others: the error of a cubic spline falls with the fourth power of the spacing, so
    it is a sixteenth of what a spline through every second direction makes at those between.
    """
    found = harmonics(circle, table)
    if circle.even:
        limit = len(circle.angle) // 2
        m = np.abs(orders(found))
        size = 2 * np.abs(found[:, (m > limit - 3) & (m <= limit)]).max(axis=1)
    else:
        size = np.maximum(*(_left_out(circle, table, first) for first in (0, 1))) / 16
    return np.asarray((size / largest(found, together)).max(axis=1))


def _left_out(circle: Circle, table: NDArray, first: int) -> Array:
    """Error (n, entries) at every second direction of the spline through the others."""
    drop = np.zeros(len(circle.angle), dtype=bool)
    drop[first::2] = True
    rest = Circle(*(getattr(circle, f.name)[~drop] for f in fields(Circle)))
    wrong = _spline(rest, table[:, ~drop], circle.angle[drop]) - table[:, drop]
    return np.asarray(np.abs(wrong).max(axis=1))


def highest_harmonic(k: float, radius: float) -> float:
    """Order above which a load on a hull within `radius` [m] in waves of k [rad/m] is below 1 %.

    In the transition `J_m(x)` falls like the Airy function of `(m - x) (2 / x)^(1/3)` (Abramowitz
    & Stegun 1964, eq. 9.3.23), which is below 0.01 at 3.
    """
    x = k * radius
    return float(x + 3 * np.cbrt(0.5 * x))


def round_step(step: float) -> float:
    """Largest of STEPS [deg] not above `step`, the smallest if there is none."""
    return float(next((s for s in STEPS if s <= step + 1e-9), STEPS[-1]))
