"""From MJCF with hydrodynamic coefficients to a model that steps with plain `mj_step`."""

import difflib
from collections.abc import Mapping, Sequence
from dataclasses import fields
from pathlib import Path

import mujoco
import numpy as np

from marine_mj.environment import Environment
from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.body_settings import BodySettings, memory_of
from marine_mj.hydrodynamics.coefficients import BodyCoefficients, read_coefficients
from marine_mj.hydrodynamics.contact_pairs import (
    add_contact_pairs,
    check_contact_step,
    compile_dry,
    convert_contacts,
    prepare_contacts,
)
from marine_mj.hydrodynamics.low_frequency import LOW_FREQUENCY_PREFIX, follows_waves
from marine_mj.hydrodynamics.memory_pack import MEMORY_PREFIX
from marine_mj.hydrodynamics.native import install, records, table_of
from marine_mj.hydrodynamics.pack import in_this_water, pack_table
from marine_mj.hydrodynamics.stability import check_timestep
from marine_mj.library import find_model

Settings = Mapping[str, BodySettings | Mapping]

_DISABLE = mujoco.mjtDisableBit
_ENABLE = mujoco.mjtEnableBit


def _refuse_options(spec: mujoco.MjSpec) -> None:
    """Raise on MuJoCo options under which the hydrodynamics would be wrong or not run at all."""
    option = spec.option
    springs_and_dampers = _DISABLE.mjDSBL_SPRING | _DISABLE.mjDSBL_DAMPER
    refusals = (
        (
            option.solver == mujoco.mjtSolver.mjSOL_PGS,
            "solver is PGS, allowed are Newton and CG: PGS projects the contact problem with the "
            'inertia before added mass; set <option solver="Newton"/>',
        ),
        (
            option.noslip_iterations > 0,
            f"noslip_iterations is {option.noslip_iterations}, allowed is 0: the noslip solver "
            'works with the inertia before added mass; use <option cone="elliptic" '
            'impratio="10"/> against slip',
        ),
        (
            option.density != 0 or option.viscosity != 0,
            f"density is {option.density:g} and viscosity {option.viscosity:g}, allowed is 0 for "
            "both: MuJoCo's own fluid model would count the water twice; remove them from <option>",
        ),
        (
            option.disableflags & springs_and_dampers == springs_and_dampers,
            "the flags spring and damper are both disabled: MuJoCo then never calls the "
            "hydrodynamics; enable one of them in <option><flag>",
        ),
        (
            bool(option.enableflags & _ENABLE.mjENBL_SLEEP),
            "sleep is enabled: sleeping bodies skip the added mass; remove sleep from "
            "<option><flag>",
        ),
    )
    for wrong, message in refusals:
        if wrong:
            raise ModelError(message)


def _rescale_contacts(model: mujoco.MjModel) -> None:
    """Recompute the inverse weights at qpos0 that set contact softness, with added mass.

    MuJoCo's compiler knows only the dry mass. Same definitions as its `mj_setConst`: means over
    the translations and the rotations of `J M^-1 J^T`. The whole added mass counts, wherever the
    body lies at qpos0: softness must not depend on where a run starts.
    """
    data = mujoco.MjData(model)
    data.qpos[:] = model.qpos0
    table = table_of(model)
    before = table.copy()
    for record in records(table):
        record[[t_.B_HALF_HEIGHT, t_.B_SURFACE]] = 0.0
    mujoco.mj_forward(model, data)
    table[:] = before
    M = np.zeros((model.nv, model.nv))
    mujoco.mju_sparse2dense(M, data.M, model.M_rownnz, model.M_rowadr, model.M_colind)
    inverse = np.linalg.inv(np.tril(M) + np.tril(M, -1).T)
    for body in range(1, model.nbody):
        if model.body_weldid[body] == 0:
            continue
        J = np.zeros((6, model.nv))
        mujoco.mj_jacBodyCom(model, data, J[:3], J[3:], body)
        A = J @ inverse @ J.T
        model.body_invweight0[body] = np.trace(A[:3, :3]) / 3, np.trace(A[3:, 3:]) / 3
    for joint in range(model.njnt):
        dof = model.jnt_dofadr[joint]
        kind = mujoco.mjtJoint(model.jnt_type[joint])
        groups = {
            mujoco.mjtJoint.mjJNT_FREE: [(0, 3), (3, 6)],
            mujoco.mjtJoint.mjJNT_BALL: [(0, 3)],
        }.get(kind, [(0, 1)])
        for start, stop in groups:
            dofs = np.arange(dof + start, dof + stop)
            model.dof_invweight0[dofs] = inverse[dofs, dofs].mean()


