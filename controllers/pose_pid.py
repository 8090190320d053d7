"""Pose PID in six axes with hydrostatic feed-forward (docking digest 6.2 and 6.8).

Errors and wrenches are in body axes FLU at the body origin, [X, Y, Z, K, M, N]. All gains are per
axis, so a table printed for FRD axes holds unchanged in FLU.
"""

from dataclasses import dataclass, replace

import numpy as np
from marine_mj.controllers.demand import Demand
from marine_mj.controllers.hydrostatics import Hydrostatics, steady_wrench
from marine_mj.controllers.kinematics import RigidState
from marine_mj.controllers.pid import Limits, Pid, PidGains, PidState, named_gains

from marine_mj.frames import Array, flip

#: Wrench limits of the Scout [X, Y, Z, K, M, N], FRD, N and N m (digest 3.1 and 3.4).
SCOUT_WRENCH_LOW_FRD = np.array([-152.0, -68.0, -68.0, -5.0, -20.0, -20.0])
SCOUT_WRENCH_HIGH_FRD = np.array([192.0, 68.0, 68.0, 5.0, 20.0, 20.0])

#: Gain sets of the reference (tables 7.4 and 7.5): sway = heave, yaw = pitch; roll by choice.
GAINS = {
    "manual": PidGains(
        P=[200.0, 150.0, 150.0, 40.0, 100.0, 100.0],
        I=[3.0, 15.0, 15.0, 4.0, 10.0, 10.0],
        D=[159.0, 15.0, 15.0, 10.0, 2.0, 2.0],
    ),
    "brute_force": PidGains(
        P=[2738.42, 5011.87, 5011.87, 40.0, 4097.32, 4097.32],
        I=[0.0, 3.16, 3.16, 4.0, 10.0, 10.0],
        D=[630.96, 0.0, 0.0, 10.0, 1778.28, 1778.28],
    ),
    # Ours for the full vehicle with thruster lag (not in the reference): critically damped
    # at about 1 rad/s in translation with the wet mass, softer than brute force at the dock.
    "extended": PidGains(
        P=[180.0, 260.0, 260.0, 20.0, 60.0, 60.0],
        I=[15.0, 25.0, 25.0, 2.0, 8.0, 8.0],
        D=[150.0, 300.0, 300.0, 6.0, 50.0, 50.0],
    ),
}


def gain_set(name: str) -> PidGains:
    """Named gain set.

    Raises:
        ScenarioError: the name is not one of `GAINS`.
    """
    return named_gains(GAINS, name, "pose_pid")


def limits_from_frd(low: Array, high: Array) -> Limits:
    """Wrench limits in FLU of limits (6,) given in FRD (axes that flip swap their bounds)."""
    bounds = np.stack([flip(low), flip(high)])
    return Limits(bounds.min(axis=0), bounds.max(axis=0))


@dataclass(frozen=True)
class PosePid:
    """PID on the pose error, with limits of the wrench and optional hydrostatic feed-forward.

    Attributes:
        pid: six-axis PID [x, y, z, roll, pitch, yaw].
        hydrostatics: weight and buoyancy to cancel, None to leave them to the integral.
        error_limit: longest position error that the proportional and integral parts see, m; with
            the derivative it limits the speed to about `P / D error_limit`, so that far targets
            do not saturate the thrusters (inf as in the reference).
    """

    pid: Pid
    hydrostatics: Hydrostatics | None = None
    error_limit: float = np.inf

    @classmethod
    def from_name(
        cls,
        gains: str,
        limits: Limits,
        period: float,
        hydrostatics: Hydrostatics | None = None,
        error_limit: float = np.inf,
    ) -> "PosePid":
        """Pose PID with a named gain set (`GAINS`) and wrench limits in FLU."""
        return cls(Pid(gain_set(gains), limits, period), hydrostatics, error_limit)

    def initial(self, shape: tuple[int, ...] = ()) -> PidState:
        """State before the first update, for a leading shape."""
        return self.pid.initial(shape)

    def update(self, state: PidState, body: RigidState, demand: Demand) -> tuple[Array, PidState]:
        """Wrench (..., 6) FLU at the body origin, and the next state; see `Controller.update`.

        Acceleration of the target and contact do not count.
        """
        _, wrench = steady_wrench(self.hydrostatics, body, demand.push)
        error = demand.error(body)
        return self.pid.update(state, self._limited(error), wrench, error)

    def applied(self, state: PidState, wrench: Array) -> PidState:
        """The same state: the anti-windup of the reference does not look at what was achieved."""
        return state

    def _limited(self, error: Array) -> Array:
        """Pose error (..., 6) with the length of its position part limited."""
        length = np.linalg.norm(error[..., :3], axis=-1, keepdims=True)
        limit = np.asarray(self.error_limit)[..., None]
        share = np.minimum(1.0, limit / np.maximum(length, 1e-12))
        return np.concatenate([error[..., :3] * share, error[..., 3:]], axis=-1)

    def with_limits(self, limits: Limits) -> "PosePid":
        """The same controller with other wrench limits (FLU)."""
        return replace(self, pid=replace(self.pid, limits=limits))
