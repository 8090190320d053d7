"""Is this vehicle plausible? Numbers a naval architect looks at first, each with pass or fail."""

import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from marine_mj.environment import Environment, irregular_sea
from marine_mj.errors import ModelError
from marine_mj.frames import Array, euler_from_quaternion, flip_quaternion
from marine_mj.hydrodynamics.body_settings import BodySettings, memory_of
from marine_mj.hydrodynamics.coefficients import BodyCoefficients, read_coefficients
from marine_mj.hydrodynamics.contact_check import hits
from marine_mj.hydrodynamics.excitation import equivalent_box, excitation_of
from marine_mj.hydrodynamics.floating import afloat, equilibrium
from marine_mj.hydrodynamics.inertia import subtree_inertia
from marine_mj.hydrodynamics.loader import load
from marine_mj.hydrodynamics.memory import ALLOWED_ERROR, Memory
from marine_mj.hydrodynamics.memory_store import memory_report
from marine_mj.hydrodynamics.mesh import read_mesh
from marine_mj.hydrodynamics.stability import largest_timestep
from marine_mj.hydrodynamics.surface import half_height, hull_depth
from marine_mj.library import find_model

WATER_DENSITY, GRAVITY = 1025.0, 9.81
_DOFS = ("surge", "sway", "heave", "roll", "pitch", "yaw")


@dataclass(frozen=True)
class Check:
    """One line of the report; `ok` is None where a value is for information only."""

    quantity: str
    value: float
    unit: str
    allowed: str
    ok: bool | None


def _submerged(body: BodyCoefficients, mass: float, center: Array, M: Array) -> Iterator[Check]:
    """Buoyancy, trim and pendulum periods of a submerged body."""
    lift = body.buoyancy or body.displaced_volume * WATER_DENSITY * GRAVITY
    weight = mass * GRAVITY
    net = lift - weight
    yield Check("weight", weight, "N", "", None)
    yield Check("buoyancy", lift, "N", "", None)
    small = abs(net) < 0.1 * weight
    yield Check("net buoyancy / weight", 100 * net / weight, "%", "-10 to 10", small)
    height = half_height(body, lift / WATER_DENSITY / GRAVITY)
    yield Check("half height out of the water", height, "m", "", None)
    arm = body.center_of_buoyancy * lift - center * weight  # r_b B - r_g W
    height = arm[2] / weight
    yield Check("BG, buoyancy above gravity", height, "m", "> 0", bool(height > 0))
    if height <= 0:
        return
    for name, along in (("pitch", -arm[0]), ("roll", arm[1])):
        trim = float(np.degrees(np.arctan2(along, arm[2]))) + 0.0
        yield Check(f"static trim, {name}", trim, "deg", "-15 to 15", bool(abs(trim) < 15))
    for axis in (3, 4):
        period = 2 * np.pi * np.sqrt(M[axis, axis] / arm[2])
        yield Check(f"natural period, {_DOFS[axis]}", period, "s", "", None)


def _floating(
    body: BodyCoefficients, mass: float, M: Array, memory: Memory | None
) -> Iterator[Check]:
    """Metacentric heights and natural periods of a floating body."""
    G = np.asarray(body.restoring)
    weight = mass * GRAVITY
    yield Check("weight", weight, "N", "", None)
    if G[2, 2] > 0:
        area = G[2, 2] / (WATER_DENSITY * GRAVITY)
        yield Check("waterplane area", area, "m2", "> 0", True)
        draught = weight / G[2, 2]
        depth = hull_depth(body, weight, WATER_DENSITY * GRAVITY)
        yield Check("draught, weight / G33", draught, "m", "", None)
        yield Check("hull depth, where its lift ends", depth, "m", f">= {draught:.3g}", True)
    for name, axis in (("GM_T", 3), ("GM_L", 4)):
        height = G[axis, axis] / weight
        yield Check(name, height, "m", "> 0", bool(height > 0))
    for axis in (2, 3, 4):
        if G[axis, axis] > 0:
            omega = np.sqrt(G[axis, axis] / M[axis, axis])
            for _ in range(50 if memory is not None else 0):  # M grows by that of the memory
                assert memory is not None
                extra = memory.retardation(np.array([omega]))[0, axis, axis].imag / omega
                omega = np.sqrt(G[axis, axis] / (M[axis, axis] + extra))
            yield Check(f"natural period, {_DOFS[axis]}", 2 * np.pi / omega, "s", "", None)


