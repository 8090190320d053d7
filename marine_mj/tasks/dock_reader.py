"""Reading the state of a dock that hangs on its carrier by joints of its own."""

from dataclasses import dataclass

import mujoco
import numpy as np

from marine_mj import frames
from marine_mj.controllers import RigidState
from marine_mj.controllers.kinematics import rotate, unrotate
from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.tasks.reader import BodyReader


@dataclass(frozen=True)
class DockJoint:
    """A sliding or turning joint between carrier and dock.

    Attributes:
        qpos, qvel: indices of its coordinate.
        turns: whether it is a hinge.
        axis: (3,) unit vector, dock axes.
        anchor: (3,) point of a hinge's axis, dock axes, m.
        rest: coordinate in which the dock is where its model draws it, m or rad.
    """

    qpos: int
    qvel: int
    turns: bool
    axis: tuple[float, ...]
    anchor: tuple[float, ...]
    rest: float


@dataclass(frozen=True)
class DockReader:
    """Reads the state of a suspended dock from generalised coordinates of any leading shape.

    Attributes:
        carrier: reader of the carrier.
        position: (3,) dock origin in the carrier's axes FLU at rest, m.
        quaternion: (4,) its attitude there, wxyz.
        joints: from the carrier to the dock, in MuJoCo's order.
    """

    carrier: BodyReader
    position: Array
    quaternion: Array
    joints: tuple[DockJoint, ...]

    @classmethod
    def of(cls, model: mujoco.MjModel, body: int, carrier: int) -> "DockReader":
        """Reader of a dock body with slides and hinges that is a child of its carrier's body.

        Raises:
            ModelError: the dock hangs on another body or by another kind of joint.
        """
        name = model.body(body).name
        if model.body_parentid[body] != carrier:
            raise ModelError(
                f"the dock body {name!r} hangs on {model.body(model.body_parentid[body]).name!r}; "
                f"allowed is the main body of its carrier, {model.body(carrier).name!r}: put its "
                "joints on the root body of the dock's model"
            )
        joints = []
        first = int(model.body_jntadr[body])
        for j in range(first, first + int(model.body_jntnum[body])):
            kind = mujoco.mjtJoint(int(model.jnt_type[j]))
            if kind not in (mujoco.mjtJoint.mjJNT_SLIDE, mujoco.mjtJoint.mjJNT_HINGE):
                raise ModelError(
                    f"joint {model.joint(j).name!r} of the dock {name!r} is of type {kind.name}; "
                    "allowed are slide and hinge"
                )
            address = int(model.jnt_qposadr[j])
            joints.append(
                DockJoint(
                    qpos=address,
                    qvel=int(model.jnt_dofadr[j]),
                    turns=kind == mujoco.mjtJoint.mjJNT_HINGE,
                    axis=tuple(model.jnt_axis[j].tolist()),
                    anchor=tuple(model.jnt_pos[j].tolist()),
                    rest=float(model.qpos0[address]),
                )
            )
        return cls(
            carrier=BodyReader.of(model, carrier),
            position=model.body_pos[body].copy(),
            quaternion=model.body_quat[body].copy(),
            joints=tuple(joints),
        )

    def state(self, qpos: Array, qvel: Array) -> RigidState:
        """State of the dock body's origin, NWU/FLU."""
        carrier = self.carrier.state(qpos, qvel)
        shape = carrier.position.shape[:-1]
        position = np.broadcast_to(self.position, (*shape, 3))
        quaternion = np.broadcast_to(self.quaternion, (*shape, 4))
        slide, spin = np.zeros((*shape, 3)), np.zeros((*shape, 3))
        hinges = []  # (angular velocity, anchor) in the carrier's axes
        for joint in self.joints:
            turn = frames.rotation_from_quaternion(quaternion)
            axis = rotate(turn, np.array(joint.axis))
            way = (qpos[..., joint.qpos] - joint.rest)[..., None]
            rate = qvel[..., joint.qvel][..., None] * axis
            if not joint.turns:
                position = position + way * axis
                slide = slide + rate
                continue
            lever = np.array(joint.anchor)
            anchor = position + rotate(turn, lever)
            sine = np.sin(0.5 * way) * np.array(joint.axis)
            half = np.concatenate([np.cos(0.5 * way), sine], axis=-1)
            quaternion = frames.quaternion_multiply(quaternion, half)
            turn = frames.rotation_from_quaternion(quaternion)
            position = anchor - rotate(turn, lever)
            spin = spin + rate
            hinges.append((rate, anchor))
        for rate, anchor in hinges:
            slide = slide + frames.cross(rate, position - anchor)
        # moved with the carrier, and then by the joints
        carried = carrier.attached(position, quaternion)
        turn = frames.rotation_from_quaternion(quaternion)
        own = np.concatenate([unrotate(turn, slide), unrotate(turn, spin)], axis=-1)
        return RigidState(carried.position, carried.quaternion, carried.velocity + own)
