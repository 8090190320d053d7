"""The sea in pictures: scenery for an `MjSpec` and a water sheet that follows the wave field.

Physics never sees any of this: the geoms have neither mass nor contacts. The sheet is one mesh on
a tensor grid (fine around the vehicle, growing to the horizon), present twice: `water_top` faces
up, `water_under` faces down, so each side has its own look. Its colour is a texture computed here
per frame (Fresnel reflection of the sky, light through crests, foam, Snell's window), because
MuJoCo's fixed lighting knows none of these.

On a tensor grid exp(i (k_x x + k_y y)) = X(x) Y(y), so the sum over N components on n x n points
is one (n, N) by (N, n) matrix product, and moving the grid is only a phase.
"""

from dataclasses import dataclass
from typing import Any, Protocol

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from marine_mj import textures
from marine_mj.errors import RenderError
from marine_mj.hydrodynamics.table import SEA_BED
from marine_mj.textures import Palette
from marine_mj.water_shading import Shader

Float = NDArray[np.float32]

#: Names of what `add_scenery` adds.
TOP, UNDER, SHEET = "water_top", "water_under", "water_sheet"
SEABED, BACKDROP, SUN = "seabed", "water_backdrop", "sun"
#: Geom group that MuJoCo's default view shows, and one that it hides.
SHOWN, HIDDEN = 0, 5


class Waves(Protocol):
    """What the sheet reads of `marine_mj.environment.WaveField` (docs/architecture.md)."""

    @property
    def omega(self) -> Any: ...
    @property
    def wavenumber(self) -> Any: ...
    @property
    def direction(self) -> Any: ...
    @property
    def amplitude(self) -> Any: ...
    @property
    def phase(self) -> Any: ...


@dataclass(frozen=True)
class Components:
    """Plane waves (N,): rad/s, rad/m, rad (NWU), m, rad; what pictures keep of a wave field."""

    omega: NDArray[np.float64]
    wavenumber: NDArray[np.float64]
    direction: NDArray[np.float64]
    amplitude: NDArray[np.float64]
    phase: NDArray[np.float64]


def components(waves: Waves) -> Components:
    """The plane waves of a wave field."""
    names = Components.__dataclass_fields__
    return Components(*(np.array(getattr(waves, name), float).ravel() for name in names))


def elevation(waves: Waves, x: ArrayLike, y: ArrayLike, time: float) -> NDArray[np.float64]:
    """Elevation (...) in m of the sea at points (...), m, NWU: every component, no grid."""
    k, b = np.asarray(waves.wavenumber, float), np.asarray(waves.direction, float)
    along = np.multiply.outer(x, k * np.cos(b)) + np.multiply.outer(y, k * np.sin(b))
    return np.cos(along - np.asarray(waves.omega) * time + waves.phase) @ np.asarray(
        waves.amplitude
    )


#: Cells grow by the first factor up to MIDDLE m from the centre, by the second beyond.
GROWTH, MIDDLE = (1.16, 1.6), 60.0


def sheet_axis(spacing: float, core: float, radius: float) -> NDArray[np.float64]:
    """Ascending coordinates (n,) in m of the sheet's grid lines along one axis.

    Equal `spacing` within `core` m of the centre, then growing cells up to at least `radius`.
    """
    lines = list(np.arange(0.0, core + spacing / 2, spacing))
    step = spacing
    while lines[-1] < radius:
        step *= GROWTH[0] if lines[-1] < MIDDLE else GROWTH[1]
        lines.append(lines[-1] + step)
    half = np.array(lines)
    return np.concatenate([-half[:0:-1], half])


def texel_axis(axis: NDArray, core: float) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
    """Texel coordinates (m,) in m and the texel (n,) at each grid line: more texels per cell
    where the cells are near."""
    middle = 0.5 * np.abs(axis[1:] + axis[:-1])
    count = np.where(middle < core, 4, np.where(middle < 2 * core, 2, 1))
    index = np.concatenate([[0], np.cumsum(count)])
    return np.interp(np.arange(index[-1] + 1), index, axis), index