def _excitation(body: BodyCoefficients, mass: float, center: Array) -> Iterator[Check]:
    """By what waves act, and the box that stands for the hull in long waves."""
    kind = excitation_of(body, BodySettings())
    # every row has a value: here the number of laws
    yield Check(f"waves act by: {kind}", float(kind != "none"), "law", "", None)
    if kind != "long waves":
        return
    environment = Environment(water_density=WATER_DENSITY, gravity=GRAVITY)
    box = equivalent_box(body, mass, center, environment)
    for side, value in (("length", box.length), ("breadth", box.breadth), ("draught", box.draught)):
        yield Check(f"{side} of the hull in long waves", value, "m", "> 0", value > 0)
    yield Check("waves are long above", 5 * box.length, "m", "", None)


def _memory(body: BodyCoefficients, memory: Memory) -> Iterator[Check]:
    """Order and fit of the radiation memory."""
    yield Check("states of the radiation memory", memory.states, "1", "", None)
    for pair in memory_report(str(body.wave_database)):
        name = f"fit of {pair.name}, order {pair.order}: error"
        fine = pair.error <= ALLOWED_ERROR
        yield Check(name, 100 * pair.error, "%", f"<= {100 * ALLOWED_ERROR:g}", fine)


def _step_time(name: str, body: str, **settings: Any) -> float:
    """Time of one step [us] in sea state 4 with 100 components, best of some."""
    sea = Environment(waves=irregular_sea(1.1, 5.515, components=100, seed=1))
    model = load(name, sea, {body: settings})
    best = np.inf
    for _ in range(5):
        data = mujoco.MjData(model)
        mujoco.mj_step(model, data, 20)
        begin = time.perf_counter()
        mujoco.mj_step(model, data, 100)
        best = min(best, (time.perf_counter() - begin) / 100)
    return 1e6 * best


def _panels(
    name: str, body: BodyCoefficients, mass: float, center: Array, M: Array
) -> Iterator[Check]:
    """Equilibrium, stability and natural periods by the hull mesh, and what its panels cost."""
    hull = read_mesh(str(body.hull_mesh))
    yield Check("panels of the hull mesh", float(len(hull.triangles)), "-", "", None)
    cost = _step_time(name, body.name, hydrostatics="panels")
    yield Check("step with panels in 100 waves, measured", cost, "us", "", None)
    reserve = hull.volume * WATER_DENSITY / mass
    floats = reserve > 1
    yield Check("volume of the hull mesh / needed", reserve, "-", "> 1", floats)
    if not floats:
        return
    pose = equilibrium(hull, mass, center, WATER_DENSITY)
    state = afloat(hull, pose)
    buoyancy = pose.body(state.center_of_buoyancy)
    yield Check("displaced volume, panels", state.volume, "m3", "", None)
    for letter, value in zip("xyz", buoyancy.round(9) + 0.0, strict=True):
        yield Check(f"centre of buoyancy {letter}, panels", float(value), "m", "", None)
    yield Check("height of the origin afloat, panels", pose.height, "m", "", None)
    yield Check("draught, panels", state.draught, "m", "", None)
    for angle, value in (("heel", pose.roll), ("trim", pose.pitch)):
        degrees = float(np.degrees(value)) + 0.0
        yield Check(f"static {angle}, panels", degrees, "deg", "-15 to 15", abs(degrees) < 15)
    level = pose.place(center)
    for label, height in zip(("GM_T", "GM_L"), state.metacentric_heights(level), strict=True):
        yield Check(f"{label}, panels", height, "m", "> 0", bool(height > 0))
    G = state.stiffness(WATER_DENSITY, GRAVITY, mass, level, pose.origin)
    for axis in (2, 3, 4):
        if G[axis, axis] > 0:
            period = 2 * np.pi * np.sqrt(M[axis, axis] / G[axis, axis])
            yield Check(f"natural period, {_DOFS[axis]}, panels", period, "s", "", None)


