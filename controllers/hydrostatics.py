"""Weight and buoyancy of a submerged vehicle, as its controllers cancel them."""

from dataclasses import dataclass

import numpy as np
from marine_mj.controllers.kinematics import RigidState, unrotate

from marine_mj.frames import Array, cross


@dataclass(frozen=True)
class Hydrostatics:
    """What a submerged body needs to hover.

    Attributes:
        weight: N.
        buoyancy: N, fully submerged.
        center_of_gravity: (3,) from the body origin, FLU, m.
        center_of_buoyancy: (3,) from the body origin, FLU, m.
    """

    weight: float
    buoyancy: float
    center_of_gravity: Array
    center_of_buoyancy: Array

    def feed_forward(self, rotation: Array) -> Array:
        """Wrench (..., 6) FLU that cancels weight and buoyancy at attitude (..., 3, 3)."""
        up = rotation[..., 2, :]  # world z in body axes
        weight, buoyancy = (np.asarray(v)[..., None] for v in (self.weight, self.buoyancy))
        force = (weight - buoyancy) * up
        arm = weight * self.center_of_gravity - buoyancy * self.center_of_buoyancy
        return np.concatenate([force, cross(arm, up)], axis=-1)


def steady_wrench(
    hydrostatics: Hydrostatics | None, body: RigidState, push: Array | float
) -> tuple[Array, Array]:
    """Wrench (..., 6) FLU that cancels the hydrostatics, and the same with an extra force.

    Args:
        hydrostatics: weight and buoyancy to cancel, None for nothing.
        body: state of the vehicle.
        push: (..., 3) extra force in world axes NWU, N.
    """
    statics = np.zeros_like(body.velocity)
    if hydrostatics is not None:
        statics = hydrostatics.feed_forward(body.rotation)
    push = np.broadcast_to(np.asarray(push, dtype=float), body.position.shape)
    extra = np.concatenate([unrotate(body.rotation, push), np.zeros_like(push)], axis=-1)
    return statics, statics + extra
