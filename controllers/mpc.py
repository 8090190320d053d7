"""Model-predictive control onto a dock whose motion is predicted (docking digest 6.9).

Model: six axes in the vehicle's present body axes, held over the horizon,

    p' = v,   M v' = f + d - D (v - v_now),   T f' = u - f,

with the observed disturbance d (so there is no offset at rest), f and u thrust and wrench beyond
the hydrostatics. Over N steps the weighted squares of pose and velocity relative to the predicted
target, of the wrench and of its changes are least, within the limits of the wrench and of its rate,
with the vehicle below the aperture plane while it waits and inside the corridor while it enters.
Condensed to a quadratic programme in a few moves, solved by daqp (Arnström, Bemporad and Axehill
2022, "A dual active-set solver for embedded quadratic programming using recursive LDL updates"),
row by row in a batch, every few control steps; between them the first move is held. Where no plan
exists, and in contact, which the model does not know, a cascade (`Cpv`) steers instead.
"""

from dataclasses import dataclass, field, replace
from typing import NamedTuple

import daqp
import numpy as np
from marine_mj.controllers.cpv import Cpv, CpvState
from marine_mj.controllers.demand import Demand, Preview
from marine_mj.controllers.hydrostatics import steady_wrench
from marine_mj.controllers.kinematics import (
    RigidState,
    pose_error,
    relative_velocity,
    rotate,
    unrotate,
    world_velocity,
)
from marine_mj.controllers.lqr import sampled
from marine_mj.controllers.mpc_settings import MpcSettings
from marine_mj.controllers.prediction import displaced
from marine_mj.controllers.waypoint_loops import CORRIDOR_SLOPE
from numpy.typing import NDArray

from marine_mj import frames
from marine_mj.errors import ScenarioError
from marine_mj.frames import Array

# A bound that does not bind.
_FREE = 1e30
# From this step of the horizon on, and at every so many steps, geometry is looked at.
_LOOK = 5


class Programme(NamedTuple):
    """`min z H z / 2 + f z` with `low <= [z; A z] <= high`."""

    hessian: Array
    slope: Array
    rows: Array
    low: Array
    high: Array


@dataclass(frozen=True)
class MpcState:
    """Memory of the controller.

    Attributes:
        cascade: of the cascade, with the observer.
        move: (..., 6) wrench beyond the hydrostatics that is held, FLU.
        planned: (..., 6 moves) the whole plan as shares of the wrench limits.
        fallback: (...,) bool: there is no plan, the cascade steers.
        failures: (...,) how many plans failed so far.
        count: (...,) updates so far.
    """

    cascade: CpvState
    move: Array
    planned: Array
    fallback: NDArray[np.bool_]
    failures: Array
    count: Array


