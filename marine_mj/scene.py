"""From a scenario to a compiled model: vehicles, docks, latches and actuation in one MjSpec."""

import copy
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from marine_mj import frames, hydrodynamics
from marine_mj.environment import Environment
from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.hydrodynamics import table
from marine_mj.hydrodynamics.contact_parts import scale_stiffness
from marine_mj.hydrodynamics.numerics import SCALABLE
from marine_mj.library import find_model
from marine_mj.scenario import HeadingControl, Scenario, Vehicle
from marine_mj.scene_choices import choose_integrator
from marine_mj.sea_bed import add_sea_bed, check_start
from marine_mj.weather import environment_of

if TYPE_CHECKING:
    from marine_mj.simulation.log import Log

#: Site on a carrier at which a dock is attached.
DOCK_MOUNT = "dock_mount"
#: Axes of the ideal wrench, in the order of its actuators.
WRENCH_AXES = ("surge", "sway", "heave", "roll", "pitch", "yaw")
#: Joints of a planar vehicle, in the order in which they act.
PLANAR_JOINTS = ("planar_x", "planar_z", "planar_pitch")

_INTEGRATORS = {
    "Euler": mujoco.mjtIntegrator.mjINT_EULER,
    "RK4": mujoco.mjtIntegrator.mjINT_RK4,
    "implicit": mujoco.mjtIntegrator.mjINT_IMPLICIT,
    "implicitfast": mujoco.mjtIntegrator.mjINT_IMPLICITFAST,
}
_CONES = {
    "pyramidal": mujoco.mjtCone.mjCONE_PYRAMIDAL,
    "elliptic": mujoco.mjtCone.mjCONE_ELLIPTIC,
}


@dataclass(frozen=True)
class Scene:
    """A compiled scene.

    Attributes:
        scenario: what it was built from.
        model: compiled model with the packed hydrodynamics table.
        environment: the frozen sea, current and wind in it.
    """

    scenario: Scenario
    model: mujoco.MjModel
    environment: Environment


def compile_scene(
    scenario: Scenario,
    environment: Environment | None = None,
    scenery: Callable[[mujoco.MjSpec], Any] | None = None,
    visual: bool = True,
) -> Scene:
    """Scene of a scenario, ready to step.

    Args:
        scenario: validated scenario.
        environment: sea, current and wind; default: drawn from the scenario's seed.
        scenery: called with the spec before compiling, to add what only pictures need.
        visual: False leaves out what is only seen: the same motion, a quarter faster to step.

    Raises:
        ModelError: a model does not exist or cannot be simulated as asked.
        ScenarioError: a vehicle starts in the sea bed.
    """
    environment = environment_of(scenario) if environment is None else environment
    spec = build_scene(scenario)
    if scenery is not None:
        scenery(spec)
    spec.compiler.discardvisual = not visual
    model = hydrodynamics.compile_spec(spec, environment, body_settings(scenario, spec))
    check_start(scenario, model)
    return Scene(scenario, model, environment)


def scene_from_log(log: "Log", scenery: Callable[[mujoco.MjSpec], Any] | None = None) -> Scene:
    """The scene that a log was recorded in, rebuilt from its scenario.

    Raises:
        LogError: the log holds no valid scenario.
        ModelError: a vehicle of the scenario does not exist any more.
    """
    return compile_scene(log.scenario, scenery=scenery)


