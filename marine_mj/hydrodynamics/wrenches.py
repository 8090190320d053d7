"""Forces on a body by cause, and checks of a running simulation."""

from collections.abc import Iterable

import mujoco
import numpy as np

from marine_mj.errors import SimulationError
from marine_mj.frames import Array
from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.native import records, report, table_of

#: Causes that `wrenches` reports, in this order.
CAUSES = (*t_.CAUSES, "gravity", "contact", "constraint", "propulsion", "applied")


def body_acceleration(model: mujoco.MjModel, data: mujoco.MjData, body: int) -> Array:
    """nu_dot (6) = d/dt [v; omega] of the body frame in its own axes FLU, from `data.qacc`."""
    return _twist_rate(model, data, body, data.xmat[body].reshape(3, 3), None)


def _twist_rate(
    model: mujoco.MjModel, data: mujoco.MjData, body: int, R: Array, spin: Array | None
) -> Array:
    """d/dt [v; omega] (6) of the body origin in axes R that turn with `spin` (None: the body's)."""
    x = data.xpos[body]
    J, J_dot = np.zeros((6, model.nv)), np.zeros((6, model.nv))
    mujoco.mj_jac(model, data, J[:3], J[3:], x, body)
    mujoco.mj_jacDot(model, data, J_dot[:3], J_dot[3:], x, body)
    world = J @ data.qacc + J_dot @ data.qvel
    v, omega = R.T @ (J[:3] @ data.qvel), R.T @ (J[3:] @ data.qvel)
    spin = omega if spin is None else spin
    return np.concatenate(
        [R.T @ world[:3] - np.cross(spin, v), R.T @ world[3:] - np.cross(spin, omega)]
    )


def _level_axes(model: mujoco.MjModel, data: mujoco.MjData, body: int) -> tuple[Array, Array]:
    """Level axes (3, 3) turned by the yaw of a body, and their angular velocity (3) in them."""
    own = data.xmat[body].reshape(3, 3)
    c, s = own[:2, 0] / np.hypot(*own[:2, 0])
    rate = np.cross(data.cvel[body, :3], own[:, 0])
    turn = (own[0, 0] * rate[1] - own[1, 0] * rate[0]) / (own[:2, 0] @ own[:2, 0])
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]), np.array([0.0, 0.0, turn])


def added_mass_of(model: mujoco.MjModel, body: int) -> Array:
    """Added mass (6, 6) of a body under water or afloat, FLU, about the body origin.

    In the air and at the surface the kernel takes the wet share of it.
    """
    for record in records(table_of(model)):
        if int(record[t_.B_BODY]) == body:
            return record[t_.B_ADDED_MASS : t_.B_ADDED_MASS + 36].reshape(6, 6)
    return np.zeros((6, 6))


def damping_of(model: mujoco.MjModel, body: int, speed: float, rate: float) -> Array:
    """Slope (6, 6) of a body's damping at a speed, `D_L + 2 D_Q |nu|` with strips, FLU.

    Args:
        model: marine model.
        body: id of the body; zeros if it has no coefficients.
        speed: of the origin along each axis, m/s.
        rate: about each axis, rad/s.
    """
    for p in records(table_of(model)):
        if int(p[t_.B_BODY]) == body:
            linear, quadratic = (
                p[at : at + 36].reshape(6, 6) for at in (t_.B_LINEAR, t_.B_QUADRATIC)
            )
            slope = linear + 2 * quadratic * np.repeat([speed, rate], 3)
            dx = p[t_.B_STRIP_DX]
            x = p[t_.B_STRIP_X] + dx * np.arange(int(p[t_.B_STRIPS]))
            sway, heave = 2 * dx * p[t_.B_STRIP_DRAG : t_.B_STRIP_DRAG + 2]
            along, about = speed * len(x), rate * np.sum(np.abs(x) ** 3)
            return slope + np.diag([0, sway * along, heave * along, 0, heave * about, sway * about])
    return np.zeros((6, 6))


