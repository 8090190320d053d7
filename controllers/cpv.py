"""Cascade of pose and velocity (docking digest 6.3) in six axes, and our model-based extension.

The pose error gives a speed towards the target; a second loop holds that speed *relative to the
target*, so the vehicle moves with a dock that heaves and pitches. Ours on top, when the wet inertia
is known: feed-forward of the target's acceleration, and an observer of what else acts on the
vehicle. The observer matters in waves: the water carries the vehicle about as it carries the dock,
and feed-forward alone would push twice.

Errors, velocities and wrenches are in body axes FLU at the body origin, [X, Y, Z, K, M, N].
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from marine_mj.controllers.kinematics import (
    RigidState,
    body_acceleration,
    pose_error,
    relative_velocity,
    unrotate,
)
from marine_mj.controllers.pid import Limits, Pid, PidGains, PidState
from marine_mj.controllers.pose_pid import Hydrostatics

from marine_mj import frames
from marine_mj.errors import ScenarioError
from marine_mj.frames import Array


@dataclass(frozen=True)
class CpvGains:
    """Gains of both stages.

    Attributes:
        pose: pose error (m, rad) to speed (m/s, rad/s).
        speed: (6,) largest speed towards the target, m/s and rad/s.
        velocity: speed error to wrench (N, N m).
    """

    pose: PidGains
    speed: Array | Sequence[float]
    velocity: PidGains

    def __post_init__(self) -> None:
        """Raise ScenarioError for a speed limit that is not positive."""
        speed = np.asarray(self.speed, dtype=float)
        object.__setattr__(self, "speed", speed)
        if not np.all(speed > 0):
            raise ScenarioError(f"CPV speed limits must be > 0, got {speed}")


CPV_GAINS = {
    # Table 7.6 of the reference: sway = heave, yaw = pitch; roll is ours, for 1.9 N m of authority.
    "reference": CpvGains(
        pose=PidGains(
            P=[1.0, 1.5, 1.5, 1.0, 1.0, 1.0],
            I=np.zeros(6),
            D=[0.05, 0.075, 0.075, 0.1, 0.1, 0.1],
        ),
        speed=np.full(6, 0.5),
        velocity=PidGains(
            P=[200.0, 200.0, 200.0, 3.0, 60.0, 60.0],
            I=[10.0, 15.0, 15.0, 0.1, 2.5, 2.5],
            D=[5.0, 15.0, 15.0, 0.0, 2.0, 2.0],
        ),
    ),
    # Ours, for the model-based extension: the velocity loop closes at 2.5 to 3 rad/s with the wet
    # inertia (the thrusters' lag of 0.15 s allows no more), the pose loop at 1 rad/s; the observer
    # stands in for the integral. Sway and heave stay below the vehicle's top speed of 0.37 m/s.
    "extended": CpvGains(
        pose=PidGains(P=[1.0, 1.0, 1.0, 1.5, 1.2, 1.0], I=np.zeros(6), D=np.zeros(6)),
        speed=[0.8, 0.35, 0.3, 0.5, 0.5, 0.5],
        velocity=PidGains(P=[200.0, 320.0, 320.0, 2.0, 75.0, 75.0], I=np.zeros(6), D=np.zeros(6)),
    ),
}


def cpv_gain_set(name: str) -> CpvGains:
    """Named gain set.

    Raises:
        ScenarioError: the name is not one of `CPV_GAINS`.
    """
    if name not in CPV_GAINS:
        raise ScenarioError(
            f"gains = {name!r} does not exist for cpv; available: {', '.join(CPV_GAINS)}"
        )
    return CPV_GAINS[name]


@dataclass(frozen=True)
class VehicleModel:
    """What the model-based extension knows of the vehicle.

    Attributes:
        inertia: (6, 6) rigid-body and added inertia about the body origin, FLU.
        lag: time constant of the thrusters, s (0: none).
        observer: time constant of the disturbance observer, s.
        observer_limit: largest disturbance believed, as a share of the wrench limits.
    """

    inertia: Array
    lag: float = 0.15
    observer: float = 0.3
    observer_limit: float = 1.0

    def __post_init__(self) -> None:
        """Raise ScenarioError for a time that cannot be."""
        if not (np.all(np.asarray(self.lag) >= 0) and np.all(np.asarray(self.observer) > 0)):
            raise ScenarioError(
                f"thruster lag must be >= 0 s and observer > 0 s, got {self.lag}, {self.observer}"
            )


@dataclass(frozen=True)
class CpvState:
    """Memory of the cascade.

    Attributes:
        pose: of the pose stage.
        velocity: of the velocity stage.
        asked: (..., 6) wrench the thrusters were asked for at the last update, FLU.
        thrust: (..., 6) wrench they give by now, FLU.
        seen: (..., 6) velocity of the vehicle at the last update, FLU; NaN before the first one.
        disturbance: (..., 6) what acts on the vehicle besides thrust and hydrostatics, FLU.
    """

    pose: PidState
    velocity: PidState
    asked: Array
    thrust: Array
    seen: Array
    disturbance: Array


@dataclass(frozen=True)
class Cpv:
    """Cascade: `v = PID(pose error)` limited, wrench `PID(v + target velocity - velocity)`.

    Attributes:
        pose: pose stage; its limits are those of the speed.
        velocity: velocity stage; its limits are those of the wrench.
        hydrostatics: weight and buoyancy to cancel, None to leave them to the integral.
        model: for acceleration feed-forward and disturbance observer, None as in the reference.
    """

    pose: Pid
    velocity: Pid
    hydrostatics: Hydrostatics | None = None
    model: VehicleModel | None = None

    @classmethod
    def from_gains(
        cls,
        gains: CpvGains,
        limits: Limits,
        period: float,
        hydrostatics: Hydrostatics | None = None,
        model: VehicleModel | None = None,
    ) -> "Cpv":
        """Cascade with wrench limits in FLU."""
        return cls(
            Pid(gains.pose, Limits(-np.asarray(gains.speed), np.asarray(gains.speed)), period),
            Pid(gains.velocity, limits, period),
            hydrostatics,
            model,
        )

    def initial(self, shape: tuple[int, ...] = ()) -> CpvState:
        """State before the first update, for a leading shape."""
        zero = np.zeros((*shape, 6))
        return CpvState(
            self.pose.initial(shape),
            self.velocity.initial(shape),
            asked=zero,
            thrust=zero,
            seen=np.full((*shape, 6), np.nan),
            disturbance=zero,
        )

    def applied(self, state: CpvState, wrench: Array) -> CpvState:
        """State when the thrusters were asked for another wrench (..., 6) than `update` gave."""
        return replace(state, asked=np.asarray(wrench, dtype=float))

    def update(
        self,
        state: CpvState,
        body: RigidState,
        target: RigidState,
        scale: Array | float = 1.0,
        push: Array | float = 0.0,
        acceleration: Array | float = 0.0,
        contact: Array | bool = False,
    ) -> tuple[Array, CpvState]:
        """Wrench (..., 6) FLU at the body origin, and the next state.

        Args:
            state: state after the previous update.
            body: measured state of the vehicle.
            target: where it should be and how fast it should move there.
            scale: (..., 6) factor on the pose error per axis: 0 lets an axis go.
            push: (..., 3) extra force in world axes NWU, N.
            acceleration: (..., 6) acceleration of the target, world axes NWU; used with `model`.
            contact: (...,) bool: forces of contact act on the vehicle, the observer forgets.
        """
        statics = np.zeros_like(body.velocity)
        if self.hydrostatics is not None:
            statics = self.hydrostatics.feed_forward(body.rotation)
        push = np.broadcast_to(np.asarray(push, dtype=float), body.position.shape)
        extra = np.concatenate([unrotate(body.rotation, push), np.zeros_like(push)], axis=-1)
        feed_forward = statics + extra
        thrust, disturbance = state.thrust, state.disturbance
        if self.model is not None:
            thrust, disturbance = self._observe(self.model, state, body, statics, contact)
            wanted = body_acceleration(body, acceleration)
            feed_forward = feed_forward + frames.apply(self.model.inertia, wanted) - disturbance
        speed, pose = self.pose.update(state.pose, pose_error(target, body) * scale)
        slip = relative_velocity(body, target) * (np.asarray(scale) != 0)
        wrench, velocity = self.velocity.update(state.velocity, speed - slip, feed_forward)
        following = CpvState(pose, velocity, wrench, thrust, body.velocity, disturbance)
        return wrench, following

    def _observe(
        self,
        model: VehicleModel,
        state: CpvState,
        body: RigidState,
        statics: Array,
        contact: Array | bool,
    ) -> tuple[Array, Array]:
        """Thrust (..., 6) by now, and the disturbance (..., 6) of the last period, low-passed."""
        period = self.velocity.period
        with np.errstate(divide="ignore"):
            share = -np.expm1(-period / np.asarray(model.lag, dtype=float))[..., None]
        thrust = state.thrust + share * (state.asked - state.thrust)
        gained = np.where(np.isnan(state.seen), 0.0, (body.velocity - state.seen) / period)
        # Hydrostatics push with minus what cancels them.
        mean_thrust = 0.5 * (thrust + state.thrust)
        found = frames.apply(model.inertia, gained) - mean_thrust + statics
        found = np.where(np.isnan(state.seen), state.disturbance, found)
        limits, most = self.velocity.limits, np.asarray(model.observer_limit)[..., None]
        found = np.where(np.asarray(contact)[..., None], 0.0, found)
        step = -np.expm1(-period / np.asarray(model.observer))[..., None]
        disturbance = state.disturbance + step * (found - state.disturbance)
        return thrust, np.clip(disturbance, most * limits.low, most * limits.high)
