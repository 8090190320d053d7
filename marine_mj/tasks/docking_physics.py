"""Physics with the vocabulary of docking: dock error, relative velocity, latch."""

from typing import Any

import mujoco
import numpy as np

from marine_mj import frames
from marine_mj.controllers import DockFrames, RigidState, pose_error, relative_velocity
from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.tasks.physics import MarinePhysics


class DockingPhysics(MarinePhysics):
    """Vocabulary of docking. The pair of vehicle and carrier comes from the latch's weld."""

    def _reload_from_data(self, data: Any) -> None:
        """Find latch, vehicle, carrier and dock by name."""
        super()._reload_from_data(data)
        model = self.model.ptr
        welds = [i for i in range(model.neq) if "/latch/" in model.equality(i).name]
        if not welds:
            raise ModelError("the scene has no latch: a vehicle needs dock = NAME")
        self.weld = welds[0]
        self.carrier, _, self.vehicle = model.equality(self.weld).name.split("/")
        self.dock_frames = self._dock_frames()

    def _dock_frames(self) -> DockFrames:
        """Sites of the dock in the carrier's axes."""
        model = self.model.ptr
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        body = self.main_body(self.carrier)
        rotation = data.xmat[body].reshape(3, 3)
        found = []
        for name in ("aperture", "seat"):
            site = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, f"{self.carrier}/dock/{name}")
            if site < 0:
                raise ModelError(f"the dock of {self.carrier!r} has no site {name!r}")
            quaternion = np.zeros(4)
            mujoco.mju_mat2Quat(
                quaternion, (rotation.T @ data.site_xmat[site].reshape(3, 3)).flatten()
            )
            found += [rotation.T @ (data.site_xpos[site] - data.xpos[body]), quaternion]
        return DockFrames(*found)

    def dock_states(self) -> tuple[RigidState, RigidState]:
        """States of the aperture frame and of the seat, NWU/FLU."""
        return self.remember(
            "dock", lambda: self.dock_frames.states(self.vehicle_state(self.carrier))
        )

    def dock_error(self) -> Array:
        """Seat pose minus vehicle pose (6,), in the vehicle's FLU axes, m and rad."""
        return self.remember(
            "dock_error",
            lambda: pose_error(self.dock_states()[1], self.vehicle_state(self.vehicle)),
        ).copy()

    def aperture_pose(self) -> Array:
        """Vehicle pose (6,) in the aperture frame: position m, rotation vector rad, FLU."""
        return pose_error(self.vehicle_state(self.vehicle), self.dock_states()[0])

    def relative_velocity(self) -> Array:
        """Velocity (6,) of the vehicle relative to the seat, in the vehicle's FLU axes."""
        return self.remember(
            "relative_velocity",
            lambda: relative_velocity(self.vehicle_state(self.vehicle), self.dock_states()[1]),
        ).copy()

    def relative_energy(self) -> float:
        """Kinetic energy of the relative motion with the dry mass, `0.5 dnu^T M_RB dnu` [J].

        Relative to the aperture frame, about the vehicle's origin (digest 7.0).
        """
        model = self.model.ptr
        body = self.main_body(self.vehicle)
        nu = relative_velocity(self.vehicle_state(self.vehicle), self.dock_states()[0])
        turn = frames.rotation_from_quaternion(model.body_iquat[body])
        inertia = turn @ np.diag(model.body_inertia[body]) @ turn.T
        at_center = nu[:3] + np.cross(nu[3:], model.body_ipos[body])
        mass = model.body_mass[body]
        return 0.5 * float(mass * at_center @ at_center + nu[3:] @ inertia @ nu[3:])

    def latched(self) -> bool:
        """Whether the latch is closed."""
        return bool(self.data.eq_active[self.weld])

    def close_latch(self) -> None:
        """Weld the vehicle to the dock in its present pose."""
        model, data = self.model.ptr, self.data.ptr
        mujoco.mj_kinematics(model, data)
        dock, body = model.eq_obj1id[self.weld], model.eq_obj2id[self.weld]
        rotation = data.xmat[dock].reshape(3, 3)
        inverse, relative = np.zeros(4), np.zeros(4)
        mujoco.mju_negQuat(inverse, data.xquat[dock])
        mujoco.mju_mulQuat(relative, inverse, data.xquat[body])
        weld = model.eq_data[self.weld]
        weld[0:3] = 0.0
        weld[3:6] = rotation.T @ (data.xpos[body] - data.xpos[dock])
        weld[6:10] = relative
        data.eq_active[self.weld] = 1