def _contact_wrenches(model: mujoco.MjModel, data: mujoco.MjData, groups: Array) -> Array:
    """World wrench (nbody, 6) [force; moment about the world origin] of all contacts, by group."""
    total = np.zeros((model.nbody, 6))
    force = np.zeros(6)
    for index in range(data.ncon):
        contact = data.contact[index]
        mujoco.mj_contactForce(model, data, index, force)
        frame = contact.frame.reshape(3, 3)
        push, twist = frame.T @ force[:3], frame.T @ force[3:]
        wrench = np.concatenate([push, np.cross(contact.pos, push) + twist])
        for geom, sign in zip(contact.geom, (-1.0, 1.0), strict=True):
            if geom >= 0:
                total[groups[model.geom_bodyid[geom]]] += sign * wrench
    return total


def _generalized(
    model: mujoco.MjModel, data: mujoco.MjData, body: int, force: Array
) -> Array | None:
    """Wrench (6) at a free body's origin, body axes, of generalized forces; None if not free."""
    joint = model.body_jntadr[body]
    if model.body_jntnum[body] != 1 or model.jnt_type[joint] != mujoco.mjtJoint.mjJNT_FREE:
        return None
    dof = model.jnt_dofadr[joint]
    R = data.xmat[body].reshape(3, 3)
    return np.concatenate([R.T @ force[dof : dof + 3], force[dof + 3 : dof + 6]])


def wrenches(model: mujoco.MjModel, data: mujoco.MjData) -> dict[str, dict[str, Array]]:
    """Wrench on every hydrodynamic body by cause, for the state and acceleration in `data`.

    Call `mj_forward` (or step) first. The causes sum to the rate of change of the rigid body's
    momentum, `M_RB nu_dot + C_RB(nu) nu` (with everything rigidly fixed to it). "propulsion",
    "constraint" and "applied" (the user's `qfrc_applied`, `xfrc_applied`, springs and limits) are
    reported for bodies with a free joint of their own; on an articulated vehicle they are spread
    over the joints and come out as zero here.

    Returns:
        {body name: {cause: (6,) [N, N m]}}, about the body origin, body axes FLU; causes are
        added_mass (with `-M_A nu_dot`), damping, restoring (buoyancy, hydrostatics), waves, wind,
        ballast, prescribed, gravity, contact, constraint (latch), propulsion, applied.

    Raises:
        ModelError: the model has no hydrodynamics table.
    """
    raw = report(model, data)
    welded = np.asarray(model.body_weldid)
    contacts = _contact_wrenches(model, data, welded)
    result: dict[str, dict[str, Array]] = {}
    for row, record in zip(raw, records(table_of(model)), strict=True):
        body = int(record[t_.B_BODY])
        forces = row[: 6 * len(t_.CAUSES)].reshape(-1, 6)
        inertia = row[6 * len(t_.CAUSES) :].reshape(t_.INERTIAS, 6, 6)
        causes = {name: forces[i].copy() for i, name in enumerate(t_.CAUSES)}
        R, x = data.xmat[body].reshape(3, 3), data.xpos[body]
        axes, spin = _level_axes(model, data, body) if record[t_.B_SEAKEEPING] else (R, None)
        nu_dot = _twist_rate(model, data, body, axes, spin)
        owners = ("added_mass", "ballast", "prescribed")
        for name, matrix in zip(owners, inertia, strict=True):
            causes[name] -= matrix @ nu_dot
        to_body = R.T @ axes
        for name, force in causes.items():
            causes[name] = np.concatenate([to_body @ force[:3], to_body @ force[3:]])
        group = np.flatnonzero(welded == welded[body])
        weight = np.zeros(6)
        for part in group:
            push = R.T @ (model.body_mass[part] * model.opt.gravity)
            arm = R.T @ (data.xipos[part] - x)
            weight += np.concatenate([push, np.cross(arm, push)])
        causes["gravity"] = weight
        push = contacts[welded[body]][:3]
        twist = contacts[welded[body]][3:] - np.cross(x, push)
        causes["contact"] = np.concatenate([R.T @ push, R.T @ twist])
        none = np.zeros(6)
        constraint = _generalized(model, data, body, data.qfrc_constraint)
        causes["constraint"] = none if constraint is None else constraint - causes["contact"]
        thrust = _generalized(model, data, body, data.qfrc_actuator)
        causes["propulsion"] = none if thrust is None else thrust
        other: Array = data.qfrc_applied + data.qfrc_spring
        other = other + data.qfrc_damper + data.qfrc_gravcomp
        applied = _generalized(model, data, body, other)
        causes["applied"] = none if applied is None else _pushed(applied, data, group, R, x)
        result[model.body(body).name] = {name: causes[name] for name in CAUSES}
    return result


