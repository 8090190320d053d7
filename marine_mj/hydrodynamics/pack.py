"""Packing coefficients and environment into the table that the native kernels read."""

from collections.abc import Sequence
from dataclasses import replace

import mujoco
import numpy as np

from marine_mj.environment import Environment, WaveField
from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.body_settings import BodySettings, memory_of, motion_of
from marine_mj.hydrodynamics.coefficients import BodyCoefficients
from marine_mj.hydrodynamics.element_pack import free_root, pack_elements, start_pose
from marine_mj.hydrodynamics.excitation import long_wave_block
from marine_mj.hydrodynamics.inertia import subtree_inertia
from marine_mj.hydrodynamics.low_frequency import drift_in, filter_entries
from marine_mj.hydrodynamics.panels import restoring_of, uses_panels
from marine_mj.hydrodynamics.raos import radiation
from marine_mj.hydrodynamics.sea_check import check_directions, check_sea
from marine_mj.hydrodynamics.shelter import shelter_block
from marine_mj.hydrodynamics.surface import half_height, surface_block
from marine_mj.hydrodynamics.table_builder import TableBuilder
from marine_mj.hydrodynamics.wave_file import WaveDatabase


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


def _environment(table: TableBuilder, environment: Environment) -> Array:
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


def _contacts(model: mujoco.MjModel, table: TableBuilder, fixed: Array) -> None:
    """Address of the contact sensor, the geoms that must not be touched, and the sea bed."""
    sensor = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, t_.CONTACT_SENSOR)
    if sensor < 0:
        return
    fixed[t_.E_BED] = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_GEOM, t_.SEA_BED) + 1
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


def _volume(body: BodyCoefficients, environment: Environment) -> float:
    """Displaced volume, m3."""
    if body.buoyancy:
        return body.buoyancy / (environment.water_density * environment.gravity)
    return body.displaced_volume


def in_this_water(
    body: BodyCoefficients, settings: BodySettings, environment: Environment
) -> BodyCoefficients:
    """The body with the density and the hull symmetry at which its wave database is used."""
    if body.wave_database is None:
        return body
    name = WaveDatabase(body.wave_database, environment.water_density, settings.hull_symmetry)
    return replace(body, wave_database=name)


def _check_database(body: BodyCoefficients, settings: BodySettings, sea: Environment) -> None:
    """Tell what the wave database of a body lacks in this sea; see `check_sea`."""
    motion = motion_of(body, settings)
    if body.wave_database is None or motion not in ("dynamic", "rao"):
        return
    response = "motion"
    if motion == "dynamic":
        panels = uses_panels(body, settings) and settings.froude_krylov
        response = "diffraction" if panels else "force"
    check_sea(body.name, body.wave_database, response, sea)


def _record(
    model: mujoco.MjModel,
    table: TableBuilder,
    body: BodyCoefficients,
    environment: Environment,
    settings: BodySettings,
    afloat: set[int],
    bodies: Sequence[BodyCoefficients],
) -> Array:
    """Record of one body; what it points at goes into the table first.

    `afloat`: bodies with a buoyancy of their own, which their carrier does not bear. `bodies`: all.
    """
    body = in_this_water(body, settings, environment)
    _check_database(body, settings, environment)
    index = model.body(body.name).id
    last, count = _chain(model, index, body.name)
    motion = motion_of(body, settings)
    p = np.zeros(t_.B_FIXED_SIZE)
    p[t_.B_SIZE] = t_.B_FIXED_SIZE
    p[t_.B_BODY], p[t_.B_ROOT] = index, model.body_rootid[index]
    p[t_.B_LAST_DOF], p[t_.B_CHAIN] = last, count
    p[t_.B_FREE] = free_root(model, index)
    panels = uses_panels(body, settings)
    p[t_.B_VOLUME] = 0.0 if panels else _volume(body, environment)
    p[t_.B_CB : t_.B_CB + 3] = body.center_of_buoyancy
    p[t_.B_FROUDE_KRYLOV] = settings.froude_krylov
    p[t_.B_CONVECTIVE] = settings.convective
    p[t_.B_SEAKEEPING] = motion == "dynamic"
    if settings.sheltered_by is not None:
        p[t_.B_SHELTER] = shelter_block(
            model, table, body.name, settings.sheltered_by, motion, bodies, environment.waves
        )
        shelter = next(b.shelter_database for b in bodies if b.name == settings.sheltered_by)
        if len(environment.waves.omega):
            check_directions(settings.sheltered_by, str(shelter), "shelter")
    p[t_.B_LONG_WAVE] = long_wave_block(model, table, body, environment, settings, afloat)
    quadratic = body.quadratic_damping
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
    elif body.quadratic_damping_lumped is not None:
        quadratic = body.quadratic_damping_lumped
    p[t_.B_SURFACE] = surface_block(
        model, table, body, index, environment, settings, motion, afloat
    )
    if not settings.constant_buoyancy:
        p[t_.B_HALF_HEIGHT] = half_height(body, _volume(body, environment))
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
            start_pose(model, body, index, motion)[2],
        )
        linear = linear + body.viscous_damping
    p[t_.B_ADDED_MASS : t_.B_ADDED_MASS + 36] = added_mass.ravel()
    p[t_.B_LINEAR : t_.B_LINEAR + 36] = linear.ravel()
    p[t_.B_QUADRATIC : t_.B_QUADRATIC + 36] = quadratic.ravel()
    drift = drift_in(body, settings, environment.waves)
    p[t_.B_LOW_FREQUENCY : t_.B_REACH + 1] = filter_entries(model, body.name, environment)
    elements = pack_elements(
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
    table = TableBuilder()
    table.add(np.zeros(t_.FIXED_SIZE))
    fixed = _environment(table, environment)
    _contacts(model, table, fixed)
    afloat = {
        int(model.body(body.name).id)
        for body in bodies
        if body.displaced_volume or body.buoyancy or body.restoring is not None
    }
    records = [
        _record(
            *(model, table, body, environment),
            settings.get(body.name, BodySettings()),
            *(afloat, bodies),
        )
        for body in bodies
    ]
    fixed[t_.H_BODIES], fixed[t_.H_FIRST_BODY] = len(records), table.length
    table.add(*records)
    fixed[t_.H_LENGTH] = table.length
    values = table.array()
    values[: t_.FIXED_SIZE] = fixed
    return values
