"""Mean wave drift from the far field of a linear solution."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from marine_mj.errors import ModelError
from marine_mj.hydrodynamics.raos import DOFS

if TYPE_CHECKING:
    import xarray as xr

    from marine_mj.hydrodynamics.bem.solver import Solution

#: Degrees of freedom in which waves push steadily.
DRIFT_DOFS = ["Surge", "Sway", "Yaw"]
_TURN = 2 * np.pi
#: Directions of the far field, every half degree.
_STEPS = 720


def _kochin(results: Sequence[Any], dofs: list[str]) -> "xr.Dataset":
    """Kochin functions of all results, as `far_field_mean_drift_force` wants them."""
    import xarray as xr
    from capytaine.bem.problems_and_results import DiffractionResult, RadiationResult
    from capytaine.post_pro.kochin import compute_kochin

    results = [r for r in results if 0 < r.omega < np.inf]
    # past a whole turn on both sides: derivatives at its ends need neighbours
    theta = np.concatenate([[-1.0], np.arange(_STEPS), [_STEPS, _STEPS + 1.0]]) / _STEPS * _TURN
    radiation = {(r.omega, r.radiating_dof): r for r in results if isinstance(r, RadiationResult)}
    scattered = {
        (r.omega, r.wave_direction): r for r in results if isinstance(r, DiffractionResult)
    }
    omega = sorted({w for w, _ in radiation} & {w for w, _ in scattered})
    direction = sorted({beta for _, beta in scattered})
    whole = all((w, dof) in radiation for w in omega for dof in dofs) and all(
        (w, beta) in scattered for w in omega for beta in direction
    )
    if not omega or not whole:
        raise ModelError(
            f"mean drift from {len(radiation)} radiation and {len(scattered)} diffraction results: "
            f"needed are, at each frequency, radiation in {', '.join(dofs)} and diffraction for "
            "every wave direction; solve the missing problems"
        )
    if any(r.sources is None for r in (*radiation.values(), *scattered.values())):
        raise ModelError(
            "mean drift needs the sources of every result, and some have none; solve with "
            "method='indirect' and keep_details=True"
        )
    first = scattered[omega[0], direction[0]]
    return xr.Dataset(
        {
            "kochin_radiation": (
                ("omega", "radiating_dof", "theta"),
                [[compute_kochin(radiation[w, dof], theta) for dof in dofs] for w in omega],
            ),
            "kochin_diffraction": (
                ("omega", "wave_direction", "theta"),
                [[compute_kochin(scattered[w, b], theta) for b in direction] for w in omega],
            ),
            "water_depth": first.water_depth,
            "rho": first.rho,
            "g": first.g,
        },
        coords={
            "omega": omega,
            "wavenumber": ("omega", [scattered[w, direction[0]].wavenumber for w in omega]),
            "wave_direction": direction,
            "radiating_dof": dofs,
            "theta": theta,
        },
    )


def mean_drift_force(results: Sequence[Any], rao: "xr.DataArray") -> "xr.DataArray":
    """Mean drift force and yaw moment `mean_drift_force` (omega, wave_direction, drift_dof).

    Momentum conservation between the hull and a control surface far away (Maruo 1960, J. Ship
    Res. 4; yaw moment: Newman 1967, J. Ship Res. 11), by Capytaine's `far_field_mean_drift_force`
    from the Kochin function H of the scattered waves and of those of the motion. It assumes no
    conservation of energy, so the motion may hold viscous damping. In N/m2 and N m/m2: per squared
    metre of wave amplitude; the mean force in a regular wave of amplitude a is a^2 times it.

    Args:
        results: Capytaine results of one body without forward speed, in one water depth: all
            radiation and diffraction problems of each frequency, solved with `method="indirect"`
            and `keep_details=True` (`BEMSolver.solve_all`); infinite frequencies are left out.
        rao: complex motion (omega, wave_direction, radiating_dof) per metre of amplitude, phasor
            exp(-i omega t), m and rad, viscous damping included. Its degrees of freedom are those
            that move; a fixed body has RAOs of zero.

    Body axes x forward, y port, z up; the yaw moment is about the z axis of the mesh's frame;
    `wave_direction` is the direction of travel, rad counter-clockwise from x.

    Raises:
        ModelError: results are missing or have no sources, or `rao` lacks one of their frequencies
            or directions.
    """
    import xarray as xr
    from capytaine.post_pro.mean_drift_force import far_field_mean_drift_force

    dofs = [str(dof) for dof in rao["radiating_dof"].values]
    kochin = _kochin(results, dofs)
    rao = rao.transpose("omega", "wave_direction", "radiating_dof")
    near = {"omega": kochin["omega"], "wave_direction": kochin["wave_direction"]}
    try:
        motion = rao.sel(near, method="nearest", tolerance=1e-6)
    except KeyError as error:
        raise ModelError(
            f"the RAO has the frequencies {rao['omega'].values} rad/s and directions "
            f"{rao['wave_direction'].values} rad; needed are those of the results, "
            f"{kochin['omega'].values} and {kochin['wave_direction'].values}"
        ) from error
    motion = motion.assign_coords(near)
    columns = []
    for direction in kochin["wave_direction"].values:
        # one direction at a time: the formula would pair each with every other one
        place = {"wave_direction": [direction]}
        turned = {"wave_direction": [np.mod(direction, _TURN)]}
        force = far_field_mean_drift_force(
            motion.sel(place).assign_coords(turned), kochin.sel(place).assign_coords(turned)
        )
        parts = [force[f"drift_force_{dof.lower()}"].values[:, 0, 0].real for dof in DRIFT_DOFS]
        columns.append(np.stack(parts, axis=-1))
    return xr.DataArray(
        np.stack(columns, axis=1),
        dims=("omega", "wave_direction", "drift_dof"),
        coords={**near, "drift_dof": DRIFT_DOFS},
        name="mean_drift_force",
        attrs={
            "units": "N/m2, N m/m2",
            "description": "mean drift per squared metre of wave amplitude, far field, with the "
            "motion of RAO",
        },
    )


def database_drift(solution: "Solution", motions: NDArray[np.complex128]) -> "xr.DataArray":
    """`mean_drift_force` of a solution for its database, see there.

    Args:
        solution: by `solve` with `method="indirect"` and `keep=True`.
        motions: (omega, wave_direction, 6) motion RAOs.

    Raises:
        ModelError: the solution was made without keeping its results.
    """
    import xarray as xr

    moving = xr.DataArray(
        motions,
        dims=("omega", "wave_direction", "radiating_dof"),
        coords={
            "omega": solution.omega,
            "wave_direction": solution.directions,
            "radiating_dof": DOFS,
        },
    )
    return mean_drift_force(list(solution.details.values()), moving).astype(np.float32)
