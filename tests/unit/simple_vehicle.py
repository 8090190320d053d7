"""A vehicle about like the Scout, for tests of controllers."""

import numpy as np
from marine_mj.controllers import Limits, RigidState

LEVEL = np.array([1.0, 0, 0, 0])
PERIOD = 0.01
LIMITS = Limits(np.array([-152.0, -68, -68, -5, -20, -20]), np.array([192.0, 68, 68, 5, 20, 20]))
INERTIA = np.diag([67.3, 126.6, 126.6, 0.41, 26.1, 26.1])
LAG = 0.15


def at(*position, velocity=(0.0,) * 6):
    """Level state at a position, heading north."""
    return RigidState(np.array(position, dtype=float), LEVEL, np.array(velocity, dtype=float))
