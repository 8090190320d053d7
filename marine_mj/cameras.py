"""Camera paths for whole runs: they know the future, so they follow smoothly and without lag.

`chase`: behind and above a vehicle. `side`: abeam of it. `dock`: under water beside the docking
station, with station and approaching vehicle in the picture. `close`: the same nearer, for small
pictures. `split`: the same at the surface, half above and half below. Any other name is a camera of
the model.
"""

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from marine_mj.errors import RenderError
from marine_mj.rendering import Pose, look_at
from marine_mj.replay import States, place
from marine_mj.water import Waves, elevation

Array = NDArray[np.float64]

#: Cameras that exist in every scene.
CAMERAS = ("chase", "side", "dock", "close", "split")
#: Smallest distance between a camera and the water surface, m.
CLEARANCE = 0.6


@dataclass(frozen=True)
class Actor:
    """A followed body over time: position (n, 3), unit heading (n, 2), NWU; size in m."""

    position: Array
    heading: Array
    radius: float


def moving_bodies(model: mujoco.MjModel) -> list[int]:
    """Bodies that move in the world on their own, in model order: the vehicles."""
    return [
        body
        for body in range(1, model.nbody)
        if model.body_parentid[body] == 0
        and (model.body_dofnum[body] > 0 or model.body_mocapid[body] >= 0)
    ]


def dock_site(model: mujoco.MjModel) -> int | None:
    """Site `aperture` of the first docking station, if there is one."""
    for site in range(model.nsite):
        if model.site(site).name.split("/")[-1] == "aperture":
            return site
    return None


