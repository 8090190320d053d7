"""dm_control Physics of marine scenes: states of vehicles, actuation, contact forces."""

import contextlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

import mujoco
import numpy as np
from dm_control import mujoco as dm_mujoco
from dm_control.mujoco import wrapper
from dm_control.rl import control

from marine_mj import frames
from marine_mj.controllers import Allocator, Hydrostatics, Limits, RigidState
from marine_mj.controllers.kinematics import rotate, unrotate
from marine_mj.errors import ModelError, SimulationError
from marine_mj.frames import Array
from marine_mj.hydrodynamics import table
from marine_mj.hydrodynamics.inertia import rigid_inertia
from marine_mj.hydrodynamics.wrenches import added_mass_of, check_state

T = TypeVar("T")


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


class MarinePhysics(dm_mujoco.Physics):
    """Physics of a scene compiled by marine_mj.

    Steps with `mj_step` one at a time, so that contact forces are seen at every physics step.
    All answers are computed from the generalised coordinates, which are never stale.
    """

    @classmethod
    def from_mjmodel(cls, model: mujoco.MjModel) -> "MarinePhysics":
        """Physics of a compiled model."""
        return cls.from_model(wrapper.MjModel(model))

    def _reload_from_data(self, data: wrapper.MjData) -> None:
        """Set up names and addresses; called on construction, copy and unpickling."""
        self._readers: dict[int, BodyReader] = {}
        self._memory: dict[str, Any] = {}
        self._memory_key = b""
        self._peak_force = 0.0
        super()._reload_from_data(data)
        model = self.model.ptr
        roots = [b for b in range(1, model.nbody) if model.body_parentid[b] == 0]
        named = [b for b in roots if "/" in model.body(b).name]
        sensor = model.sensor(table.CONTACT_SENSOR)
        self._contact_sensor = slice(int(sensor.adr[0]), int(sensor.adr[0] + sensor.dim[0]))
        self._bodies = {model.body(b).name.split("/")[0]: b for b in named}

    @property
    def vehicles(self) -> tuple[str, ...]:
        """Instance names of the vehicles."""
        return tuple(self._bodies)

    def main_body(self, instance: str) -> int:
        """Id of the main body of a vehicle.

        Raises:
            ModelError: there is no such vehicle; the message lists them.
        """
        if instance not in self._bodies:
            raise ModelError(f"no vehicle {instance!r}; there are: {', '.join(self._bodies)}")
        return self._bodies[instance]

    def reader(self, instance: str) -> BodyReader:
        """Reader of a vehicle's state."""
        body = self.main_body(instance)
        if body not in self._readers:
            self._readers[body] = BodyReader.of(self.model.ptr, body)
        return self._readers[body]

    def vehicle_state(self, instance: str) -> RigidState:
        """State of a vehicle's main body at its origin, NWU/FLU."""
        return self.remember(
            instance, lambda: self.reader(instance).state(self.data.qpos, self.data.qvel)
        )

    def remember(self, name: str, compute: Callable[[], T]) -> T:
        """Result of `compute`, kept as long as positions and velocities do not change."""
        key = self.data.qpos.tobytes() + self.data.qvel.tobytes()
        if key != self._memory_key:
            self._memory, self._memory_key = {}, key
        if name not in self._memory:
            self._memory[name] = compute()
        return self._memory[name]

    def eta_ned(self, instance: str) -> Array:
        """Pose `eta` (6,) in NED, m and rad."""
        state = self.vehicle_state(instance)
        return frames.eta_ned(state.position, state.quaternion)

    def nu_frd(self, instance: str) -> Array:
        """Velocity `nu` (6,) in body axes FRD, m/s and rad/s."""
        return frames.flip(self.vehicle_state(instance).velocity)

    def set_control(self, control: Array) -> None:
        """Set the actuator commands.

        Raises:
            SimulationError: a command is NaN or infinite; names the actuator and the time.
        """
        bad = np.flatnonzero(~np.isfinite(control))
        if bad.size:
            name = self.model.ptr.actuator(int(bad[0])).name
            raise SimulationError(
                f"control of actuator {name!r} is {np.asarray(control).flat[bad[0]]} at t = "
                f"{self.data.time:.3f} s: the controller must give finite commands"
            )
        super().set_control(control)

    def step(self, nstep: int = 1) -> None:
        """Advance by `nstep` physics steps.

        Raises:
            SimulationError: the state diverged; names the time, the body and its state.
        """
        model, data = self.model.ptr, self.data.ptr
        self._peak_force = 0.0
        for _ in range(nstep):
            mujoco.mj_step(model, data)
            self._peak_force = max(self._peak_force, self.contact_force())
        self.check_state()

    @contextlib.contextmanager
    def check_invalid_state(self):
        """Turn MuJoCo's warnings about invalid states into errors that name the state."""
        try:
            with super().check_invalid_state():
                yield
        except control.PhysicsError:
            self.check_state()
            raise

    def check_state(self) -> None:
        """Raise SimulationError if the state is not finite or MuJoCo reported divergence."""
        check_state(self.model.ptr, self.data.ptr)

    def contact_force(self) -> float:
        """Sum of normal forces between bodies of different vehicles at the last step, N."""
        return float(self._contacts()[0])

    def peak_contact_force(self) -> float:
        """Largest `contact_force` during the last call of `step`, N."""
        return self._peak_force

    def forbidden_contact(self) -> bool:
        """Whether a geom whose name starts with `forbidden_` was touched at the last step."""
        return bool(self._contacts()[1] > 0)

    def _contacts(self) -> Array:
        """Values (2,) of the scene's contact sensor."""
        return self.data.sensordata[self._contact_sensor]

    def actuators(self, instance: str) -> Array:
        """Ids of a vehicle's actuators."""
        model = self.model.ptr
        prefix = f"{instance}/"
        return np.array(
            [i for i in range(model.nu) if model.actuator(i).name.startswith(prefix)], dtype=int
        )

    def allocator(self, instance: str) -> Allocator:
        """Allocation of a wrench (FLU, at the main body's origin) to the vehicle's actuators."""
        model = self.model.ptr
        ids = self.actuators(instance)
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        body = self.main_body(instance)
        origin, rotation = data.xpos[body], data.xmat[body].reshape(3, 3)
        columns = []
        for i in ids:
            if model.actuator_trntype[i] != mujoco.mjtTrn.mjTRN_SITE:
                raise ModelError(
                    f"actuator {model.actuator(i).name!r} does not act on a site: no allocation"
                )
            site = model.actuator_trnid[i, 0]
            turn = rotation.T @ data.site_xmat[site].reshape(3, 3)
            arm = rotation.T @ (data.site_xpos[site] - origin)
            force, torque = turn @ model.actuator_gear[i, :3], turn @ model.actuator_gear[i, 3:]
            gain = model.actuator_gainprm[i, 0]
            columns.append(gain * np.concatenate([force, torque + np.cross(arm, force)]))
        span = model.actuator_ctrlrange[ids]
        return Allocator(np.array(columns).T, Limits(span[:, 0], span[:, 1]))

    def inertia(self, instance: str) -> Array:
        """Rigid-body and added inertia (6, 6) of a vehicle's main body about its origin, FLU."""
        model, body = self.model.ptr, self.main_body(instance)
        return rigid_inertia(model, body) + added_mass_of(model, body)

    def thruster_lag(self, instance: str) -> float:
        """Longest time constant of a vehicle's actuators with first-order dynamics, s; 0: none."""
        model, ids = self.model.ptr, self.actuators(instance)
        first_order = (mujoco.mjtDyn.mjDYN_FILTER, mujoco.mjtDyn.mjDYN_FILTEREXACT)
        lags = [
            model.actuator_dynprm[i, 0] for i in ids if model.actuator_dyntype[i] in first_order
        ]
        return float(max(lags, default=0.0))

    def hydrostatics(self, instance: str, water_density: float) -> Hydrostatics:
        """Weight and buoyancy of a vehicle in still water, fully submerged."""
        model = self.model.ptr
        body = self.main_body(instance)
        name = model.body(body).name
        gravity = float(np.linalg.norm(model.opt.gravity))
        volume, buoyancy = _numeric(model, f"{name}.displaced_volume"), 0.0
        if volume is not None:
            buoyancy = float(water_density * gravity * volume[0])
        published = _numeric(model, f"{name}.buoyancy")
        if published is not None:
            buoyancy = float(published[0])
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        rotation = data.xmat[body].reshape(3, 3)
        gravity_center = rotation.T @ (data.subtree_com[body] - data.xpos[body])
        site = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, f"{name}.center_of_buoyancy")
        center = gravity_center
        if site >= 0:
            center = rotation.T @ (data.site_xpos[site] - data.xpos[body])
        weight = float(gravity * model.body_subtreemass[body])
        return Hydrostatics(weight, buoyancy, gravity_center, center)


def _numeric(model: mujoco.MjModel, name: str) -> Array | None:
    """Values of a named numeric, None if there is none."""
    index = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_NUMERIC, name)
    return None if index < 0 else model.numeric(index).data.copy()