def add_scenery(
    spec: mujoco.MjSpec,
    *,
    size: tuple[int, int] = (960, 540),
    seabed_depth: float | None = None,
    spacing: float = 0.6,
    core: float = 10.0,
    radius: float = 2500.0,
    palette: Palette | None = None,
) -> None:
    """Add sky, sun, seabed and the water sheet to `spec`; changes `spec` in place.

    Args:
        spec: a scene; whatever it has stays. Existing lights are left alone.
        size: largest picture (width, height) in pixels that will be rendered.
        seabed_depth: depth of the visible seabed below still water, m. A picture only. None: where
            the scene has its sea bed; 10 m in a scene without, whose water is deep.
        spacing, core, radius: grid of the sheet, see `sheet_axis`, m.
        palette: colours; default day.

    Raises:
        RenderError: the spec has scenery already.
    """
    if any(mesh.name == TOP for mesh in spec.meshes):
        raise RenderError(f"the scene has a mesh '{TOP}' already: add_scenery was called twice")
    palette = palette or Palette()
    if seabed_depth is None:
        bed = spec.geom(SEA_BED)
        seabed_depth = 10.0 if bed is None else -float(bed.pos[2])
    _set_visual(spec, size, palette)
    axis = sheet_axis(spacing, core, radius)
    texels, index = texel_axis(axis, core)
    spec.add_numeric(name=SHEET, data=[spacing, core, radius, *palette_numbers(palette)])
    n_texel = len(texels)
    for name, flip in ((TOP, False), (UNDER, True)):
        color = palette.underside if flip else palette.deep
        pixels = np.broadcast_to((np.array(color) * 255).astype(np.uint8), (n_texel, n_texel, 3))
        _add_texture(spec, name, pixels)
        # Full emission: the texture alone gives the colour, MuJoCo's lights add nothing to it.
        material = spec.add_material(name=name, emission=1.0, specular=0.0, shininess=0.0)
        material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = name
        material.rgba = [1, 1, 1, 1.0 if flip else 0.93]
        _add_sheet(spec, name, axis, (index + 0.5) / n_texel, flip)
    _add_backdrop(spec, radius)
    _add_texture(spec, SEABED, textures.sand(palette))
    material = spec.add_material(name=SEABED, specular=0.0, shininess=0.0)
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = SEABED
    material.texrepeat, material.texuniform = [0.16, 0.16], True
    values = {"size": [150, 150, 5], "pos": [0, 0, -seabed_depth], "material": SEABED}
    _add_picture_geom(spec, SEABED, mujoco.mjtGeom.mjGEOM_PLANE, HIDDEN, **values)
    spec.worldbody.add_light(
        name=SUN,
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        pos=[0, 0, 50],
        dir=[-value for value in palette.sun],
        castshadow=False,
        diffuse=[0.7, 0.68, 0.62],
        specular=[0.5, 0.5, 0.5],
    )


def palette_numbers(palette: Palette) -> list[float]:
    """The palette as a flat list, so that a compiled model carries it."""
    return np.hstack([np.ravel(value) for value in vars(palette).values()]).tolist()


def palette_from_numbers(numbers: ArrayLike) -> Palette:
    """The palette that `palette_numbers` wrote."""
    rest = [float(value) for value in np.ravel(numbers)]
    values: dict[str, Any] = {}
    for name, value in vars(Palette()).items():
        count = len(np.ravel(value))
        values[name] = tuple(rest[:count]) if count > 1 else rest[0]
        rest = rest[count:]
    return Palette(**values)


def _set_visual(spec: mujoco.MjSpec, size: tuple[int, int], palette: Palette) -> None:
    visual, stat = spec.visual, spec.stat
    visual.global_.offwidth = max(visual.global_.offwidth, size[0])
    visual.global_.offheight = max(visual.global_.offheight, size[1])
    # Shadows and multisampling cost a factor of three without a GPU.
    visual.quality.offsamples, visual.quality.shadowsize = 0, 0
    # Distances in <map> are multiples of the extent: near 0.1 m, far 6 km.
    stat.extent, stat.center = 10.0, [0, 0, 0]
    visual.map.znear, visual.map.zfar, visual.map.haze = 0.01, 600.0, 0.02
    visual.map.fogstart, visual.map.fogend = 0.05, palette.murk_range / 10.0
    visual.rgba.fog, visual.rgba.haze = [*palette.murk, 1], [*palette.horizon, 1]
    visual.headlight.ambient, visual.headlight.diffuse = [0.38, 0.40, 0.42], [0.2, 0.2, 0.2]
    if not any(t.type == mujoco.mjtTexture.mjTEXTURE_SKYBOX for t in spec.textures):
        _add_texture(spec, "sky", textures.sky_cube(palette), mujoco.mjtTexture.mjTEXTURE_SKYBOX)


def _add_texture(
    spec: mujoco.MjSpec,
    name: str,
    pixels: NDArray[np.uint8],
    kind: mujoco.mjtTexture = mujoco.mjtTexture.mjTEXTURE_2D,
) -> None:
    texture = spec.add_texture(name=name, type=kind, nchannel=3)
    texture.height, texture.width = pixels.shape[:2]
    texture.data = np.ascontiguousarray(pixels).tobytes()


