"""The docking study's cylinder free beneath its free USV box: two bodies in the same waves."""

from collections.abc import Iterator

import mujoco
import numpy as np
from numpy.typing import NDArray

from marine_mj.environment import Environment, regular_wave
from marine_mj.frames import Array
from marine_mj.hydrodynamics.bem.panels import Panels, lid, rectangle
from marine_mj.hydrodynamics.bem.rao import motion_raos
from marine_mj.hydrodynamics.bem.solver import Part, solve_bodies
from marine_mj.hydrodynamics.hydrostatics import hydrostatics
from marine_mj.hydrodynamics.wrenches import wrenches
from marine_mj.scenario import Scenario
from marine_mj.scene import Scene, compile_scene
from marine_mj.validation.geometry import lying_cylinder, lying_cylinder_inertia
from marine_mj.validation.rows import Row, row

RHO, G = 1025.0, 9.81
SOURCE = "docking study, appendix A"
#: A body, its rigid-body inertia and its stiffness (6, 6).
Free = tuple[Part, Array, Array]
#: As the study made its tables: 10 cm panels with sources. Potentials on 12.5 cm panels give 0.360
#: for surge at 2 s beneath the USV: 3.3 % off, 2.2 % of it already alone (the cylinder's panels).
PANEL, METHOD = 0.1, "indirect"
PERIODS = np.array([6.7, 4.6, 3.0, 2.5, 2.0])
#: Free surge and heave of the cylinder at 1 m, alone and beneath the USV.
ALONE = {0: (0.880, 0.792, 0.596, 0.472, 0.296), 2: (0.896, 0.807, 0.610, 0.485, 0.309)}
BENEATH = {0: (0.881, 0.795, 0.615, 0.515, 0.349), 2: (0.905, 0.823, 0.625, 0.471, 0.210)}
NAMES = {0: "surge", 2: "heave", 4: "pitch"}


def box_panels(panel: float) -> Panels:
    """Half of the wetted 5 x 1.5 x 0.3 m box (y > 0) with its mirror, about square panels [m]."""
    n_x, n_y, n_z = (int(np.ceil(s / panel - 1e-9)) for s in (5.0, 0.75, 0.3))
    return (
        rectangle((-2.5, 0, -0.3), (0, 0.75, 0), (5, 0, 0), n_y, n_x)
        + rectangle((-2.5, 0.75, -0.3), (0, 0, 0.3), (5, 0, 0), n_z, n_x)
        + rectangle((2.5, 0, -0.3), (0, 0.75, 0), (0, 0, 0.3), n_y, n_z)
        + rectangle((-2.5, 0, -0.3), (0, 0, 0.3), (0, 0.75, 0), n_z, n_y)
    ).mirrored(1)


def free_motions(bodies: list[Free], omega: Array) -> NDArray[np.complex128]:
    """Motion RAOs (n, 6 p) of bodies free in waves along x, with no damping but radiation."""
    result = solve_bodies(
        [part for part, _, _ in bodies],
        omega=omega,
        directions=np.zeros(1),
        density=RHO,
        gravity=G,
        method=METHOD,
    )
    M = _block([rigid for _, rigid, _ in bodies])
    C = _block([stiffness for _, _, stiffness in bodies])
    force = result.froude_krylov + result.diffraction
    return motion_raos(omega, M + result.added_mass, result.damping, C, force)[:, 0]


def _block(matrices: list[Array]) -> Array:
    """Block diagonal matrix of (6, 6) blocks."""
    out = np.zeros((6 * len(matrices),) * 2)
    for i, matrix in enumerate(matrices):
        out[6 * i : 6 * i + 6, 6 * i : 6 * i + 6] = matrix
    return out


def usv_part(panel: float) -> Free:
    """The study's USV box, its rigid-body inertia and its hydrostatic stiffness (6, 6)."""
    hull = box_panels(panel)
    still = hydrostatics(*hull.triangles())
    C = still.stiffness(RHO, G, RHO * still.volume, np.zeros(3), np.zeros(3))
    rigid = np.diag([2306.0, 2306.0, 2306.0, 1040.0, 5412.0, 5237.0])
    return Part(hull, np.zeros(3), lid(hull, panel)), rigid, C


def cylinder_part(depth: float) -> Free:
    """The study's cylinder, its rigid-body inertia and its righting stiffness (6, 6)."""
    part = Part(lying_cylinder(depth), np.array([0, 0, -depth]))
    return part, lying_cylinder_inertia(RHO), np.diag([0, 0, 0, 6.13, 6.13, 0.0])


