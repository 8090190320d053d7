"""Cascade of pose, velocity and acceleration (docking digest 6.4) in six axes.

The pose error gives a speed towards the target, the error of the speed relative to the target an
acceleration, and the error of the acceleration the wrench. The last stage closes an algebraic loop,
wrench on acceleration on wrench: it takes the vehicle's acceleration of the previous sample, and is
stable while its gain is below the wet inertia. Body axes FLU at the body origin.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from marine_mj.controllers.demand import Demand
from marine_mj.controllers.hydrostatics import Hydrostatics, steady_wrench
from marine_mj.controllers.kinematics import RigidState
from marine_mj.controllers.pid import Limits, Pid, PidGains, PidState, named_gains

from marine_mj.errors import ScenarioError
from marine_mj.frames import Array


@dataclass(frozen=True)
class CpvaGains:
    """Gains of the three stages and the limits between them.

    Attributes:
        pose: pose error (m, rad) to speed (m/s, rad/s).
        speed: (6,) largest speed towards the target, m/s and rad/s.
        velocity: speed error to acceleration (m/s2, rad/s2).
        acceleration_low, acceleration_high: (6,) limits of the wanted acceleration, FLU.
        acceleration: acceleration error to wrench (N, N m).
    """

    pose: PidGains
    speed: Array | Sequence[float]
    velocity: PidGains
    acceleration_low: Array | Sequence[float]
    acceleration_high: Array | Sequence[float]
    acceleration: PidGains

    def __post_init__(self) -> None:
        """Raise ScenarioError for a limit of speed or acceleration that does not contain zero."""
        for name in ("speed", "acceleration_low", "acceleration_high"):
            object.__setattr__(self, name, np.asarray(getattr(self, name), dtype=float))
        if not np.all(np.asarray(self.speed) > 0):
            raise ScenarioError(f"CPVA speed limits must be > 0, got {self.speed}")
        low, high = np.asarray(self.acceleration_low), np.asarray(self.acceleration_high)
        if not (np.all(low < 0) and np.all(high > 0)):
            raise ScenarioError(f"CPVA acceleration limits must be < 0 and > 0, got {low}, {high}")


_NONE = np.zeros(6)
CPVA_GAINS = {
    # Table 7.7 of the reference: sway = heave, yaw = pitch; roll is ours (5 N m, 0.41 kg m2).
    "reference": CpvaGains(
        pose=PidGains(
            P=[1.0, 1.5, 1.5, 1.0, 1.0, 1.0], I=_NONE, D=[0.05, 0.075, 0.075, 0.1, 0.1, 0.1]
        ),
        speed=np.full(6, 0.5),
        velocity=PidGains(
            P=np.full(6, 6.0), I=np.full(6, 0.1), D=[0.05, 0.075, 0.075, 0.1, 0.1, 0.1]
        ),
        acceleration_low=[-2.3, -0.55, -0.55, -12.0, -0.77, -0.77],
        acceleration_high=[2.9, 0.55, 0.55, 12.0, 0.77, 0.77],
        acceleration=PidGains(P=[60.0, 80.0, 80.0, 0.3, 20.0, 20.0], I=_NONE, D=_NONE),
    ),
    # Ours, for thrusters with a lag of 0.15 s: the velocity stage at 2.5 to 4 rad/s.
    "extended": CpvaGains(
        pose=PidGains(P=[1.0, 1.0, 1.0, 1.0, 1.0, 1.0], I=_NONE, D=_NONE),
        speed=[0.8, 0.35, 0.3, 0.5, 0.5, 0.5],
        velocity=PidGains(P=[4.0, 4.0, 4.0, 4.0, 4.0, 4.0], I=np.full(6, 0.5), D=_NONE),
        acceleration_low=[-2.3, -0.55, -0.55, -12.0, -0.77, -0.77],
        acceleration_high=[2.9, 0.55, 0.55, 12.0, 0.77, 0.77],
        acceleration=PidGains(P=[67.0, 120.0, 120.0, 0.4, 26.0, 26.0], I=_NONE, D=_NONE),
    ),
}


def cpva_gain_set(name: str) -> CpvaGains:
    """Named gain set.

    Raises:
        ScenarioError: the name is not one of `CPVA_GAINS`.
    """
    return named_gains(CPVA_GAINS, name, "cpva")


@dataclass(frozen=True)
class CpvaState:
    """Memory of the cascade.

    Attributes:
        pose, velocity, acceleration: of the three stages.
        seen: (..., 6) velocity of the vehicle at the last update, FLU; NaN before the first one.
    """

    pose: PidState
    velocity: PidState
    acceleration: PidState
    seen: Array


@dataclass(frozen=True)
class Cpva:
    """Cascade of three PIDs: `v = PID(e)`, `a = PID(v + nu_t - nu)`, `PID(a + nu_t' - nu')`.

    Attributes:
        pose: pose stage; its limits are those of the speed.
        velocity: velocity stage; its limits are those of the acceleration.
        acceleration: acceleration stage; its limits are those of the wrench.
        hydrostatics: weight and buoyancy to cancel, None to leave them to the integrals.
    """

    pose: Pid
    velocity: Pid
    acceleration: Pid
    hydrostatics: Hydrostatics | None = None

    @classmethod
    def from_gains(
        cls,
        gains: CpvaGains,
        limits: Limits,
        period: float,
        hydrostatics: Hydrostatics | None = None,
    ) -> "Cpva":
        """Cascade with wrench limits in FLU."""
        speed = np.asarray(gains.speed)
        middle = Limits(np.asarray(gains.acceleration_low), np.asarray(gains.acceleration_high))
        return cls(
            Pid(gains.pose, Limits(-speed, speed), period),
            Pid(gains.velocity, middle, period),
            Pid(gains.acceleration, limits, period),
            hydrostatics,
        )

    def initial(self, shape: tuple[int, ...] = ()) -> CpvaState:
        """State before the first update, for a leading shape."""
        return CpvaState(
            self.pose.initial(shape),
            self.velocity.initial(shape),
            self.acceleration.initial(shape),
            np.full((*shape, 6), np.nan),
        )

    def applied(self, state: CpvaState, wrench: Array) -> CpvaState:
        """The same state: what the thrusters gave is seen in the acceleration."""
        return state

    def update(self, state: CpvaState, body: RigidState, demand: Demand) -> tuple[Array, CpvaState]:
        """Wrench (..., 6) FLU at the body origin, and the next state; see `Controller.update`.

        Contact does not count.
        """
        _, feed_forward = steady_wrench(self.hydrostatics, body, demand.push)
        first = np.isnan(state.seen)
        period = self.acceleration.period
        gained = np.where(first, 0.0, (body.velocity - state.seen) / period)
        missing = (demand.rates(body) - gained) * demand.held
        speed, pose = self.pose.update(state.pose, demand.error(body))
        wanted, velocity = self.velocity.update(state.velocity, speed - demand.slip(body))
        wrench, last = self.acceleration.update(
            state.acceleration, wanted * demand.held + missing, feed_forward
        )
        return wrench, CpvaState(pose, velocity, last, body.velocity)