def _add_backdrop(spec: mujoco.MjSpec, radius: float) -> None:
    """A box seen from inside: what is behind everything under water, all fog."""
    corner = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * radius
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    mesh = spec.add_mesh(name=BACKDROP, inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL)
    mesh.uservert = corner.ravel()
    mesh.userface = np.array([t for a, b, c, d in quads for t in ((a, c, b), (a, d, c))]).ravel()
    _add_picture_geom(spec, BACKDROP, mujoco.mjtGeom.mjGEOM_MESH, HIDDEN, meshname=BACKDROP)


def _add_picture_geom(
    spec: mujoco.MjSpec, name: str, kind: mujoco.mjtGeom, group: int, **values: Any
) -> None:
    spec.worldbody.add_geom(
        name=name, type=kind, group=group, contype=0, conaffinity=0, mass=0, **values
    )


def _add_sheet(
    spec: mujoco.MjSpec, name: str, axis: NDArray, coordinate: NDArray, flip: bool
) -> None:
    """One side of the sheet as a flat mesh and its geom; `coordinate` (n,) in the texture."""
    n = len(axis)
    x, y = np.meshgrid(axis, axis, indexing="ij")
    index = np.arange(n * n, dtype=np.int32).reshape(n, n)
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    face = np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)], 2).reshape(-1, 3)
    v, u = np.meshgrid(coordinate, coordinate, indexing="ij")
    mesh = spec.add_mesh(name=name, inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL)
    mesh.uservert = np.stack([x, y, 0 * x], -1).ravel()
    mesh.usernormal = np.tile([0.0, 0.0, -1.0 if flip else 1.0], n * n)
    mesh.usertexcoord = np.stack([u, v], -1).ravel()
    mesh.userface = (face[:, ::-1] if flip else face).ravel()
    mesh.userfacenormal = mesh.userface
    mesh.userfacetexcoord = mesh.userface
    group = HIDDEN if flip else SHOWN
    kind = mujoco.mjtGeom.mjGEOM_MESH
    _add_picture_geom(spec, name, kind, group, meshname=name, material=name)