def build_scene(scenario: Scenario) -> mujoco.MjSpec:
    """Uncompiled scene: each vehicle under the prefix `<instance>/`, its dock `<instance>/dock/`.

    Raises:
        ModelError: a model does not exist, has no free root body, or lacks the dock's site.
    """
    spec = mujoco.MjSpec()
    spec.modelname = scenario.name
    spec.option.timestep = scenario.timestep
    spec.option.integrator = _INTEGRATORS[choose_integrator(scenario)]
    spec.option.cone = _CONES[scenario.friction_cone]
    # A diverging run must raise, not start again silently.
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
    if not scenario.contact:
        spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    if scenario.sea.depth is not None:
        add_sea_bed(spec, scenario.sea.depth)
    for instance, vehicle in scenario.vehicles.items():
        _attach_vehicle(spec, instance, vehicle)
        if vehicle.heading_control is not None:
            _add_heading_control(spec, instance, vehicle, vehicle.heading_control)
    carriers = [name for name, vehicle in scenario.vehicles.items() if vehicle.dock is not None]
    for carrier in carriers:
        dock = _attach_dock(spec, carrier, scenario.vehicles[carrier])
        for instance in scenario.vehicles:
            if instance not in carriers:
                _add_latch(spec, carrier, dock, instance)
    spec.add_sensor(
        name=table.CONTACT_SENSOR,
        type=mujoco.mjtSensor.mjSENS_USER,
        datatype=mujoco.mjtDataType.mjDATATYPE_REAL,
        needstage=mujoco.mjtStage.mjSTAGE_ACC,
        dim=table.CONTACT_VALUES,
    )
    return spec


def main_body(spec: mujoco.MjSpec, instance: str) -> Any:
    """Root body of a vehicle in a scene."""
    for body in spec.worldbody.bodies:
        if body.name.startswith(f"{instance}/"):
            return body
    raise ModelError(f"no body of vehicle {instance!r} in the scene")


def main_bodies(model: mujoco.MjModel) -> dict[str, int]:
    """Id of the root body of every vehicle in a compiled scene, by instance name."""
    roots = [b for b in range(1, model.nbody) if model.body_parentid[b] == 0]
    return {model.body(b).name.split("/")[0]: b for b in roots if "/" in model.body(b).name}


def at_origin(model: mujoco.MjModel) -> mujoco.MjData:
    """Kinematics of a scene with every vehicle level at the origin and its joints at rest.

    Positions on a vehicle relative to it come out the same wherever it starts.
    """
    model = copy.copy(model)
    free = int(mujoco.mjtJoint.mjJNT_FREE)
    for body in main_bodies(model).values():
        model.body_pos[body], model.body_quat[body] = 0.0, [1.0, 0.0, 0.0, 0.0]
        joint = model.body_jntadr[body]
        if joint >= 0 and model.jnt_type[joint] == free:
            address = model.jnt_qposadr[joint]
            model.qpos0[address : address + 7] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    return data


def body_settings(scenario: Scenario, spec: mujoco.MjSpec) -> dict[str, dict[str, Any]]:
    """Settings of each hydrodynamic main body for `hydrodynamics.compile_spec`."""
    wet = {body.name for body in hydrodynamics.read_coefficients(spec)}
    bodies = {main_body(spec, instance).name: v for instance, v in scenario.vehicles.items()}
    return {
        name: {
            "motion": vehicle.motion,
            "radiation": vehicle.radiation,
            "froude_krylov": vehicle.froude_krylov,
            "convective": vehicle.convective,
            "strips": vehicle.strips,
            "constant_buoyancy": vehicle.constant_buoyancy,
            "thrust_loss": vehicle.thrust_loss,
            "drift": vehicle.drift,
            "hydrostatics": vehicle.hydrostatics,
            "excitation": vehicle.excitation,
            "sheltered_by": vehicle.sheltered_by and main_body(spec, vehicle.sheltered_by).name,
            "hull_symmetry": vehicle.hull_symmetry,
        }
        for name, vehicle in bodies.items()
        if name in wet
    }


def start_pose(vehicle: Vehicle) -> tuple[Array, Array]:
    """Start position (3,) NWU and attitude (4,) wxyz of a vehicle's settings."""
    heading = np.deg2rad(vehicle.heading_deg)
    return frames.pose_from_eta([*vehicle.position_ned, 0.0, 0.0, heading])


def latch_name(carrier: str, instance: str) -> str:
    """Name of the weld that holds a vehicle in the dock of a carrier."""
    return f"{carrier}/latch/{instance}"


