"""From a mesh to a hull in still water: the first steps of `marine-mj hydro`."""

import hashlib
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from marine_mj.environment import wavenumber
from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.hydrodynamics.bem.find import find_hull
from marine_mj.hydrodynamics.bem.panels import Panels, from_triangles, is_mirrored, lid
from marine_mj.hydrodynamics.bem.remesh import remesh
from marine_mj.hydrodynamics.bem.rigid_body import RigidBody, rigid_body
from marine_mj.hydrodynamics.bem.settings import Settings, check_settings
from marine_mj.hydrodynamics.cut import cut
from marine_mj.hydrodynamics.harmonics import highest_harmonic, round_step
from marine_mj.hydrodynamics.hydrostatics import Hydrostatics, hydrostatics
from marine_mj.hydrodynamics.mesh import HullMesh, read_mesh
from marine_mj.hydrodynamics.wave_file import (
    LARGEST_GAP,
    SAME,
    HullSymmetry,
    missing_directions,
    whole_circle,
)

#: Panels of the whole hull that the default panel size aims at.
DEFAULT_PANELS = 700
#: Vertices this close to a cut, as a share of the extent, are moved onto it: no sliver panels.
SNAP = 1e-6
#: Default frequencies over sqrt(g / L): waves from 60 to 1/4 hull lengths.
DEFAULT_OMEGA = np.linspace(0.32, 5.0, 40)


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

    @property
    def radius(self) -> float:
        """Largest horizontal distance of the wetted hull from the origin, m."""
        return float(np.linalg.norm(self.wetted[0][:, :2] - self.origin[:2], axis=1).max())

    @property
    def mirror_planes(self) -> HullSymmetry:
        """Planes through the origin about which the hull and its mass are symmetric."""
        size = float(np.ptp(self.mesh.vertices, axis=0).max())
        inertia = self.body.inertia

        def mirrored(axis: int) -> bool:
            places = abs(self.origin[axis]), abs(self.body.center_of_mass[axis])
            products = np.delete(inertia[axis], axis)
            straight = np.abs(products).max() <= 1e-4 * np.abs(inertia).max()
            return max(places) <= 1e-4 * size and bool(
                straight and is_mirrored(self.mesh.vertices, axis)
            )

        if not mirrored(1):
            return "none"
        return "xz yz" if mirrored(0) else "xz"

    def largest_step(self) -> float:
        """Largest step of the wave direction that holds the loads of the shortest waves, rad."""
        s, omega = self.settings, self.omega()
        k = float(wavenumber(omega[-1], s.depth, s.gravity)) if len(omega) else 0.0
        return float(np.pi / max(highest_harmonic(k, self.radius), 1.0))

    def directions(self) -> Array:
        """Directions asked for, or all around in steps that the shortest waves need, rad."""
        if self.settings.directions is not None:
            return np.asarray(self.settings.directions, dtype=float)
        step = min(round_step(np.degrees(self.largest_step())), 15.0)
        return np.radians(np.arange(0.0, 360.0 - 1e-9, step))

    def direction_notes(self) -> list[str]:
        """What the directions asked for lack; nothing for the default ones."""
        if self.unbounded or self.settings.directions is None:
            return []
        circle = whole_circle(self.directions(), self.mirror_planes)
        if circle.gap > LARGEST_GAP + SAME:
            text = missing_directions(circle, self.mirror_planes)
            return [f"the database cannot be simulated with: {text}"]
        step = self.largest_step() * (1 if circle.even else 0.5)
        if circle.gap <= step + SAME:
            return []
        return [
            f"directions are up to {np.degrees(circle.gap):.3g} deg apart, and in the shortest "
            f"waves ({self.omega()[-1]:.3g} rad/s) of a hull of {self.radius:.3g} m radius loads "
            f"are lost between them: compute them every {round_step(np.degrees(step)):g} deg, or "
            "leave out the highest frequencies"
        ]

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
    if unbounded and settings.shelter:
        raise ModelError(
            f"shelter of {file.name}, which is taken as deeply submerged: allowed is a hull in "
            "waves; give --waves or leave out --shelter"
        )
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
    hull = Hull(
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
    return replace(hull, notes=(*hull.notes, *hull.direction_notes()))


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
