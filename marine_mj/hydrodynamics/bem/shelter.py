"""Shelter databases: how a floating hull disturbs the water motion around and below it."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.hydrodynamics.bem.solver import Solution, capytaine
from marine_mj.hydrodynamics.raos import DOFS
from marine_mj.hydrodynamics.table import MAX_SHELTER_MODES

if TYPE_CHECKING:
    import xarray as xr

#: Modes are added until they leave out less than this share of the field (rms), most of it at the
#: edges of the hull. Below the USV box, from 0.5 m depth on, 0.005 of the surface speed at 3 s,
#: 0.011 at 2 s and 0.035 at 1.5 s.
RESIDUE = 0.08
#: Weight of a frequency in it: amplitudes of a wind sea fall like omega^-2.5 (spectrum omega^-5).
TAIL = -2.5
# Nodes of the grid, ours, chosen at the USV box and in breadths of the hull, the length over which
# a disturbance dies: between its ends, beyond its ends and sides, below its keel; across the hull
# in half breadths. On the outermost ones the field is zero.
_ALONG, _AHEAD, _BESIDE = 1 / 3, (1 / 3, 2 / 3, 7 / 6), (1 / 3, 5 / 6)
_ACROSS = (-1, -8 / 15, 0, 8 / 15, 1)
_BELOW = (1 / 15, 1 / 6, 0.3, 7 / 15, 11 / 15, 17 / 15, 1.8, 2.8)


def shelter_grid(
    low: Array, high: Array, panel: float, depth: float = np.inf
) -> tuple[Array, Array, Array]:
    """x, y and z [m] of the nodes of a shelter database, ascending, denser near the hull.

    Args:
        low, high: (3,) extent of the wetted hull, z = 0 is the still water surface, m.
        panel: size of the panels, m: the field is not resolved nearer to them.
        depth: of the water, m.
    """
    breadth = float(high[1] - low[1])
    steps = int(np.ceil((high[0] - low[0]) / breadth / _ALONG - 1e-9))
    along = np.linspace(low[0], high[0], steps + 1)
    across = 0.5 * (low[1] + high[1]) + 0.5 * breadth * np.array(_ACROSS)
    ahead, beside, below = (breadth * np.array(step) for step in (_AHEAD, _BESIDE, _BELOW))
    z = low[2] - np.unique(np.maximum(below, panel))[::-1]
    return (
        np.r_[low[0] - ahead[::-1], along, high[0] + ahead],
        np.r_[low[1] - beside[::-1], across, high[1] + beside],
        z[z > -depth],
    )


def disturbance(
    solution: Solution, motions: NDArray[np.complex128], points: Array
) -> NDArray[np.complex128]:
    """Velocity (n, m, p, 3) [m/s per m] that a hull adds to undisturbed waves at fixed points.

    The gradient of the potentials of diffraction and of the hull's motion, with phasors
    `v(t) = Re(V exp(-i omega t))` for the elevation `Re(exp(i (k s - omega t)))` of the waves at
    the hull's origin: what the sources on the hull (and lid) induce,
    `V = grad(phi_D + sum_j X_j phi_j)`.

    Args:
        solution: of one body, by `solve` with `method="indirect"` and `keep=True`.
        motions: (n, m, 6) motion RAOs X.
        points: (p, 3) m, below the surface, outside the hull.

    Raises:
        ModelError: the solution holds no sources.
    """
    engine = capytaine().BEMSolver(method="indirect").engine
    out = np.zeros((len(solution.omega), len(solution.directions), len(points), 3), dtype=complex)
    for i, omega in enumerate(solution.omega.tolist()):
        results: list[Any] = [
            solution.details.get((omega, key)) for key in (*DOFS, *solution.directions.tolist())
        ]
        if any(result is None or result.sources is None for result in results):
            raise ModelError(
                f"the solution at {omega:g} rad/s has no sources: solve with method='indirect' and "
                "keep=True"
            )
        radiated = np.stack([result.sources for result in results[:6]])
        scattered = np.stack([result.sources for result in results[6:]])
        first = results[0]
        kernel = engine.build_fullK_matrix(
            points,
            first.body.mesh_including_lid,
            free_surface=first.free_surface,
            water_depth=first.water_depth,
            wavenumber=first.wavenumber,
        )
        sources = scattered + motions[i] @ radiated  # (m, panels)
        for axis in range(3):
            out[i, :, :, axis] = (np.asarray(kernel[axis]) @ sources.T).T
    return out


def shelter_database(
    solution: Solution,
    motions: NDArray[np.complex128],
    axes: Sequence[Array],
    attributes: Mapping[str, Any],
    origin: Array | None = None,
) -> "xr.Dataset":
    """Dataset of the disturbance of a hull on a grid, as a few modes in space.

    Singular values of the disturbance over all frequencies and directions give spatial modes
    `field` (x, y, z, axis, mode), real and orthonormal, and their complex strengths
    `shelter_strength` per metre of amplitude; their product is the velocity. As many modes are
    kept as leave `RESIDUE` of it out, frequencies weighted by omega^-2.5, at most those that the
    kernels take. On the outermost nodes of the grid, but for the shallowest, the field is set to
    zero: there it fades out.

    Args:
        solution, motions: see `disturbance`.
        axes: ascending x, y and z of the grid, m, in the hull's axes about its origin.
        attributes: of the dataset.
        origin: (3,) of those axes in the solution's frame, m; default (0, 0, 0).

    Raises:
        ModelError: an axis has less than three values or does not rise, or see `disturbance`.
    """
    import xarray as xr

    for name, axis in zip("xyz", axes, strict=True):
        if len(axis) < 3 or (np.diff(axis) <= 0).any():
            raise ModelError(f"{name} of the grid is {axis}; allowed are 3 or more rising values")
    shape = tuple(len(axis) for axis in axes)
    inner = np.zeros(shape, dtype=bool)
    inner[1:-1, 1:-1, 1:] = True
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)[inner]
    velocity = disturbance(solution, motions, points if origin is None else points + origin)
    n, m = velocity.shape[:2]
    columns = velocity.reshape(n * m, -1)
    weight = np.repeat(solution.omega**TAIL, m)[:, None]
    weighted = weight * columns
    left, size, _ = np.linalg.svd(
        np.concatenate([weighted.real, weighted.imag]).T, full_matrices=False
    )
    rest = np.sqrt(np.cumsum(size[::-1] ** 2)[::-1] / (size**2).sum())
    count = min(int((rest > RESIDUE).sum()), MAX_SHELTER_MODES)
    modes = left[:, :count]
    field = np.zeros((*shape, 3, count))
    field[inner] = modes.reshape(-1, 3, count)
    strength = (columns @ modes).reshape(n, m, count)
    return xr.Dataset(
        {
            "field": (("x", "y", "z", "axis", "mode"), field.astype(np.float32)),
            "shelter_strength": (
                ("complex", "omega", "wave_direction", "mode"),
                np.stack([strength.real, strength.imag]).astype(np.float32),
                {"units": "m/s per m"},
            ),
        },
        coords={
            **{name: (name, axis, {"units": "m"}) for name, axis in zip("xyz", axes, strict=True)},
            "omega": ("omega", solution.omega, {"units": "rad/s"}),
            "wave_direction": ("wave_direction", solution.directions, {"units": "rad"}),
            "complex": ["re", "im"],
            "axis": ["x", "y", "z"],
        },
        attrs={
            **attributes,
            "frame": "hull axes x forward, y port, z up; phases at the hull's origin",
            "convention": "v(t) = Re(V exp(-i omega t)), zeta = Re(exp(i (k s - omega t)))",
            "left_out": f"{rest[count] if count < len(rest) else 0.0:.4f} of the field (rms, "
            f"frequencies weighted by omega^{TAIL:g})",
        },
    )