def _rest(model: mujoco.MjModel, body: str, seconds: float = 30.0) -> Iterator[Check]:
    """Still water, no control: the body may rise, sink and swing, but must not run away."""
    data = mujoco.MjData(model)
    index = model.body(body).id
    if model.jnt_type[model.body_jntadr[index]] == mujoco.mjtJoint.mjJNT_FREE:
        joint = model.body_jntadr[index]
        height = model.jnt_qposadr[joint] + 2
        if data.qpos[height] == 0:
            data.qpos[height] = model.qpos0[height]
    mujoco.mj_step(model, data, round(seconds / model.opt.timestep))
    finite = bool(np.isfinite(data.qvel).all() and np.abs(data.qvel).max() < 10)
    yield Check(
        f"speed after {seconds:g} s without control",
        float(np.linalg.norm(data.cvel[index, 3:])),
        "m/s",
        "< 10",
        finite,
    )
    phi, theta, _ = np.degrees(euler_from_quaternion(flip_quaternion(data.xquat[index])))
    yield Check("roll there", float(phi), "deg", "", None)
    yield Check("pitch there", float(theta), "deg", "", None)


def check_model(name: str) -> list[Check]:
    """Report on a vehicle: mass against displacement, trim, stability, periods, M_A, time step.

    Contact parts of a vehicle or dock are told with what a nominal hit does.

    Args:
        name: vehicle of the package, or path of a vehicle's folder or MJCF file.

    Raises:
        ModelError: there is no such vehicle, or its coefficients are refused.
    """
    bodies = read_coefficients(mujoco.MjSpec.from_file(str(find_model(name))))
    model = load(name)
    contacts = [Check(*row, "", None) for row in hits(model)]
    if not bodies and not contacts:
        raise ModelError(
            f"{name!r} has no hydrodynamic coefficients, so there is nothing to check; add "
            '<custom><numeric name="BODY.added_mass_frd" .../> and the others of '
            "docs/architecture.md"
        )
    rows: list[Check] = []
    for body in bodies:
        index = model.body(body.name).id
        mass, center, rigid = subtree_inertia(model, index)
        memory = memory_of(body, BodySettings())
        added = body.added_mass if memory is None else memory.infinite_added_mass
        M = rigid + added
        rows.append(Check(f"{body.name}: mass", mass, "kg", "> 0", mass > 0))
        eigenvalues = np.linalg.eigvalsh(added)
        lowest = float(eigenvalues[0])
        rows.append(
            Check("smallest eigenvalue of M_A", lowest, "kg, kg m2", ">= 0", lowest >= -1e-9)
        )
        rows.append(Check("largest eigenvalue of M_A", float(eigenvalues[-1]), "kg", "", None))
        for axis in range(6):
            if rigid[axis, axis] > 0:
                ratio = added[axis, axis] / rigid[axis, axis]
                rows.append(Check(f"M_A / M_RB, {_DOFS[axis]}", float(ratio), "-", "", None))
        if body.restoring is not None:
            rows += _floating(body, mass, M, memory)
        elif body.displaced_volume or body.buoyancy:
            rows += _submerged(body, mass, center, M)
        rows += _excitation(body, mass, center)
        if memory is not None:
            rows += _memory(body, memory)
        if body.hull_mesh:
            rows += _panels(name, body, mass, center, M)
        bound = largest_timestep(model, body, BodySettings())
        step = model.opt.timestep
        rows.append(
            Check("largest stable time step", bound, "s", f">= {step:g}", bool(bound >= step))
        )
        rows += _rest(model, body.name)
    return rows + contacts
