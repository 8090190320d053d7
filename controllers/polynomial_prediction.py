"""Polynomial prediction (docking digest 6.7): a line or parabola through the last samples."""

from dataclasses import dataclass, field

import numpy as np
from marine_mj.controllers.kinematics import RigidState, world_velocity
from marine_mj.controllers.prediction import SAME, displaced, turn_quaternion

from marine_mj import frames
from marine_mj.errors import ScenarioError
from marine_mj.frames import Array


@dataclass(frozen=True)
class PolynomialState:
    """The last p samples, newest first.

    Attributes:
        position: (..., p, 3) NWU, m; NaN before the first sample.
        quaternion: (..., p, 4) wxyz.
        velocity: (..., p, 6) of origin and rotation, world axes NWU.
    """

    position: Array
    quaternion: Array
    velocity: Array


@dataclass(frozen=True)
class PolynomialPredictor:
    """Least-squares polynomial through the poses and velocities of the last `t_past` seconds.

    Poses and velocities are fitted independently, as in the reference (t_past 0.03 s at 100 Hz are
    3 samples). Before enough samples came, earlier ones are made up with the first velocity.

    Attributes:
        period: time between samples, s.
        order: of the polynomial, 1 or 2.
        t_past: time whose samples are fitted, s; at least `order + 1` samples.
    """

    period: float
    order: int = 1
    t_past: float = field(default=0.03, metadata=SAME)

    def __post_init__(self) -> None:
        """Raise ScenarioError for an order that is not 1 or 2, or too few samples for it."""
        if self.order not in (1, 2):
            raise ScenarioError(f"polynomial prediction: order must be 1 or 2, got {self.order}")
        if not self.period > 0 or self.samples <= self.order:
            raise ScenarioError(
                f"polynomial prediction of order {self.order} needs t_past >= "
                f"{(self.order + 1) * self.period:g} s ({self.order + 1} samples), got "
                f"{self.t_past}"
            )

    @property
    def samples(self) -> int:
        """Number of samples that are fitted."""
        return round(self.t_past / self.period)

    def initial(self, shape: tuple[int, ...] = ()) -> PolynomialState:
        """State before the first sample, for a leading shape."""
        return PolynomialState(*(np.full((*shape, self.samples, k), np.nan) for k in (3, 4, 6)))

    def update(self, state: PolynomialState, body: RigidState) -> PolynomialState:
        """State after one more sample."""
        velocity = world_velocity(body)
        new = (body.position, body.quaternion, velocity)
        old = (state.position, state.quaternion, state.velocity)
        rows = [
            np.concatenate([n[..., None, :], o[..., :-1, :]], axis=-2)
            for n, o in zip(new, old, strict=True)
        ]
        first = np.isnan(state.position[..., 0, 0])
        if np.any(first):
            back = -self.period * np.arange(self.samples)[:, None]
            motion = back * velocity[..., None, :]
            turn = turn_quaternion(motion[..., 3:])
            attitude = frames.quaternion_multiply(turn, body.quaternion[..., None, :])
            made_up = (
                body.position[..., None, :] + motion[..., :3],
                attitude,
                np.broadcast_to(velocity[..., None, :], motion.shape),
            )
            mask = first[..., None, None]
            rows = [np.where(mask, m, r) for m, r in zip(made_up, rows, strict=True)]
        return PolynomialState(*rows)

    def ahead(self, state: PolynomialState, body: RigidState, time: Array | float) -> RigidState:
        """State of the body `time` s after its last sample; see `Predictor`."""
        weight = self._weights(np.asarray(time, dtype=float))
        back = frames.quaternion_conjugate(body.quaternion)
        motion: Array | float = 0.0
        velocity: Array | float = 0.0
        for j in range(self.samples):
            shift = state.position[..., j, :] - body.position
            turn = frames.quaternion_multiply(state.quaternion[..., j, :], back)
            sample = np.concatenate([shift, frames.rotation_vector(turn)], axis=-1)
            motion = motion + weight[..., j, None] * sample
            velocity = velocity + weight[..., j, None] * state.velocity[..., j, :]
        return displaced(body, np.asarray(motion), np.asarray(velocity))

    def _weights(self, time: Array) -> Array:
        """Weights (..., p) of the samples in the polynomial's value at `time` (...,)."""
        past = -np.arange(self.samples, dtype=float)
        fit = np.linalg.pinv(past[:, None] ** np.arange(self.order + 1))  # (order + 1, p)
        at = time / self.period
        total = np.zeros((*time.shape, self.samples))
        for k in range(self.order + 1):
            total = total + at[..., None] ** k * fit[k]
        return total
