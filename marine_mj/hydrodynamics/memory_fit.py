"""Identification of the radiation memory from frequency-domain data."""

from collections.abc import Iterator

import numpy as np

from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.hydrodynamics.memory import ALLOWED_ERROR, DOFS, Memory, symmetric
from marine_mj.hydrodynamics.vector_fitting import Complex, Residues, fit_poles

#: The number of poles rises until the error is below this.
TARGET_ERROR = 0.01
#: Largest number of pole pairs per group of coupled degrees of freedom.
MOST_POLES = 8
#: Poles farther above the highest frequency stand for a wrong A(inf), not for memory.
FARTHEST_POLE = 4.0
#: Couplings below this share of the diagonal entries are panel noise: left out.
NEGLIGIBLE = 1e-3


def _check_data(omega: Array, A: Array, B: Array, infinite: Array) -> None:
    """Raise unless the data can be those of radiation at zero speed."""
    n = len(omega)
    if n < 8 or A.shape != (n, 6, 6) or B.shape != (n, 6, 6) or infinite.shape != (6, 6):
        raise ModelError(
            f"radiation data have the shapes omega {omega.shape}, added mass {A.shape}, damping "
            f"{B.shape}, A(inf) {infinite.shape}; allowed are (n,), (n, 6, 6), (n, 6, 6), (6, 6) "
            "with n >= 8 frequencies"
        )
    finite = all(np.isfinite(values).all() for values in (omega, A, B, infinite))
    if not (finite and omega[0] > 0 and (np.diff(omega) > 0).all()):
        raise ModelError(
            f"omega of the radiation data is {omega}; allowed are finite, positive, rising "
            "frequencies with finite A, B and A(inf): leave out omega = 0 and infinity"
        )
    for name, values in (("added mass", A), ("damping", B)):
        size = np.sqrt(np.abs(values).max(axis=0).diagonal())
        skew = np.abs(values - np.swapaxes(values, 1, 2)).max(axis=0)
        skew = skew / np.maximum(np.outer(size, size), 1e-300)
        i, j = np.unravel_index(skew.argmax(), skew.shape)
        if skew[i, j] > 0.05:
            raise ModelError(
                f"radiation {name} ({DOFS[i]}, {DOFS[j]}) and its mirror differ by "
                f"{skew[i, j]:.3g} of the diagonal, allowed is 0.05: zero speed and one origin for "
                "forces and motions are needed"
            )
    smallest = float(np.linalg.eigvalsh(symmetric(infinite))[0])
    if smallest < -1e-6 * np.abs(infinite).max():
        raise ModelError(
            f"A(inf) of the radiation data has the eigenvalue {smallest:.4g}, allowed is >= 0: it "
            "must be the added mass at infinite frequency about the same origin"
        )
    size = np.sqrt(np.abs(B).max(axis=0).diagonal())
    size = np.maximum(size, 1e-6 * max(size.max(), 1e-300))
    lowest = np.linalg.eigvalsh(symmetric(B / np.outer(size, size)))[:, 0]
    worst = int(lowest.argmin())
    if lowest[worst] < -0.02:
        raise ModelError(
            f"radiation damping at {omega[worst]:.4g} rad/s has the eigenvalue "
            f"{lowest[worst]:.3g} of its largest value, allowed is >= -0.02: it would feed energy "
            "into the body; check the mesh (irregular frequencies: add a lid) and the signs"
        )


def _coupled(K: Complex) -> Iterator[list[int]]:
    """Groups of degrees of freedom with more than negligible coupling."""
    size = np.sqrt(np.abs(K).max(axis=0).diagonal())
    moving = [i for i in range(6) if size[i] ** 2 > 1e-12 * (size**2).max() > 0]
    linked = np.abs(K).max(axis=0) > NEGLIGIBLE * np.outer(size, size)
    while moving:
        group, queue = [], [moving[0]]
        while queue:
            i = queue.pop()
            group.append(i)
            moving.remove(i)
            queue += [j for j in moving if linked[i, j] and j not in queue]
        yield sorted(group)


def fit_memory(
    omega: Array,
    added_mass: Array,
    damping: Array,
    infinite_added_mass: Array,
    *,
    target: float = TARGET_ERROR,
    allowed: float = ALLOWED_ERROR,
    most_poles: int = MOST_POLES,
) -> Memory:
    """Radiation memory that fits frequency-domain data, stable and passive. Deterministic.

    K(i omega) = B + i omega (A - A(inf)) is approximated by rational functions of relative degree
    1 with a zero at omega = 0 (Perez & Fossen 2009, "A Matlab toolbox for parametric
    identification of radiation-force models", sec. 3) that hold the high-frequency tail
    B ~ omega^-2. Degrees of freedom that are coupled share their poles, which vector fitting finds;
    the residues follow from least squares with passivity as a condition, at every frequency up to
    1000 times the band. The order rises until the error of every pair is below `target`.

    Args:
        omega: (n,) rising, rad/s, without 0 and infinity.
        added_mass: A (n, 6, 6), about the body origin, any one frame.
        damping: B (n, 6, 6).
        infinite_added_mass: A(inf) (6, 6).
        target: error (see `PairFit`) at which the order does not rise any more.
        allowed: largest error of the best fit.
        most_poles: largest number of pole pairs per group of coupled degrees of freedom.

    Raises:
        ModelError: the data have other shapes, are not symmetric within 5 %, have damping with a
            negative eigenvalue beyond 2 % or a negative A(inf); or the fit of a pair is worse than
            `allowed`.
    """
    omega = np.asarray(omega, dtype=float)
    A, B = np.asarray(added_mass, dtype=float), np.asarray(damping, dtype=float)
    infinite = np.asarray(infinite_added_mass, dtype=float)
    _check_data(omega, A, B, infinite)
    infinite = symmetric(infinite)
    K = symmetric(B) + 1j * omega[:, None, None] * (symmetric(A) - infinite)
    all_poles, all_residues = [np.zeros(0, dtype=complex)], [np.zeros((0, 6, 6), dtype=complex)]
    for group in _coupled(K):
        upper = np.triu_indices(len(group))
        i, j = np.array(group)[upper[0]], np.array(group)[upper[1]]
        norm = np.sqrt(np.linalg.norm(K, axis=0).diagonal())
        scale = norm[i] * norm[j]
        H = K[:, i, j] / scale
        best: tuple[float, Complex, Complex] | None = None
        for count in range(2, min(most_poles, len(omega) // 3) + 1):
            poles = fit_poles(omega, H, count)
            if np.abs(poles).max() > FARTHEST_POLE * omega[-1]:
                continue
            values = Residues(omega, H, poles, len(group)).passive()
            if values is None:
                continue
            residues = np.zeros((count, 6, 6), dtype=complex)
            residues[:, i, j] = residues[:, j, i] = values * scale
            wrong = (Memory(infinite, poles, residues).retardation(omega) - K)[:, i, j] / scale
            error = float(np.linalg.norm(wrong, axis=0).max())
            if best is None or error < best[0]:
                best = error, poles, residues
            if error <= target:
                break
        if best is None:
            raise ModelError(
                f"no passive radiation memory was found in {', '.join(DOFS[d] for d in group)} "
                f"with 2 to {most_poles} poles: check infinite_added_mass, give the wave database "
                "more frequencies, or allow more poles"
            )
        all_poles.append(best[1])
        all_residues.append(best[2])
    memory = Memory(infinite, np.concatenate(all_poles), np.concatenate(all_residues))
    memory.check_fit(omega, A, B, allowed)
    memory.check()
    return memory
