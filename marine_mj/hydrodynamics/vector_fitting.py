"""Rational approximation of radiation forces: vector fitting of poles, passive residues.

A group of coupled degrees of freedom shares its poles. `H` are its distinct entries (i <= j), each
divided by a scale that makes them comparable, as functions of s = i omega:

    H_k(s) = sum_p 1/2 (r_pk / (s - lambda_p) + r_pk* / (s - lambda_p*)),  H_k(0) = 0.
"""

import numpy as np
from numpy.typing import NDArray

from marine_mj.frames import Array

Complex = NDArray[np.complex128]

#: Rounds of pole relocation; it has converged to 3 digits after about ten.
RELOCATIONS = 30
#: Rounds of adding the frequencies at which the last residues were not passive.
CUTS = 40
#: Smallest eigenvalue that the cuts ask for, of the scaled Re K (1 is its usual size).
MARGIN = 1e-5
#: Below this one Re K is looked at more closely between the frequencies of the grid.
NEAR = 0.02


def passivity_grid(poles: Complex) -> Array:
    """Frequencies [rad/s] at which passivity is asked for.

    From 1/1000 to 1000 times the poles, and densely around each of them: a lightly damped pole is
    narrower than any even grid. `between_minima` adds to it where Re K comes near zero. Beyond the
    last pole Re K falls with omega^-2, below the first one with omega^2; `passivity_weight` undoes
    that, so that the ends count as the middle. Fit and check use the same frequencies and weights,
    so that what the one makes the other allows.
    """
    sizes = np.abs(poles)
    low, high = float(sizes.min()), float(sizes.max())
    around = np.abs(poles.imag)[:, None] + np.abs(poles.real)[:, None] * np.linspace(-5, 5, 101)
    omega: Array = np.concatenate(
        [
            np.geomspace(1e-3 * low, 0.03 * low, 150, endpoint=False),
            np.geomspace(0.03 * low, 30 * high, 2000),
            np.geomspace(30 * high, 1e3 * high, 151)[1:],
            around[around > 1e-3 * low],
        ]
    )
    return np.unique(omega)


def passivity_weight(omega: Array, poles: Complex) -> Array:
    """Weights (n,) of Re K at `omega`: see `passivity_grid`."""
    sizes = np.abs(poles)
    center = float(np.sqrt(sizes.min() * sizes.max()))
    weight: Array = (omega / center) ** 2 + (center / omega) ** 2
    return weight


def between_minima(grid: Array, lowest: Array) -> Array:
    """More frequencies around the places of the grid where the smallest eigenvalue may dip below.

    Args:
        grid: from `passivity_grid`.
        lowest: smallest eigenvalue of the scaled and weighted Re K there.
    """
    low = (lowest[1:-1] <= lowest[:-2]) & (lowest[1:-1] <= lowest[2:]) & (lowest[1:-1] < NEAR)
    places = np.flatnonzero(low) + 1
    share = np.linspace(0.0, 1.0, 34)[1:-1]
    return np.sort(
        (grid[places - 1, None] + (grid[places + 1] - grid[places - 1])[:, None] * share).ravel()
    )


def basis(s: Complex, poles: Complex) -> Complex:
    """Values (n, 2 p) at s (n,) of the functions whose factors are Re r (p), then Im r (p)."""
    above, below = 0.5 / (s[:, None] - poles), 0.5 / (s[:, None] - poles.conj())
    return np.concatenate([above + below, 1j * (above - below)], axis=1)


def _stacked(values: Complex) -> Array:
    """Real parts above imaginary parts."""
    return np.concatenate([values.real, values.imag])


