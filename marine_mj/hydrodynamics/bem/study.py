"""From a mesh to a wave database: the steps of `marine-mj hydro`."""

import dataclasses
import hashlib
import json
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from marine_mj.environment import wavenumber
from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.hydrodynamics.bem.database import hydrostatic_variables, wave_database
from marine_mj.hydrodynamics.bem.drift import database_drift
from marine_mj.hydrodynamics.bem.find import find_hull
from marine_mj.hydrodynamics.bem.panels import Panels, from_triangles, is_mirrored, lid
from marine_mj.hydrodynamics.bem.rao import (
    drag_motion_raos,
    motion_raos,
    natural_periods,
    viscous_damping,
)
from marine_mj.hydrodynamics.bem.remesh import remesh
from marine_mj.hydrodynamics.bem.rigid_body import RigidBody, rigid_body
from marine_mj.hydrodynamics.bem.settings import Settings, check_settings
from marine_mj.hydrodynamics.bem.solver import Solution, check_panels, solve
from marine_mj.hydrodynamics.cut import cut
from marine_mj.hydrodynamics.hydrostatics import Hydrostatics, hydrostatics
from marine_mj.hydrodynamics.mesh import HullMesh, read_mesh

if TYPE_CHECKING:
    import xarray as xr

#: Panels of the whole hull that the default panel size aims at.
DEFAULT_PANELS = 700
#: Vertices this close to a cut, as a share of the extent, are moved onto it: no sliver panels.
SNAP = 1e-6
#: Default frequencies over sqrt(g / L): waves from 60 to 1/4 hull lengths.
DEFAULT_OMEGA = np.linspace(0.32, 5.0, 40)
DEFAULT_DIRECTIONS = np.radians(np.arange(0.0, 360.0, 15.0))


@dataclass(frozen=True)
class Hull:
    """A checked hull in still water; coordinates with z = 0 at the water surface.

    Attributes:
        name: for file names and titles.
        source: file name of the mesh.
        sha256: of the mesh file.
        mesh: closed surface, m.
        still: hydrostatics of the mesh.
        body: rigid body.
        origin: (3,) origin of the body axes, m: moments and motions are about it.
        unbounded: no water surface.
        wetted: points and faces below the surface (all, if unbounded).
        settings: as given.
        notes: what is assumed or doubtful.
    """

    name: str
    source: str
    sha256: str
    mesh: HullMesh
    still: Hydrostatics
    body: RigidBody
    origin: Array
    unbounded: bool
    wetted: tuple[Array, np.ndarray]
    settings: Settings
    notes: tuple[str, ...]

    @property
    def stiffness(self) -> Array:
        """Hydrostatic stiffness (6, 6) about the origin."""
        s = self.settings
        return self.still.stiffness(
            s.density, s.gravity, self.body.mass, self.body.center_of_mass, self.origin
        )

    @property
    def rigid(self) -> Array:
        """Rigid-body inertia (6, 6) about the origin."""
        return self.body.matrix(self.origin)

    def panel_size(self) -> float:
        """The panel size asked for, or one that gives about 700 panels, m."""
        if self.settings.panel is not None:
            return self.settings.panel
        return float(np.sqrt(self.still.wetted_surface / DEFAULT_PANELS * 4 / np.sqrt(3)))

    def panels(self, size: float) -> tuple[Panels, Panels | None]:
        """Hull and lid of about that panel size [m], a half or quarter where it is symmetric."""
        points, faces = self.wetted
        mirrors: tuple[int, ...] = ()
        if self.settings.symmetry:
            mirrors = tuple(axis for axis in (1, 0) if is_mirrored(self.mesh.vertices, axis))
        for axis in mirrors:
            points, faces = cut(points, faces, axis, 1, SNAP)
        hull = from_triangles(*remesh(points, faces, size), mirrors)
        floats = self.settings.lid and self.still.waterplane_area > 0 and not self.unbounded
        return hull, lid(hull, size) if floats else None

    def omega(self) -> Array:
        """Frequencies asked for, or the default ones for the hull's length, rad/s."""
        if self.unbounded:
            return np.zeros(0)
        if self.settings.omega is not None:
            return np.sort(np.asarray(self.settings.omega, dtype=float))
        length = max(self.still.length, self.still.breadth)
        return DEFAULT_OMEGA * np.sqrt(self.settings.gravity / length)


