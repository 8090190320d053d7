"""The way out of a dock: back along the way in, clear of the dock, home to waypoint 1.

It begins when the latch of a docked vehicle opens. First the target leaves along the entry axis,
moving with the dock and out of it by `leave_speed`, to `leave_depth` before the aperture; then the
vehicle goes back to waypoint 1 and stays there.
"""

import numpy as np
from marine_mj.controllers.kinematics import RigidState, unrotate

from marine_mj.frames import Array


def way_out(
    aperture: RigidState,
    seat: RigidState,
    axis: int,
    share: Array,
    speed: Array | float,
    distance: Array | float,
) -> RigidState:
    """State to have on the way out, NWU/FLU: fixed to the dock, moving out of it.

    Args:
        aperture, seat: states of the dock's frames.
        axis: axis of the aperture frame along which vehicles enter.
        share: (...,) way from the aperture (0) to the seat (1); negative outside the dock.
        speed: at which the target moves out, m/s.
        distance: where it stops, m before the aperture.
    """  # fmt: skip
    inside = unrotate(aperture.rotation, seat.position - aperture.position)
    target = aperture.attached(np.asarray(share)[..., None] * inside)
    moving = share > end_of_way(inside[..., axis], distance)
    velocity = target.velocity.copy()
    velocity[..., axis] -= np.where(moving, speed, 0.0)
    return RigidState(target.position, target.quaternion, velocity)


def end_of_way(travel: Array | float, distance: Array | float) -> Array:
    """Share (...,) of the way from aperture to seat at which the target stops: negative.

    Args:
        travel: way from the aperture to the seat, m.
        distance: of the end before the aperture, m.
    """
    return -np.asarray(distance) / np.maximum(travel, 1e-9)
