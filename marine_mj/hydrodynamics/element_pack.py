"""The elements of a body in the packed table: force laws that only some bodies have."""

import mujoco
import numpy as np

from marine_mj.environment import Environment, WaveField
from marine_mj.errors import ModelError
from marine_mj.frames import Array, rotation_from_quaternion
from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.body_settings import BodySettings, Motion
from marine_mj.hydrodynamics.coefficients import BodyCoefficients
from marine_mj.hydrodynamics.drift import Drift, mean_drift
from marine_mj.hydrodynamics.inertia import subtree_inertia
from marine_mj.hydrodynamics.memory import Memory
from marine_mj.hydrodynamics.memory_pack import memory_element
from marine_mj.hydrodynamics.panels import panel_parameters, uses_panels
from marine_mj.hydrodynamics.raos import heading_count, responses
from marine_mj.hydrodynamics.table_builder import TableBuilder

#: Headings for which wave drift is tabulated: forces like c|c| bend sharply in beam and head seas.
DRIFT_HEADINGS = 96
#: Inertia of a body with prescribed motion, kg and kg m2 (a calibration: far above any vehicle,
#: far below what would spoil the solver's scaling).
PRESCRIBED_INERTIA = 1e9
#: Stands for no limit of a force, N.
_UNLIMITED = 1e30


def free_root(model: mujoco.MjModel, body: int) -> bool:
    """Whether the body hangs on the world by a free joint of its own."""
    joint = model.body_jntadr[body]
    return bool(
        model.body_jntnum[body] == 1
        and model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_FREE
        and model.body_parentid[body] == 0
    )


def start_pose(
    model: mujoco.MjModel, body: BodyCoefficients, index: int, motion: Motion
) -> tuple[float, float, float]:
    """x, y [m] and yaw [rad], NWU, of a floating body at qpos0.

    Raises:
        ModelError: it has no free joint of its own.
    """
    if not free_root(model, index):
        raise ModelError(
            f"motion {motion!r} of {body.name!r} needs a free joint of its own on a body of the "
            "world"
        )
    address = model.jnt_qposadr[model.body_jntadr[index]]
    pose = model.qpos0[address : address + 7]
    R = rotation_from_quaternion(pose[3:])
    return float(pose[0]), float(pose[1]), float(np.arctan2(R[1, 0], R[0, 0]))


def _path(
    model: mujoco.MjModel,
    table: TableBuilder,
    body: BodyCoefficients,
    index: int,
    waves: WaveField,
    motion: Motion,
) -> list[float]:
    """Where RAO motion goes on about the pose at qpos0: x, y, z, yaw, offset of the amplitudes.

    The amplitudes (6, 2, N) are complex pose deviations in the reference heading's level axes.
    """
    x, y, yaw = start_pose(model, body, index, motion)
    if motion == "fixed":
        amplitude = np.zeros((6, len(waves.omega)), dtype=complex)
    else:
        amplitude = responses(str(body.wave_database), "motion", waves, yaw)
    along = np.cos(waves.direction) * x + np.sin(waves.direction) * y
    amplitude = amplitude * np.exp(1j * (waves.wavenumber * along + waves.phase))
    offset = table.add(np.stack([amplitude.real, amplitude.imag], axis=1))
    return [x, y, body.equilibrium_height, yaw, offset]


def reference_yaw(waves: WaveField) -> float:
    """Yaw [rad], NWU, at which tables over the heading start: the direction of one component.

    Tables then depend on the directions relative to the hull only.
    """
    return float(waves.direction[0])


def by_heading(
    table: TableBuilder, database: str, waves: WaveField, response: str
) -> tuple[int, int, float]:
    """Number of headings, offset of a response (headings, entries, 2, N), yaw of the first one.

    See `responses`.
    """
    reference, headings = reference_yaw(waves), heading_count(database, response)
    yaws = reference + 2 * np.pi * np.arange(headings) / headings
    each = responses(database, response, waves, yaws)
    return headings, table.add(np.stack([each.real, each.imag], axis=2)), reference


def _drift(
    table: TableBuilder, body: BodyCoefficients, environment: Environment, drift: Drift
) -> list[float]:
    """Mode, number of headings, offset of (DRIFT_HEADINGS, 3[, N]), and yaw of the first one."""
    amplitude = environment.waves.amplitude
    blocks = []
    reference = reference_yaw(environment.waves)
    for heading in range(DRIFT_HEADINGS):
        yaw = reference + 2 * np.pi * heading / DRIFT_HEADINGS
        each = amplitude * mean_drift(body, environment, yaw)
        blocks.append(each if drift == "slow" else each @ amplitude)
    return [t_.DRIFT_MODES[drift], DRIFT_HEADINGS, table.add(np.stack(blocks)), reference]


