"""Pictures of one instant: OpenGL context without a window, looks above and below water.

MuJoCo's own `Renderer` binds to the GL platform at the import of `mujoco`; here the context is
made when the first picture is asked for, so importing marine_mj never needs GL.
"""

import contextlib
import functools
import importlib
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from marine_mj.errors import RenderError
from marine_mj.water import (
    BACKDROP,
    HIDDEN,
    SEABED,
    SHOWN,
    SUN,
    TOP,
    UNDER,
    WaterSurface,
    Waves,
    elevation,
)

Frame = NDArray[np.uint8]
#: Adds geoms to a scene.
Decor = Callable[[mujoco.MjvScene], None]

#: GL platforms of MuJoCo that work without a window, and what they need on Debian or Ubuntu.
PACKAGES = {
    "egl": "sudo apt-get install libegl1 libegl-mesa0 libgl1-mesa-dri",
    "osmesa": "sudo apt-get install libosmesa6 libgl1-mesa-dri",
    "glfw": "a display (set MUJOCO_GL=egl to render without one)",
}


@dataclass(frozen=True)
class GlStatus:
    """Whether pictures can be made here; truthy when they can.

    Attributes:
        ok: a test picture was rendered.
        reason: the OpenGL renderer's name if ok; otherwise what failed and what to type.
    """

    ok: bool
    reason: str

    def __bool__(self) -> bool:
        return self.ok


def gl_platform() -> str:
    """GL platform in use: MUJOCO_GL, or `egl` if the user did not set it."""
    return os.environ.setdefault("MUJOCO_GL", "egl").strip().lower()


def gl_status() -> GlStatus:
    """Try to render one pixel in another process, so that a broken driver cannot kill this one.

    The answer is kept for each value of MUJOCO_GL.
    """
    return _probe(gl_platform())


_PROBE = """
from marine_mj.rendering import make_context
import mujoco
context = make_context(16, 16)
model = mujoco.MjModel.from_xml_string("<mujoco/>")
mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_50)
from OpenGL import GL
print("renderer:", GL.glGetString(GL.GL_RENDERER).decode(), flush=True)
import os
os._exit(0)
"""


@functools.cache
def _probe(platform: str) -> GlStatus:
    if platform not in PACKAGES:
        return GlStatus(
            False,
            f"MUJOCO_GL is '{platform}', which cannot render; allowed are"
            f" {', '.join(PACKAGES)}. Type: export MUJOCO_GL=egl",
        )
    environment = {**os.environ, "MUJOCO_GL": platform}
    try:
        result = subprocess.run(
            [sys.executable, "-c", _PROBE],
            capture_output=True,
            text=True,
            timeout=120,
            env=environment,
        )
    except subprocess.TimeoutExpired:
        lines, code = ["the OpenGL driver did not answer within 120 s"], -1
    else:
        for line in result.stdout.splitlines():
            if line.startswith("renderer:"):
                return GlStatus(True, f"{platform}: {line.removeprefix('renderer:').strip()}")
        lines, code = result.stderr.strip().splitlines(), result.returncode
    detail = lines[-1] if lines else f"the test process ended with code {code}"
    return GlStatus(
        False,
        f"OpenGL without a window does not work here (MUJOCO_GL={platform}): {detail}\n"
        f"What it needs, on Debian or Ubuntu: {PACKAGES[platform]}",
    )


def require_gl() -> None:
    """Raises `RenderError` with the reason and the remedy if pictures cannot be made here."""
    status = gl_status()
    if not status:
        raise RenderError(status.reason)


def make_context(width: int, height: int) -> Any:
    """A current OpenGL context of the platform `gl_platform()`."""
    context = importlib.import_module(f"mujoco.{gl_platform()}").GLContext(width, height)
    context.make_current()
    return context


@dataclass(frozen=True)
class Pose:
    """Where a camera is: position (3,) m, unit `forward` and `up` (3,), NWU; `fovy` in degrees."""

    position: NDArray[np.float64]
    forward: NDArray[np.float64]
    up: NDArray[np.float64]
    fovy: float = 45.0

    @property
    def right(self) -> NDArray[np.float64]:
        return np.cross(self.forward, self.up)


def look_at(position: Any, target: Any, fovy: float = 45.0) -> Pose:
    """Pose at `position` with `target` in the middle of the picture and the horizon level."""
    position = np.asarray(position, float)
    forward = np.asarray(target, float) - position
    forward = forward / max(float(np.linalg.norm(forward)), 1e-9)
    right = np.array([forward[1], -forward[0], 0.0])
    right = right / max(float(np.linalg.norm(right)), 1e-9)
    return Pose(position, forward, np.cross(right, forward), fovy)


