"""Markers in pictures: where the controller steers to, and where it believes things to be.

They are decoration of the rendered scene (`mjvGeom`), not of the model: physics and the log know
nothing of them. A cross stands in world axes, axes turn with what they mark.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from marine_mj import frames
from marine_mj.replay import bracket, slerp

Array = NDArray[np.float64]
Color = tuple[float, float, float]

#: Colours: target, and the axes forward, port, up (as everywhere: red, green, blue).
TARGET: Color = (1.0, 0.35, 0.75)
AXES: tuple[Color, Color, Color] = ((1.0, 0.32, 0.25), (0.45, 1.0, 0.35), (0.35, 0.65, 1.0))
#: Radius of a bar, m; length of the arms behind the origin as part of those ahead.
_RADIUS, _BEHIND = 0.014, 0.5


@dataclass(frozen=True)
class Marker:
    """Something marked, for every frame; a frame in which it is NaN does not show it.

    Attributes:
        name: "target", "vehicle" or "goal".
        position: (n, 3) NWU, m.
        rotation: (n, 3, 3) its axes as columns, NWU; None for a cross in world axes.
        size: length of the arms, m.
    """

    name: str
    position: Array
    rotation: Array | None = None
    size: float = 0.4

    def bars(self, i: int) -> list[tuple[Array, Array, Color]]:
        """Ends and colour of the bars in frame `i`; nothing where it is not known."""
        position = self.position[i]
        if not np.all(np.isfinite(position)):
            return []
        if self.rotation is None:
            arms = self.size * np.eye(3)
            return [(position - arm, position + arm, TARGET) for arm in arms]
        if not np.all(np.isfinite(self.rotation[i])):
            return []
        # Arms behind the origin too: one of each pair looks out of the hull that it lies in.
        arms = self.size * self.rotation[i].T
        return [
            (position - _BEHIND * arm, position + arm, color)
            for arm, color in zip(arms, AXES, strict=True)
        ]


def docking_markers(model: mujoco.MjModel, data: Any, times: Array) -> tuple[Marker, ...]:
    """Markers of a docking log at `times` (n,) s; none for a log without a target.

    A cross where the controller steers to (`target_ned`), axes where it believes the vehicle's
    origin and the dock's aperture to be (`estimated_eta_ned`, `estimated_carrier_eta_ned`). There
    are none before the controller's first look, and none in open loop.

    Args:
        model: scene of the log, for the place of the aperture in its carrier.
        data: dataset of the log.
        times: of the frames.
    """
    if "target_ned" not in data or "estimated_eta_ned" not in data:
        return ()
    time = np.asarray(data["time"], float)
    before, after, weight = bracket(time, times)
    estimate = np.asarray(data["estimated_eta_ned"], float)
    looked = np.isfinite(estimate[:, :1])
    target = np.where(looked, frames.flip(np.asarray(data["target_ned"], float)), np.nan)
    # At a new waypoint the target jumps: it is not drawn on the way.
    phase = np.asarray(data["phase"], float) if "phase" in data else np.zeros(len(time))
    held = np.where(phase[before] == phase[after], weight, 0.0)
    position, quaternion = _pose(estimate, before, after, weight)
    markers = [
        Marker("target", _mix(target, before, after, held), size=0.3),
        Marker("vehicle", position, frames.rotation_from_quaternion(quaternion)),
    ]
    if "estimated_carrier_eta_ned" in data:
        carrier = np.asarray(data["estimated_carrier_eta_ned"], float)
        markers.append(_goal(model, *_pose(carrier, before, after, weight)))
    return tuple(markers)


def draw_markers(scene: mujoco.MjvScene, markers: Sequence[Marker], i: int) -> None:
    """Add the bars of all markers in frame `i` to a scene that has been updated."""
    for marker in markers:
        for start, end, color in marker.bars(i):
            # A full scene leaves decoration out.
            if scene.ngeom >= scene.maxgeom:
                return
            geom = scene.geoms[scene.ngeom]
            kind = mujoco.mjtGeom.mjGEOM_CAPSULE
            rgba = np.array([*color, 1.0], np.float32)
            mujoco.mjv_initGeom(geom, kind, np.zeros(3), np.zeros(3), np.eye(3).ravel(), rgba)
            mujoco.mjv_connector(geom, kind, _RADIUS, start, end)
            # They shine: a marker in the shadow of a hull is as readable as any.
            geom.emission, geom.specular = 0.8, 0.0
            geom.category = mujoco.mjtCatBit.mjCAT_DECOR
            scene.ngeom += 1


def _mix(values: Array, before: Array, after: Array, weight: Array) -> Array:
    """Values (n, k) linear between samples."""
    part = weight[:, None]
    # A weight of 0 must not bring in the NaN of the other sample.
    return np.where(part > 0, values[before] * (1 - part) + values[after] * part, values[before])


def _pose(eta: Array, before: Array, after: Array, weight: Array) -> tuple[Array, Array]:
    """Positions (n, 3) and quaternions (n, 4) between samples of a pose `eta` (m, 6), NED."""
    position, quaternion = frames.pose_from_eta(eta)
    turned = slerp(quaternion[before], quaternion[after], weight)
    return _mix(position, before, after, weight), turned


def _goal(model: mujoco.MjModel, position: Array, quaternion: Array) -> Marker:
    """The aperture as the believed pose of its carrier puts it."""
    from marine_mj.controllers import RigidState
    from marine_mj.tasks.docking_geometry import DockingGeometry

    carrier = RigidState(position, quaternion, np.zeros((len(position), 6)))
    aperture, _ = DockingGeometry.of(model).frames.states(carrier)
    return Marker("goal", aperture.position, aperture.rotation)