def _thrusters(model: mujoco.MjModel, body: BodyCoefficients, index: int) -> Array:
    """Number of thrusters, and the row of each.

    Raises:
        ModelError: the body has none, or one is no plain force along a single axis of a site.
    """
    if not body.thrust_loss:
        raise ModelError(
            f"thrust_loss is True for {body.name!r}, whose model has no numeric "
            f"'{body.name}.thrust_loss.ACTUATOR': add them, or leave thrust_loss out"
        )
    rows = []
    for name, loss in body.thrust_loss:
        actuator = model.actuator(name)
        i, site = actuator.id, actuator.trnid[0]
        gear = model.actuator_gear[i]
        force = np.linalg.norm(gear[:3])
        plain = (
            model.actuator_trntype[i] == mujoco.mjtTrn.mjTRN_SITE
            and model.actuator_gaintype[i] == mujoco.mjtGain.mjGAIN_FIXED
            and model.actuator_biastype[i] == mujoco.mjtBias.mjBIAS_NONE
            and model.site_bodyid[site] == index
            and force > 0
            and not gear[3:].any()
        )
        if not plain:
            raise ModelError(
                f"thrust_loss of {name!r}: allowed is an actuator with a fixed gain, no bias and a "
                f"gear that is a force at a site of {body.name!r}"
            )
        address = model.actuator_actadr[i]
        gain = model.actuator_gainprm[i, 0]
        low, high = -_UNLIMITED, _UNLIMITED
        if address < 0 and model.actuator_ctrllimited[i]:
            low, high = np.sort(gain * model.actuator_ctrlrange[i])
        if model.actuator_forcelimited[i]:
            low = max(low, model.actuator_forcerange[i, 0])
            high = min(high, model.actuator_forcerange[i, 1])
        place = i if address < 0 else address
        axis = rotation_from_quaternion(model.site_quat[site]) @ gear[:3] / force
        scale = [gain * force, low * force, high * force]
        rows.append([place, address >= 0, *scale, loss, *model.site_pos[site], *axis])
    return np.concatenate([[len(rows)], *np.array(rows, dtype=float)])


def pack_elements(
    model: mujoco.MjModel,
    table: TableBuilder,
    body: BodyCoefficients,
    index: int,
    environment: Environment,
    motion: Motion,
    drift: Drift,
    memory: Memory | None,
    settings: BodySettings,
    afloat: set[int],
) -> list[tuple[float, Array]]:
    """(kind, parameters) of every element of a body; what they point at goes into the table.

    Args:
        model: compiled model.
        table: grows by the data of the elements.
        body: coefficients.
        index: number of the body.
        environment: sea, current and wind.
        motion, drift, memory: of the body, see `BodySettings`.
        settings: of the body.
        afloat: bodies with buoyancy of their own, which nothing carries.

    Raises:
        ModelError: the body cannot be simulated so.
    """
    found: list[tuple[float, Array]] = []
    if memory is not None and memory.states:
        found.append((t_.MEMORY, memory_element(model, body.name, memory)))
    waves = environment.waves
    panels = uses_panels(body, settings)
    if panels:
        found.append((t_.PANELS, panel_parameters(table, body, waves, settings)))
    elif body.restoring is not None:
        mass, center, _ = subtree_inertia(model, index, afloat)
        weight = mass * environment.gravity
        data = np.concatenate([body.restoring.ravel(), [body.equilibrium_height, weight], center])
        found.append((t_.RESTORING, data))
    if motion == "dynamic" and len(waves.omega):
        path = _path(model, table, body, index, waves, motion)
        # the panels have the pressure of the undisturbed wave already
        response = "diffraction" if panels and settings.froude_krylov else "force"
        force = by_heading(table, str(body.wave_database), waves, response)
        found.append((t_.EXCITATION, np.array([*path, *force])))
    elif motion in ("rao", "fixed"):
        path = _path(model, table, body, index, waves, motion)
        kappa = PRESCRIBED_INERTIA
        found.append((t_.PRESCRIBED, np.array([*path, kappa, kappa])))
    if drift != "none" and len(waves.omega):
        found.append((t_.DRIFT, np.array(_drift(table, body, environment, drift))))
    if body.wind is not None:  # in still air, too: it brakes
        exponent = environment.wind.height_exponent
        found.append((t_.WIND, body.wind.element(body.equilibrium_height, exponent)))
    if settings.thrust_loss:
        found.append((t_.THRUSTERS, _thrusters(model, body, index)))
    for tank in body.tanks:
        actuator = model.actuator(tank.actuator).id
        address = model.actuator_actadr[actuator]
        if address < 0:
            raise ModelError(
                f"tank of {body.name!r}: the actuator {tank.actuator!r} has no activation; give it "
                'a dyntype, e.g. "integrator"'
            )
        found.append((t_.TANK, np.array([address, tank.density, *tank.position])))
    return found
