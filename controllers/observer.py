"""What a model-based controller knows of its vehicle, and an observer of what else acts on it.

The observer matters in waves: the water carries a vehicle about as it carries the dock above it, so
a feed-forward of the dock's acceleration alone would push twice. Wrenches and velocities are in
body axes FLU at the body origin.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from marine_mj.controllers.kinematics import RigidState
from marine_mj.controllers.pid import Limits

from marine_mj import frames
from marine_mj.errors import ScenarioError
from marine_mj.frames import Array


@dataclass(frozen=True)
class VehicleModel:
    """What a model-based controller knows of the vehicle.

    Attributes:
        inertia: (6, 6) rigid-body and added inertia about the body origin, FLU.
        lag: time constant of the thrusters, s (0: none).
        observer: time constant of the disturbance observer, s.
        observer_limit: largest disturbance believed, as a share of the wrench limits.
        damping: (6, 6) linearised drag, FLU, N s/m ... (0: left to the observer).
    """

    inertia: Array
    lag: float = 0.15
    observer: float = 0.3
    observer_limit: float = 1.0
    damping: Array = field(default_factory=lambda: np.zeros((6, 6)))

    def __post_init__(self) -> None:
        """Raise ScenarioError for a time that cannot be."""
        if not (np.all(np.asarray(self.lag) >= 0) and np.all(np.asarray(self.observer) > 0)):
            raise ScenarioError(
                f"thruster lag must be >= 0 s and observer > 0 s, got {self.lag}, {self.observer}"
            )


@dataclass(frozen=True)
class ObserverState:
    """Memory of the observer.

    Attributes:
        asked: (..., 6) wrench the thrusters were asked for at the last update, FLU.
        thrust: (..., 6) wrench they give by now, FLU.
        seen: (..., 6) velocity of the vehicle at the last update, FLU; NaN before the first one.
        disturbance: (..., 6) what acts on the vehicle besides thrust and hydrostatics (drag too).
    """

    asked: Array
    thrust: Array
    seen: Array
    disturbance: Array

    @classmethod
    def initial(cls, shape: tuple[int, ...] = ()) -> "ObserverState":
        """State before the first update, for a leading shape."""
        zero = np.zeros((*shape, 6))
        return cls(zero, zero, np.full((*shape, 6), np.nan), zero)

    def asked_for(self, wrench: Array) -> "ObserverState":
        """State when the thrusters are asked for a wrench (..., 6)."""
        return replace(self, asked=np.asarray(wrench, dtype=float))


def observe(
    model: VehicleModel,
    limits: Limits,
    period: float,
    state: ObserverState,
    body: RigidState,
    statics: Array,
    contact: Array | bool = False,
) -> ObserverState:
    """State with the thrust by now and the disturbance of the last period, low-passed.

    `d = M dnu/dt - thrust + statics`, with the thrust through a first-order lag.

    Args:
        model: of the vehicle.
        limits: of the wrench, FLU.
        period: since the last update, s.
        state: state after the last update.
        body: measured state of the vehicle.
        statics: (..., 6) wrench that cancels weight and buoyancy.
        contact: (...,) bool: forces of contact act on the vehicle, the observer forgets.
    """
    with np.errstate(divide="ignore"):
        share = -np.expm1(-period / np.asarray(model.lag, dtype=float))[..., None]
    thrust = state.thrust + share * (state.asked - state.thrust)
    first = np.isnan(state.seen)
    gained = np.where(first, 0.0, (body.velocity - state.seen) / period)
    # Hydrostatics push with minus what cancels them.
    mean_thrust = 0.5 * (thrust + state.thrust)
    found = frames.apply(model.inertia, gained) - mean_thrust + statics
    found = np.where(first, state.disturbance, found)
    found = np.where(np.asarray(contact)[..., None], 0.0, found)
    step = -np.expm1(-period / np.asarray(model.observer))[..., None]
    disturbance = state.disturbance + step * (found - state.disturbance)
    most = np.asarray(model.observer_limit)[..., None]
    disturbance = np.clip(disturbance, most * limits.low, most * limits.high)
    return ObserverState(state.asked, thrust, body.velocity, disturbance)