@dataclass(frozen=True)
class Mpc:
    """Model-predictive controller with a cascade to fall back on.

    Attributes:
        settings: weights and horizon.
        cascade: cascade with a model; its limits, hydrostatics, model and period are used.
        free: (12 N, 18) pose and velocity at all steps by the state [pose; velocity; thrust].
        by_move: (12 N, 6 moves) the same by the scaled moves.
        by_disturbance: (12 N, 6) the same by the disturbance.
        hessian: of the programme.
    """

    settings: MpcSettings = field(metadata={"stack": "same"})
    cascade: Cpv
    free: Array = field(init=False)
    by_move: Array = field(init=False)
    by_disturbance: Array = field(init=False)
    hessian: Array = field(init=False)

    def __post_init__(self) -> None:
        """Condense the model.

        Raises:
            ScenarioError: the cascade has no model, or the step is no multiple of its period.
        """
        if self.cascade.model is None:
            raise ScenarioError("MPC needs a cascade with a vehicle model (gains = 'extended')")
        ratio = self.settings.step / self.cascade.velocity.period
        if ratio < 0.999 or abs(ratio - round(ratio)) > 1e-6:
            raise ScenarioError(
                f"MPC step = {self.settings.step} s must be a whole multiple of the control "
                f"period {self.cascade.velocity.period} s"
            )
        a, b, e = self._model()
        free, by_move, by_disturbance = [], [], []
        x, moved, pushed = np.eye(18), np.zeros((18, 6 * len(self.settings.moves))), e * 0
        for move, length in enumerate(self.settings.moves):
            for _ in range(length):
                x, moved, pushed = a @ x, a @ moved, a @ pushed + e
                moved[:, 6 * move : 6 * move + 6] += b * self.scale
                free.append(x[:12])
                by_move.append(moved[:12])
                by_disturbance.append(pushed[:12])
        object.__setattr__(self, "free", np.concatenate(free))
        object.__setattr__(self, "by_move", np.concatenate(by_move))
        object.__setattr__(self, "by_disturbance", np.concatenate(by_disturbance))
        difference = self._difference()
        price, change = self._prices()
        weighted = self.by_move.T * self._weight()
        hessian = weighted @ self.by_move + np.diag(price)
        object.__setattr__(self, "hessian", hessian + difference.T * change @ difference)

    @property
    def times(self) -> Array:
        """Instants (N,) of the horizon after the present, s."""
        return self.settings.step * np.arange(1.0, self.settings.steps + 1, dtype=np.float64)

    @property
    def scale(self) -> Array:
        """Wrench (..., 6) of a move of 1."""
        limits = self.cascade.velocity.limits
        return 0.5 * (limits.high - limits.low)

    @property
    def _every(self) -> int:
        """Updates per plan."""
        return round(self.settings.step / self.cascade.velocity.period)

    def _model(self) -> tuple[Array, Array, Array]:
        """Sampled matrices of the state [pose; velocity; thrust] for wrench and disturbance."""
        model = self.cascade.model
        assert model is not None
        eye, zero = np.eye(6), np.zeros((6, 6))
        inverse = np.linalg.inv(model.inertia)
        # Thrusters without lag answer within a tenth of a step.
        lag = max(float(model.lag), 0.1 * self.settings.step)
        a = np.block(
            [[zero, eye, zero], [zero, -inverse @ model.damping, inverse], [zero, zero, -eye / lag]]
        )
        b = np.block([[zero, zero], [zero, inverse], [eye / lag, zero]])
        a, b = sampled(a, b, self.settings.step)
        return a, b[:, :6], b[:, 6:]

    def _weight(self) -> Array:
        """Weights (12 N,) of pose and velocity at all steps."""
        one = 1 / np.concatenate([self.settings.pose, self.settings.velocity]) ** 2
        weight = np.tile(one, (self.settings.steps, 1))
        weight[-1] *= self.settings.terminal
        return weight.ravel()

    def _prices(self) -> tuple[Array, Array]:
        """Weights (6 moves,) of scaled moves, and of their changes."""
        duration = np.repeat(self.settings.moves, 6)
        count = len(self.settings.moves)
        price = np.tile((self.scale / self.settings.wrench) ** 2, count) * duration
        return price, np.tile((self.scale / self.settings.change) ** 2, count)

    def _difference(self) -> Array:
        """Matrix (6 moves, 6 moves) of the changes between moves; the first is a move itself."""
        count = 6 * len(self.settings.moves)
        return np.eye(count) - np.eye(count, k=-6)

    def initial(self, shape: tuple[int, ...] = ()) -> MpcState:
        """State before the first update, for a leading shape."""
        return MpcState(
            self.cascade.initial(shape),
            np.zeros((*shape, 6)),
            np.zeros((*shape, 6 * len(self.settings.moves))),
            np.zeros(shape, dtype=bool),
            np.zeros(shape),
            np.zeros(shape),
        )

    def plans_now(self, state: MpcState) -> bool:
        """Whether the next update makes a plan for one of the vehicles."""
        return bool(np.any(np.mod(state.count, self._every) == 0))

    def applied(self, state: MpcState, wrench: Array) -> MpcState:
        """State when the thrusters were asked for another wrench (..., 6) than `update` gave."""
        return replace(state, cascade=self.cascade.applied(state.cascade, wrench))

    def update(self, state: MpcState, body: RigidState, demand: Demand) -> tuple[Array, MpcState]:
        """Wrench (..., 6) FLU at the body origin, and the next state; see `Controller.update`.

        Scale and push act in contact only, where the cascade steers. Without a preview the target
        keeps its acceleration and nothing is in the way.
        """
        asked = state.cascade.observer.asked
        wrench, cascade = self.cascade.update(state.cascade, body, demand)
        statics, _ = steady_wrench(self.cascade.hydrostatics, body, 0.0)
        due = np.asarray(np.mod(state.count, self._every) == 0)
        move, planned, fallback = state.move, state.planned, state.fallback
        failures = state.failures
        touching = np.broadcast_to(np.asarray(demand.contact, dtype=bool), due.shape)
        if np.any(due):
            preview = demand.preview or self._assumed(body, demand)
            wanted = due & ~touching
            plan, solved = self._plan(cascade, body, statics, asked, preview, wanted)
            planned = np.where(wanted[..., None], plan, planned)
            move = np.where(wanted[..., None], plan[..., :6] * self.scale, move)
            fallback = np.where(wanted, ~solved, fallback)
            failures = failures + (wanted & ~solved)
        own = self.cascade.velocity.limits.clip(statics + move)
        wrench = np.where((fallback | touching)[..., None], wrench, own)
        cascade = self.cascade.applied(cascade, wrench)
        return wrench, MpcState(cascade, move, planned, fallback, failures, state.count + 1.0)

    def _assumed(self, body: RigidState, demand: Demand) -> Preview:
        """Preview of a target that keeps its acceleration, for every vehicle."""
        target = demand.target
        parts = (target.position, target.quaternion, target.velocity)
        shape = body.position.shape[:-1]
        target = RigidState(*(np.broadcast_to(p, (*shape, p.shape[-1])) for p in parts))
        t = self.times.reshape(-1, *([1] * target.position.ndim))
        v = world_velocity(target)
        a = np.broadcast_to(np.asarray(demand.acceleration, dtype=float), v.shape)
        future = displaced(target, t * v + 0.5 * t**2 * a, v + t * a)
        # An entry through an aperture that is wide and far above: nothing in the way.
        away = replace(future, position=future.position + np.array([0.0, 0.0, 1e6]))
        return Preview(future, away, np.full(2, 1e6), np.ones(target.position.shape[:-1], bool))

    def programmes(
        self, cascade: CpvState, body: RigidState, statics: Array, asked: Array, preview: Preview
    ) -> tuple[Array, Array, Array, Array]:
        """Slope, rows of the geometry, lower and upper bounds of the programmes (..., k).

        Args:
            cascade: state of the cascade, with the observer.
            body: measured state of the vehicle.
            statics: (..., 6) wrench that cancels weight and buoyancy.
            asked: (..., 6) wrench that was asked for last.
            preview: what comes.
        """
        settings, model = self.settings, self.cascade.model
        assert model is not None
        limits = self.cascade.velocity.limits
        moves, steps = len(settings.moves), settings.steps
        observer = cascade.observer
        # What the plan is compared with, in the present body axes.
        pose = pose_error(preview.target, body)
        first = pose[0, ..., :3]
        length = np.sqrt(np.sum(first**2, axis=-1, keepdims=True))
        share = np.minimum(1.0, settings.error_limit / np.maximum(length, 1e-12))
        place = pose[..., :3] - (1.0 - share) * first
        speed = body.velocity - relative_velocity(body, preview.target)
        wanted = np.moveaxis(np.concatenate([place, pose[..., 3:], speed], axis=-1), 0, -2)
        wanted = wanted.reshape(*wanted.shape[:-2], 12 * steps)
        zero = np.zeros_like(body.velocity)
        x = np.concatenate([zero, body.velocity, observer.thrust - statics], axis=-1)
        push = observer.disturbance + frames.apply(model.damping, body.velocity)
        drift = frames.apply(self.free, x) + frames.apply(self.by_disturbance, push)
        missed = (drift - wanted) * self._weight()
        slope = frames.apply_transposed(self.by_move, missed)
        price, change = self._prices()
        scale = self.scale
        low, high = (limits.low - statics) / scale, (limits.high - statics) / scale
        before = np.minimum(np.maximum((asked - statics) / scale, low), high)
        slope = slope + price * np.tile(observer.disturbance / scale, moves)
        slope[..., :6] -= change[:6] * before
        # Rates: the first change is from what is given now.
        most = np.ones(6 * moves) * 2.0 * settings.step / settings.sweep
        rate_low, rate_high = np.broadcast_arrays(-most, most + 0 * slope)[:2]
        rate_low, rate_high = rate_low.copy(), rate_high.copy()
        rate_low[..., :6] += before
        rate_high[..., :6] += before
        rows, bound = self._geometry(body, preview, drift)
        lower = [np.tile(low, moves), rate_low, np.full(bound.shape, -_FREE)]
        upper = [np.tile(high, moves), rate_high, bound]
        return slope, rows, np.concatenate(lower, axis=-1), np.concatenate(upper, axis=-1)

    def _geometry(self, body: RigidState, preview: Preview, drift: Array) -> tuple[Array, Array]:
        """Rows (..., 5 k, 6 moves) and upper bounds (..., 5 k) of clearance and corridor."""
        rows: list[Array] = []
        bounds: list[Array] = []
        half = np.asarray(preview.corridor)
        entering = np.asarray(preview.entering)
        for k in range(_LOOK - 1, self.settings.steps, _LOOK):
            frame = preview.aperture.rotation[k]
            offset = unrotate(frame, body.position - preview.aperture.position[k])
            axes = [rotate(body.rotation, np.eye(3)[i]) for i in range(3)]
            turn = np.stack([unrotate(frame, axis) for axis in axes], axis=-1)  # body to aperture
            place = offset + rotate(turn, drift[..., 12 * k : 12 * k + 3])
            by_move = self.by_move[..., 12 * k : 12 * k + 3, :]
            for axis in (0, 1, 0, 1):
                sign = 1.0 if len(rows) % 5 < 2 else -1.0
                direction = sign * turn[..., axis, :] + CORRIDOR_SLOPE * turn[..., 2, :]
                rows.append(frames.apply_transposed(by_move, direction))
                now = sign * place[..., axis] + CORRIDOR_SLOPE * place[..., 2]
                bounds.append(np.where(entering, half[..., axis] - now, _FREE))
            rows.append(frames.apply_transposed(by_move, turn[..., 2, :]))
            room = -self.settings.clearance - place[..., 2]
            bounds.append(np.where(entering, _FREE, room))
        return np.stack(rows, axis=-2), np.stack(bounds, axis=-1)

    def _plan(
        self,
        cascade: CpvState,
        body: RigidState,
        statics: Array,
        asked: Array,
        preview: Preview,
        wanted: NDArray[np.bool_],
    ) -> tuple[Array, NDArray[np.bool_]]:
        """Plans (..., 6 moves) in shares of `scale`, and whether (...,) there is one."""
        slope, rows, low, high = self.programmes(cascade, body, statics, asked, preview)
        size = slope.shape[-1]
        plans = np.zeros((wanted.size, size))
        solved = np.zeros(wanted.size, dtype=bool)
        hessian = np.broadcast_to(self.hessian, (*wanted.shape, size, size))
        hessian = hessian.reshape(-1, size, size) if wanted.ndim else hessian[None]
        flat = [v.reshape(wanted.size, *v.shape[wanted.ndim :]) for v in (slope, rows, low, high)]
        difference = self._difference()
        for i in np.flatnonzero(wanted):
            f, geometry, lower, upper = (v[i] for v in flat)
            # Rows that cannot bind are left out.
            binds = upper[2 * size :] < 0.5 * _FREE
            keep = np.concatenate([np.ones(2 * size, bool), binds])
            matrix = np.concatenate([difference, geometry[binds]])
            found = solve(Programme(hessian[i], f, matrix, lower[keep], upper[keep]))
            if found is not None:
                plans[i], solved[i] = found, True
        return plans.reshape(*wanted.shape, size), solved.reshape(wanted.shape)


def solve(programme: Programme) -> Array | None:
    """Solution (k,) of a strictly convex programme, None if its constraints contradict."""
    x, _, flag, _ = daqp.solve(
        *(np.array(part) for part in (programme.hessian, programme.slope, programme.rows)),
        np.array(programme.high),
        np.array(programme.low),
        np.zeros(len(programme.high), dtype=np.int32),
        primal_tol=1e-8,
    )
    return np.asarray(x) if flag == 1 else None
