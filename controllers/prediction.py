"""Where a moving body will be: the protocol of predictors, and kinematic prediction.

A predictor is fed the state of a body once per control period and gives its state some time ahead
(docking digest 6.7). Displacements and rotation vectors are in world axes NWU. The rotation of the
next seconds is taken as one rotation vector: exact about a fixed axis, else to second order.
"""

from dataclasses import dataclass, field
from typing import Any, Literal, Protocol

import numpy as np
from marine_mj.controllers.kinematics import RigidState, unrotate, world_velocity

from marine_mj import frames
from marine_mj.errors import ScenarioError
from marine_mj.frames import Array, cross

#: Of fields that shape the memory of a predictor: they cannot differ within one batch.
SAME = {"stack": "same"}
# Limits of a plausible wave frequency, rad/s, and the one to assume before anything moved.
_SLOWEST, _FASTEST, _USUAL = 0.2, 4.0, 1.2


class Predictor(Protocol):
    """What a predictor offers; its memory is an explicit state."""

    def initial(self, shape: tuple[int, ...] = ()) -> Any:
        """State before the first sample, for a leading shape."""

    def update(self, state: Any, body: RigidState) -> Any:
        """State after one more sample, one period after the last."""

    def ahead(self, state: Any, body: RigidState, time: Array | float) -> RigidState:
        """State of the body `time` s after its last sample `body`.

        Args:
            state: state after `update` with `body`.
            body: last sample, leading shape (...,).
            time: broadcasts with (...,): (m, 1) gives m instants of n bodies, shape (m, n).
        """


def turn_quaternion(vector: Array) -> Array:
    """Quaternion (..., 4) wxyz of the rotation by a rotation vector (..., 3), rad."""
    angle = np.sqrt(np.sum(np.square(vector), axis=-1, keepdims=True))
    half = 0.5 * angle
    share = np.where(angle > 1e-12, np.sin(half) / np.maximum(angle, 1e-12), 0.5)
    return np.concatenate([np.cos(half), share * vector], axis=-1)


def displaced(body: RigidState, motion: Array, velocity: Array) -> RigidState:
    """State of a body after a motion (..., 6), with a velocity (..., 6) then.

    Args:
        body: state before.
        motion: displacement m and rotation vector rad, world axes NWU.
        velocity: of origin and rotation afterwards, world axes NWU.
    """
    attitude = frames.quaternion_multiply(turn_quaternion(motion[..., 3:]), body.quaternion)
    rotation = frames.rotation_from_quaternion(attitude)
    twist = [unrotate(rotation, velocity[..., :3]), unrotate(rotation, velocity[..., 3:])]
    position = body.position + motion[..., :3]
    return RigidState(position, attitude, np.concatenate(twist, axis=-1))


@dataclass(frozen=True)
class KinematicState:
    """Memory of a `KinematicPredictor`.

    Attributes:
        velocity: (..., 6) at the last sample, world axes; NaN before the first one.
        acceleration: (..., 6) at the last sample, world axes.
        frequency: (..., 6) of its oscillation, rad/s.
        coarse: (..., 2, 6) velocity one and two strides ago.
        moments: (..., 2, 6) sums of the frequency estimate.
        count: (...,) samples so far.
    """

    velocity: Array
    acceleration: Array
    frequency: Array
    coarse: Array
    moments: Array
    count: Array


