"""From a hull to its databases: radiation, wave loads, motions, the water around it."""

import dataclasses
import json
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from marine_mj.environment import wavenumber
from marine_mj.frames import Array
from marine_mj.hydrodynamics.bem.database import (
    hydrostatic_variables,
    water_attributes,
    wave_database,
)
from marine_mj.hydrodynamics.bem.drift import database_drift
from marine_mj.hydrodynamics.bem.panels import Panels
from marine_mj.hydrodynamics.bem.rao import (
    drag_motion_raos,
    motion_raos,
    natural_periods,
    viscous_damping,
)
from marine_mj.hydrodynamics.bem.settings import Settings
from marine_mj.hydrodynamics.bem.shelter import shelter_database, shelter_grid
from marine_mj.hydrodynamics.bem.solver import Solution, check_panels, solve
from marine_mj.hydrodynamics.bem.study import Hull
from marine_mj.hydrodynamics.hydrostatics import hydrostatics

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class Response:
    """Linear response of a hull, of which its databases are made.

    Attributes:
        size: of the panels, m.
        panels, lid: what was solved for.
        solution: radiation and wave loads about the hull's origin.
        viscous: value and description of viscous damping by variable name.
        motions: (n, m, 6) motion RAOs; None in an unbounded fluid.
        notes: what is assumed or doubtful.
    """

    size: float
    panels: Panels
    lid: Panels | None
    solution: Solution
    viscous: dict[str, tuple[Array | float, str]]
    motions: NDArray[np.complex128] | None
    notes: tuple[str, ...]


