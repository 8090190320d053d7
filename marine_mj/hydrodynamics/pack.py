"""Packing coefficients and environment into the table that the native kernels read."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import mujoco
import numpy as np

from marine_mj.environment import Environment, WaveField
from marine_mj.errors import ModelError
from marine_mj.frames import Array, rotation_from_quaternion
from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.coefficients import BodyCoefficients
from marine_mj.hydrodynamics.drift import Drift, drift_of, mean_drift
from marine_mj.hydrodynamics.inertia import subtree_inertia
from marine_mj.hydrodynamics.memory import Memory
from marine_mj.hydrodynamics.memory_pack import memory_element
from marine_mj.hydrodynamics.memory_store import database_memory, has_memory_data
from marine_mj.hydrodynamics.panels import panel_parameters, restoring_of, uses_panels
from marine_mj.hydrodynamics.raos import radiation, responses

Motion = Literal["free", "dynamic", "rao"]
Radiation = Literal["memory", "constant"]
Hydrostatics = Literal["linear", "panels"]
#: Headings for which the exciting forces of a floating body are tabulated.
HEADINGS = 24
#: Headings for which wave drift is tabulated: forces like c|c| bend sharply in beam and head seas.
DRIFT_HEADINGS = 48
#: Inertia of a body with prescribed motion, kg and kg m2 (a calibration: far above any vehicle,
#: far below what would spoil the solver's scaling).
PRESCRIBED_INERTIA = 1e9


@dataclass(frozen=True)
class BodySettings:
    """How a body is simulated; the defaults are the complete physics.

    Attributes:
        motion: "dynamic" (wave forces from force RAOs), "rao" (plays back motion RAOs whatever
            touches it), "free" (no RAO table); None: "dynamic" with a wave database, else "free".
        radiation: of a "dynamic" body: "memory" (Cummins' equation with A(inf) and states for
            the memory of the water), or "constant" added mass and damping chosen for the sea;
            None: "memory" where the wave database has A(inf), else "constant".
        strips: False reduces a slender body to one point with its lumped damping.
        froude_krylov: undisturbed wave pressure on the displaced volume.
        convective: material acceleration of the water; False: its local time derivative.
        constant_buoyancy: buoyancy does not change at the surface.
        drift: second-order wave drift, "mean" or "slow" (mean and slowly varying part); None:
            "slow" where the body has coefficients for it (`hydrodynamics.drift`) and is not on
            panels, else "none".
        hydrostatics: "linear" (restoring matrix, or displaced volume), "panels" (pressure of still
            water and incident waves on the wetted panels of the hull mesh, instead of both and of
            the Froude-Krylov part of force RAOs); None: "panels" for a body that has a hull mesh
            and neither restoring nor volume, else "linear".
    """

    motion: Motion | None = None
    strips: bool = True
    froude_krylov: bool = True
    convective: bool = True
    constant_buoyancy: bool = False
    drift: Drift | None = None
    radiation: Radiation | None = None
    hydrostatics: Hydrostatics | None = None

    def __post_init__(self) -> None:
        """Check the choices."""
        for name, kinds in (
            ("motion", Motion),
            ("drift", Drift),
            ("radiation", Radiation),
            ("hydrostatics", Hydrostatics),
        ):
            value = getattr(self, name)
            if value is not None and value not in get_args(kinds):
                raise ModelError(f"{name} is {value!r}, allowed are {', '.join(get_args(kinds))}")
        if self.hydrostatics == "panels" and self.constant_buoyancy:
            raise ModelError(
                'constant_buoyancy is True with hydrostatics "panels", allowed is False: panels '
                "lose their buoyancy above the surface; leave out one of them"
            )


def motion_of(body: BodyCoefficients, settings: BodySettings) -> Motion:
    """The motion a body gets; see `BodySettings.motion`.

    Raises:
        ModelError: RAOs are asked for and the body names no wave database.
    """
    motion = settings.motion or ("dynamic" if body.wave_database else "free")
    if motion != "free" and body.wave_database is None:
        raise ModelError(
            f"motion {motion!r} of {body.name!r} needs RAOs; allowed is 'free', or a database: "
            f'<text name="{body.name}.wave_database" data="FILE.nc"/>'
        )
    return motion


def memory_of(body: BodyCoefficients, settings: BodySettings) -> Memory | None:
    """The radiation memory a body is simulated with; see `BodySettings.radiation`.

    Raises:
        ModelError: memory is asked for and the body is not "dynamic", or its wave database lacks
            what it needs or cannot be fitted.
    """
    motion = motion_of(body, settings)
    if motion != "dynamic":
        if settings.radiation == "memory":
            raise ModelError(
                f"radiation 'memory' of {body.name!r} needs the motion 'dynamic', it is "
                f"{motion!r}: leave radiation out"
            )
        return None
    name = str(body.wave_database)
    if settings.radiation == "constant" or (
        settings.radiation is None and not has_memory_data(name)
    ):
        return None
    return database_memory(name)


class _Table:
    """A growing list of float64 with blocks at known offsets."""

    def __init__(self) -> None:
        self.values: list[Array] = []
        self.length = 0

    def add(self, *parts: Array | Sequence[float] | float) -> int:
        """Append the parts; returns the offset of the first."""
        offset = self.length
        for part in parts:
            block = np.atleast_1d(np.asarray(part, dtype=float)).ravel()
            self.values.append(block)
            self.length += block.size
        return offset

    def array(self) -> Array:
        """Everything as one array."""
        return np.concatenate(self.values)


def _wave_rows(waves: WaveField) -> Array:
    """Wave data (WAVE_ROWS, N)."""
    rows = np.zeros((t_.WAVE_ROWS, len(waves.omega)))
    rows[t_.W_OMEGA] = waves.omega
    rows[t_.W_K] = waves.wavenumber
    rows[t_.W_BX] = np.cos(waves.direction)
    rows[t_.W_BY] = np.sin(waves.direction)
    rows[t_.W_PHASE] = waves.phase
    rows[t_.W_AMPLITUDE] = waves.amplitude
    with np.errstate(over="ignore"):
        finite = 1 - np.exp(-2 * waves.wavenumber * waves.depth) if len(waves.omega) else 1.0
    rows[t_.W_SPEED] = waves.amplitude * waves.omega / finite
    return rows


def _environment(table: _Table, environment: Environment) -> Array:
    """Fixed part of the table with everything of the environment filled in."""
    waves, current, wind = environment.waves, environment.current, environment.wind
    if len(waves.omega) > t_.MAX_WAVES:
        raise ModelError(
            f"the sea has {len(waves.omega)} components, allowed are {t_.MAX_WAVES} at most: "
            "lower the number of components"
        )
    fixed = np.zeros(t_.FIXED_SIZE)
    fixed[t_.H_MAGIC], fixed[t_.H_VERSION] = t_.MAGIC, t_.VERSION
    fixed[t_.E_DENSITY], fixed[t_.E_GRAVITY] = environment.water_density, environment.gravity
    fixed[t_.E_DEPTH] = waves.depth if np.isfinite(waves.depth) else 0.0
    fixed[t_.E_STRETCHING] = t_.STRETCHING[waves.stretching]
    fixed[t_.E_WAVES] = len(waves.omega)
    fixed[t_.E_WAVE_DATA] = table.add(_wave_rows(waves))
    fixed[t_.E_CREST] = waves.amplitude.sum()
    # the place is taken without a current, too: tables of other environments have to fit
    fixed[t_.E_LEVEL_DATA] = table.add(current.levels, current.velocity)
    fixed[t_.E_KNOT_DATA] = table.add(current.fluctuation)
    if np.any(current.velocity) or len(current.fluctuation):
        fixed[t_.E_LEVELS] = len(current.levels)
        fixed[t_.E_KNOTS] = len(current.fluctuation)
        fixed[t_.E_INTERVAL] = current.interval
    fixed[t_.E_WIND_KNOTS] = len(wind.velocity)
    fixed[t_.E_WIND_INTERVAL] = wind.interval
    fixed[t_.E_WIND_DATA] = table.add(wind.velocity)
    fixed[t_.E_AIR_DENSITY] = wind.air_density
    return fixed


def _contacts(model: mujoco.MjModel, table: _Table, fixed: Array) -> None:
    """Address of the contact sensor and the geoms that must not be touched."""
    sensor = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, t_.CONTACT_SENSOR)
    if sensor < 0:
        return
    names = [model.geom(i).name.split("/")[-1] for i in range(model.ngeom)]
    forbidden = [float(i) for i, name in enumerate(names) if name.startswith(t_.FORBIDDEN)]
    fixed[t_.H_SENSOR] = model.sensor_adr[sensor] + 1
    fixed[t_.H_FORBIDDEN] = len(forbidden)
    fixed[t_.H_FORBIDDEN_DATA] = table.add(forbidden)


def _chain(model: mujoco.MjModel, body: int, name: str) -> tuple[int, int]:
    """Last degree of freedom that moves the body, and how many do; checks the rows of M."""
    moving = int(model.body_weldid[body])
    if moving == 0 or model.body_dofnum[moving] == 0:
        raise ModelError(
            f"hydrodynamic body {name!r} cannot move: give it or a parent a joint, or remove its "
            "coefficients"
        )
    last = int(model.body_dofadr[moving] + model.body_dofnum[moving] - 1)
    dof, count = last, 0
    while dof >= 0:
        count += 1
        dof = int(model.dof_parentid[dof])
    if count > t_.MAX_CHAIN:
        raise ModelError(
            f"{count} degrees of freedom move the body {name!r}, allowed are {t_.MAX_CHAIN}"
        )
    dof, left = last, count
    while dof >= 0:
        if model.M_rownnz[dof] != left:
            raise ModelError(
                f"MuJoCo treats the body {name!r} as simple and stores only the diagonal of its "
                'inertia: set simple="false" on it (marine_mj.load_xml does)'
            )
        left -= 1
        dof = int(model.dof_parentid[dof])
    return last, count


def _free_root(model: mujoco.MjModel, body: int) -> bool:
    """Whether the body hangs on the world by a free joint of its own."""
    joint = model.body_jntadr[body]
    return bool(
        model.body_jntnum[body] == 1
        and model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_FREE
        and model.body_parentid[body] == 0
    )


def _start_pose(
    model: mujoco.MjModel, body: BodyCoefficients, index: int, motion: Motion
) -> tuple[float, float, float]:
    """x, y [m] and yaw [rad], NWU, of a floating body at qpos0.

    Raises:
        ModelError: it has no free joint of its own.
    """
    if not _free_root(model, index):
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
    table: _Table,
    body: BodyCoefficients,
    index: int,
    waves: WaveField,
    motion: Motion,
) -> list[float]:
    """Where RAO motion goes on about the pose at qpos0: x, y, z, yaw, offset of the amplitudes.

    The amplitudes (6, 2, N) are complex pose deviations in the reference heading's level axes.
    """
    x, y, yaw = _start_pose(model, body, index, motion)
    amplitude = responses(str(body.wave_database), "motion", waves, yaw)
    along = np.cos(waves.direction) * x + np.sin(waves.direction) * y
    amplitude = amplitude * np.exp(1j * (waves.wavenumber * along + waves.phase))
    offset = table.add(np.stack([amplitude.real, amplitude.imag], axis=1))
    return [x, y, body.equilibrium_height, yaw, offset]


def _exciting_forces(
    table: _Table, body: BodyCoefficients, waves: WaveField, response: str
) -> list[float]:
    """Number of headings and offset of the exciting forces (HEADINGS, 6, 2, N)."""
    blocks = []
    for heading in range(HEADINGS):
        yaw = 2 * np.pi * heading / HEADINGS
        force = responses(str(body.wave_database), response, waves, yaw)
        blocks.append(np.stack([force.real, force.imag], axis=1))
    return [HEADINGS, table.add(np.stack(blocks))]


def _drift(
    table: _Table, body: BodyCoefficients, environment: Environment, drift: Drift
) -> list[float]:
    """Mode, number of headings and offset of the drift: (DRIFT_HEADINGS, 3), or (..., 3, N)."""
    amplitude = environment.waves.amplitude
    blocks = []
    for heading in range(DRIFT_HEADINGS):
        each = amplitude * mean_drift(body, environment, 2 * np.pi * heading / DRIFT_HEADINGS)
        blocks.append(each if drift == "slow" else each @ amplitude)
    return [t_.DRIFT_MODES[drift], DRIFT_HEADINGS, table.add(np.stack(blocks))]


def _elements(
    model: mujoco.MjModel,
    table: _Table,
    body: BodyCoefficients,
    index: int,
    environment: Environment,
    motion: Motion,
    drift: Drift,
    memory: Memory | None,
    settings: BodySettings,
    afloat: set[int],
) -> list[tuple[float, Array]]:
    """(kind, parameters) of every element of a body."""
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
        force = _exciting_forces(table, body, waves, response)
        found.append((t_.EXCITATION, np.array([*path, *force])))
    elif motion == "rao":
        path = _path(model, table, body, index, waves, motion)
        kappa = PRESCRIBED_INERTIA
        found.append((t_.PRESCRIBED, np.array([*path, kappa, kappa])))
    if drift != "none" and len(waves.omega):
        found.append((t_.DRIFT, np.array(_drift(table, body, environment, drift))))
    if body.wind is not None:  # in still air, too: it brakes
        found.append((t_.WIND, body.wind))
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


def _volume(body: BodyCoefficients, environment: Environment) -> float:
    """Displaced volume, m3."""
    if body.buoyancy:
        return body.buoyancy / (environment.water_density * environment.gravity)
    return body.displaced_volume


def _record(
    model: mujoco.MjModel,
    table: _Table,
    body: BodyCoefficients,
    environment: Environment,
    settings: BodySettings,
    afloat: set[int],
) -> Array:
    """Record of one body; what it points at goes into the table first.

    `afloat`: bodies with a buoyancy of their own, which their carrier does not bear.
    """
    index = model.body(body.name).id
    last, count = _chain(model, index, body.name)
    motion = motion_of(body, settings)
    p = np.zeros(t_.B_FIXED_SIZE)
    p[t_.B_SIZE] = t_.B_FIXED_SIZE
    p[t_.B_BODY], p[t_.B_ROOT] = index, model.body_rootid[index]
    p[t_.B_LAST_DOF], p[t_.B_CHAIN] = last, count
    p[t_.B_FREE] = _free_root(model, index)
    panels = uses_panels(body, settings)
    p[t_.B_VOLUME] = 0.0 if panels else _volume(body, environment)
    p[t_.B_CB : t_.B_CB + 3] = body.center_of_buoyancy
    p[t_.B_FROUDE_KRYLOV] = settings.froude_krylov
    p[t_.B_CONVECTIVE] = settings.convective
    p[t_.B_SEAKEEPING] = motion == "dynamic"
    quadratic = body.quadratic_damping
    half_height = body.submergence_height
    if body.strips is not None and settings.strips:
        strips = body.strips
        x = strips.x
        mean = float(strips.weight @ x)
        p[t_.B_STRIPS] = len(x)
        p[t_.B_STRIP_X], p[t_.B_STRIP_DX] = strips.first, strips.length
        p[t_.B_STRIP_DRAG : t_.B_STRIP_DRAG + 2] = strips.drag
        p[t_.B_STRIP_WEIGHT] = table.add(strips.weight)
        p[t_.B_STRIP_MEAN] = mean
        p[t_.B_STRIP_SPREAD] = strips.weight @ (x - mean) ** 2
        half_height = half_height or strips.radius
    elif body.quadratic_damping_lumped is not None:
        quadratic = body.quadratic_damping_lumped
    p[t_.B_HALF_HEIGHT] = 0.0 if settings.constant_buoyancy else half_height
    added_mass, linear = body.added_mass, body.linear_damping
    memory = memory_of(body, settings)
    if memory is not None:
        added_mass, linear = memory.infinite_added_mass, body.viscous_damping
    elif motion == "dynamic" and len(environment.waves.omega):
        added_mass, linear = radiation(
            str(body.wave_database),
            environment.waves,
            subtree_inertia(model, index, afloat)[2],
            restoring_of(model, body, settings, environment),
            body.viscous_damping,
            _start_pose(model, body, index, motion)[2],
        )
        linear = linear + body.viscous_damping
    p[t_.B_ADDED_MASS : t_.B_ADDED_MASS + 36] = added_mass.ravel()
    p[t_.B_LINEAR : t_.B_LINEAR + 36] = linear.ravel()
    p[t_.B_QUADRATIC : t_.B_QUADRATIC + 36] = quadratic.ravel()
    drift: Drift = "none"  # calm water needs no database, panels have their own
    if settings.drift or (len(environment.waves.omega) and not uses_panels(body, settings)):
        drift = drift_of(body, settings.drift, motion)
    elements = _elements(
        model, table, body, index, environment, motion, drift, memory, settings, afloat
    )
    p[t_.B_ELEMENTS] = len(elements)
    p[t_.B_ELEMENT_DATA] = table.length
    for kind, data in elements:
        table.add([kind, t_.EL_DATA + data.size], data)
    return p


def pack_table(
    model: mujoco.MjModel,
    bodies: Sequence[BodyCoefficients],
    environment: Environment,
    settings: dict[str, BodySettings],
) -> Array:
    """The packed table (n,) of a compiled model for one environment.

    The length depends on the numbers of bodies, wave components and knots only, so tables of
    different seeds fit in the same model and in `mujoco.batch.Batch.expand("numeric_data")`.

    Args:
        model: compiled model that has the bodies.
        bodies: from `read_coefficients`.
        environment: sea, current and wind.
        settings: by body name; bodies that are not named get the defaults.

    Raises:
        ModelError: a setting names no hydrodynamic body, or a body cannot be simulated so.
    """
    names = [body.name for body in bodies]
    for name in settings:
        if name not in names:
            raise ModelError(f"settings name the body {name!r}; hydrodynamic bodies are {names}")
    table = _Table()
    table.add(np.zeros(t_.FIXED_SIZE))
    fixed = _environment(table, environment)
    _contacts(model, table, fixed)
    afloat = {
        int(model.body(body.name).id)
        for body in bodies
        if body.displaced_volume or body.buoyancy or body.restoring is not None
    }
    records = [
        _record(model, table, body, environment, settings.get(body.name, BodySettings()), afloat)
        for body in bodies
    ]
    fixed[t_.H_BODIES], fixed[t_.H_FIRST_BODY] = len(records), table.length
    table.add(*records)
    fixed[t_.H_LENGTH] = table.length
    values = table.array()
    values[: t_.FIXED_SIZE] = fixed
    return values
