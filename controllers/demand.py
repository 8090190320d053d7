"""What guidance asks of a controller at one update."""

from dataclasses import dataclass

import numpy as np
from marine_mj.controllers.kinematics import (
    RigidState,
    body_acceleration,
    pose_error,
    relative_velocity,
)
from numpy.typing import NDArray

from marine_mj.frames import Array


@dataclass(frozen=True)
class Preview:
    """What comes over the horizon; the first dimension runs over its N instants.

    Attributes:
        target: states to reach (N, ...), NWU/FLU.
        aperture: states of the aperture frame (N, ...), NWU/FLU.
        corridor: (2,) or (..., 2) half length and half width of the corridor at the aperture, m.
        entering: (...,) bool: the corridor counts; otherwise the clearance below the aperture.
    """

    target: RigidState
    aperture: RigidState
    corridor: Array
    entering: NDArray[np.bool_]


@dataclass(frozen=True)
class Demand:
    """A state to reach and how, for vehicles of one leading shape.

    Attributes:
        target: where the vehicle should be and how fast it should move there, NWU/FLU.
        scale: (..., 6) factor on the pose error per axis: 0 lets an axis go.
        push: (..., 3) extra force in world axes NWU, N.
        acceleration: (..., 6) acceleration of the target, world axes NWU, m/s2 and rad/s2.
        contact: (...,) bool: forces of contact act on the vehicle, observers forget.
        preview: what comes, for a controller that plans; None: it is not known or not needed now.
    """

    target: RigidState
    scale: Array | float = 1.0
    push: Array | float = 0.0
    acceleration: Array | float = 0.0
    contact: Array | bool = False
    preview: Preview | None = None

    @property
    def held(self) -> NDArray[np.bool_]:
        """Which axes (..., 6) are not let go."""
        return np.asarray(self.scale) != 0

    def error(self, body: RigidState) -> Array:
        """Scaled pose error (..., 6) of the vehicle, in its FLU axes, m and rad."""
        return pose_error(self.target, body) * self.scale

    def slip(self, body: RigidState) -> Array:
        """Velocity (..., 6) of the vehicle relative to the target, FLU; 0 in axes let go."""
        return relative_velocity(body, self.target) * self.held

    def rates(self, body: RigidState) -> Array:
        """Rates (..., 6) of `nu` with which the vehicle accelerates as the target does."""
        return body_acceleration(body, self.acceleration)
