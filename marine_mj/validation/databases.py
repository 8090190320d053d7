"""Wave databases between their directions, and radiation memories of awkward data, against BEM."""

from collections.abc import Iterator, Sequence
from functools import lru_cache

import numpy as np

from marine_mj.environment import WaveField
from marine_mj.frames import Array
from marine_mj.hydrodynamics.bem.panels import Panels, lid, rectangle
from marine_mj.hydrodynamics.bem.response import respond
from marine_mj.hydrodynamics.bem.settings import Settings
from marine_mj.hydrodynamics.bem.solver import Solution, solve
from marine_mj.hydrodynamics.bem.study import read_hull
from marine_mj.hydrodynamics.harmonics import harmonics, orders
from marine_mj.hydrodynamics.memory import Memory
from marine_mj.hydrodynamics.memory_fit import fit_memory
from marine_mj.hydrodynamics.raos import database_path, read_responses, responses
from marine_mj.hydrodynamics.vector_fitting import Complex
from marine_mj.hydrodynamics.wave_file import whole_circle
from marine_mj.library import assets_folder
from marine_mj.validation.rows import Row, row

RHO, G = 1025.0, 9.81
SOURCE = "boundary element method (Capytaine) at directions between"
#: Largest error that is allowed, % of the largest force of the axis.
ALLOWED = 1.0
#: Directions in the middle between those of the files, deg; step 11.25 and 7.5.
BOX_BETWEEN = (5.625, 50.625, 84.375, 95.625, 129.375, 174.375)
VIKNES_BETWEEN = (3.75, 48.75, 86.25, 93.75, 131.25, 176.25)


def box_panels(length: float, breadth: float, draught: float, panel: float) -> Panels:
    """A quarter of a wetted box with two mirrors, m."""
    half = 0.5 * length, 0.5 * breadth
    n_x, n_y, n_z = (int(np.ceil(s / panel - 1e-9)) for s in (*half, draught))
    quarter = (
        rectangle((0, 0, -draught), (0, half[1], 0), (half[0], 0, 0), n_y, n_x)
        + rectangle((0, half[1], -draught), (0, 0, draught), (half[0], 0, 0), n_z, n_x)
        + rectangle((half[0], 0, -draught), (0, half[1], 0), (0, 0, draught), n_y, n_z)
    )
    return quarter.mirrored(1, 0)


def _worst(database: str, solution: Solution) -> float:
    """Largest difference of a database's force from a solution, % of the axis's largest."""
    omega, directions = np.meshgrid(solution.omega, solution.directions, indexing="ij")
    ones = np.ones(omega.size)
    waves = WaveField(omega.ravel(), omega.ravel() ** 2 / G, directions.ravel(), ones, 0 * ones)
    got = responses(database, "force", waves, 0.0).reshape(6, *omega.shape).transpose(1, 2, 0)
    scale = np.abs(read_responses(database_path(database), "force")[2]).max(axis=(0, 1))
    wanted = solution.froude_krylov + solution.diffraction
    return float(100 * (np.abs(got - wanted) / scale).max())


def usv_box_between(indices: Sequence[int], degrees: Sequence[float] = BOX_BETWEEN) -> float:
    """Worst force error of `dus_v5750_box.nc` at these frequencies between its directions, %."""
    omega = read_responses(database_path("dus_v5750_box.nc"), "force")[0][list(indices)]
    hull = box_panels(5.0, 1.5, 0.3, 0.1)
    beta = np.radians(degrees)
    cover = lid(hull, 0.1)
    solution = solve(
        hull, cover, omega=omega, directions=beta, density=RHO, gravity=G, method="indirect"
    )
    return _worst("dus_v5750_box.nc", solution)


def viknes_between(indices: Sequence[int], degrees: Sequence[float] = VIKNES_BETWEEN) -> float:
    """Worst force error of `viknes830.nc` at these frequencies between its directions, %."""
    omega = read_responses(database_path("viknes830.nc"), "force")[0][list(indices)]
    settings = Settings(
        mass=5002.6,
        panel=0.2,
        center_of_mass=(0.0, 0.0, 0.252),
        gyration=(0.89, 1.96, 1.96),
        omega=tuple(omega.tolist()),
        directions=tuple(np.radians(degrees).tolist()),
    )
    hull = read_hull(str(assets_folder() / "viknes830_hull.stl"), settings)
    return _worst("viknes830.nc", respond(hull).solution)


@lru_cache(maxsize=2)
def ship_loads(ratio: float) -> tuple[Array, Complex]:
    """Directions (144,), every 2.5 deg, and force (1, 144, 6) on a 200 x 32 x 10 m box hull.

    Args:
        ratio: length of the waves over that of the hull.
    """
    directions = np.radians(np.arange(0.0, 360.0, 2.5))
    hull = box_panels(200.0, 32.0, 10.0, 5.0)
    omega = np.array([np.sqrt(2 * np.pi * G / (200.0 * ratio))])
    solution = solve(hull, omega=omega, directions=directions, density=RHO, gravity=G)
    return directions, np.asarray(solution.froude_krylov + solution.diffraction)