def body_radius(model: mujoco.MjModel, body: int) -> float:
    """Radius in m about the body's origin that holds the geoms of its tree (at rest)."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    geoms = np.flatnonzero(model.body_rootid[model.geom_bodyid] == model.body_rootid[body])
    distance = np.linalg.norm(data.geom_xpos[geoms] - data.xpos[body], axis=1)
    return float(np.max(distance + model.geom_rbound[geoms], initial=0.5))


def camera_poses(
    model: mujoco.MjModel,
    states: States,
    waves: Waves,
    camera: str,
    follow: str | None = None,
) -> list[Pose]:
    """Poses of `camera` for every state.

    Args:
        model: the scene.
        states: of the run, at the times of the frames.
        waves: the sea; keeps cameras out of the surface.
        camera: one of `CAMERAS` or a camera of the model.
        follow: body that `chase` and `side` follow and the others watch. Default: for `chase` and
            `side` the carrier of the docking station, or else the first vehicle; for the others
            the first vehicle that is not the carrier.

    Raises:
        RenderError: unknown camera or body, or a scene without vehicles.
    """
    fixed = {model.camera(i).name: i for i in range(model.ncam)}
    data = mujoco.MjData(model)
    if camera in fixed:
        return _fixed_poses(model, data, states, fixed[camera])
    if camera not in CAMERAS:
        raise RenderError(f"camera is '{camera}', available are {', '.join([*CAMERAS, *fixed])}")
    bodies = moving_bodies(model)
    if not bodies:
        raise RenderError(f"camera '{camera}' follows a vehicle, the scene has none")
    site = dock_site(model)
    carrier = int(model.body_rootid[model.site_bodyid[site]]) if site is not None else bodies[0]
    others = [body for body in bodies if body != carrier] or [carrier]
    main = carrier if camera in ("chase", "side") else others[0]
    if follow is not None:
        named = {model.body(i).name: i for i in range(model.nbody)}
        if follow not in named:
            names = ", ".join(model.body(body).name for body in bodies)
            raise RenderError(f"follow is '{follow}', vehicles are {names}")
        main = named[follow]
    if camera in ("chase", "side"):
        return _follow(_actors(model, data, states, [main])[0], states, waves, camera == "side")
    actors = _actors(model, data, states, [main, carrier])
    goal = _site_path(model, data, states, site) if site is not None else actors[1].position
    return _watch(actors[0], actors[1], goal, states, waves, camera)


def _fixed_poses(
    model: mujoco.MjModel, data: mujoco.MjData, states: States, camera: int
) -> list[Pose]:
    poses = []
    for i in range(len(states)):
        place(model, data, states, i)
        axes = data.cam_xmat[camera].reshape(3, 3)
        fovy = float(model.cam_fovy[camera])
        poses.append(Pose(data.cam_xpos[camera].copy(), -axes[:, 2], axes[:, 1].copy(), fovy))
    return poses


def _actors(
    model: mujoco.MjModel, data: mujoco.MjData, states: States, bodies: list[int]
) -> list[Actor]:
    position = np.empty((len(bodies), len(states), 3))
    heading = np.empty((len(bodies), len(states), 2))
    for i in range(len(states)):
        place(model, data, states, i)
        position[:, i] = data.xpos[bodies]
        heading[:, i] = data.xmat[bodies].reshape(-1, 3, 3)[:, :2, 0]
    return [
        Actor(p, h, body_radius(model, body))
        for p, h, body in zip(position, heading, bodies, strict=True)
    ]


def _site_path(model: mujoco.MjModel, data: mujoco.MjData, states: States, site: int) -> Array:
    path = np.empty((len(states), 3))
    for i in range(len(states)):
        place(model, data, states, i)
        path[i] = data.site_xpos[site]
    return path


def smooth(values: Array, states: States, seconds: float) -> Array:
    """Values (n, ...) averaged over a Gaussian of standard deviation `seconds`, without lag.

    Where frames are not equally far apart (slow motion) the average is taken on a grid that is.
    """
    values, time = np.asarray(values, float), states.time
    if len(states) < 3:
        return values
    steps = np.diff(time)
    step = max(float(np.max(steps)), 1e-6)
    if np.ptp(steps) < 1e-6:
        return gaussian_filter1d(values, seconds / step, axis=0, mode="nearest")
    grid = np.linspace(time[0], time[-1], max(round((time[-1] - time[0]) / step), 1) + 1)
    columns = values.reshape(len(time), -1).T
    even = np.stack([np.interp(grid, time, column) for column in columns], axis=1)
    even = gaussian_filter1d(even, seconds * (len(grid) - 1) / np.ptp(grid), axis=0, mode="nearest")
    return np.stack([np.interp(time, grid, column) for column in even.T], 1).reshape(values.shape)


def _unit(vectors: Array) -> Array:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-9)


def _turned(heading: Array, angle_deg: float) -> Array:
    """Headings (n, 2) turned counter-clockwise (to port)."""
    c, s = np.cos(np.deg2rad(angle_deg)), np.sin(np.deg2rad(angle_deg))
    return np.stack(
        [c * heading[:, 0] - s * heading[:, 1], s * heading[:, 0] + c * heading[:, 1]], 1
    )


def _sea_level(waves: Waves, position: Array, states: States) -> Array:
    """Elevation (n,) at a moving point."""
    return np.array(
        [elevation(waves, p[0], p[1], t) for p, t in zip(position, states.time, strict=True)]
    )


def _follow(actor: Actor, states: States, waves: Waves, abeam: bool) -> list[Pose]:
    target = smooth(actor.position, states, 1.2)
    heading = _unit(smooth(actor.heading, states, 1.5 if not abeam else 20.0))
    direction = _turned(heading, -90.0 if abeam else 152.0)
    reach = 2.3 * actor.radius + 0.5
    position = np.empty_like(target)
    position[:, :2] = target[:, :2] + reach * direction
    position[:, 2] = target[:, 2] + (0.22 if abeam else 0.36) * reach
    level = _sea_level(waves, position, states)
    # A vehicle deeper than its own size is filmed from below the surface, any other from above.
    if np.median(actor.position[:, 2]) < -(actor.radius + 0.5):
        position[:, 2] = np.minimum(position[:, 2], level - CLEARANCE)
    else:
        position[:, 2] = np.maximum(position[:, 2], level + CLEARANCE)
    position[:, 2] = smooth(position[:, 2], states, 0.3)
    return [look_at(p, t) for p, t in zip(position, target, strict=True)]


def _watch(
    actor: Actor, carrier: Actor, goal: Array, states: States, waves: Waves, camera: str
) -> list[Pose]:
    """Beside the dock, far enough off to have vehicle and dock in the picture, and the hull above
    unless `camera` is "close"."""
    near, dock = smooth(actor.position, states, 1.0), smooth(goal, states, 1.2)
    middle = 0.5 * (near + dock)
    apart = np.linalg.norm(near - dock, axis=1)
    heading = _unit(smooth(carrier.heading, states, 6.0))
    share = 0.0 if camera == "close" else 0.55
    reach = 1.9 * actor.radius + share * carrier.radius + 0.8 * smooth(apart, states, 2.0) + 0.6
    position = np.empty_like(middle)
    position[:, :2] = middle[:, :2] + reach[:, None] * _turned(heading, -68.0)
    position[:, 2] = smooth(np.minimum(near[:, 2], dock[:, 2]) - 0.12 * reach, states, 1.5)
    level = _sea_level(waves, position, states)
    if camera == "split":
        position[:, 2] = smooth(level, states, 0.25)
        target = middle * [1, 1, 0.35]
        return [look_at(p, t, 55.0) for p, t in zip(position, target, strict=True)]
    position[:, 2] = smooth(np.minimum(position[:, 2], level - CLEARANCE), states, 0.3)
    target = middle + np.array([0, 0, 0.25])
    return [look_at(p, t, 50.0) for p, t in zip(position, target, strict=True)]
