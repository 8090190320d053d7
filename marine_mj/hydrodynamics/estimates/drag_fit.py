"""Drag coefficients from measured speeds and forces (docking study, 4.4.5)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from marine_mj.errors import ModelError
from marine_mj.frames import Array


@dataclass(frozen=True)
class DragFit:
    """A law `F = linear v + quadratic |v| v` fitted to points.

    Attributes:
        linear: N s/m (N m s).
        quadratic: N s2/m2 (N m s2).
        rms: root mean square of what is left, N (N m).
    """

    linear: float
    quadratic: float
    rms: float

    def force(self, speed: ArrayLike) -> Array:
        """Force, N (N m), at speeds, m/s (rad/s)."""
        v = np.asarray(speed, dtype=float)
        return self.linear * v + self.quadratic * np.abs(v) * v


def fit_drag(speed: ArrayLike, force: ArrayLike) -> dict[str, DragFit]:
    """Least-squares fits: `linear` a v, `quadratic` b |v| v, `both` c v + d |v| v.

    Args:
        speed: (n,) steady speeds, m/s or rad/s, of either sign.
        force: (n,) forces or moments that keep them, N or N m.

    Raises:
        ModelError: other shapes, a value is not finite, or the speeds do not tell both terms apart.
    """
    v, F = np.asarray(speed, dtype=float), np.asarray(force, dtype=float)
    if v.ndim != 1 or v.shape != F.shape or not np.all(np.isfinite([v, F])):
        raise ModelError(
            f"speed {v.shape} and force {F.shape} must be two rows of finite numbers of the same "
            "length"
        )
    sizes = len({*np.abs(v[v != 0]).round(12)})
    if sizes < 2:
        raise ModelError(
            f"{sizes} different speeds besides 0 do not tell linear from quadratic drag: measure "
            "two or more"
        )
    found = {}
    for name, terms in (("linear", [0]), ("quadratic", [1]), ("both", [0, 1])):
        columns = np.stack([v, np.abs(v) * v], axis=1)
        solution = np.zeros(2)
        solution[terms] = np.linalg.lstsq(columns[:, terms], F, rcond=None)[0]
        rest = F - columns @ solution
        a, b = solution.tolist()
        found[name] = DragFit(a, b, float(np.sqrt(np.mean(rest**2))))
    return found
