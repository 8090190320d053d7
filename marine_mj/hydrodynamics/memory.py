"""Radiation memory: a passive state-space model of frequency-dependent added mass and damping."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.hydrodynamics.vector_fitting import (
    Complex,
    between_minima,
    passivity_grid,
    passivity_weight,
)

Index = NDArray[np.intp]

#: Largest error of a fit that is accepted.
ALLOWED_ERROR = 0.05
DOFS = ("surge", "sway", "heave", "roll", "pitch", "yaw")


@dataclass(frozen=True)
class PairFit:
    """How well the model fits one entry of the radiation matrices.

    Attributes:
        i, j: degrees of freedom, 0 surge to 5 yaw; the entry (j, i) is the same.
        order: order of the transfer function K_ij(s).
        r2_damping: coefficient of determination of B_ij(omega).
        r2_added_mass: the same of A_ij(omega).
        error: norm of K_fit - K over the frequencies / sqrt(norm of K_ii norm of K_jj).
    """

    i: int
    j: int
    order: int
    r2_damping: float
    r2_added_mass: float
    error: float

    @property
    def name(self) -> str:
        """Names of the two degrees of freedom."""
        return DOFS[self.i] if self.i == self.j else f"{DOFS[self.i]}-{DOFS[self.j]}"


@dataclass(frozen=True)
class Memory:
    """Radiation force `-A(inf) nu_dot - mu` with `mu(t) = int K(t - tau) nu(tau) dtau`.

    Cummins (1962), Fossen (2021), sec. 5.4. In modal form, one complex state per pole and degree
    of freedom that drives it (two real states):

        z_pj' = lambda_p z_pj + nu_j,    mu_i = sum_pj Re(r_p,ij z_pj).

    Attributes:
        infinite_added_mass: A(inf) (6, 6), kg, kg m, kg m2.
        poles: lambda (n,), rad/s, Re < 0 < Im.
        residues: r (n, 6, 6), symmetric; poles of other groups of degrees of freedom have zeros.
    """

    infinite_added_mass: Array
    poles: Complex
    residues: Complex

    @cached_property
    def groups(self) -> tuple[tuple[Index, Index], ...]:
        """(degrees of freedom, poles) as indices, of each group that shares its poles."""
        found: dict[tuple[int, ...], list[int]] = {}
        for p, residue in enumerate(self.residues):
            found.setdefault(tuple(np.flatnonzero(residue.any(axis=0)).tolist()), []).append(p)
        return tuple((np.array(dofs, dtype=int), np.array(p)) for dofs, p in found.items())

    @property
    def states(self) -> int:
        """Number of real states."""
        return 2 * sum(len(dofs) * len(poles) for dofs, poles in self.groups)

    def scaled(self, factor: float) -> "Memory":
        """The memory of water of another density: A(inf) and residues times `factor`."""
        if factor == 1.0:
            return self
        return Memory(factor * self.infinite_added_mass, self.poles, factor * self.residues)

    def retardation(self, omega: Array) -> Complex:
        """K(i omega) = B + i omega (A - A(inf)), (k, 6, 6), N s/m ... N m s, omega (k,) in rad/s.

        Phasors exp(+i omega t); Ogilvie's relations (Fossen 2021, eq. 5.103).
        """
        s = 1j * np.asarray(omega, dtype=float)[:, None]
        above, below = 0.5 / (s - self.poles), 0.5 / (s - self.poles.conj())
        return np.tensordot(above, self.residues, 1) + np.tensordot(below, self.residues.conj(), 1)

    def impulse_response(self, t: Array) -> Array:
        """K(t) (k, 6, 6), N/m ... N m, at times t (k,) >= 0 in s."""
        t = np.asarray(t, dtype=float)
        return np.tensordot(np.exp(t[:, None] * self.poles), self.residues, 1).real

    def state_space(self) -> tuple[Array, Array, Array]:
        """A (n, n), B (n, 6), C (6, n) of `x' = A x + B nu, mu = C x`.

        The states are those of the simulation: by group, by driving degree of freedom, Re z of all
        poles, then Im z.
        """
        B, C = np.zeros((self.states, 6)), np.zeros((6, self.states))
        for dof, poles, re, im in self._banks():
            B[re, dof] = 1.0
            C[:, re] = self.residues[poles, :, dof].real.T
            C[:, im] = -self.residues[poles, :, dof].imag.T
        return self._diagonal(self.poles), B, C

    def discrete(self, step: float) -> tuple[Array, Array]:
        """Phi (n, n), Gamma (n, 6) of `x(t + step) = Phi x + Gamma nu` with nu held, step in s."""
        growth = np.exp(self.poles * step)
        return self._diagonal(growth), self._diagonal(
            (growth - 1) / self.poles
        ) @ self.state_space()[1]

    def _banks(self) -> Iterator[tuple[int, Index, Index, Index]]:
        """Driving degree of freedom, its poles, the places of their Re z and Im z in the state."""
        place = 0
        for dofs, poles in self.groups:
            for dof in dofs:
                re = place + np.arange(len(poles))
                yield int(dof), poles, re, re + len(poles)
                place += 2 * len(poles)

    def _diagonal(self, values: Complex) -> Array:
        """Real form (states, states) of `z -> values z`, values by pole."""
        matrix = np.zeros((self.states, self.states))
        for _, poles, re, im in self._banks():
            real, imag = values[poles].real, values[poles].imag
            matrix[re, re], matrix[re, im], matrix[im, re], matrix[im, im] = real, -imag, imag, real
        return matrix

    def check(self) -> None:
        """Raise unless the model is stable and cannot give net energy.

        Raises:
            ModelError: a pole has Re >= 0, or Re K(i omega) has a negative eigenvalue on the grid
                of the fit (`vector_fitting.passivity_grid`): from 1/1000 to 1000 times the poles.
        """
        if len(self.poles) == 0:
            return
        unstable = self.poles[~(self.poles.real < 0)]
        if len(unstable):
            raise ModelError(
                f"a pole of the radiation memory is {unstable[0]:.4g} rad/s, allowed are negative "
                "real parts: fit the memory again (marine_mj.hydrodynamics.fit_memory)"
            )
        for dofs, poles in self.groups:
            self._check_passive(dofs, poles)

    def _check_passive(self, dofs: Index, poles: Index) -> None:
        """Raise unless a group of degrees of freedom is passive, on the grid of its fit."""
        own = self.poles[poles]
        omega = passivity_grid(own)
        K = self.retardation(omega).real[:, dofs[:, None], dofs]
        scale = np.sqrt(np.abs(K).max(axis=0).diagonal())
        scale = np.maximum(scale, 1e-6 * max(scale.max(), 1e-300))

        def eigenvalues(w: Array) -> Array:
            real = self.retardation(w).real[:, dofs[:, None], dofs] / np.outer(scale, scale)
            values = np.linalg.eigvalsh(passivity_weight(w, own)[:, None, None] * real)
            return np.asarray(values[:, 0], dtype=float)

        lowest = eigenvalues(omega)
        more = between_minima(omega, lowest)
        omega, lowest = np.append(omega, more), np.append(lowest, eigenvalues(more))
        worst = int(lowest.argmin())
        if lowest[worst] < -1e-6:
            raise ModelError(
                f"the radiation memory in {', '.join(DOFS[d] for d in dofs)} is not passive: the "
                f"smallest eigenvalue of the scaled Re K is {lowest[worst]:.3g} at "
                f"{omega[worst]:.4g} rad/s, allowed is >= 0; make it with "
                "marine_mj.hydrodynamics.fit_memory, which gives passive ones only"
            )

    def fits(self, omega: Array, added_mass: Array, damping: Array) -> tuple[PairFit, ...]:
        """Report of every coupled pair (i <= j) against data: omega (n,), A and B (n, 6, 6)."""
        A, B = symmetric(added_mass), symmetric(damping)
        w = np.asarray(omega, dtype=float)[:, None, None]
        wanted = B + 1j * w * (A - self.infinite_added_mass)
        got = self.retardation(np.asarray(omega))
        norm = np.sqrt(np.linalg.norm(wanted, axis=0).diagonal())
        found = []
        for dofs, poles in self.groups:
            for i, j in ((i, j) for i in dofs for j in dofs if i <= j):
                K = got[:, i, j]
                fitted = self.infinite_added_mass[i, j] + K.imag / w[:, 0, 0]
                error = np.linalg.norm(K - wanted[:, i, j]) / (norm[i] * norm[j])
                r2 = _r2(B[:, i, j], K.real), _r2(A[:, i, j], fitted)
                found.append(PairFit(int(i), int(j), 2 * len(poles), *r2, float(error)))
        return tuple(found)

    def check_fit(
        self, omega: Array, added_mass: Array, damping: Array, allowed: float = ALLOWED_ERROR
    ) -> tuple[PairFit, ...]:
        """The report of `fits`, after a check of every error.

        Raises:
            ModelError: the error of a pair is above `allowed`; names it and its error.
        """
        report = self.fits(omega, added_mass, damping)
        for pair in report:
            if not pair.error <= allowed:
                raise ModelError(
                    f"the radiation memory in {pair.name} has the error {pair.error:.3g} at order "
                    f"{pair.order}, allowed is {allowed:g}: give the wave database more "
                    "frequencies (also higher ones), check its infinite_added_mass, allow a "
                    "higher order in marine_mj.hydrodynamics.fit_memory, or simulate with "
                    "radiation 'constant'"
                )
        return report


def symmetric(matrix: Array) -> Array:
    """Symmetric part of matrices (..., 6, 6)."""
    matrix = np.asarray(matrix, dtype=float)
    return 0.5 * (matrix + np.swapaxes(matrix, -1, -2))


def _r2(data: Array, fit: Array) -> float:
    """Coefficient of determination."""
    spread = ((data - data.mean()) ** 2).sum()
    return float(1 - ((data - fit) ** 2).sum() / max(spread, 1e-300))