class WaterSurface:
    """The water sheet of a compiled model, moved and coloured from a wave field.

    Args:
        model: compiled from a spec with `add_scenery`; its mesh, texture and geom arrays are
            written by `update` and `shade`.
        wave_field: `marine_mj.environment.WaveField` or anything with its component arrays:
            zeta = sum a cos(k (x cos b + y sin b) - omega t + phase), NWU.

    Raises:
        RenderError: the model has no scenery.
    """

    def __init__(self, model: mujoco.MjModel, wave_field: Waves) -> None:
        names = [model.numeric(i).name for i in range(model.nnumeric)]
        if SHEET not in names:
            raise RenderError(
                "the model has no water sheet: call marine_mj.water.add_scenery(spec) before"
                " spec.compile()"
            )
        numbers = model.numeric(SHEET).data
        self.model = model
        self.palette = palette_from_numbers(numbers[3:])
        self.spacing, self.core = float(numbers[0]), float(numbers[1])
        self.axis = sheet_axis(*numbers[:3])
        self.texel_axis, vertex = texel_axis(self.axis, self.core)
        self._vertex = np.ix_(vertex, vertex)
        self.center = np.zeros(2)
        self._ids = {name: model.geom(name).id for name in (TOP, UNDER)}
        for name, geom in self._ids.items():
            # The mesh is written in world axes, so undo the frame the compiler gave it.
            model.geom_pos[geom], model.geom_quat[geom] = 0, [1, 0, 0, 0]
            model.geom_sameframe[geom] = 0
            vertices = self._mesh(name, "vert")
            grid = np.meshgrid(self.axis, self.axis, indexing="ij")
            vertices[:, :2] = np.stack(grid, -1).reshape(-1, 2)
        self._set_components(wave_field)
        self._shader = Shader(self.texel_axis, self.palette, self.significant_height)
        self.update(0.0)

    def _set_components(self, field: Waves) -> None:
        k, b = np.asarray(field.wavenumber, float), np.asarray(field.direction, float)
        self._omega, self._phase = np.asarray(field.omega, float), np.asarray(field.phase, float)
        self._amplitude = np.asarray(field.amplitude, float)
        self._k = np.stack([k * np.cos(b), k * np.sin(b)])
        # 4 sqrt(m0): sets the heights at which crests turn green and break.
        self.significant_height = 4 * float(np.sqrt(0.5 * np.sum(self._amplitude**2)))
        spacing = np.gradient(self.texel_axis)
        factors = []
        for k_axis in self._k:
            # A component that the grid cannot carry is faded out where it cannot.
            texels = 2 * np.pi / np.maximum(np.abs(k_axis), 1e-9) / spacing[:, None]
            weight = np.clip((texels - 3.0) / 3.0, 0, 1)
            factors.append(weight * np.exp(1j * np.outer(self.texel_axis, k_axis)))
        x, y = factors
        self._x = np.ascontiguousarray(x.astype(np.complex64))
        # Re(P Q^T) = [Re P, -Im P] [Re Q, Im Q]^T: real arithmetic, half the work.
        self._y = np.ascontiguousarray(np.hstack([y.real, y.imag]).T.astype(np.float32))

    def _mesh(self, name: str, what: str) -> Any:
        """View of the mesh's vertices or normals (n n, 3) inside the model."""
        model, mesh = self.model, self.model.geom_dataid[self._ids[name]]
        start = getattr(model, f"mesh_{what}adr")[mesh]
        count = getattr(model, f"mesh_{what}num")[mesh]
        return getattr(model, f"mesh_{what}")[start : start + count]

    def mesh_id(self, name: str) -> int:
        """Mesh of the side `TOP` or `UNDER`, for `mjr_uploadMesh`."""
        return int(self.model.geom_dataid[self._ids[name]])

    def update(self, time: float, around: ArrayLike | None = None) -> None:
        """Move the sheet to `time` (s); writes vertices and normals of both sides.

        Args:
            time: simulation time, s.
            around: (2,) or (3,) NWU position to keep in the fine part, m. The grid jumps by
                whole cells, and only when this point is a third of the core away.
        """
        if around is not None:
            offset = np.asarray(around, float)[:2] - self.center
            if np.abs(offset).max() > self.core / 3:
                self.center = self.center + np.round(offset / self.spacing) * self.spacing
                self._shader.move(self.center)
                self._move_bottom()
        self.time = time
        angle = self._k.T @ self.center - self._omega * time + self._phase
        strength = self._amplitude * np.exp(1j * angle)
        self.elevation = self._sum(strength)
        self.slope = (self._sum(1j * self._k[0] * strength), self._sum(1j * self._k[1] * strength))
        z = self.elevation[self._vertex].ravel()
        normal = np.stack([-slope[self._vertex].ravel() for slope in self.slope], -1)
        up = 1 / np.sqrt(1 + np.sum(normal**2, axis=1))
        for name, geom in self._ids.items():
            self.model.geom_pos[geom, :2] = self.center
            self._mesh(name, "vert")[:, 2] = z
            sign = 1 if name == TOP else -1
            normals = self._mesh(name, "normal")
            normals[:, :2] = sign * normal * up[:, None]
            normals[:, 2] = sign * up

    def _move_bottom(self) -> None:
        """Keep seabed and backdrop below the sheet; the seabed by whole tiles of its texture."""
        model = self.model
        tile = 1 / model.mat_texrepeat[model.geom_matid[model.geom(SEABED).id]]
        model.geom_pos[model.geom(SEABED).id, :2] = np.round(self.center / tile) * tile
        model.geom_pos[model.geom(BACKDROP).id, :2] = self.center

    def _sum(self, strength: NDArray) -> Float:
        """Re sum_n X_in s_n Y_jn (n_texel, n_texel)."""
        left = self._x * strength.astype(np.complex64)
        return np.hstack([left.real, -left.imag]) @ self._y

    def elevation_at_vertices(self) -> tuple[NDArray, NDArray, NDArray]:
        """World x, y and elevation (n, n) in m of the vertices as rendered, with their core only.

        Outside the core, components too short for the coarse cells are missing by intention.
        """
        inside = np.abs(self.axis) <= self.core
        n = len(self.axis)
        vertices = self._mesh(TOP, "vert").reshape(n, n, 3)[inside][:, inside].astype(float)
        return (
            vertices[..., 0] + self.center[0],
            vertices[..., 1] + self.center[1],
            vertices[..., 2],
        )

    def shade(self, name: str, camera: ArrayLike) -> int:
        """Colour the side `name` as seen from `camera` (3,) NWU, m.

        Returns:
            The texture that changed, for `mjr_uploadTexture`. Mipmaps would mix near texels
            into far ones along the grid's axes: sample it without them.
        """
        model = self.model
        color = self._shader(
            self.elevation,
            self.slope,
            np.asarray(camera, float) - [*self.center, 0.0],
            self.time,
            name == UNDER,
        )
        material = model.geom_matid[self._ids[name]]
        texture = model.mat_texid[material, mujoco.mjtTextureRole.mjTEXROLE_RGB]
        start = model.tex_adr[texture]
        model.tex_data[start : start + color.size] = color.ravel()
        return int(texture)