@dataclass(frozen=True)
class KinematicPredictor:
    """Prediction from position, velocity and acceleration of the last sample.

    Assumptions on the future acceleration, with the exact solution of each:

    - `zero`: the velocity stays, in world axes (`turning`: in body axes, on a screw motion);
    - `constant`: `x + v t + a t^2 / 2`;
    - `harmonic`: `x + v sin(wt)/w + a (1 - cos wt)/w^2`, oscillation about a fixed place. w is
      estimated online, per axis, by least squares on `v(k+1) + v(k-1) = 2 cos(w s) v(k)` at a
      stride s (Prony 1795 for one frequency) with exponential forgetting.

    Attributes:
        period: time between samples, s.
        future: assumption on the acceleration.
        turning: with `zero`, the velocity turns with the body.
        smoothing: time constant of a low-pass on the acceleration, s (0: none).
        stride: between the samples of the frequency estimate, s.
        memory: of the frequency estimate, s.
    """

    period: float
    future: Literal["zero", "constant", "harmonic"] = "zero"
    turning: bool = False
    smoothing: float = field(default=0.0, metadata=SAME)
    stride: float = field(default=0.2, metadata=SAME)
    memory: float = field(default=20.0, metadata=SAME)

    def __post_init__(self) -> None:
        """Raise ScenarioError for an unknown assumption or a time that cannot be."""
        if self.future not in ("zero", "constant", "harmonic"):
            raise ScenarioError(
                f"future acceleration {self.future!r} does not exist; available: zero, constant, "
                "harmonic"
            )
        if not (self.period > 0 and self.stride >= self.period and self.memory > self.stride):
            raise ScenarioError(
                f"prediction needs 0 < period <= stride < memory, got {self.period}, "
                f"{self.stride}, {self.memory} s"
            )

    def initial(self, shape: tuple[int, ...] = ()) -> KinematicState:
        """State before the first sample, for a leading shape."""
        return KinematicState(
            velocity=np.full((*shape, 6), np.nan),
            acceleration=np.zeros((*shape, 6)),
            frequency=np.full((*shape, 6), _USUAL),
            coarse=np.full((*shape, 2, 6), np.nan),
            moments=np.zeros((*shape, 2, 6)),
            count=np.zeros(shape),
        )

    def update(self, state: KinematicState, body: RigidState) -> KinematicState:
        """State after one more sample."""
        velocity = world_velocity(body)
        if self.future == "zero":
            return KinematicState(
                velocity, state.acceleration, state.frequency, state.coarse, state.moments,
                state.count,
            )  # fmt: skip
        frequency, coarse, moments = state.frequency, state.coarse, state.moments
        if self.future == "harmonic":
            stride = round(self.stride / self.period)
            due = (np.mod(state.count, stride) == 0)[..., None]
            if np.any(due):
                kept = np.exp(-stride * self.period / self.memory)
                before, last = coarse[..., 1, :], coarse[..., 0, :]
                full = due & ~np.isnan(before)
                products = np.stack([last * (velocity + before), 2 * last * last], axis=-2)
                grown = kept * moments + products
                moments = np.where(full[..., None, :], grown, moments)
                most = np.stack([velocity, last], axis=-2)
                coarse = np.where(due[..., None], most, coarse)
                energy = moments[..., 1, :]
                known = energy > 1e-12
                cosine = np.where(known, moments[..., 0, :] / np.where(known, energy, 1.0), 0.0)
                found = np.arccos(np.clip(cosine, -1.0, 1.0)) / (stride * self.period)
                found = np.clip(found, _SLOWEST, _FASTEST)
                frequency = np.where(known, found, frequency)
            step = frequency * self.period
            gained = frequency * (velocity * np.cos(step) - state.velocity) / np.sin(step)
        else:
            gained = (velocity - state.velocity) / self.period
        gained = np.where(np.isnan(gained), 0.0, gained)
        if self.smoothing > 0:
            share = -np.expm1(-self.period / self.smoothing)
            gained = state.acceleration + share * (gained - state.acceleration)
        return KinematicState(velocity, gained, frequency, coarse, moments, state.count + 1.0)

    def ahead(self, state: KinematicState, body: RigidState, time: Array | float) -> RigidState:
        """State of the body `time` s after its last sample; see `Predictor`."""
        t = np.asarray(time, dtype=float)[..., None]
        v, a = world_velocity(body), state.acceleration
        if self.future == "zero":
            motion, later = t * v, v + 0.0 * t
            if self.turning:
                motion, later = _screw(v, t)
        elif self.future == "constant":
            motion, later = t * v + 0.5 * t**2 * a, v + t * a
        else:
            w = state.frequency
            s, c = np.sin(w * t), np.cos(w * t)
            motion, later = v * s / w + a * (1 - c) / w**2, v * c + a * s / w
        return displaced(body, motion, later)


def _screw(velocity: Array, t: Array) -> tuple[Array, Array]:
    """Motion (..., 6) and final velocity when the velocity turns with the body for t (..., 1)."""
    v, turn = velocity[..., :3], velocity[..., 3:] * t
    v, turn = np.broadcast_arrays(v, turn)
    angle = np.sqrt(np.sum(turn**2, axis=-1, keepdims=True))
    small = angle < 1e-4
    safe = np.where(small, 1.0, angle)
    sine = np.where(small, 1 - angle**2 / 6, np.sin(safe) / safe)
    first = np.where(small, 0.5 - angle**2 / 24, (1 - np.cos(safe)) / safe**2)
    second = np.where(small, 1 / 6 - angle**2 / 120, (1 - np.sin(safe) / safe) / safe**2)
    once = cross(turn, v)
    twice = cross(turn, once)
    shift = t * (v + first * once + second * twice)
    spin = np.broadcast_to(velocity[..., 3:], turn.shape)
    later = np.concatenate([v + sine * once + first * twice, spin], axis=-1)
    return np.concatenate([shift, turn], axis=-1), later


@dataclass(frozen=True)
class PredictionState:
    """Memory of a `Prediction`: of the predictors of vehicle and carrier."""

    vehicle: Any
    carrier: Any


@dataclass(frozen=True)
class Prediction:
    """Where vehicle and carrier are taken to be when a controller acts (docking digest 6.7).

    Attributes:
        time: how far ahead, s.
        vehicle, carrier: predictors; None: the present state is used.
    """

    time: float
    vehicle: Predictor | None = None
    carrier: Predictor | None = None

    def initial(self, shape: tuple[int, ...] = ()) -> PredictionState:
        """State before the first sample, for a leading shape."""
        return PredictionState(
            None if self.vehicle is None else self.vehicle.initial(shape),
            None if self.carrier is None else self.carrier.initial(shape),
        )

    def update(
        self, state: PredictionState, vehicle: RigidState, carrier: RigidState
    ) -> tuple[RigidState, RigidState, PredictionState]:
        """Predicted vehicle, predicted carrier, and the next state."""
        ours, theirs = state.vehicle, state.carrier
        body, dock = vehicle, carrier
        if self.vehicle is not None:
            ours = self.vehicle.update(ours, vehicle)
            body = self.vehicle.ahead(ours, vehicle, self.time)
        if self.carrier is not None:
            theirs = self.carrier.update(theirs, carrier)
            dock = self.carrier.ahead(theirs, carrier, self.time)
        return body, dock, PredictionState(ours, theirs)
