"""How many Chebyshev nodes the wave pressure around a hull needs in a given sea."""

import numpy as np
from scipy.special import ive, jv

from marine_mj.environment import WaveField
from marine_mj.frames import Array
from marine_mj.hydrodynamics import table as t_

#: Bound of the root-mean-square error of elevation and pressure head, as a share of that of the
#: elevation. Measured are at most 0.1 % of the significant height anywhere on a hull of 5 to 10 m
#: in sea states 2 to 6, and 0.02 % of the force.
TOLERANCE = 2e-2
#: Cost of summing at one vertex, and of each component there (sine, cosine, exponential), in units
#: of one multiplication of the expansion (measured: 30 ns, 3 ns, 0.1 ns).
_VERTEX, _COMPONENT = 300.0, 30.0
_ORDERS = np.arange(t_.MAX_NODES + 60)


def _nodes(tails: Array, amplitude: Array, lost: float) -> int:
    """Fewest nodes with a weighted truncation error of at most `lost`; 0 if none are enough.

    tails (order, N): largest sum of all Chebyshev terms from that order on, per component.
    """
    for n in range(2, t_.MAX_NODES + 1):
        # aliasing doubles the truncation error at most
        if 2 * np.sqrt(np.sum((amplitude * tails[n]) ** 2)) <= lost:
            return n
    return 0


def node_counts(waves: WaveField, extent: Array, vertices: int) -> tuple[int, int, int, int]:
    """Nodes along, across and downwards, and the number of components that they serve.

    Short waves need many nodes and have little energy: up to `MAX_SHORT` of them are summed at
    every vertex, as many as is cheapest. Zeros where summing all of them there is cheaper still.

    The Chebyshev coefficients of `cos(kappa t + c)` are at most `2 J_m(kappa)`, those of
    `exp(-kappa (1 + t))` are `2 exp(-kappa) I_m(kappa)` (Jacobi-Anger); the sum of those left out
    bounds the error of each component, and components of random phase add up in the mean square.
    It holds at every heading, roll and pitch: the hull's diagonals bound its extents.

    Args:
        waves: wave field with at least one component.
        extent: lengths (3,) of the hull along its axes x, y, z, m.
        vertices: number of vertices.
    """
    diagonal, section = np.linalg.norm(extent), np.linalg.norm(extent[1:])
    lost = TOLERANCE / 3 * np.sqrt(np.sum(waves.amplitude**2))
    tails = []
    for length, bessel, factor in ((diagonal, jv, 2.0), (section, jv, 2.0), (diagonal, ive, 2.0)):
        kappa = 0.5 * waves.wavenumber * length
        terms = factor * np.abs(bessel(_ORDERS[:, None], kappa))
        # orders beyond the last are far beyond kappa and vanish, where a count is found
        tails.append(np.cumsum(terms[::-1], axis=0)[::-1])
    components = len(waves.omega)
    best = vertices * (_VERTEX + _COMPONENT * components), (0, 0, 0, 0)
    rising = bool((np.diff(waves.wavenumber) >= 0).all())
    shortest = max(1, components - t_.MAX_SHORT) if rising else components
    for long in range(shortest, components + 1):
        n_x, n_y, n_s = (_nodes(tail[:, :long], waves.amplitude[:long], lost) for tail in tails)
        if 0 in (n_x, n_y, n_s):
            break
        grid = n_x * n_y * (n_s + 4) * (long + vertices)
        cost = grid + vertices * _COMPONENT * (components - long)
        if cost < best[0]:
            best = cost, (n_x, n_y, n_s, long)
    return best[1]


def _gauss(n: int) -> tuple[Array, Array]:
    """Chebyshev nodes of the first kind, and the matrix from values to coefficients."""
    angle = np.pi * (np.arange(n) + 0.5) / n
    matrix = 2 / n * np.cos(np.outer(np.arange(n), angle))
    matrix[0] *= 0.5
    return np.cos(angle), matrix


def _lobatto(n: int) -> tuple[Array, Array]:
    """Chebyshev nodes with both ends, the lower first: -1 is the surface or the highest point."""
    angle = np.pi * np.arange(n)[::-1] / (n - 1)
    matrix = 2 / (n - 1) * np.cos(np.outer(np.arange(n), angle))
    matrix[:, [0, -1]] *= 0.5
    matrix[[0, -1]] *= 0.5
    return np.cos(angle), matrix


def expansion(waves: WaveField, extent: Array, vertices: int) -> Array:
    """Counts, nodes and transforms as they stand in the parameters of the panels, from P_COUNTS.

    Args as `node_counts`; without components all zeros.
    """
    block = np.zeros(t_.P_SIZE)
    *counts, long = node_counts(waves, extent, vertices) if len(waves.omega) else (0, 0, 0, 0)
    block[t_.P_LONG] = long
    for axis, (n, rule) in enumerate(zip(counts, (_gauss, _gauss, _lobatto), strict=True)):
        if n == 0:
            continue
        nodes, matrix = rule(n)
        block[t_.P_COUNTS + axis] = n
        start = t_.P_NODES + axis * t_.MAX_NODES
        block[start : start + n] = nodes
        start = t_.P_TRANSFORMS + axis * t_.MAX_NODES**2
        block[start : start + n * n] = matrix.ravel()
    return block[t_.P_COUNTS :]
