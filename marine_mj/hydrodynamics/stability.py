"""The largest time step at which the explicit hydrodynamic forces are stable."""

from collections.abc import Mapping, Sequence

import mujoco
import numpy as np

from marine_mj.environment import Environment
from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.hydrodynamics.body_settings import BodySettings, memory_of
from marine_mj.hydrodynamics.coefficients import BodyCoefficients
from marine_mj.hydrodynamics.inertia import rigid_inertia
from marine_mj.hydrodynamics.memory import Memory
from marine_mj.hydrodynamics.panels import restoring_of

#: Largest h lambda of `x' = -lambda x` (semi-implicit Euler and kin; RK4; both measured).
DAMPING_LIMIT, DAMPING_LIMIT_RK4 = 2.0, 2.78
#: Largest h omega of `x'' = -omega^2 x`.
SPRING_LIMIT, SPRING_LIMIT_RK4 = 2.0, 2.82


def damping_at(body: BodyCoefficients, settings: BodySettings) -> Array:
    """Slope (6, 6) of the damping force at the reference speed: `D_L + 2 D_Q |nu|`, FLU."""
    nu = np.repeat(np.abs(body.reference_speed), 3)
    quadratic = body.quadratic_damping
    if settings.strips and body.strips is not None:
        strips = body.strips
        sway, heave = strips.drag * strips.length
        x = strips.x
        quadratic = quadratic.copy()
        quadratic[1, 1] += sway * len(x)
        quadratic[2, 2] += heave * len(x)
        quadratic[4, 4] += heave * np.sum(np.abs(x) ** 3)
        quadratic[5, 5] += sway * np.sum(np.abs(x) ** 3)
    elif body.quadratic_damping_lumped is not None:
        quadratic = body.quadratic_damping_lumped
    memory = memory_of(body, settings)
    linear = body.linear_damping if memory is None else body.viscous_damping
    return linear + 2 * quadratic * nu[None, :]


def _growth(inverse: Array, D: Array, G: Array, memory: Memory, step: float, rk4: bool) -> float:
    """Spectral radius of one linear time step of a body with radiation memory.

    The state is [eta (held degrees of freedom), nu, memory]; `inverse` is that of M.
    """
    held = np.flatnonzero(G.any(axis=0))
    A, B, C = memory.state_space()
    n, m = len(held), len(A)
    F = np.zeros((n + 6 + m, n + 6 + m))
    eta, nu, x = slice(0, n), slice(n, n + 6), slice(n + 6, None)
    if rk4:
        F[np.arange(n), n + held] = 1.0
        F[nu, eta], F[nu, nu], F[nu, x] = -inverse @ G[:, held], -inverse @ D, -inverse @ C
        F[x, nu], F[x, x] = B, A
        one = np.eye(len(F))
        F = step * F
        F = one + F @ (one + F @ (one + F @ (one + F / 4) / 3) / 2)
    else:
        growth, drive = memory.discrete(step)
        F[x, nu], F[x, x] = drive, growth
        F[nu] = -step * inverse @ C @ F[x]  # the force of the states at the end of the step
        F[nu, eta] -= step * inverse @ G[:, held]
        F[nu, nu] += np.eye(6) - step * inverse @ D
        F[eta] = step * F[nu][held]
        F[eta, eta] += np.eye(n)
    return float(np.abs(np.linalg.eigvals(F)).max())


def largest_timestep(
    model: mujoco.MjModel, body: BodyCoefficients, settings: BodySettings
) -> float:
    """Largest stable time step [s] of a body: `h D / M < 2` and `h omega < 2` (RK4: 2.78, 2.82).

    The mass is the body's own with added mass (what hangs on it can only raise the limit); the
    damping slope is taken at `reference_speed`, the restoring of a hull mesh at its equilibrium.
    With radiation memory the added mass is A(inf), and the limit is lowered until the linear step
    of body and memory together does not grow.

    Raises:
        ModelError: the hull mesh of a body on panels finds no equilibrium.
    """
    memory = memory_of(body, settings)
    M = rigid_inertia(model, model.body(body.name).id)
    M = M + (body.added_mass if memory is None else memory.infinite_added_mass)
    rk4 = model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4
    inverse = np.asarray(np.linalg.pinv(M), dtype=float)
    D = damping_at(body, settings)
    rate = np.abs(np.linalg.eigvals(inverse @ D)).max()
    bounds = [np.inf]
    if rate > 0:
        bounds.append((DAMPING_LIMIT_RK4 if rk4 else DAMPING_LIMIT) / rate)
    G = restoring_of(model, body, settings, Environment())
    square = np.abs(np.linalg.eigvals(inverse @ G)).max()
    if square > 0:
        bounds.append((SPRING_LIMIT_RK4 if rk4 else SPRING_LIMIT) / np.sqrt(square))
    bound = float(min(bounds))
    if memory is None:
        return bound
    bound = min(bound, 1.0)
    while _growth(inverse, D, G, memory, bound, rk4) > 1 + 1e-9:
        bound *= 0.9
    return bound


def check_timestep(
    model: mujoco.MjModel,
    bodies: Sequence[BodyCoefficients],
    settings: Mapping[str, BodySettings],
) -> None:
    """Raise if the model's time step is above the stable bound of one of its bodies.

    Raises:
        ModelError: it is; the message gives the bound.
    """
    for body in bodies:
        chosen = settings.get(body.name, BodySettings())
        if chosen.motion == "rao":
            continue
        bound = largest_timestep(model, body, chosen)
        if model.opt.timestep > bound:
            speed, spin = body.reference_speed
            raise ModelError(
                f"timestep is {model.opt.timestep:g} s, allowed is at most {bound:.4g} s: above "
                f"it the damping or restoring of {body.name!r} is unstable (at its reference "
                f"speed of {speed:g} m/s and {spin:g} rad/s); lower the timestep or use RK4"
            )