def _settings(settings: Settings | None) -> dict[str, BodySettings]:
    """Settings by body name as dataclasses."""
    known = [field.name for field in fields(BodySettings)]
    chosen = {}
    for name, value in (settings or {}).items():
        if not isinstance(value, BodySettings):
            for key in value:
                if key not in known:
                    near = difflib.get_close_matches(key, known, 1, 0.5)
                    hint = f"did you mean {near[0]!r}? " if near else ""
                    raise ModelError(
                        f"setting {key!r} of {name!r} is unknown; {hint}there are "
                        f"{', '.join(known)}"
                    )
            value = BodySettings(**value)
        chosen[name] = value
    return chosen


def _set_numeric(spec: mujoco.MjSpec, values: Array) -> None:
    """Put the packed table into the spec as its last numeric."""
    for numeric in list(spec.numerics):
        if numeric.name == t_.NAME:
            spec.delete(numeric)
    spec.add_numeric(name=t_.NAME, data=values, size=len(values))


#: Actuator group of our states: one that nobody disables for other reasons.
_STATE_GROUP = 30


def _joint_of(spec: mujoco.MjSpec, name: str) -> mujoco.MjsJoint:
    """A joint that moves a body: its own first, or that of the nearest parent."""
    body = spec.body(name)
    while not body.joints:
        if body.parent is None or body.name == "world":
            raise ModelError(
                f"hydrodynamic body {name!r} cannot move: give it or a parent a joint, or remove "
                "its coefficients"
            )
        body = body.parent
    return body.joints[0]


def _add_states(
    spec: mujoco.MjSpec, prefix: str, law: float, body: str, number: int, count: int, what: str
) -> None:
    """An actuator without force that holds `count` states of a body, behind all others.

    Raises:
        ModelError: actuation is disabled.
    """
    option = spec.option
    if option.disableflags & _DISABLE.mjDSBL_ACTUATION or (
        option.disableactuator & 1 << _STATE_GROUP
    ):
        raise ModelError(
            f"actuation, or the actuator group {_STATE_GROUP}, is disabled: the {what} of {body!r} "
            "would stand still; enable it in <option>"
        )
    joint = _joint_of(spec, body)
    joint.name = joint.name or prefix + body
    spec.add_actuator(
        name=prefix + body,
        trntype=mujoco.mjtTrn.mjTRN_JOINT,
        target=joint.name,
        gear=np.zeros(6),
        dyntype=mujoco.mjtDyn.mjDYN_USER,
        dynprm=[law, number, *np.zeros(8)],
        actdim=count,
        gainprm=np.zeros(10),
        ctrllimited=False,
        group=_STATE_GROUP,
    )


def _add_all_states(
    spec: mujoco.MjSpec,
    bodies: Sequence[BodyCoefficients],
    settings: Mapping[str, BodySettings],
    environment: Environment,
) -> None:
    """Actuators for radiation memories, then for low-frequency places."""
    for actuator in list(spec.actuators):
        if actuator.name.startswith((MEMORY_PREFIX, LOW_FREQUENCY_PREFIX)):
            spec.delete(actuator)
    chosen = [settings.get(body.name, BodySettings()) for body in bodies]
    bodies = [in_this_water(b, c, environment) for b, c in zip(bodies, chosen, strict=True)]
    for number, body in enumerate(bodies):
        memory = memory_of(body, chosen[number])
        if memory is not None and memory.states:
            if not spec.body(body.name).joints:
                raise ModelError(
                    f"{body.name!r} has radiation memory but no joint of its own: give it a free "
                    "joint, or simulate it with radiation 'constant'"
                )
            law, count = t_.RADIATION_MEMORY, memory.states
            what = "radiation memory"
            _add_states(spec, MEMORY_PREFIX, law, body.name, number, count, what)
    for number, body in enumerate(bodies):
        if follows_waves(body, chosen[number]):
            law, count = t_.LOW_FREQUENCY, t_.LF_STATES
            what = "low-frequency place for wave loads"
            _add_states(spec, LOW_FREQUENCY_PREFIX, law, body.name, number, count, what)


