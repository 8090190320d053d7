"""dm_control Physics of marine scenes: states of vehicles, actuation, contact forces."""

import contextlib
from collections.abc import Callable
from typing import Any, TypeVar

import mujoco
import numpy as np
from dm_control import mujoco as dm_mujoco
from dm_control.mujoco import wrapper
from dm_control.rl import control

from marine_mj import frames
from marine_mj.controllers import Allocator, Hydrostatics, Limits, RigidState
from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.hydrodynamics import table
from marine_mj.hydrodynamics.inertia import rigid_inertia
from marine_mj.hydrodynamics.low_frequency import states_before
from marine_mj.hydrodynamics.wrenches import added_mass_of, check_control, check_state, damping_of
from marine_mj.scene import at_origin, main_bodies
from marine_mj.tasks.reader import BodyReader

T = TypeVar("T")


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
        super()._reload_from_data(data)
        model = self.model.ptr
        sensor = model.sensor(table.CONTACT_SENSOR)
        self._contact_sensor = slice(int(sensor.adr[0]), int(sensor.adr[0] + sensor.dim[0]))
        self._contacts = np.zeros((1, table.CONTACT_VALUES))
        self._bodies = main_bodies(model)

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
        check_control(self.model.ptr, np.asarray(control), self.data.time)
        super().set_control(control)

    def step(self, nstep: int = 1) -> None:
        """Advance by `nstep` physics steps.

        Raises:
            SimulationError: the state diverged; names the time, the body and its state.
        """
        model, data = self.model.ptr, self.data.ptr
        self._contacts = np.zeros((nstep, table.CONTACT_VALUES))
        for number in range(nstep):
            mujoco.mj_step(model, data)
            self._contacts[number] = data.sensordata[self._contact_sensor]
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

    def contacts(self) -> Array:
        """Contact sensor (steps, 4) at every step of the last call of `step`.

        Columns: sum of normal forces between different vehicles (N), contacts of geoms whose name
        starts with `forbidden_`, power that contacts between vehicles take out of the motion (W),
        deepest overlap of their geoms (m).
        """
        return self._contacts.copy()

    @property
    def observed_states(self) -> int:
        """Number of activations that an observation shows: without low-frequency places."""
        return states_before(self.model.ptr)

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
        data = at_origin(model)
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

    def damping(self, instance: str, speed: float = 0.2, rate: float = 0.15) -> Array:
        """Slope (6, 6) of a vehicle's damping at a speed (m/s, rad/s), FLU, about its origin."""
        return damping_of(self.model.ptr, self.main_body(instance), speed, rate)

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
        data = at_origin(model)
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
