"""Sliding mode with a boundary layer in six axes (Slotine and Li 1991, section 7.2; Fossen 2021).

The surface is `s = v - (nu - nu_t)` with `v = lambda e` limited: on it the pose error decays at
`lambda`. The equivalent wrench keeps the vehicle on the surface as far as model and observer know
it, the switching part brings it back; inside the boundary layer it is proportional, because
thrusters that lag would chatter. Body axes FLU at the body origin.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from marine_mj.controllers.demand import Demand
from marine_mj.controllers.hydrostatics import Hydrostatics, steady_wrench
from marine_mj.controllers.kinematics import RigidState, pose_error
from marine_mj.controllers.observer import ObserverState, VehicleModel, observe
from marine_mj.controllers.pid import Limits, hold_positive

from marine_mj import frames
from marine_mj.frames import Array


@dataclass(frozen=True)
class SlidingGains:
    """Surface and reaching law per axis, (6,) or (..., 6), all > 0.

    Attributes:
        rate: `lambda`, at which the pose error decays on the surface, 1/s.
        speed: largest speed towards the target, m/s and rad/s.
        reach: `eta`, acceleration towards the surface outside the boundary layer, m/s2, rad/s2.
        layer: `phi`, half width of the boundary layer, m/s and rad/s.
    """

    rate: Array | Sequence[float]
    speed: Array | Sequence[float]
    reach: Array | Sequence[float]
    layer: Array | Sequence[float]

    def __post_init__(self) -> None:
        """Raise ScenarioError for a value that is not positive."""
        hold_positive(self, "sliding mode", "rate", "speed", "reach", "layer")


SLIDING_GAINS = {
    # Ours: reach over layer is the bandwidth inside the layer, 2 to 3 rad/s with thrusters that
    # lag by 0.15 s; the reach is about three quarters of what the thrusters can give.
    "extended": SlidingGains(
        rate=[1.0, 1.0, 1.0, 1.5, 1.2, 1.0],
        speed=[0.8, 0.35, 0.3, 0.5, 0.5, 0.5],
        reach=[1.5, 0.4, 0.4, 6.0, 0.6, 0.6],
        layer=[0.5, 0.16, 0.16, 1.5, 0.21, 0.21],
    ),
}


@dataclass(frozen=True)
class SlidingMode:
    """`tau = M (nu_t' + lambda e' + eta sat(s / phi)) - d` plus hydrostatics, clipped.

    Attributes:
        gains: surface and reaching law.
        limits: of the wrench, FLU.
        period: time between two updates, s.
        model: wet inertia, thruster lag and observer.
        hydrostatics: weight and buoyancy to cancel, None to leave them to the observer.
    """

    gains: SlidingGains
    limits: Limits
    period: float
    model: VehicleModel
    hydrostatics: Hydrostatics | None = None

    def initial(self, shape: tuple[int, ...] = ()) -> ObserverState:
        """State before the first update, for a leading shape."""
        return ObserverState.initial(shape)

    def applied(self, state: ObserverState, wrench: Array) -> ObserverState:
        """State when the thrusters were asked for another wrench (..., 6) than `update` gave."""
        return state.asked_for(wrench)

    def update(
        self, state: ObserverState, body: RigidState, demand: Demand
    ) -> tuple[Array, ObserverState]:
        """Wrench (..., 6) FLU at the body origin, and the next state; see `Controller.update`."""
        gains = self.gains
        rate, speed = np.asarray(gains.rate), np.asarray(gains.speed)
        statics, feed_forward = steady_wrench(self.hydrostatics, body, demand.push)
        state = observe(self.model, self.limits, self.period, state, body, statics, demand.contact)
        slip = demand.slip(body)
        free = rate * pose_error(demand.target, body) * demand.scale
        wanted = np.minimum(np.maximum(free, -speed), speed)
        # On the surface the wanted speed changes as the error does, where it is not limited.
        change = np.where(wanted == free, -rate * slip, 0.0)
        pull = np.clip((wanted - slip) / gains.layer, -1.0, 1.0) * gains.reach
        rates = demand.rates(body) + change + pull
        wrench = feed_forward + frames.apply(self.model.inertia, rates) - state.disturbance
        wrench = self.limits.clip(wrench)
        return wrench, state.asked_for(wrench)
