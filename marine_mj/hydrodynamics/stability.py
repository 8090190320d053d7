"""The largest time step at which the explicit hydrodynamic forces are stable."""

from collections.abc import Mapping, Sequence

import mujoco
import numpy as np

from marine_mj.environment import Environment
from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.hydrodynamics.coefficients import BodyCoefficients
from marine_mj.hydrodynamics.inertia import rigid_inertia
from marine_mj.hydrodynamics.pack import BodySettings
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
    return body.linear_damping + 2 * quadratic * nu[None, :]


def largest_timestep(
    model: mujoco.MjModel, body: BodyCoefficients, settings: BodySettings
) -> float:
    """Largest stable time step [s] of a body: `h D / M < 2` and `h omega < 2` (RK4: 2.78, 2.82).

    The mass is the body's own with added mass (what hangs on it can only raise the limit); the
    damping slope is taken at `reference_speed`, the restoring of a hull mesh at its equilibrium.

    Raises:
        ModelError: the hull mesh of a body on panels finds no equilibrium.
    """
    M = rigid_inertia(model, model.body(body.name).id) + body.added_mass
    rk4 = model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4
    inverse = np.linalg.pinv(M)
    rate = np.abs(np.linalg.eigvals(inverse @ damping_at(body, settings))).max()
    bounds = [np.inf]
    if rate > 0:
        bounds.append((DAMPING_LIMIT_RK4 if rk4 else DAMPING_LIMIT) / rate)
    G = restoring_of(model, body, settings, Environment())
    square = np.abs(np.linalg.eigvals(inverse @ G)).max()
    if square > 0:
        bounds.append((SPRING_LIMIT_RK4 if rk4 else SPRING_LIMIT) / np.sqrt(square))
    return float(min(bounds))


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