def _pushed(start: Array, data: mujoco.MjData, group: Iterable[int], R: Array, x: Array) -> Array:
    """`start` (6) plus the user's `xfrc_applied` on the bodies of a group, at x, body axes."""
    total = start.copy()
    for part in group:
        push, twist = data.xfrc_applied[part, :3], data.xfrc_applied[part, 3:]
        arm = data.xipos[part] - x
        total += np.concatenate([R.T @ push, R.T @ (twist + np.cross(arm, push))])
    return total


#: MuJoCo's warnings after which a state is worth nothing.
STATE_WARNINGS = (
    mujoco.mjtWarning.mjWARN_BADQPOS,
    mujoco.mjtWarning.mjWARN_BADQVEL,
    mujoco.mjtWarning.mjWARN_BADQACC,
    mujoco.mjtWarning.mjWARN_BADCTRL,
)


def check_control(model: mujoco.MjModel, control: Array, time: float) -> None:
    """Raise if a command (nu,) is not a finite number.

    Raises:
        SimulationError: names the actuator, its command and the time [s].
    """
    bad = np.flatnonzero(~np.isfinite(control))
    if bad.size:
        name = model.actuator(int(bad[0])).name
        raise SimulationError(
            f"control of actuator {name!r} is {np.asarray(control).flat[bad[0]]} at t = "
            f"{time:.3f} s: the controller must give finite commands"
        )


def check_state(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Raise if the simulation has diverged or was fed something that is not a number.

    Raises:
        SimulationError: names the time, the body and its state.
    """
    for warning in STATE_WARNINGS:
        record = data.warning[warning]
        if record.number == 0:
            continue
        index = record.lastinfo
        if warning == mujoco.mjtWarning.mjWARN_BADCTRL:
            name = model.actuator(index).name or f"number {index}"
            raise SimulationError(
                f"control of actuator {name!r} is {data.ctrl[index]} at t = {data.time:.4f} s, "
                "allowed are finite numbers: check the controller that wrote it"
            )
        if warning == mujoco.mjtWarning.mjWARN_BADQPOS:
            joint = int(np.searchsorted(model.jnt_qposadr, index, side="right")) - 1
            index = int(model.jnt_dofadr[joint])
        dof = min(index, model.nv - 1)
        body = int(model.dof_bodyid[dof])
        mujoco.mj_kinematics(model, data)  # positions of the state, not of the last step
        raise SimulationError(
            f"the simulation diverged at t = {data.time:.4f} s: body {model.body(body).name!r} has "
            f"position {np.round(data.xpos[body], 3)} m and velocity "
            f"{np.round(data.qvel[model.body_dofadr[body] :][:6], 3)}, acceleration "
            f"{data.qacc_warmstart[dof]:.3g}; lower the time step (see marine-mj check-model) or "
            "the forces"
        )
    if not (np.isfinite(data.qpos).all() and np.isfinite(data.qvel).all()):
        raise SimulationError(
            f"the state holds values that are not finite numbers at t = {data.time:.4f} s: "
            f"qpos {data.qpos}, qvel {data.qvel}"
        )
