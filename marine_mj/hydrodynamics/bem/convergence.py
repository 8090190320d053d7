"""How much the coefficients of a hull still depend on the panels."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from marine_mj.frames import Array
from marine_mj.hydrodynamics.bem.solver import solve
from marine_mj.hydrodynamics.bem.study import Hull


@dataclass(frozen=True)
class Convergence:
    """One coefficient at several panel sizes.

    Attributes:
        name: of the coefficient, as `A33(2.5)`: at 2.5 rad/s.
        sizes: (n,) mean panel sizes `sqrt(area / panels)`, m, coarse to fine.
        values: (n,) SI units.
        order: observed order p of `f(h) = f_0 + c h^p`; NaN where the values do not approach
            monotonically.
        limit: Richardson's f_0; the finest value where p is not known.
    """

    name: str
    sizes: Array
    values: Array
    order: float
    limit: float

    @property
    def uncertainty(self) -> float:
        """Distance of the finest value from the limit; the spread of all where p is not known."""
        if np.isfinite(self.order):
            return abs(float(self.values[-1] - self.limit))
        return float(np.ptp(self.values))


def richardson(sizes: Array, values: Array) -> tuple[float, float]:
    """Observed order and extrapolated value (p, f_0) of `f(h) = f_0 + c h^p`, last three sizes.

    (Roache 1998; unequal ratios.) The order is NaN with less than three values, or where they do
    not approach monotonically with an order from 0.3 to 6; the value is then the finest one.

    Args:
        sizes: (n,) descending, n >= 2.
        values: (n,).
    """
    h, f = np.asarray(sizes, dtype=float)[-3:], np.asarray(values, dtype=float)[-3:]
    order = float("nan")
    if len(h) == 3 and (f[0] - f[1]) * (f[1] - f[2]) > 0:
        ratio = (f[0] - f[1]) / (f[1] - f[2])

        def miss(p: float) -> float:
            return float((h[0] ** p - h[1] ** p) / (h[1] ** p - h[2] ** p) - ratio)

        if miss(0.3) * miss(6.0) < 0:
            order = float(brentq(miss, 0.3, 6.0))
    if not np.isfinite(order):
        return order, float(f[-1])
    share = h[-1] ** order / (h[-2] ** order - h[-1] ** order)
    return order, float(f[-1] + (f[-1] - f[-2]) * share)


def convergence(
    hull: Hull,
    sizes: Array | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> list[Convergence]:
    """Key coefficients of a hull at several panel sizes, coarse to fine.

    A at infinite frequency on the diagonal; with waves also A, B and the excitation in heave and
    the roll or pitch moment, at the frequency where waves are two hulls long.

    Args:
        hull: see `read_hull`.
        sizes: panel sizes, m; default 2, sqrt(2) and 1 times that of the settings.
        progress: called with (solved, all) meshes.

    Raises:
        ModelError: see `analyse`.
    """
    if sizes is None:
        sizes = hull.panel_size() * np.array([2.0, np.sqrt(2), 1.0])
    s = hull.settings
    length = max(hull.still.length, hull.still.breadth)
    omega = np.zeros(0) if hull.unbounded else np.array([np.sqrt(np.pi * s.gravity / length)])
    steps = np.sort(np.asarray(sizes, dtype=float))[::-1]
    actual, rows = [], []
    for done, size in enumerate(steps):
        if progress:
            progress(done, len(steps))
        panels, cover = hull.panels(float(size))
        result = solve(
            panels,
            cover,
            omega=omega,
            directions=np.array([0.25 * np.pi]),
            density=s.density,
            gravity=s.gravity,
            depth=s.depth,
            origin=hull.origin,
            unbounded=hull.unbounded,
            method=s.method,
        )
        actual.append(np.sqrt(hull.still.wetted_surface / len(panels)))
        found = {f"A{i + 1}{i + 1}(inf)": result.infinite[i, i] for i in range(6)}
        if len(omega):
            w = f"({omega[0]:.3g})"
            for i in range(2, 5):
                found[f"A{i + 1}{i + 1}{w}"] = result.added_mass[0, i, i]
                found[f"B{i + 1}{i + 1}{w}"] = result.damping[0, i, i]
            force = np.abs(result.froude_krylov + result.diffraction)[0, 0]
            found |= {f"|F{i + 1}|{w}": force[i] for i in range(2, 5)}
        rows.append(found)
    if progress:
        progress(len(steps), len(steps))
    h = np.array(actual)
    out = []
    for name in rows[0]:
        values = np.array([row[name] for row in rows])
        out.append(Convergence(name, h, values, *richardson(h, values)))
    return out
