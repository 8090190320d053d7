"""Autoregressive prediction: each axis of a motion continues as its own past taught.

    y(k) = c + a_1 y(k-1) + ... + a_p y(k-p),   y: displacement per stride, and velocity

Coefficients by least squares with exponential forgetting, online, one model for each of the six
displacements and six velocities in world axes (normal equations at every stride, Cholesky). A sum
of p/2 sine waves is such a process exactly. Between strides the last forecast is continued by cubic
Hermite interpolation and shifted onto the present state.
"""

from dataclasses import dataclass, field

import numpy as np
from marine_mj.controllers.kinematics import RigidState, world_velocity
from marine_mj.controllers.prediction import SAME, displaced

from marine_mj import frames
from marine_mj.errors import ScenarioError
from marine_mj.frames import Array
from marine_mj.native_loops import native_loop

# Relative ridge of the normal equations; below this sum of squares nothing moves, (m or m/s)^2.
_RIDGE, _STILL = 1e-13, 1e-14


@dataclass(frozen=True)
class ArState:
    """Memory of an `ArPredictor`; channels: 6 displacements per stride, 6 velocities.

    Attributes:
        position, quaternion: (..., 3), (..., 4) at the last stride; NaN before the first sample.
        lags: (..., 12, p) last values, newest first.
        normal: (..., 12, p + 1, p + 2) normal equations, right-hand side last.
        largest: (..., 12) largest value, slowly forgotten.
        forecast: (..., K + 1, 12) displacement and velocity at whole strides after the last one.
        count: (...,) samples so far.
    """

    position: Array
    quaternion: Array
    lags: Array
    normal: Array
    largest: Array
    forecast: Array
    count: Array


@dataclass(frozen=True)
class ArPredictor:
    """Prediction by one autoregressive model per axis, taught online.

    Before `3 (order + 1)` strides it continues with the present velocity. Forecasts are held
    within twice the largest value seen in the memory.

    Attributes:
        period: time between samples, s.
        order: p, number of coefficients beside the constant.
        stride: time step of the models, s.
        memory: of the least squares, s.
        horizon: farthest prediction, s; later times get the state at the horizon.
    """

    period: float
    order: int = 6
    stride: float = field(default=0.2, metadata=SAME)
    memory: float = field(default=60.0, metadata=SAME)
    horizon: float = field(default=2.0, metadata=SAME)

    def __post_init__(self) -> None:
        """Raise ScenarioError for an order or times that cannot be."""
        if not 1 <= self.order <= 20:
            raise ScenarioError(f"AR prediction: order must be 1 to 20, got {self.order}")
        if not (0 < self.period <= self.stride < self.memory and self.horizon > 0):
            raise ScenarioError(
                "AR prediction needs 0 < period <= stride < memory and horizon > 0, got "
                f"{self.period}, {self.stride}, {self.memory}, {self.horizon} s"
            )

    @property
    def _every(self) -> int:
        """Samples per stride."""
        return round(self.stride / self.period)

    @property
    def _step(self) -> float:
        """Stride as whole samples, s."""
        return self._every * self.period

    def initial(self, shape: tuple[int, ...] = ()) -> ArState:
        """State before the first sample, for a leading shape."""
        p = self.order
        # One stride more than the horizon: the forecast is up to a stride old.
        strides = int(np.ceil(self.horizon / self._step - 1e-9)) + 1
        return ArState(
            position=np.full((*shape, 3), np.nan),
            quaternion=np.full((*shape, 4), np.nan),
            lags=np.zeros((*shape, 12, p)),
            normal=np.zeros((*shape, 12, p + 1, p + 2)),
            largest=np.zeros((*shape, 12)),
            forecast=np.zeros((*shape, strides + 1, 12)),
            count=np.zeros(shape),
        )

    def update(self, state: ArState, body: RigidState) -> ArState:
        """State after one more sample."""
        due = np.mod(state.count, self._every) == 0
        if not np.any(due):
            return ArState(
                state.position, state.quaternion, state.lags, state.normal, state.largest,
                state.forecast, state.count + 1.0,
            )  # fmt: skip
        velocity = world_velocity(body)
        first = np.isnan(state.position[..., :1])
        back = frames.quaternion_conjugate(np.where(first, body.quaternion, state.quaternion))
        turn = frames.rotation_vector(frames.quaternion_multiply(body.quaternion, back))
        shift = np.where(first, 0.0, body.position - state.position)
        values = np.concatenate([shift, turn, velocity], axis=-1)
        strides = np.floor(state.count / self._every)
        kept = np.exp(-self._step / self.memory)
        lags, normal, largest, forecast = _learn(
            values, strides, state.lags, state.normal, state.largest, state.forecast, kept,
            self._step,
        )  # fmt: skip
        mask = due[..., None]
        deep = mask[..., None]
        return ArState(
            np.where(mask, body.position, state.position),
            np.where(mask, body.quaternion, state.quaternion),
            np.where(deep, lags, state.lags),
            np.where(deep[..., None], normal, state.normal),
            np.where(mask, largest, state.largest),
            np.where(deep, forecast, state.forecast),
            state.count + 1.0,
        )

    def ahead(self, state: ArState, body: RigidState, time: Array | float) -> RigidState:
        """State of the body `time` s after its last sample; see `Predictor`."""
        age = self.period * np.mod(state.count - 1.0, self._every)
        time = np.minimum(np.asarray(time, dtype=float), self.horizon)
        now = _continued(state.forecast, age, self._step)
        then = _continued(state.forecast, age + time, self._step)
        change = then - now
        return displaced(body, change[..., :6], world_velocity(body) + change[..., 6:])