def ship_between(ratio: float, every: int = 2) -> tuple[float, float]:
    """Worst error [%] between the directions of a 200 m box hull: ours, and of straight lines.

    Args:
        ratio: length of the waves over that of the hull.
        every: the file has every second, third ... of the 2.5 deg steps of the truth.
    """
    directions, force = ship_loads(ratio)
    scale = np.abs(force).max(axis=(0, 1))
    found = harmonics(whole_circle(directions[::every], "none"), force[:, ::every])
    ours = np.einsum("dm,nmj->ndj", np.exp(1j * np.outer(directions, orders(found))), found)
    knots = np.append(directions[::every], 2 * np.pi)
    table = np.concatenate([force[:, ::every], force[:, :1]], axis=1)[0]
    lines = np.stack([np.interp(directions, knots, column) for column in table.T], axis=1)
    return tuple(float(100 * (np.abs(x - force) / scale).max()) for x in (ours, lines[None]))  # type: ignore[return-value]


def directions() -> Iterator[Row]:
    """Wave loads between the directions of the databases."""
    indices = (20, 30, 36, 38, 39, 40)
    worst = usv_box_between(indices)
    name = "force between directions, dus_v5750_box.nc, worst of 6 frequencies and all axes"
    yield row(name, worst, 0, "% of the axis's largest", SOURCE, within=ALLOWED)
    worst = viknes_between((10, 20, 30, 35, 38, 39))
    name = "force between directions, viknes830.nc, worst of 6 frequencies and all axes"
    yield row(name, worst, 0, "% of the axis's largest", SOURCE, within=ALLOWED)
    for ratio in (0.58, 0.4):
        name = f"force between 5 deg steps, 200 m box hull, lambda/L {ratio}, worst of all axes"
        worst = ship_between(ratio)[0]
        yield row(name, worst, 0, "% of the axis's largest", SOURCE, within=ALLOWED)


# Radiation memory of a barge without a lid: irregular frequencies from 3.316 rad/s on.
BARGE = (10.0, 6.0, 1.0)  # length, breadth, draught, m


def first_irregular() -> float:
    """Lowest irregular frequency of the barge, rad/s.

    The inner problem of a box with its lid held still: `omega^2 = g k coth(k T)` with
    `k = pi sqrt(1 / L^2 + 1 / B^2)` (Lee & Sclavounos 1989, J. Fluid Mech. 207, sec. 2).
    """
    length, breadth, draught = BARGE
    k = np.pi * np.hypot(1 / length, 1 / breadth)
    return float(np.sqrt(G * k / np.tanh(k * draught)))


@lru_cache(maxsize=1)
def barge() -> tuple[Array, Array, Array, Array]:
    """omega (n,), A and B (n, 6, 6) and A(inf) (6, 6) of the barge, solved without a lid."""
    hull = box_panels(*BARGE, 0.5)
    omega = np.linspace(0.3, 4.2, 40)
    found = solve(hull, omega=omega, directions=np.zeros(0), density=RHO, gravity=G)
    return omega, found.added_mass, found.damping, found.infinite


def lowest_damping(memory: Memory) -> float:
    """Smallest eigenvalue of Re K, scaled by its largest entries, at 40,000 frequencies."""
    sizes = np.abs(memory.poles)
    omega = np.geomspace(1e-3 * sizes.min(), 1e3 * sizes.max(), 40_000)
    lowest = 0.0
    for dofs, _ in memory.groups:
        K = memory.retardation(omega).real[:, dofs[:, None], dofs]
        scale = np.sqrt(np.abs(K).max(axis=0).diagonal())
        weight = omega**2 / (sizes.min() * sizes.max()) + sizes.min() * sizes.max() / omega**2
        K = weight[:, None, None] * K / np.outer(scale, scale)
        lowest = min(lowest, float(np.linalg.eigvalsh(K)[:, 0].min()))
    return lowest


def memories() -> Iterator[Row]:
    """Passivity of memories fitted to a barge's data below its irregular frequencies."""
    omega, A, B, infinite = barge()
    for until in (2.5, 3.0):
        memory = fit_memory(omega, A, B, infinite, band=(0.0, until))
        name = f"radiation memory of a barge without a lid, fit up to {until} rad/s: lowest Re K"
        source = "passivity from 1/1000 to 1000 times the poles"
        yield row(name, lowest_damping(memory), 0, "of its largest", source, within=1e-6)


CASES = (directions, memories)