def read_hull(name: str, settings: Settings | None = None) -> Hull:
    """Hull of a mesh file or vehicle, checked and put into the water; needs no Capytaine.

    Args:
        name: see `find_hull`.
        settings: see `Settings`.

    Raises:
        ModelError: the mesh is unfit (`read_mesh`), lies above the water or only touches it,
            floats and sinks by different masses (`rigid_body`), or a setting is not allowed.
    """
    settings = settings or Settings()
    check_settings(settings)
    file, vehicle = find_hull(name)
    mesh = read_mesh(file, settings.scale, settings.repair)
    bottom, top = float(mesh.vertices[:, 2].min()), float(mesh.vertices[:, 2].max())
    level = settings.waterline
    if settings.draught is not None:
        level = bottom + settings.draught
    if level is None:
        level = -vehicle.equilibrium_height if vehicle else 0.0
    if bottom >= level:
        raise ModelError(
            f"{file.name} lies above the water: its lowest point is {bottom - level:.4g} m above "
            f"the still water line z = {level:.4g} m; give --draught or --waterline"
        )
    shift = np.array([0.0, 0.0, -level])
    mesh = mesh.moved(shift)
    under = top <= level
    unbounded = under if settings.submerged is None else settings.submerged
    notes = []
    if under and settings.submerged is None:
        notes.append(
            f"the hull is {level - top:.3g} m under water: taken as deeply submerged, no waves "
            "(--waves for waves on it)"
        )
    points, faces = mesh.vertices, mesh.triangles
    if not (unbounded or under):
        points, faces = cut(points, faces, 2, -1, SNAP)
    still = hydrostatics(points, faces)
    if still.volume <= 0:
        raise ModelError(
            f"the wetted surface of {file.name} encloses {still.volume:.4g} m3, must be > 0: give "
            "a larger --draught or a higher --waterline"
        )
    if not unbounded and np.isfinite(settings.depth) and still.draught >= settings.depth:
        raise ModelError(
            f"the draught {still.draught:.4g} m reaches the bottom at {settings.depth:g} m; "
            "allowed is a depth above the draught"
        )
    values = {k: getattr(settings, k) for k in ("mass", "center_of_mass", "inertia", "gyration")}
    if values["center_of_mass"] is not None:
        values["center_of_mass"] = np.asarray(values["center_of_mass"], dtype=float) + shift
    given = _of_vehicle(name, vehicle.name, shift) if vehicle else None
    if given is not None and not any(v is not None for v in values.values()):
        body = given
        displaced = settings.density * still.volume
        if abs(body.mass - displaced) > 0.05 * displaced:
            notes.append(f"mass {body.mass:.6g} kg, displaced {displaced:.6g} kg")
    else:
        body = rigid_body(mesh, settings.density * still.volume, still.center_of_buoyancy, **values)
    # A mesh has its origin on the water line, a vehicle where its MJCF has it.
    origin = shift if vehicle else np.zeros(3)
    notes += [f"assumed {text}" for text in body.assumptions]
    notes += _trim(still, body)
    digest = hashlib.sha256(file.read_bytes()).hexdigest()
    wetted = (points, faces)
    title = vehicle.name if vehicle else file.stem
    name = Path(name).stem if vehicle else title
    return Hull(
        name,
        file.name,
        digest,
        mesh,
        still,
        body,
        origin,
        unbounded,
        wetted,
        settings,
        tuple(notes),
    )


