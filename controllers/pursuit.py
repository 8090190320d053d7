"""Guidance to one waypoint in the vertical plane, at rest or under way (docking digest 7.2)."""

from dataclasses import dataclass, field, replace

import numpy as np
from marine_mj.controllers.docking_plan import DockingPlan
from marine_mj.controllers.kinematics import RigidState
from marine_mj.controllers.station import StationGuidance
from marine_mj.controllers.waypoints import GuidanceCommand, GuidanceState

from marine_mj import frames
from marine_mj.frames import Array

#: Places of x, z, theta among the six degrees of freedom.
_PLANE = [0, 2, 4]


@dataclass(frozen=True)
class PursuitGuidance:
    """A target whose x, z, theta are parabolas of time: `pose + rate t + acceleration t^2 / 2`.

    Attributes:
        period: control period, s.
        pose: (..., 3) x, z, theta at the start, NED, m and rad; y and all other angles are 0.
        rate: (..., 3) m/s and rad/s.
        acceleration: (..., 3) m/s2 and rad/s2.
        plan: its aperture counts.
    """

    period: float
    pose: Array
    rate: Array
    acceleration: Array
    plan: DockingPlan = field(default_factory=DockingPlan)

    def initial(self, shape: tuple[int, ...] = ()) -> GuidanceState:
        """State at the start, for a leading shape; `waited` is its clock."""
        return StationGuidance(plan=self.plan).initial(shape)

    def update(
        self,
        state: GuidanceState,
        vehicle: RigidState,
        carrier: RigidState,
        aperture: RigidState,
        seat: RigidState,
        latched: Array,
        period: float,
    ) -> tuple[GuidanceCommand, GuidanceState]:
        """Command for the controller, and the state a period later; see `DockingGuidance`."""
        following = replace(state, waited=state.waited + period)
        gained = np.broadcast_to(self.acceleration, (*vehicle.position.shape[:-1], 3))
        acceleration = np.zeros_like(vehicle.velocity)
        acceleration[..., _PLANE] = gained
        command = GuidanceCommand(
            target=self.target(following, carrier, aperture, seat),
            scale=np.ones_like(vehicle.velocity),
            push=np.zeros_like(vehicle.position),
            entered=np.zeros(vehicle.position.shape[:-1], dtype=bool),
            follow=np.zeros_like(vehicle.velocity),
            acceleration=frames.flip(acceleration),
        )
        return command, following

    def target(
        self, state: GuidanceState, carrier: RigidState, aperture: RigidState, seat: RigidState
    ) -> RigidState:
        """State to reach at the last update; the carrier does not count."""
        t = np.asarray(state.waited - self.period)[..., None]
        shape = (*carrier.position.shape[:-1], 6)
        eta, rate = np.zeros(shape), np.zeros(shape)
        eta[..., _PLANE] = self.pose + t * (self.rate + 0.5 * t * self.acceleration)
        rate[..., _PLANE] = self.rate + t * self.acceleration
        position, quaternion = frames.pose_from_eta(eta)
        world = frames.flip(rate)
        rotation = frames.rotation_from_quaternion(quaternion)
        # The plane's axis of rotation is the same in world and body axes.
        linear = frames.apply_transposed(rotation, world[..., :3])
        return RigidState(position, quaternion, np.concatenate([linear, world[..., 3:]], axis=-1))
