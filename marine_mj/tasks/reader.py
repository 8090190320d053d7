"""Reading and writing the state of a vehicle in generalised coordinates."""

from dataclasses import dataclass

import mujoco
import numpy as np

from marine_mj import frames
from marine_mj.controllers import RigidState
from marine_mj.controllers.kinematics import rotate, unrotate
from marine_mj.errors import ModelError
from marine_mj.frames import Array


@dataclass(frozen=True)
class BodyReader:
    """Reads the state of one root body from generalised coordinates of any leading shape.

    Works on `qpos` (..., nq) and `qvel` (..., nv), so it serves one simulation and a batch.

    Attributes:
        qpos: index of the body's first position coordinate.
        qvel: index of its first velocity coordinate.
        planar: whether it moves in its vertical plane only (x, z, pitch joints).
        position: (3,) start position of a planar body, NWU, m.
        quaternion: (4,) start attitude of a planar body, wxyz.
    """

    qpos: int
    qvel: int
    planar: bool
    position: Array
    quaternion: Array

    @classmethod
    def of(cls, model: mujoco.MjModel, body: int) -> "BodyReader":
        """Reader of a body with a free joint or the three planar joints.

        Raises:
            ModelError: the body moves in another way.
        """
        first = model.body_jntadr[body]
        kinds = [int(k) for k in model.jnt_type[first : first + model.body_jntnum[body]]]
        free = int(mujoco.mjtJoint.mjJNT_FREE)
        slide, hinge = int(mujoco.mjtJoint.mjJNT_SLIDE), int(mujoco.mjtJoint.mjJNT_HINGE)
        if kinds not in ([free], [slide, slide, hinge]):
            raise ModelError(
                f"body {model.body(body).name!r} has joints of types {kinds}: "
                "only a free joint or x, z, pitch (planar) can be read"
            )
        return cls(
            qpos=int(model.jnt_qposadr[first]),
            qvel=int(model.jnt_dofadr[first]),
            planar=len(kinds) == 3,
            position=model.body_pos[body].copy(),
            quaternion=model.body_quat[body].copy(),
        )

    def state(self, qpos: Array, qvel: Array) -> RigidState:
        """State of the body origin, NWU/FLU."""
        q, v = qpos[..., self.qpos :], qvel[..., self.qvel :]
        if not self.planar:
            quaternion = q[..., 3:7].copy()
            rotation = frames.rotation_from_quaternion(quaternion)
            linear = unrotate(rotation, v[..., :3])
            velocity = np.concatenate([linear, v[..., 3:6]], axis=-1)
            return RigidState(q[..., :3].copy(), quaternion, velocity)
        plane = frames.rotation_from_quaternion(self.quaternion)
        zero = np.zeros_like(q[..., 0])
        position = self.position + rotate(plane, np.stack([q[..., 0], zero, q[..., 1]], axis=-1))
        half = 0.5 * q[..., 2]
        pitch = np.stack([np.cos(half), zero, np.sin(half), zero], axis=-1)
        quaternion = frames.quaternion_multiply(self.quaternion, pitch)
        rotation = frames.rotation_from_quaternion(quaternion)
        linear = rotate(plane, np.stack([v[..., 0], zero, v[..., 1]], axis=-1))
        angular = np.stack([zero, v[..., 2], zero], axis=-1)
        velocity = np.concatenate([unrotate(rotation, linear), angular], axis=-1)
        return RigidState(position, quaternion, velocity)

    def write(self, qpos: Array, qvel: Array, state: RigidState) -> None:
        """Write a state into `qpos` (nq,) and `qvel` (nv,); a planar body takes what it can."""
        i, j = self.qpos, self.qvel
        if not self.planar:
            qpos[i : i + 3], qpos[i + 3 : i + 7] = state.position, state.quaternion
            qvel[j : j + 3], qvel[j + 3 : j + 6] = state.linear_velocity, state.velocity[3:]
            return
        plane = frames.rotation_from_quaternion(self.quaternion)
        moved = unrotate(plane, state.position - self.position)
        linear = unrotate(plane, state.linear_velocity)
        turn = frames.quaternion_multiply(
            frames.quaternion_conjugate(self.quaternion), state.quaternion
        )
        qpos[i : i + 3] = moved[0], moved[2], frames.rotation_vector(turn)[1]
        qvel[j : j + 3] = linear[0], linear[2], state.velocity[4]
