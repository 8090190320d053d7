"""Starting states of floating bodies: already moving with the sea instead of dropped into it."""

import mujoco
import numpy as np

from marine_mj import frames
from marine_mj.controllers import RigidState
from marine_mj.controllers.kinematics import rotate
from marine_mj.environment import WaveField
from marine_mj.hydrodynamics.raos import responses


def moving_with_waves(
    model: mujoco.MjModel, body: int, mean: RigidState, waves: WaveField, time: float
) -> RigidState:
    """State of a body whose motion RAOs are known, at its steady response to the waves.

    A body that starts at rest in a sea carries the missing velocity along as a drift that only
    damping takes away, slowly in surge.

    Args:
        model: compiled scene; the wave database is named by its text `BODY.wave_database`.
        body: id of the body.
        mean: its mean state: position, heading, and a velocity that is added.
        waves: wave field.
        time: s.

    Returns:
        `mean` itself if the body has no wave database or there are no waves.
    """
    name = f"{model.body(body).name}.wave_database"
    index = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_TEXT, name)
    if index < 0 or len(waves.omega) == 0:
        return mean
    start = model.text_adr[index]
    stored = bytes(model.text_data[start : start + model.text_size[index]])
    database = stored.rstrip(b"\0").decode()
    heading = float(mean.heading)
    X = responses(database, "motion", waves, heading)
    x, y = mean.position[:2]
    along = x * np.cos(waves.direction) + y * np.sin(waves.direction)
    phase = waves.wavenumber * along - waves.omega * time + waves.phase
    motion = X * np.exp(1j * phase)
    offset, rate = motion.sum(axis=1).real, (-1j * waves.omega * motion).sum(axis=1).real
    level = frames.rotation_from_quaternion(frames.quaternion_from_euler([0.0, 0.0, heading]))
    angle = np.linalg.norm(offset[3:])
    axis = offset[3:] / max(angle, 1e-12)
    turn = np.concatenate([[np.cos(angle / 2)], np.sin(angle / 2) * axis])
    # Small angles: turned about axes of the mean attitude.
    attitude = frames.quaternion_multiply(mean.quaternion, turn)
    linear = rotate(level, rate[:3]) + mean.linear_velocity
    rotation = frames.rotation_from_quaternion(attitude)
    velocity = np.concatenate([rotation.T @ linear, mean.velocity[3:] + rate[3:]])
    return RigidState(mean.position + rotate(level, offset[:3]), attitude, velocity)