def compile_spec(
    spec: mujoco.MjSpec,
    environment: Environment | None = None,
    settings: Settings | None = None,
) -> mujoco.MjModel:
    """A compiled model with its hydrodynamics, ready for plain `mj_step`.

    A spec without hydrodynamic coefficients is compiled as it is, with its contact parts.

    Args:
        spec: scene; its options are kept, except that automatic reset is disabled and
            hydrodynamic bodies are stored with their full inertia.
        environment: sea, current and wind; default still water and still air.
        settings: by body name (with its attach prefix): `BodySettings` or its keywords.

    Raises:
        ModelError: coefficients, options, settings or the time step are not allowed.
    """
    bodies = read_coefficients(spec)
    if not bodies:
        return compile_dry(spec)
    install()  # somebody may have removed or replaced the callbacks since the import
    environment = environment or Environment()
    chosen = _settings(settings)
    _refuse_options(spec)
    spec.option.disableflags |= _DISABLE.mjDSBL_AUTORESET
    for body in bodies:
        spec.body(body.name).simple = False
    if np.any(spec.option.gravity[:2]):
        raise ModelError(
            f"gravity of the model is {spec.option.gravity} m/s2, allowed is straight down (0 0 -g)"
            ": the water lies level"
        )
    gravity = -spec.option.gravity[2]
    if abs(gravity - environment.gravity) > 1e-9 and gravity != 0:
        raise ModelError(
            f"gravity of the model is {gravity:g} m/s2 but {environment.gravity:g} in the "
            "environment; allowed is the same in both"
        )
    _add_all_states(spec, bodies, chosen, environment)
    # once for the addresses, once more with the table that needs them
    parts = prepare_contacts(spec)
    plain = spec.compile()
    if parts:
        add_contact_pairs(spec, plain)
    _set_numeric(spec, pack_table(plain, bodies, environment, chosen))
    model = spec.compile()
    check_timestep(model, bodies, chosen)
    _rescale_contacts(model)
    convert_contacts(model)
    check_contact_step(model)
    return model


def write_environment(
    model: mujoco.MjModel,
    bodies: Sequence[BodyCoefficients],
    environment: Environment,
    settings: Settings | None = None,
) -> None:
    """Replace the environment of a compiled model in place, e.g. for another seed.

    Args:
        model: from `compile_spec`.
        bodies: `read_coefficients` of the spec the model was compiled from.
        environment: the new sea, current and wind.
        settings: as given to `compile_spec`.

    Raises:
        ModelError: the new table has another size (other numbers of components or knots).
    """
    values = pack_table(model, bodies, environment, _settings(settings))
    table = table_of(model)
    if len(values) != len(table):
        raise ModelError(
            f"the new environment needs a table of {len(values)} numbers, the model has "
            f"{len(table)}: keep the numbers of wave components and time knots, or compile again"
        )
    before = _added_masses(table)
    table[:] = values
    if not np.array_equal(before, _added_masses(table)):
        _rescale_contacts(model)
        convert_contacts(model)


def _added_masses(table: Array) -> Array:
    """Added masses (bodies, 36) in a packed table."""
    return np.array([p[t_.B_ADDED_MASS : t_.B_ADDED_MASS + 36] for p in records(table)])


def load_xml(
    text_or_path: str | Path,
    environment: Environment | None = None,
    settings: Settings | None = None,
) -> mujoco.MjModel:
    """A compiled model from MJCF text or an MJCF file with the documented numerics.

    Options (time step, integrator) are those of the MJCF. See `compile_spec`.

    Raises:
        ModelError: the MJCF cannot be read or compiled, or see `compile_spec`.
    """
    text = str(text_or_path)
    try:
        if text.lstrip().startswith("<"):
            spec = mujoco.MjSpec.from_string(text)
        else:
            spec = mujoco.MjSpec.from_file(text)
    except (ValueError, OSError) as error:
        raise ModelError(f"cannot read the MJCF {text[:80]!r}: {error}") from error
    try:
        return compile_spec(spec, environment, settings)
    except ValueError as error:
        raise ModelError(f"cannot compile the MJCF {text[:80]!r}: {error}") from error


def load(
    name: str,
    environment: Environment | None = None,
    settings: Settings | None = None,
    timestep: float = 0.005,
) -> mujoco.MjModel:
    """A compiled model of one vehicle or dock, with the elliptic friction cone.

    The integrator is implicitfast, or RK4 with several bodies in the water.

    Args:
        name: vehicle of the package, or path of a vehicle's folder or MJCF file.
        environment: sea, current and wind; default still water and still air.
        settings: by body name, see `BodySettings`.
        timestep: s.

    Raises:
        ModelError: no such vehicle, or see `compile_spec`.
    """
    spec = mujoco.MjSpec.from_file(str(find_model(name)))
    spec.option.timestep = timestep
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    # joints between bodies in the water: the first-order error of implicitfast feeds them energy
    articulated = len(read_coefficients(spec)) > 1
    integrators = mujoco.mjtIntegrator
    spec.option.integrator = (
        integrators.mjINT_RK4 if articulated else integrators.mjINT_IMPLICITFAST
    )
    if environment is not None:
        spec.option.gravity = [0.0, 0.0, -environment.gravity]
    return compile_spec(spec, environment, settings)