def _load(name: str) -> mujoco.MjSpec:
    """Spec of a model folder, with file names made absolute so that they survive attachment."""
    path = find_model(name)
    try:
        spec = mujoco.MjSpec.from_file(str(path))
    except ValueError as error:
        raise ModelError(f"model {name!r} ({path}) cannot be read: {error}") from None
    for mesh in spec.meshes:
        if mesh.file:
            mesh.file = str(_asset(path, spec.meshdir, mesh.file))
    for texture in spec.textures:
        if texture.file:
            texture.file = str(_asset(path, spec.texturedir, texture.file))
    for text in spec.texts:
        if text.name.endswith((".wave_database", ".shelter_database", ".hull_mesh")):
            # A name that is not a file of the vehicle is one of the package's assets.
            own = _asset(path, spec.meshdir or "assets", text.data)
            text.data = str(own) if own.is_file() else text.data
    return spec


def _asset(xml: Path, folder: str, file: str) -> Path:
    """Absolute path of a file that an XML names."""
    return (xml.parent / (folder or ".") / file).resolve()


def _attach_vehicle(spec: mujoco.MjSpec, instance: str, vehicle: Vehicle) -> None:
    """Attach one vehicle at its start pose."""
    child = _load(vehicle.model)
    _scale(child, instance, vehicle)
    position, quaternion = start_pose(vehicle)
    frame = spec.worldbody.add_frame(pos=position, quat=quaternion)
    spec.attach(child, frame=frame, prefix=f"{instance}/")
    body = main_body(spec, instance)
    free = [j for j in body.joints if j.type == mujoco.mjtJoint.mjJNT_FREE]
    if not free:
        raise ModelError(
            f"model {vehicle.model!r} of vehicle {instance!r} has no free joint on its root body "
            f"{body.name!r}: vehicles are free, docks are named by the vehicle that carries them"
        )
    free[0].name = f"{instance}/free"
    if vehicle.planar:
        if vehicle.motion in ("rao", "fixed"):
            raise ModelError(
                f'vehicle {instance!r} has motion = "{vehicle.motion}" and planar = true: a '
                "prescribed vehicle is planar in head seas anyway, leave out planar"
            )
        spec.delete(free[0])
        for name, axis in zip(PLANAR_JOINTS, ([1, 0, 0], [0, 0, 1], [0, 1, 0]), strict=True):
            hinge = name == "planar_pitch"
            kind = mujoco.mjtJoint.mjJNT_HINGE if hinge else mujoco.mjtJoint.mjJNT_SLIDE
            body.add_joint(name=f"{instance}/{name}", type=kind, axis=axis)
    if vehicle.actuation == "wrench":
        _replace_actuators(spec, instance, vehicle, body)


def _scale(child: mujoco.MjSpec, instance: str, vehicle: Vehicle) -> None:
    """Apply the factors of a vehicle's `scale` to its root body."""
    body = child.worldbody.first_body()
    known: dict[str, list[Any]] = {}
    for numeric in child.numerics:
        owner, _, quantity = numeric.name.partition(".")
        stem = quantity.removesuffix("_frd").removesuffix("_flu")
        if body is not None and owner == body.name and stem in SCALABLE:
            known.setdefault(stem, []).append(numeric)
    for quantity, factor in vehicle.scale.items():
        if quantity == "mass":
            body.mass = factor * body.mass
            body.inertia = factor * np.asarray(body.inertia)
            body.fullinertia = factor * np.asarray(body.fullinertia)
        elif quantity in known:
            for numeric in known[quantity]:
                numeric.data = factor * np.asarray(numeric.data)
        else:
            raise ModelError(
                f"vehicles.{instance}.scale names {quantity!r}; {vehicle.model!r} has mass, "
                f"{', '.join(known)}"
            )


