"""Linear-quadratic regulator with integral action in six axes.

Model: deviations from the feed-forward, linear in body axes, with the thrusters' lag T,

    x = [sum of e; e; v; f],   e' = -v,   M v' = f - D v,   T f' = u - f,

e pose error, v velocity relative to the target, f thrust beyond the feed-forward. The gain
minimises `sum(x' Q x + u' R u)` for the sampled model (discrete Riccati equation, `scipy.linalg`).
Body axes FLU at the body origin.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from marine_mj.controllers.demand import Demand
from marine_mj.controllers.hydrostatics import Hydrostatics, steady_wrench
from marine_mj.controllers.kinematics import RigidState
from marine_mj.controllers.observer import ObserverState, VehicleModel, observe
from marine_mj.controllers.pid import Limits, hold_positive

from marine_mj import frames
from marine_mj.errors import ScenarioError
from marine_mj.frames import Array


@dataclass(frozen=True)
class LqrWeights:
    """What counts as equally bad in each axis (Bryson's rule: `Q = 1 / value^2`), all > 0.

    Attributes:
        integral: (6,) sum of the pose error, m s and rad s.
        pose: (6,) pose error, m and rad.
        velocity: (6,) relative velocity, m/s and rad/s.
        wrench: (6,) wrench, N and N m.
        speed: (6,) largest speed towards the target, m/s and rad/s.
    """

    integral: Array | Sequence[float]
    pose: Array | Sequence[float]
    velocity: Array | Sequence[float]
    wrench: Array | Sequence[float]
    speed: Array | Sequence[float]

    def __post_init__(self) -> None:
        """Raise ScenarioError for a value that is not positive."""
        hold_positive(self, "LQR weights", "integral", "pose", "velocity", "wrench", "speed")


LQR_WEIGHTS = {
    # Ours: the wrench weights bring the closed loop to 1 to 3 rad/s.
    "extended": LqrWeights(
        integral=[0.6, 0.6, 0.6, 1.0, 0.6, 0.6],
        pose=[0.3, 0.3, 0.3, 0.3, 0.3, 0.3],
        velocity=[0.4, 0.4, 0.4, 0.6, 0.4, 0.4],
        wrench=[90.0, 130.0, 130.0, 1.5, 35.0, 35.0],
        speed=[0.8, 0.35, 0.3, 0.5, 0.5, 0.5],
    ),
}


def sampled(a: Array, b: Array, period: float) -> tuple[Array, Array]:
    """Matrices of `x+ = A x + B u` for `x' = a x + b u` with u held over the period (s)."""
    n, m = b.shape
    block = np.zeros((n + m, n + m))
    block[:n, :n], block[:n, n:] = a, b
    from scipy.linalg import expm  # here: it takes a fifth of a second

    both = expm(block * period)
    return both[:n, :n], both[:n, n:]


def lqr_model(model: VehicleModel, period: float) -> tuple[Array, Array]:
    """Sampled matrices A, B of the module's model; without lag the thrust is no state."""
    eye, zero = np.eye(6), np.zeros((6, 6))
    inverse = np.linalg.inv(model.inertia)
    drag = -inverse @ model.damping
    if model.lag == 0:
        a = np.block([[zero, eye, zero], [zero, zero, -eye], [zero, zero, drag]])
        return sampled(a, np.vstack([zero, zero, inverse]), period)
    a = np.block(
        [
            [zero, eye, zero, zero],
            [zero, zero, -eye, zero],
            [zero, zero, drag, inverse],
            [zero, zero, zero, -eye / model.lag],
        ]
    )
    return sampled(a, np.vstack([zero, zero, zero, eye / model.lag]), period)


def lqr_gain(model: VehicleModel, weights: LqrWeights, period: float) -> Array:
    """Gain K (6, 24) of `u = -K x`; without lag the last six columns are zero.

    Raises:
        ScenarioError: the Riccati equation has no stabilising solution.
    """
    a, b = lqr_model(model, period)
    worst = np.concatenate([weights.integral, weights.pose, weights.velocity])
    # The thrust state itself is free: the wrench it follows has a price.
    state_cost = np.zeros(len(a))
    state_cost[:18] = 1 / worst**2
    price = np.diag(1 / np.asarray(weights.wrench) ** 2)
    try:
        from scipy.linalg import solve_discrete_are

        p = solve_discrete_are(a, b, np.diag(state_cost), price)
    except np.linalg.LinAlgError as error:
        raise ScenarioError(
            f"LQR: no stabilising gain for inertia diagonal {np.diag(model.inertia)} and lag "
            f"{model.lag} s ({error}); check the inertia and the weights"
        ) from None
    gain = np.zeros((6, 24))
    gain[:, : len(a)] = np.linalg.solve(price + b.T @ p @ b, b.T @ p @ a)
    return gain


@dataclass(frozen=True)
class LqrState:
    """Memory of the regulator.

    Attributes:
        integral: (..., 6) sum of the pose error that the regulator saw, m s and rad s.
        observer: of thrust and disturbance.
    """

    integral: Array
    observer: ObserverState


@dataclass(frozen=True)
class Lqr:
    """State feedback about a feed-forward from target acceleration and observed disturbance.

    Attributes:
        weights: what counts as equally bad.
        limits: of the wrench, FLU; the integral part is held to half of them.
        period: time between two updates, s.
        model: wet inertia, drag, thruster lag and observer.
        hydrostatics: weight and buoyancy to cancel, None to leave them to the integral.
        gain: (6, 24), computed.
    """

    weights: LqrWeights
    limits: Limits
    period: float
    model: VehicleModel
    hydrostatics: Hydrostatics | None = None
    gain: Array = field(init=False)

    def __post_init__(self) -> None:
        """Solve for the gain."""
        object.__setattr__(self, "gain", lqr_gain(self.model, self.weights, self.period))

    def initial(self, shape: tuple[int, ...] = ()) -> LqrState:
        """State before the first update, for a leading shape."""
        return LqrState(np.zeros((*shape, 6)), ObserverState.initial(shape))

    def applied(self, state: LqrState, wrench: Array) -> LqrState:
        """State when the thrusters were asked for another wrench (..., 6) than `update` gave."""
        return LqrState(state.integral, state.observer.asked_for(wrench))

    def update(self, state: LqrState, body: RigidState, demand: Demand) -> tuple[Array, LqrState]:
        """Wrench (..., 6) FLU at the body origin, and the next state; see `Controller.update`."""
        statics, feed_forward = steady_wrench(self.hydrostatics, body, demand.push)
        observer = observe(
            self.model, self.limits, self.period, state.observer, body, statics, demand.contact
        )
        wanted = frames.apply(self.model.inertia, demand.rates(body))
        feed_forward = feed_forward + wanted - observer.disturbance
        held = demand.held
        per_axis = np.diagonal(self.gain.reshape(*self.gain.shape[:-1], 4, 6), axis1=-3, axis2=-1)
        by_sum, by_error, by_speed = (np.abs(per_axis[..., i, :]) for i in range(3))
        # Far targets: no more error than what the wanted speed balances.
        farthest = self.weights.speed * by_speed / by_error
        error = np.clip(demand.error(body), -farthest, farthest)
        integral = np.clip(
            state.integral + self.period * error,
            0.5 * self.limits.low / by_sum,
            0.5 * self.limits.high / by_sum,
        )
        beyond = (observer.thrust - feed_forward) * held
        x = np.concatenate([integral * held, error, demand.slip(body), beyond], axis=-1)
        wrench = self.limits.clip(feed_forward - frames.apply(self.gain, x))
        return wrench, LqrState(integral, observer.asked_for(wrench))