@native_loop(
    # value, strides, state ..., forgetting, step; the next state
    "void(f8[:], f8, f8[:,:], f8[:,:,:], f8[:], f8[:,:], f8, f8, "
    "f8[:,:], f8[:,:,:], f8[:], f8[:,:])",
    "(c),(),(c,p),(c,q,r),(c),(k,c),(),()->(c,p),(c,q,r),(c),(k,c)",
)
def _learn(value, strides, lags, normal, largest, _, kept, step, lags_, normal_, largest_, out):
    """One stride: put the value into the normal equations, solve them, run the models ahead."""
    channels, p = lags.shape
    steps = out.shape[0]
    x = np.empty(p + 1)
    factor = np.empty((p + 1, p + 1))
    for c in range(channels):
        for i in range(p):
            x[i] = lags[c, i]
        x[p] = 1.0
        # Displacements exist from the second stride on, regressors p strides later.
        learn = strides >= p + 1
        scale = max(largest[c], 1e-9)
        x[p] = scale  # the constant in the unit of the channel: well conditioned
        for i in range(p + 1):
            for j in range(p + 1):
                normal_[c, i, j] = normal[c, i, j]
                if learn:
                    normal_[c, i, j] = kept * normal[c, i, j] + x[i] * x[j]
            normal_[c, i, p + 1] = normal[c, i, p + 1]
            if learn:
                normal_[c, i, p + 1] = kept * normal[c, i, p + 1] + x[i] * value[c]
        for i in range(p - 1, 0, -1):
            lags_[c, i] = lags[c, i - 1]
        lags_[c, 0] = value[c]
        largest_[c] = max(abs(value[c]), kept * largest[c])

        trace = 0.0
        for i in range(p + 1):
            trace += normal_[c, i, i]
        ready = strides >= 3 * p + 3 and trace > _STILL
        if ready:
            ridge = _RIDGE * trace / (p + 1)
            for i in range(p + 1):
                for j in range(i + 1):
                    total = normal_[c, i, j]
                    if i == j:
                        total += ridge
                    for k in range(j):
                        total -= factor[i, k] * factor[j, k]
                    if i == j:
                        factor[i, i] = np.sqrt(max(total, 1e-300))
                    else:
                        factor[i, j] = total / factor[j, j]
            for i in range(p + 1):
                x[i] = normal_[c, i, p + 1]
                for k in range(i):
                    x[i] -= factor[i, k] * x[k]
                x[i] /= factor[i, i]
            for i in range(p, -1, -1):
                for k in range(i + 1, p + 1):
                    x[i] -= factor[k, i] * x[k]
                x[i] /= factor[i, i]
        out[0, c] = 0.0 if c < 6 else value[c]
        bound = 2.0 * largest_[c]
        for s in range(1, steps):
            if ready:
                following = x[p] * scale
                for i in range(p):
                    # value i + 1 strides before s: a forecast, or a lag
                    if s - 1 - i > 0:
                        if c < 6:
                            past = out[s - 1 - i, c] - out[s - 2 - i, c]
                        else:
                            past = out[s - 1 - i, c]
                    else:
                        past = lags_[c, i + 1 - s]
                    following += x[i] * past
                following = min(max(following, -bound), bound)
            elif c < 6:
                following = step * value[c + 6]
            else:
                following = value[c]
            out[s, c] = out[s - 1, c] + following if c < 6 else following


@native_loop("void(f8[:,:], f8, f8, f8[:])", "(k,c),(),()->(c)")
def _continued(forecast, time, step, out):
    """Forecast at a time after its start: cubic Hermite in displacement, and its slope."""
    last = forecast.shape[0] - 2
    at = min(max(time / step, 0.0), last + 1.0)
    k = min(int(at), last)
    s = at - k
    for c in range(6):
        x0, x1 = forecast[k, c], forecast[k + 1, c]
        v0, v1 = step * forecast[k, c + 6], step * forecast[k + 1, c + 6]
        out[c] = (
            (1 + 2 * s) * (1 - s) ** 2 * x0
            + s * (1 - s) ** 2 * v0
            + s**2 * (3 - 2 * s) * x1
            + s**2 * (s - 1) * v1
        )
        # derivative of the same cubic
        slope = 6 * s * (s - 1) * (x0 - x1) + (1 - s) * (1 - 3 * s) * v0 + s * (3 * s - 2) * v1
        out[c + 6] = slope / step