def respond(
    hull: Hull,
    size: float | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Response:
    """Radiation, wave loads and motions of a hull.

    Args:
        hull: see `read_hull`.
        size: panel size instead of that of the settings, m.
        progress: called with (solved, all) frequencies.

    Raises:
        ModelError: Capytaine is missing, the panels are too few or too many, or the viscous
            damping is refused.
    """
    s = hull.settings
    size = size or hull.panel_size()
    panels, cover = hull.panels(size)
    notes = (*hull.notes, *check_panels(panels, hull.omega(), s.gravity))
    solution = solve(
        panels,
        cover,
        omega=hull.omega(),
        directions=hull.directions(),
        density=s.density,
        gravity=s.gravity,
        depth=s.depth,
        origin=hull.origin,
        unbounded=hull.unbounded,
        method=_method(s),
        keep=s.needs_sources,
        progress=progress,
    )
    viscous, motions = _damped_motions(hull, solution)
    return Response(size, panels, cover, solution, viscous, motions, notes)


def analyse(
    hull: Hull,
    size: float | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> "xr.Dataset":
    """Wave database of a hull: radiation, wave loads, hydrostatics and RAOs.

    Args and Raises: see `respond`.
    """
    return database_of(hull, respond(hull, size, progress))


def database_of(hull: Hull, response: Response) -> "xr.Dataset":
    """Wave database of a hull from its response."""
    s, solution, motions = hull.settings, response.solution, response.motions
    k = np.array([float(wavenumber(w, s.depth, s.gravity)) for w in solution.omega])
    attributes = {
        "title": f"Linear wave response of {hull.name}",
        **_attributes(hull, response),
        "panel_size": response.size,
        "panels": len(response.panels),
        "panel_volume_error": hydrostatics(*response.panels.triangles()).volume / hull.still.volume
        - 1,
        "asymmetry_before_symmetrising": solution.asymmetry,
    }
    data = wave_database(
        solution, hull.stiffness, hull.rigid, k, response.viscous, motions, attributes
    )
    data = data.assign(hydrostatic_variables(hull.still, hull.body.center_of_mass, hull.origin))
    if motions is not None:
        periods = natural_periods(solution.omega, solution.added_mass, hull.rigid, hull.stiffness)
        data.attrs["natural_periods"] = json.dumps(periods)
        if s.drift:
            data["mean_drift_force"] = database_drift(solution, motions)
    return data


def shelter_of(hull: Hull, response: Response) -> "xr.Dataset":
    """Shelter database of a hull: how it disturbs the waves around and below it.

    Args:
        hull: with the setting `shelter`.
        response: of it.

    Raises:
        ModelError: see `shelter_database`.
    """
    points = hull.wetted[0]
    axes = shelter_grid(points.min(axis=0), points.max(axis=0), response.size, hull.settings.depth)
    axes = axes[0], axes[1], axes[2] - hull.origin[2]
    about = {
        "title": f"Water motion around {hull.name}, floating",
        **_attributes(hull, response),
    }
    assert response.motions is not None  # `read_hull` refuses `shelter` without a surface
    return shelter_database(response.solution, response.motions, axes, about, hull.origin)


def _method(s: Settings) -> str:
    """Boundary integral equation that is solved."""
    return "indirect" if s.needs_sources else s.method


def _attributes(hull: Hull, response: Response) -> dict[str, Any]:
    """Attributes of every database of a hull: mesh, panels, water, settings, versions."""
    s, panels, cover = hull.settings, response.panels, response.lid
    deep = "infinite depth" if np.isinf(s.depth) else f"depth {s.depth:g} m"
    where = "unbounded fluid" if hull.unbounded else f"{deep}, zero speed"
    return {
        "geometry": hull.source,
        "mesh_sha256": hull.sha256,
        "mesh": f"{len(panels)} wetted panels of about {response.size:.3g} m and "
        f"{0 if cover is None else len(cover)} lid panels against irregular frequencies, "
        f"{len(panels.mirrors)} mirror planes, {_method(s)} method",
        "water": f"{where}, rho {s.density:g} kg/m3, g {s.gravity:g} m/s2",
        **water_attributes(s.density, s.gravity, s.depth, hull.mirror_planes, hull.radius),
        "origin": "waterline frame " + " ".join(f"{v:.6g}" for v in hull.origin) + " m",
        "settings": json.dumps({k: _plain(v) for k, v in dataclasses.asdict(s).items()}),
        "assumptions": "; ".join(response.notes),
        "software": ", ".join(
            f"{package} {version(package)}" for package in ("marine-mj", "capytaine", "numpy")
        ),
    }


def _plain(value):
    """A setting for JSON, which knows no infinity."""
    return "inf" if value == float("inf") else value


def _damped_motions(hull: Hull, solution: Solution):
    """Viscous variables and motion RAOs."""
    s = hull.settings
    if hull.unbounded:
        return {}, None
    C, M = hull.stiffness, hull.rigid
    args = (solution.omega, solution.added_mass, M, C)
    variables: dict[str, tuple[Array | float, str]] = {}
    matrix = np.zeros((6, 6))
    if s.viscous is not None:
        values = np.asarray(s.viscous, dtype=float)
        matrix = np.diag(values) if values.size == 6 else values.reshape(6, 6)
    for dof, ratio in (("Roll", s.roll_damping), ("Pitch", s.pitch_damping)):
        if ratio:
            added = viscous_damping(*args, {dof: ratio})
            i = 3 if dof == "Roll" else 4
            variables[f"viscous_{dof.lower()}_damping"] = (
                float(added[i, i]),
                f"{ratio:.3g} of critical at the {dof.lower()} natural frequency; in RAO and in "
                "viscous_damping, not in radiation_damping",
            )
            matrix = matrix + added
    matrix = viscous_damping(*args, {}, matrix)
    if matrix.any():
        variables["viscous_damping"] = (matrix, "linear, in RAO, not in radiation_damping")
    force = solution.froude_krylov + solution.diffraction
    total = solution.omega, M + solution.added_mass, matrix + solution.damping, C, force
    if s.quadratic is None:
        return variables, motion_raos(*total)
    variables["viscous_quadratic_damping"] = (
        np.diag(np.asarray(s.quadratic, dtype=float)),
        f"N s2/m2 ..., linearised in RAO at a wave amplitude of {s.amplitude:g} m",
    )
    return variables, drag_motion_raos(*total, np.asarray(s.quadratic), s.amplitude)
