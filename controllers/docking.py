"""The docking autopilot: guidance and pose control in one vectorised object."""

from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np
from marine_mj.controllers.cruise import CruiseGuidance
from marine_mj.controllers.demand import Demand, Preview
from marine_mj.controllers.kinematics import (
    AccelerationState,
    Accelerometer,
    RigidState,
    acceleration_at,
)
from marine_mj.controllers.mpc import Mpc
from marine_mj.controllers.prediction import Prediction, Predictor
from marine_mj.controllers.pursuit import PursuitGuidance
from marine_mj.controllers.station import StationGuidance
from marine_mj.controllers.waypoints import (
    DockingGuidance,
    GuidanceCommand,
    GuidanceState,
    Phase,
)

from marine_mj import trees
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


class Controller(Protocol):
    """A controller of the autopilot (`PosePid`, `Cpv`, `Cpva`, `Lqr`, `SlidingMode`, `Mpc`)."""

    def initial(self, shape: tuple[int, ...] = ()) -> Any:
        """State before the first update."""

    def update(self, state: Any, body: RigidState, demand: Demand) -> tuple[Array, Any]:
        """Wrench (..., 6) FLU at the body origin, and the next state.

        Args:
            state: state after the previous update.
            body: measured state of the vehicle.
            demand: what is asked of it.
        """

    def applied(self, state: Any, wrench: Array) -> Any:
        """State when the thrusters were asked for another wrench than `update` gave."""


@dataclass(frozen=True)
class PilotState:
    """Memory of the autopilot."""

    guidance: GuidanceState
    control: Any
    motion: AccelerationState
    prediction: Any = None
    preview: Any = None


@dataclass(frozen=True)
class DockingPilot:
    """Flies a vehicle into a dock, and out of it when the latch has opened.

    Attributes:
        controller: controller; its limits are those of the vehicle.
        frames: dock geometry.
        guidance: waypoint manager.
        period: time between updates, s.
        prediction: the controller acts on predicted states; None: on the present ones.
        preview: predictor of the carrier for a controller that looks ahead (`Mpc`).
        meter: how the acceleration of the carrier is found; None: smoothed, with a lead.
    """

    controller: Controller
    frames: DockFrames
    period: float
    guidance: DockingGuidance | StationGuidance | PursuitGuidance | CruiseGuidance = field(
        default_factory=DockingGuidance
    )
    prediction: Prediction | None = None
    preview: Predictor | None = None
    meter: Accelerometer | None = None

    def initial(self, shape: tuple[int, ...] = ()) -> PilotState:
        """State at the start of the approach, for a leading shape."""
        return PilotState(
            self.guidance.initial(shape),
            self.controller.initial(shape),
            self.accelerometer.initial(shape),
            None if self.prediction is None else self.prediction.initial(shape),
            None if self.preview is None else self.preview.initial(shape),
        )

    @property
    def accelerometer(self) -> Accelerometer:
        """How the acceleration of the carrier is found."""
        return Accelerometer(self.period) if self.meter is None else self.meter

    def applied(self, state: PilotState, wrench: Array) -> PilotState:
        """State when the thrusters were asked for another wrench (..., 6) than `update` gave."""
        return replace(state, control=self.controller.applied(state.control, wrench))

    def update(
        self,
        state: PilotState,
        vehicle: RigidState,
        carrier: RigidState,
        latched: Array,
        offset: Array | float = 0.0,
        carrier_acceleration: Array | None = None,
    ) -> tuple[Array, GuidanceCommand, PilotState]:
        """Wrench (..., 6) FLU at the vehicle's origin, the guidance command, the next state.

        Args:
            state: state after the previous update.
            vehicle: measured state of the vehicle.
            carrier: measured state of the body that carries the dock.
            latched: (...,) bool; thrust is off as long as it is.
            offset: (..., 3) shift of the goal, carrier axes FLU, m.
            carrier_acceleration: (..., 6) measured acceleration of the carrier, world axes NWU;
                None: from its velocity.
        """
        aperture, seat = self.frames.states(carrier, offset)
        command, guidance = self.guidance.update(
            state.guidance, vehicle, carrier, aperture, seat, latched, self.period
        )
        acceleration, motion = self.accelerometer.update(
            state.motion, carrier, carrier_acceleration
        )
        before = state.control
        released = (guidance.phase == Phase.LEAVE) & (state.guidance.phase == Phase.LATCHED)
        if np.any(released):  # what the latch did to the vehicle is no matter of the controller
            fresh = self.controller.initial(released.shape)
            before = trees.where(released, fresh, before)
        body, dock, target, prediction = vehicle, carrier, command.target, state.prediction
        if self.prediction is not None:
            body, dock, prediction = self.prediction.update(prediction, vehicle, carrier)
            target = self.guidance.target(guidance, dock, *self.frames.states(dock, offset))
        place = np.where(command.riding, dock.position, target.position)
        demand = Demand(
            target,
            command.scale,
            command.push,
            command.follow * acceleration_at(dock, acceleration, place) + command.acceleration,
            (guidance.phase == Phase.CONTACT)
            | ((guidance.phase == Phase.LEAVE) & (guidance.height >= 0)),
        )
        look = state.preview
        if isinstance(self.controller, Mpc) and self.preview is not None:
            look = self.preview.update(look, carrier)
            future = self._preview(self.controller, before, guidance, look, carrier, offset)
            demand = replace(demand, preview=future)
        wrench, control = self.controller.update(before, body, demand)
        off = (guidance.phase == Phase.LATCHED)[..., None]
        following = PilotState(guidance, control, motion, prediction, look)
        return np.where(off, 0.0, wrench), command, following

    def _preview(
        self,
        controller: Mpc,
        control: Any,
        guidance: GuidanceState,
        look: Any,
        carrier: RigidState,
        offset: Array | float,
    ) -> Preview | None:
        """What comes over the horizon of a controller; None when it does not plan now."""
        if self.preview is None or not controller.plans_now(control):
            return None
        times = controller.times.reshape(-1, *([1] * (carrier.position.ndim - 1)))
        future = self.preview.ahead(look, carrier, times)
        aperture, seat = self.frames.states(future, offset)
        plan = self.guidance.plan
        return Preview(
            target=self.guidance.target(guidance, future, aperture, seat),
            aperture=aperture,
            corridor=np.minimum(plan.corridor, plan.aperture),
            entering=guidance.phase == Phase.ENTER,
        )