def two_bodies() -> Iterator[Row]:
    """The docking study's cylinder free beneath the free USV box at 1 and 2 m (V37)."""
    omega = 2 * np.pi / PERIODS
    usv = usv_part(PANEL)
    own = free_motions([usv], omega)
    for depth in (1.0, 2.0):
        cylinder = cylinder_part(depth)
        alone = np.abs(free_motions([cylinder], omega))
        both = free_motions([usv, cylinder], omega)
        for dof, name in NAMES.items():
            change = np.abs(both[:, dof] - own[:, dof]).max() / np.abs(own[:, dof]).max()
            label = f"USV box above the cylinder at {depth:g} m, change of its {name} phasor"
            yield row(label, change, 0, "1", f"{SOURCE}: unchanged to 3 digits", within=0.005)
        for dof in (0, 2):
            beneath = np.abs(both[:, 6 + dof])
            if depth == 1.0:
                for i, period in enumerate(PERIODS):
                    label = f"V37 cylinder at 1 m, free {NAMES[dof]} at {period:g} s, "
                    yield row(
                        label + "alone", alone[i, dof], ALONE[dof][i], "m/m", SOURCE, percent=3
                    )
                    expected = BENEATH[dof][i]
                    yield row(
                        label + "beneath the USV", beneath[i], expected, "m/m", SOURCE, percent=3
                    )
            else:
                change = float(np.abs(beneath / alone[:, dof] - 1)[:-1].max())
                label = f"Cylinder at 2 m beneath the USV, change of its {NAMES[dof]} from 2.5 s on"
                yield row(label, change, 0, "1", f"{SOURCE}: below 6 %", within=0.06)


#: The Scout beneath the USV, sheltered by it.
SCENE = Scenario.parse(
    {
        "name": "beneath",
        "vehicles": {
            "usv": {"model": "dus_v5750", "position_ned": [10.0, 0.0, 0.0], "motion": "rao"},
            "auv": {
                "model": "scout",
                "position_ned": [10.0, 0.0, 1.0],
                "sheltered_by": "usv",
                "convective": False,
                "constant_buoyancy": True,
            },
        },
        "task": {"domain": "docking", "name": "dock"},
    },
    "beneath",
)


def water_acceleration(
    scene: Scene, position: Array, hull: tuple[Array, Array], time: float
) -> Array:
    """Acceleration (3) [m/s2], NWU, of the water that the level Scout feels, by its kernel.

    From the pressure force rho V Dv/Dt of the wave, mean over its strips.

    Args:
        scene: of `SCENE`.
        position: (3) of the Scout's origin, NWU.
        hull: position (3) and attitude (4, wxyz) of the USV.
        time: s.
    """
    model = scene.model
    data = mujoco.MjData(model)
    for name, pose in (("usv", np.concatenate(hull)), ("auv", np.r_[position, 1, 0, 0, 0])):
        address = model.joint(f"{name}/free").qposadr[0]
        data.qpos[address : address + 7] = pose
    data.time = time
    mujoco.mj_forward(model, data)
    force = wrenches(model, data)["auv/hull"]["waves"][:3]
    return np.asarray(force / (RHO * 0.061))


def sheltered_water() -> Iterator[Row]:
    """Water motion beneath the USV by its shelter database, against the two-body motions (V37)."""
    level = np.array([10.0, 0.0, 0.0]), np.array([1.0, 0, 0, 0])
    for i, period in enumerate(PERIODS.tolist()):
        environment = Environment(waves=regular_wave(0.02, period))
        size = []
        for name in ("usv", None):
            scenario = SCENE.with_values({"vehicles.auv.sheltered_by": name})
            scene = compile_scene(scenario, environment, visual=False)
            parts = [
                water_acceleration(scene, np.array([10.0, 0, -1.0]), level, t)
                for t in (0.0, 0.25 * period)
            ]
            size.append(np.hypot(*parts))
        for dof, name in ((0, "surge"), (2, "heave")):
            label = (
                f"Water at the Scout, 1 m below the USV, {name} at {period:g} s over undisturbed"
            )
            expected = BENEATH[dof][i] / ALONE[dof][i]
            source = f"{SOURCE}: free cylinder beneath the USV over alone"
            yield row(label, size[0][dof] / size[1][dof], expected, "1", source, percent=3)


CASES = (two_bodies, sheltered_water)