def _relocated(s: Complex, H: Complex, poles: Complex) -> Complex:
    """Poles after one round of vector fitting: the zeros of the common denominator."""
    n = 2 * len(poles)
    F = basis(s, poles)
    left, right = [], []
    for column in H.T:
        system = _stacked(np.concatenate([F, -column[:, None] * F, column[:, None]], axis=1))
        triangle = np.asarray(np.linalg.qr(system)[1])
        left.append(triangle[n : 2 * n, n : 2 * n])
        right.append(triangle[n : 2 * n, 2 * n])
    A = np.concatenate(left)
    scale = np.linalg.norm(A, axis=0)
    factors = np.linalg.lstsq(A / scale, np.concatenate(right), rcond=None)[0] / scale
    dynamics, drive = np.zeros((n, n)), np.zeros(n)
    for k, pole in enumerate(poles):
        place = slice(2 * k, 2 * k + 2)
        dynamics[place, place] = [[pole.real, -pole.imag], [pole.imag, pole.real]]
        drive[2 * k] = 1.0
    output = np.stack([factors[: n // 2], -factors[n // 2 :]], axis=1).ravel()
    zeros = np.linalg.eigvals(dynamics - np.outer(drive, output))
    zeros = -np.abs(zeros.real) + 1j * zeros.imag  # unstable ones mirrored
    real = np.abs(zeros.imag) < 1e-9 * np.abs(zeros)
    alone = np.sort(zeros[real].real)
    # two real poles become a pair of strongly damped ones at the same distance from zero
    pairs = -0.5 * (alone[::2] + alone[1::2]) * (-1 + 0.05j)
    found = np.concatenate([zeros[~real & (zeros.imag > 0)], pairs])
    return np.asarray(found[np.argsort(found.imag, kind="stable")], dtype=complex)


def fit_poles(omega: Array, H: Complex, count: int) -> Complex:
    """Common stable poles (count,), Im > 0, of the functions H (n, k) sampled at omega (n,) rad/s.

    Vector fitting (Gustavsen & Semlyen 1999, IEEE Trans. Power Delivery 14(3)).
    """
    start = np.linspace(omega[0] + 0.1 * omega[-1], 1.1 * omega[-1], count)
    poles = np.asarray((-0.3 + 1j) * start, dtype=complex)
    for _ in range(RELOCATIONS):
        poles = _relocated(np.asarray(1j * omega, dtype=complex), H, poles)
    return poles


class Residues:
    """Residues of given poles by least squares, with H(0) = 0 and a passive matrix.

    Passivity, `v^T Re K(i omega) v >= 0` for every v and omega, is a linear condition on the
    residues for every (omega, v): where the last solution breaks it, the condition joins the least
    squares problem (Lawson & Hanson 1974, ch. 23), until it holds on the whole grid.
    """

    def __init__(self, omega: Array, H: Complex, poles: Complex, size: int) -> None:
        """Unconstrained solution of functions H (n, size (size + 1) / 2), upper triangle by rows.

        Args:
            omega: rad/s.
            H: scaled samples.
            poles: from `fit_poles`.
            size: number of degrees of freedom in the group.
        """
        self.poles, self.size = poles, size
        self.pairs = np.triu_indices(size)
        at_zero = basis(np.zeros(1, dtype=complex), poles).real
        null: Array = np.linalg.svd(at_zero)[2][1:].T
        Q, triangle = np.linalg.qr(
            _stacked(basis(np.asarray(1j * omega, dtype=complex), poles) @ null)
        )
        self.map = null @ np.linalg.inv(triangle)  # residues (2 p, k) = map @ u
        self.u = Q.T @ _stacked(H)
        self.grid = passivity_grid(poles)
        self.real = self._rows(self.grid)

    def _rows(self, omega: Array) -> Array:
        """Weighted real parts (n, 2 p) of the basis at omega (n,), as factors of u."""
        s = np.asarray(1j * omega, dtype=complex)
        rows: Array = passivity_weight(omega, self.poles)[:, None] * (
            basis(s, self.poles).real @ self.map
        )
        return rows

    def _eigen(self, real: Array, u: Array) -> tuple[Array, Array]:
        """Smallest eigenvalues (n,) and their vectors (n, size) of the scaled Re K."""
        entries = real @ u
        matrix = np.zeros((len(entries), self.size, self.size))
        matrix[:, self.pairs[0], self.pairs[1]] = entries
        matrix[:, self.pairs[1], self.pairs[0]] = entries
        values, vectors = np.linalg.eigh(matrix)
        return values[:, 0], vectors[:, :, 0]

    def _broken(self, u: Array) -> list[tuple[Array, Array]]:
        """(row, vector) at the lowest negative eigenvalues of Re K; nothing if it is passive."""
        real = self.real
        lowest, vectors = self._eigen(real, u)
        if lowest.min() >= 0:
            real = self._rows(between_minima(self.grid, lowest))
            lowest, vectors = self._eigen(real, u)
        padded = np.concatenate([[np.inf], lowest, [np.inf]])
        worst = (lowest < 0) & (lowest <= padded[:-2]) & (lowest <= padded[2:])
        return [(real[place], vectors[place]) for place in np.flatnonzero(worst)]

    def passive(self) -> Complex | None:
        """Residues (p, k) of the nearest passive fit; None if the cuts did not end."""
        from scipy.optimize import nnls  # here: it costs 0.14 s, and stored fits do not need it

        double = np.where(self.pairs[0] == self.pairs[1], 1.0, 2.0)
        u: Array = self.u
        rows: list[Array] = []
        for _ in range(CUTS):
            broken = self._broken(u)
            if not broken:
                values = self.map @ u
                count = len(self.poles)
                return values[:count] + 1j * values[count:]
            for real, v in broken:
                products = double * v[self.pairs[0]] * v[self.pairs[1]]
                rows.append(np.outer(real, products).ravel())
            G = np.array(rows)
            h = MARGIN - G @ self.u.ravel()
            E = np.concatenate([G.T, h[None]])
            f = np.zeros(len(E))
            f[-1] = 1.0
            # columns of one size: the conditions at both ends are small ones
            length = np.linalg.norm(E, axis=0)
            r = E @ (nnls(E / length, f)[0] / length) - f
            if not r[-1] < -1e-14:
                return None
            u = self.u + (r[:-1] / -r[-1]).reshape(self.u.shape)
        return None
