"""Identification of the radiation memory from frequency-domain data."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

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
#: Fewest frequencies that are fitted.
FEWEST = 8
#: Jump of an entry between its neighbours, of its largest value, that looks irregular (ours: A and
#: B of a hull are smooth on the scale of a tenth of the band).
JUMP = 0.04
#: Couplings below this share of the diagonal entries are panel noise: left out.
NEGLIGIBLE = 1e-3


def irregular_frequencies(omega: Array, added_mass: Array, damping: Array) -> Array:
    """Frequencies (k,) [rad/s] at which radiation data look spoilt by irregular frequencies.

    The boundary integral equation of a hull without a lid has spurious eigenvalues above a certain
    frequency (John 1950; Lee & Sclavounos 1989, J. Fluid Mech. 207): near them A and B jump, and B
    may be negative. Here: an entry of the diagonal that leaves the cubic through its neighbours by
    more than `JUMP` of its largest value, or a damping below -2 % of its largest value. Narrow
    physical resonances (moonpools) look alike.

    Args:
        omega: (n,) rising, rad/s.
        added_mass, damping: (n, 6, 6).
    """
    found = np.zeros(len(omega), dtype=bool)
    for values in (damping, added_mass):
        for dof in range(6):
            entry = values[:, dof, dof]
            if np.abs(entry).max() > 1e-9 * np.abs(values).max():
                found |= _jumps(omega, entry)
                if values is damping:
                    found |= entry < -0.02 * np.abs(entry).max()
    return np.asarray(omega[found])


def _jumps(omega: Array, values: Array) -> NDArray[np.bool_]:
    """Which values (n,) leave the curve of the others; the worst first, which then counts no more.

    The curve is the cubic through the two nearest of the others on each side.
    """
    kept = list(range(len(omega)))
    out = np.zeros(len(omega), dtype=bool)
    while len(kept) > 8:
        x, y = omega[kept], values[kept]
        off = np.zeros(len(kept))
        for i in range(2, len(kept) - 2):
            near = [i - 2, i - 1, i + 1, i + 2]
            weights = [
                np.prod([(x[i] - x[b]) / (x[a] - x[b]) for b in near if b != a]) for a in near
            ]
            off[i] = abs(y[i] - np.dot(weights, y[near]))
        worst = int(off.argmax())
        if off[worst] <= JUMP * np.abs(values).max():
            break
        out[kept.pop(worst)] = True
    return out


def _irregular_hint(omega: Array, A: Array, B: Array) -> str:
    """Advice that names irregular frequencies, empty where none are seen."""
    found = irregular_frequencies(omega, A, B)
    if not len(found):
        return ""
    listed = ", ".join(f"{w:.3g}" for w in found[:6]) + (", ..." if len(found) > 6 else "")
    below = omega[omega < found[0]][:-1]
    band = ""
    if len(below) >= FEWEST:
        band = (
            f", or fit below them: band=({omega[0]:.4g}, {below[-1]:.4g}) (marine-mj hydro "
            "--memory-band, python -m marine_mj.hydrodynamics.fit_database --band)"
        )
    return (
        f". The data jump at {listed} rad/s, as irregular frequencies (or noise) make them: "
        f"compute them with a lid in the waterplane{band}"
    )


def _check_data(omega: Array, A: Array, B: Array, infinite: Array, symmetrise: bool) -> None:
    """Raise unless the data can be those of radiation at zero speed."""
    n = len(omega)
    if n < FEWEST or A.shape != (n, 6, 6) or B.shape != (n, 6, 6) or infinite.shape != (6, 6):
        raise ModelError(
            f"radiation data have the shapes omega {omega.shape}, added mass {A.shape}, damping "
            f"{B.shape}, A(inf) {infinite.shape}; allowed are (n,), (n, 6, 6), (n, 6, 6), (6, 6) "
            f"with n >= {FEWEST} frequencies"
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
        if skew[i, j] > 0.05 and not symmetrise:
            raise ModelError(
                f"radiation {name} ({DOFS[i]}, {DOFS[j]}) and its mirror differ by "
                f"{skew[i, j]:.3g} of the diagonal, allowed is 0.05: zero speed and one origin for "
                "forces and motions are needed; if it is noise of the panels, fit the mean of both "
                "by symmetrise=True (python -m marine_mj.hydrodynamics.fit_database --symmetrise)"
                + _irregular_hint(omega, A, B)
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
            + _irregular_hint(omega, A, B)
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
    band: tuple[float, float] | None = None,
    symmetrise: bool = False,
) -> Memory:
    """Radiation memory that fits frequency-domain data, stable and passive. Deterministic.

    K(i omega) = B + i omega (A - A(inf)) is approximated by rational functions of relative degree
    1 with a zero at omega = 0 (Perez & Fossen 2009, "A Matlab toolbox for parametric
    identification of radiation-force models", sec. 3) that hold the high-frequency tail
    B ~ omega^-2. Degrees of freedom that are coupled share their poles, which vector fitting finds;
    the residues follow from least squares with passivity as a condition, from 1/1000 to 1000 times
    the poles, on the grid on which `Memory.check` looks. The order rises until the error of every
    pair is below `target`.

    Args:
        omega: (n,) rising, rad/s, without 0 and infinity.
        added_mass: A (n, 6, 6), about the body origin, any one frame.
        damping: B (n, 6, 6).
        infinite_added_mass: A(inf) (6, 6).
        target: error (see `PairFit`) at which the order does not rise any more.
        allowed: largest error of the best fit.
        most_poles: largest number of pole pairs per group of coupled degrees of freedom.
        band: (lowest, highest) frequency that is fitted, rad/s; None: all of them. For data that
            are spoilt above some frequency.
        symmetrise: fit the symmetric part of A, B and A(inf) however much they differ from it.

    Raises:
        ModelError: the data have other shapes, are not symmetric within 5 %, have damping with a
            negative eigenvalue beyond 2 % or a negative A(inf); or the fit of a pair is worse than
            `allowed`. The message names frequencies that look irregular.
    """
    omega = np.asarray(omega, dtype=float)
    A, B = np.asarray(added_mass, dtype=float), np.asarray(damping, dtype=float)
    infinite = np.asarray(infinite_added_mass, dtype=float)
    if band is not None:
        inside = (omega >= band[0] * (1 - 1e-9)) & (omega <= band[1] * (1 + 1e-9))
        omega, A, B = omega[inside], A[inside], B[inside]
    _check_data(omega, A, B, infinite, symmetrise)
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
                "more frequencies, or allow more poles" + _irregular_hint(omega, A, B)
            )
        all_poles.append(best[1])
        all_residues.append(best[2])
    memory = Memory(infinite, np.concatenate(all_poles), np.concatenate(all_residues))
    try:
        memory.check_fit(omega, A, B, allowed)
    except ModelError as error:
        raise ModelError(f"{error}{_irregular_hint(omega, A, B)}") from None
    memory.check()
    return memory