def _replace_actuators(spec: mujoco.MjSpec, instance: str, vehicle: Vehicle, body: Any) -> None:
    """Six ideal motors at the body origin instead of the model's actuators.

    Raises:
        ModelError: the ideal wrench is to lose thrust with speed.
    """
    if vehicle.thrust_loss:
        raise ModelError(
            f'vehicles.{instance}: thrust_loss = true with actuation = "wrench", which has no '
            "thrusters; leave out one of them"
        )
    for numeric in list(spec.numerics):
        if numeric.name.startswith(f"{body.name}.thrust_loss."):
            spec.delete(numeric)
    for actuator in list(spec.actuators):
        if actuator.name.startswith(f"{instance}/"):
            spec.delete(actuator)
    site = body.add_site(name=f"{instance}/origin", group=4)
    bounds = np.sort(
        [frames.flip(vehicle.wrench_low_frd), frames.flip(vehicle.wrench_high_frd)], axis=0
    )
    for i, axis in enumerate(WRENCH_AXES):
        gear = np.zeros(6)
        gear[i] = 1.0
        spec.add_actuator(
            name=f"{instance}/{axis}",
            trntype=mujoco.mjtTrn.mjTRN_SITE,
            target=site.name,
            gear=gear,
            ctrllimited=True,
            ctrlrange=bounds[:, i],
        )


def _add_heading_control(
    spec: mujoco.MjSpec, instance: str, vehicle: Vehicle, control: HeadingControl
) -> None:
    """Servo on the turn about the vertical between the vehicle and the start heading.

    Raises:
        ModelError: the vehicle's motion is prescribed.
    """
    if vehicle.motion in ("rao", "fixed"):
        raise ModelError(
            f"vehicles.{instance}: heading_control turns a vehicle that moves by its forces, but "
            f'motion = "{vehicle.motion}" is prescribed: leave one of them out'
        )
    position, quaternion = start_pose(vehicle)
    start = spec.worldbody.add_site(
        name=f"{instance}:start", pos=position, quat=quaternion, group=4
    )
    site = main_body(spec, instance).add_site(name=f"{instance}:heading", group=4)
    spec.add_actuator(
        name=f"{instance}:heading",  # none of those that controllers command: it holds zero
        trntype=mujoco.mjtTrn.mjTRN_SITE,
        target=site.name,
        refsite=start.name,
        gear=[0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
        gaintype=mujoco.mjtGain.mjGAIN_FIXED,
        biastype=mujoco.mjtBias.mjBIAS_AFFINE,
        gainprm=[control.stiffness] + [0.0] * 9,
        biasprm=[0.0, -control.stiffness, -control.damping] + [0.0] * 7,
        forcelimited=True,
        forcerange=[-control.limit, control.limit],
    )


def _attach_dock(spec: mujoco.MjSpec, carrier: str, vehicle: Vehicle) -> str:
    """Attach the carrier's dock and return the name of the dock's body."""
    assert vehicle.dock is not None
    child = _load(vehicle.dock)
    scale_stiffness(child, vehicle.dock_stiffness)
    mount = f"{carrier}/{DOCK_MOUNT}"
    site = spec.site(mount)
    if site is None:
        raise ModelError(
            f"vehicle {carrier!r} has dock = {vehicle.dock!r} but its model {vehicle.model!r} has "
            f"no site {DOCK_MOUNT!r}: add one where the dock is to be fixed"
        )
    spec.attach(child, site=site, prefix=f"{carrier}/dock/")
    return next(b.name for b in spec.bodies if b.name.startswith(f"{carrier}/dock/"))


def _add_latch(spec: mujoco.MjSpec, carrier: str, dock: str, instance: str) -> None:
    """An open weld between a dock and a vehicle."""
    spec.add_equality(
        name=latch_name(carrier, instance),
        type=mujoco.mjtEq.mjEQ_WELD,
        objtype=mujoco.mjtObj.mjOBJ_BODY,
        name1=dock,
        name2=main_body(spec, instance).name,
        active=False,
    )
