"""A Scout that is pushed into a dock in plain MuJoCo, without water.

The push stands for thrust and net buoyancy, the damping for the drag; the restoring moments are
the Scout's own (6.13 N m/rad in roll and pitch, centre of buoyancy 1 cm above the origin).
"""

from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from marine_mj.hydrodynamics.contact_pairs import compile_dry

MODELS = Path(__file__).parents[2] / "models"
DAMPING = np.array([60.0, 120.0, 120.0, 2.0, 30.0, 30.0])  # N s/m, N m s; body axes
RESTORING = 6.13  # N m/rad


@dataclass(frozen=True)
class Pushed:
    """Where a pushed Scout ended, and what happened on the way.

    Attributes:
        distance: from the seat, m.
        angle: from the attitude of the seat, rad.
        forbidden: names of all forbidden geoms touched.
        deepest: deepest overlap, m; down to -0.02 m of it are compression of a soft layer.
        peak: largest sum of normal forces, N.
    """

    distance: float
    angle: float
    forbidden: set[str]
    deepest: float
    peak: float


def scene_with(dock: str) -> mujoco.MjModel:
    """The fixed USV with a dock and a free Scout in zero gravity; time step 5 ms."""
    scene = mujoco.MjSpec()
    scene.option.gravity = np.zeros(3)
    scene.option.timestep = 0.005
    scene.compiler.discardvisual = True
    usv = mujoco.MjSpec.from_file(str(MODELS / "dus_v5750" / "dus_v5750.xml"))
    usv.delete(usv.body("hull").first_joint())
    child = mujoco.MjSpec.from_file(str(MODELS / dock / f"{dock}.xml"))
    usv.attach(child, site="dock_mount", prefix="dock/")
    scene.attach(usv, frame=scene.worldbody.add_frame(), prefix="usv/")
    scout = mujoco.MjSpec.from_file(str(MODELS / "scout" / "scout.xml"))
    scene.attach(scout, frame=scene.worldbody.add_frame(), prefix="scout/")
    scene.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    return compile_dry(scene)


def push_in(model, position, push, duration, angles=(0.0, 0.0, 0.0), velocity=(0.0, 0.0, 0.0)):
    """A `Pushed` Scout.

    Start: position of the Scout from the USV's origin in m, angles in rad about its z-up axes,
    velocity in m/s, all (3,) like the push in N, world axes.
    """
    data = mujoco.MjData(model)
    data.qpos[:3], data.qvel[:3] = position, velocity
    mujoco.mju_euler2Quat(data.qpos[3:7], np.array(angles, dtype=float), "xyz")
    hull = model.body("scout/hull").id
    names = [model.geom(i).name.split("/")[-1] for i in range(model.ngeom)]
    forbidden, deepest, peak, wrench = set(), -0.02, 0.0, np.zeros(6)
    for _ in range(round(duration / model.opt.timestep)):
        rotation = data.xmat[hull].reshape(3, 3) if data.time else np.eye(3)
        twist = np.concatenate([rotation.T @ data.qvel[:3], data.qvel[3:]])
        drag = -DAMPING * twist
        up = rotation.T @ [0.0, 0.0, 1.0]
        data.qfrc_applied[:3] = rotation @ drag[:3] + push
        data.qfrc_applied[3:] = drag[3:] + RESTORING * np.cross([0.0, 0.0, 1.0], up)
        mujoco.mj_step(model, data)
        total = 0.0
        for number, (pair, gap) in enumerate(
            zip(data.contact.geom, data.contact.dist, strict=True)
        ):
            deepest = max(deepest, -gap)
            mujoco.mj_contactForce(model, data, number, wrench)
            total += wrench[0]
            forbidden |= {names[g] for g in pair if names[g].startswith("forbidden_")}
        peak = max(peak, total)
    distance = np.linalg.norm(data.xpos[hull] - data.site("usv/dock/seat").xpos)
    angle = 2 * np.arccos(np.clip(abs(data.xquat[hull, 0]), 0.0, 1.0))
    return Pushed(float(distance), float(angle), forbidden, deepest, peak)
