"""The docking autopilot: guidance and pose control in one vectorised object."""

from dataclasses import dataclass, field

import numpy as np
from marine_mj.controllers.kinematics import RigidState
from marine_mj.controllers.pid import PidState
from marine_mj.controllers.pose_pid import PosePid
from marine_mj.controllers.waypoints import (
    DockingGuidance,
    GuidanceCommand,
    GuidanceState,
    Phase,
)

from marine_mj.frames import Array


@dataclass(frozen=True)
class DockFrames:
    """Where a dock is on its carrier, in the carrier's FLU axes.

    Attributes:
        aperture: (3,) origin of the goal frame, m.
        aperture_quaternion: (4,) its attitude, wxyz.
        seat: (3,) where the origin of the docked vehicle is, m.
        seat_quaternion: (4,) attitude of the docked vehicle, wxyz.
    """

    aperture: Array
    aperture_quaternion: Array
    seat: Array
    seat_quaternion: Array

    def states(
        self, carrier: RigidState, offset: Array | float = 0.0
    ) -> tuple[RigidState, RigidState]:
        """States of aperture and seat; `offset` (..., 3) shifts both, carrier axes FLU, m."""
        return (
            carrier.attached(self.aperture + offset, self.aperture_quaternion),
            carrier.attached(self.seat + offset, self.seat_quaternion),
        )


@dataclass(frozen=True)
class PilotState:
    """Memory of the autopilot."""

    guidance: GuidanceState
    control: PidState


@dataclass(frozen=True)
class DockingPilot:
    """Flies a vehicle into a dock.

    Attributes:
        controller: pose controller; its limits are those of the vehicle.
        frames: dock geometry.
        guidance: waypoint manager.
        period: time between updates, s.
    """

    controller: PosePid
    frames: DockFrames
    period: float
    guidance: DockingGuidance = field(default_factory=DockingGuidance)

    def initial(self, shape: tuple[int, ...] = ()) -> PilotState:
        """State at the start of the approach, for a leading shape."""
        return PilotState(self.guidance.initial(shape), self.controller.initial(shape))

    def update(
        self,
        state: PilotState,
        vehicle: RigidState,
        carrier: RigidState,
        latched: Array,
        offset: Array | float = 0.0,
    ) -> tuple[Array, GuidanceCommand, PilotState]:
        """Wrench (..., 6) FLU at the vehicle's origin, the guidance command, the next state.

        Args:
            state: state after the previous update.
            vehicle: measured state of the vehicle.
            carrier: measured state of the body that carries the dock.
            latched: (...,) bool; thrust is off from then on.
            offset: (..., 3) shift of the goal, carrier axes FLU, m.
        """
        aperture, seat = self.frames.states(carrier, offset)
        command, guidance = self.guidance.update(
            state.guidance, vehicle, carrier, aperture, seat, latched, self.period
        )
        wrench, control = self.controller.update(
            state.control, vehicle, command.target, command.scale, command.push
        )
        off = (guidance.phase == Phase.LATCHED)[..., None]
        return np.where(off, 0.0, wrench), command, PilotState(guidance, control)