class SceneRenderer:
    """Renders a model with `marine_mj.water.add_scenery`, as seen from camera poses.

    A camera at the surface gets two passes, joined along the water line on its port (a disc of
    glass `port` m in front of the lens).

    Args:
        model: compiled, with scenery.
        wave_field: the sea, see `WaterSurface`.
        size: largest picture (width, height), pixels.
        port: distance of the glass, m.

    Raises:
        RenderError: no OpenGL, no scenery, or a size above the model's offscreen buffer.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        wave_field: Waves,
        size: tuple[int, int] = (960, 540),
        port: float = 0.35,
    ) -> None:
        buffer = model.vis.global_.offwidth, model.vis.global_.offheight
        if size[0] > buffer[0] or size[1] > buffer[1]:
            raise RenderError(
                f"size is {size}, the scene allows up to {buffer}: give add_scenery the size"
            )
        self.model, self.size, self.port = model, size, port
        self.water = WaterSurface(model, wave_field)
        self.waves = wave_field
        try:
            self._gl = make_context(*size)
            self._functions = importlib.import_module("OpenGL.GL")
            self._context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
        except Exception as error:
            status = gl_status()
            reason = (
                f"OpenGL works on this machine but not in this process ({error}): set MUJOCO_GL"
                " before anything imports OpenGL"
            )
            raise RenderError(reason if status else status.reason) from error
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        self._scene = mujoco.MjvScene(model, maxgeom=2 * model.ngeom + 500)
        self._option, self._camera = mujoco.MjvOption(), mujoco.MjvCamera()
        self._sun = model.light(SUN).id
        self._sides = [
            [model.geom(name).id for name in names] for names in ((TOP,), (UNDER, SEABED, BACKDROP))
        ]
        self._uploaded: dict[str, tuple] = {}

    def close(self) -> None:
        """Free the OpenGL context."""
        with contextlib.suppress(Exception):
            self._context.free()
        with contextlib.suppress(Exception):
            self._gl.free()

    def __enter__(self) -> "SceneRenderer":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def render(
        self,
        data: mujoco.MjData,
        pose: Pose,
        time: float,
        size: tuple[int, int] | None = None,
        around: Any = None,
        decor: Decor | None = None,
    ) -> Frame:
        """The picture (height, width, 3).

        Args:
            data: with kinematics done (`mj_forward`, or `mj_kinematics` and `mj_camlight`).
            pose: of the camera.
            time: of the sea, s.
            size: (width, height), default the renderer's.
            around: (2,) position that needs the fine part of the water sheet; default the
                camera's.
            decor: adds geoms to the scene before it is drawn.
        """
        self._gl.make_current()
        size = size or self.size
        self.water.update(time, pose.position if around is None else around)
        line = self._water_line(pose, time, size)
        if line is None:
            surface = elevation(self.waves, pose.position[0], pose.position[1], time)
            return self._one_side(data, pose, size, bool(pose.position[2] < surface), decor)
        above, below = (self._one_side(data, pose, size, under, decor) for under in (False, True))
        rows = np.arange(size[1])[:, None] - line[None, :]
        picture = np.where((rows < 0)[..., None], above, below)
        # The water climbs the glass a little: a dark edge with a light one above it.
        width = max(size[1] / 270, 1.0)
        edge = np.exp(-((rows / width - 0.8) ** 2))[..., None]
        return (picture * (1 - 0.55 * edge)).astype(np.uint8)

    def _water_line(self, pose: Pose, time: float, size: tuple[int, int]) -> NDArray | None:
        """Row (width,) in pixels of the water line on the port; None if the port is clear."""
        half = np.tan(np.deg2rad(pose.fovy) / 2)
        across = np.linspace(-1, 1, 25) * half * size[0] / size[1]
        point = pose.position + self.port * (pose.forward + across[:, None] * pose.right)
        above = point[:, 2] - elevation(self.waves, point[:, 0], point[:, 1], time)
        rise = self.port * half * max(float(pose.up[2]), 0.05)
        if np.all(above > rise) or np.all(above < -rise):
            return None
        row = (above / rise + 1) / 2 * size[1]
        return np.interp(np.linspace(-1, 1, size[0]), np.linspace(-1, 1, 25), row)

    def _one_side(
        self,
        data: mujoco.MjData,
        pose: Pose,
        size: tuple[int, int],
        under: bool,
        decor: Decor | None,
    ) -> Frame:
        side = UNDER if under else TOP
        self._look(under)
        self._upload(side, pose)
        self._place_camera(data, pose)
        if decor is not None:
            decor(self._scene)
        viewport = mujoco.MjrRect(0, 0, *size)
        mujoco.mjr_render(viewport, self._scene, self._context)
        picture = np.empty((size[1], size[0], 3), np.uint8)
        mujoco.mjr_readPixels(picture, None, viewport, self._context)
        picture = picture[::-1]
        return self._dim(picture, pose) if under else picture

    def _look(self, under: bool) -> None:
        """Light, haze and visible sides for a camera above or below the surface."""
        model, flags = self.model, self._scene.flags
        model.geom_group[self._sides[under]] = SHOWN
        model.geom_group[self._sides[not under]] = HIDDEN
        sun = (0.30, 0.52, 0.50) if under else (0.72, 0.69, 0.62)
        model.light_diffuse[self._sun] = sun
        model.light_specular[self._sun] = (0.15, 0.2, 0.2) if under else (0.5, 0.5, 0.45)
        # Light under water is diffuse and comes from above, whatever the sun's height.
        towards = (0.2, -0.2, 0.96) if under else self.water.palette.sun
        model.light_dir[self._sun] = -np.asarray(towards)
        headlight = model.vis.headlight
        headlight.ambient[:] = (0.42, 0.50, 0.50) if under else (0.40, 0.42, 0.45)
        headlight.diffuse[:] = (0.26, 0.32, 0.32) if under else (0.14, 0.14, 0.14)
        headlight.specular[:] = 0.1
        flags[mujoco.mjtRndFlag.mjRND_SHADOW] = 0
        flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = 0
        flags[mujoco.mjtRndFlag.mjRND_FOG] = under
        flags[mujoco.mjtRndFlag.mjRND_SKYBOX] = not under
        flags[mujoco.mjtRndFlag.mjRND_HAZE] = 0

    def _upload(self, side: str, pose: Pose) -> None:
        self._upload_texture(self.water.shade(side, pose.position))
        key = (self.water.time, *self.water.center)
        if self._uploaded.get(side) != key:
            mujoco.mjr_uploadMesh(self.model, self._context, self.water.mesh_id(side))
            self._uploaded[side] = key

    def _upload_texture(self, texture: int) -> None:
        """Like `mjr_uploadTexture` without the mipmaps, which the water must not have."""
        gl, model = self._functions, self.model
        height, width = int(model.tex_height[texture]), int(model.tex_width[texture])
        start = model.tex_adr[texture]
        pixels = model.tex_data[start : start + 3 * height * width]
        gl.glBindTexture(gl.GL_TEXTURE_2D, int(self._context.texture[texture]))
        gl.glTexParameteri(gl.GL_TEXTURE_2D, gl.GL_TEXTURE_MIN_FILTER, gl.GL_LINEAR)
        gl.glTexParameteri(gl.GL_TEXTURE_2D, gl.GL_TEXTURE_MAX_LEVEL, 0)
        gl.glPixelStorei(gl.GL_UNPACK_ALIGNMENT, 1)
        gl.glTexSubImage2D(
            gl.GL_TEXTURE_2D, 0, 0, 0, width, height, gl.GL_RGB, gl.GL_UNSIGNED_BYTE, pixels
        )

    def _place_camera(self, data: mujoco.MjData, pose: Pose) -> None:
        camera, scene = self._camera, self._scene
        camera.type = mujoco.mjtCamera.mjCAMERA_FREE
        camera.lookat[:], camera.distance = pose.position + pose.forward, 1.0
        camera.azimuth = np.rad2deg(np.arctan2(pose.forward[1], pose.forward[0]))
        camera.elevation = np.rad2deg(np.arcsin(np.clip(pose.forward[2], -1, 1)))
        # The sheet and the sun moved after the caller's kinematics.
        model = self.model
        for geom in self._sides[0] + self._sides[1]:
            data.geom_xpos[geom] = model.geom_pos[geom]
            data.geom_xmat[geom] = np.eye(3).ravel()
        data.light_xdir[self._sun] = model.light_dir[self._sun]
        everything = mujoco.mjtCatBit.mjCAT_ALL
        mujoco.mjv_updateScene(model, data, self._option, None, camera, everything, scene)
        near = model.vis.map.znear * model.stat.extent
        for view in scene.camera:
            view.pos[:], view.forward[:], view.up[:] = pose.position, pose.forward, pose.up
            view.frustum_near, view.frustum_far = near, model.vis.map.zfar * model.stat.extent
            view.frustum_top = near * np.tan(np.deg2rad(pose.fovy) / 2)
            view.frustum_bottom = -view.frustum_top
            view.frustum_center = view.frustum_width = 0

    def _dim(self, picture: Frame, pose: Pose) -> Frame:
        """Water looks brighter towards the surface and darker towards the deep."""
        rows = np.linspace(1, -1, picture.shape[0]) * np.tan(np.deg2rad(pose.fovy) / 2)
        up = pose.forward[2] + rows * pose.up[2]
        factor = np.clip(0.94 + 0.42 * up, 0.45, 1.0) - np.clip(-0.01 * pose.position[2], 0, 0.2)
        scale = (factor * 256).astype(np.uint16)[:, None, None]
        return ((picture * scale) >> 8).astype(np.uint8)