def analyse(
    hull: Hull,
    size: float | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> "xr.Dataset":
    """Wave database of a hull: radiation, wave loads, hydrostatics and RAOs.

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
    notes = [*hull.notes, *check_panels(panels, hull.omega(), s.gravity)]
    solution = solve(
        panels,
        cover,
        omega=hull.omega(),
        directions=DEFAULT_DIRECTIONS if s.directions is None else np.asarray(s.directions),
        density=s.density,
        gravity=s.gravity,
        depth=s.depth,
        origin=hull.origin,
        unbounded=hull.unbounded,
        method="indirect" if s.drift else s.method,
        keep=s.drift,
        progress=progress,
    )
    meshed = hydrostatics(*panels.triangles())
    viscous, motions = _response(hull, solution)
    k = np.array([float(wavenumber(w, s.depth, s.gravity)) for w in solution.omega])
    deep = "infinite depth" if np.isinf(s.depth) else f"depth {s.depth:g} m"
    where = "unbounded fluid" if hull.unbounded else f"{deep}, zero speed"
    attributes = {
        "title": f"Linear wave response of {hull.name}",
        "geometry": hull.source,
        "mesh_sha256": hull.sha256,
        "mesh": f"{len(panels)} wetted panels of about {size:.3g} m and "
        f"{0 if cover is None else len(cover)} lid panels against irregular frequencies, "
        f"{len(panels.mirrors)} mirror planes, {'indirect' if s.drift else s.method} method",
        "panel_size": size,
        "panels": len(panels),
        "panel_volume_error": meshed.volume / hull.still.volume - 1,
        "asymmetry_before_symmetrising": solution.asymmetry,
        "water": f"{where}, rho {s.density:g} kg/m3, g {s.gravity:g} m/s2",
        "origin": "waterline frame " + " ".join(f"{v:.6g}" for v in hull.origin) + " m",
        "settings": json.dumps({k: _plain(v) for k, v in dataclasses.asdict(s).items()}),
        "assumptions": "; ".join(notes),
        "software": ", ".join(
            f"{package} {version(package)}" for package in ("marine-mj", "capytaine", "numpy")
        ),
    }
    data = wave_database(solution, hull.stiffness, hull.rigid, k, viscous, motions, attributes)
    data = data.assign(hydrostatic_variables(hull.still, hull.body.center_of_mass, hull.origin))
    if motions is not None:
        periods = natural_periods(solution.omega, solution.added_mass, hull.rigid, hull.stiffness)
        data.attrs["natural_periods"] = json.dumps(periods)
        if s.drift:
            data["mean_drift_force"] = database_drift(solution, motions)
    return data


def _plain(value):
    """A setting for JSON, which knows no infinity."""
    return "inf" if value == float("inf") else value


def _response(hull: Hull, solution: Solution):
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


def _of_vehicle(name: str, body: str, shift: Array) -> RigidBody:
    """Rigid body of a vehicle's hydrodynamic body with all it carries."""
    from marine_mj.hydrodynamics.inertia import subtree_inertia
    from marine_mj.hydrodynamics.loader import load

    model = load(name)
    mass, center, matrix = subtree_inertia(model, model.body(body).id)
    about = RigidBody(mass, center, np.zeros((3, 3))).matrix(np.zeros(3))[3:, 3:]
    return RigidBody(mass, center + shift, matrix[3:, 3:] - about)


def _trim(still: Hydrostatics, body: RigidBody) -> list[str]:
    """Notes on a hull that would not stay as it lies, or not upright."""
    notes = []
    heights = still.metacentric_heights(body.center_of_mass)
    offset = (body.center_of_mass - still.center_of_buoyancy)[:2]
    for name, height, arm in (("heel", heights[0], offset[1]), ("trim", heights[1], offset[0])):
        if height <= 0:
            axis = "T" if name == "heel" else "L"
            notes.append(f"GM_{axis} is {height:.3g} m: the hull is not stable")
        elif abs(arm) > np.tan(np.radians(1.0)) * height:
            notes.append(
                f"the centre of gravity is {arm:+.3g} m from the centre of buoyancy: static {name} "
                f"of {np.degrees(np.arctan2(arm, height)):.2g} deg is not in the mesh"
            )
    return notes
