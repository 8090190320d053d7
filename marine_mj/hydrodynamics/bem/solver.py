"""Radiation and diffraction of one or several bodies by Capytaine (extra `bem`)."""

import contextlib
import logging
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.hydrodynamics.bem.panels import MIRRORS, Panels
from marine_mj.hydrodynamics.raos import DOFS

#: Panels that are solved for: fewer say nothing, more do not fit into memory (16 n^2 bytes, twice).
FEWEST, MOST = 20, 5000
#: Boundary integral equations.
METHODS = ("direct", "indirect")
#: Panel radii (half diagonals) per wavelength that are needed.
PER_WAVELENGTH = 8


@dataclass(frozen=True)
class Part:
    """One of several bodies in the same water.

    Attributes:
        hull: wetted panels where the body is, z = 0 is the still water surface.
        origin: (3,) centre of its rotations, m.
        lid: panels in its waterplane against irregular frequencies.
    """

    hull: Panels
    origin: Array
    lid: Panels | None = None


@dataclass(frozen=True)
class Solution:
    """Linear hydrodynamic coefficients of a body, Capytaine's conventions, about its origin.

    Of p bodies (`solve_bodies`) the last axes have 6 p entries, body by body, instead of 6.

    Attributes:
        omega: (n,) rad/s, ascending; empty in an unbounded fluid.
        directions: (m,) directions of travel, rad, counter-clockwise from x.
        added_mass: (n, 6, 6) kg, kg m, kg m2.
        damping: (n, 6, 6) radiation damping, kg/s ...
        infinite: (6, 6) added mass at infinite frequency (that of the unbounded fluid if there is
            no surface).
        zero: (6, 6) added mass at zero frequency, None in an unbounded fluid or finite depth.
        froude_krylov: (n, m, 6) complex, N/m, N m/m.
        diffraction: (n, m, 6) complex.
        asymmetry: largest |A - A'| over the largest |A| before symmetrising, a mesh error.
        details: Capytaine's results by (omega, dof name or direction) if they were asked for.
    """

    omega: Array
    directions: Array
    added_mass: Array
    damping: Array
    infinite: Array
    zero: Array | None
    froude_krylov: NDArray[np.complex128]
    diffraction: NDArray[np.complex128]
    asymmetry: float
    details: dict[tuple[float, Any], Any]


def capytaine() -> ModuleType:
    """The module capytaine.

    Raises:
        ModelError: it is not installed, or its version is not 3.
    """
    try:
        import capytaine as module
    except ImportError as error:
        raise ModelError(
            "the boundary element method needs Capytaine 3: "
            'pip install "marine-mj[bem]" (mesh checks and hydrostatics work without it: '
            "--hydrostatics)"
        ) from error
    if module.__version__.split(".")[0] != "3":
        raise ModelError(
            f'capytaine is {module.__version__}, needed is 3: pip install "marine-mj[bem]"'
        )
    return module


def floating_body(hull: Panels, lid: Panels | None, origin: Array) -> Any:
    """Capytaine's body of the panels with six rigid degrees of freedom about `origin` (3,) [m]."""
    cpt = capytaine()
    return cpt.FloatingBody(
        mesh=_mesh(hull),
        lid_mesh=None if lid is None else _mesh(lid),
        dofs=cpt.rigid_body_dofs(rotation_center=tuple(origin)),
    )


def _joined(bodies: Sequence[Part]) -> tuple[Any, list[str]]:
    """Capytaine's body of all parts, and the names of its degrees of freedom, part by part."""
    made = [floating_body(part.hull, part.lid, np.asarray(part.origin)) for part in bodies]
    if len(made) == 1:
        return made[0], DOFS
    for number, body in enumerate(made):
        body.name = f"body_{number}"
    cpt = capytaine()
    return cpt.Multibody(made), [f"{body.name}__{dof}" for body in made for dof in DOFS]


def _mesh(panels: Panels) -> Any:
    """Capytaine's mesh, symmetric where the panels are."""
    cpt = capytaine()
    flat = panels.corners.reshape(-1, 3)
    same = np.abs(panels.corners - np.roll(panels.corners, 1, axis=1)).max(axis=2) == 0
    faces = [[4 * i + j for j in range(4) if not same[i, j]] for i in range(len(panels.corners))]
    mesh = cpt.Mesh(vertices=flat, faces=faces)
    for axis in panels.mirrors:
        mesh = cpt.ReflectionSymmetricMesh(half=mesh, plane=MIRRORS[axis])
    return mesh


def check_panels(hull: Panels, omega: Array, gravity: float) -> list[str]:
    """Notes on the resolution of a hull.

    Raises:
        ModelError: there are too few or too many panels; the message has the numbers.
    """
    count = len(hull)
    if not FEWEST <= count or len(hull.corners) > MOST:
        size = float(np.sqrt(3) * np.median(hull.radius()))
        share = np.sqrt(len(hull.corners) / MOST) if count >= FEWEST else np.sqrt(count / 400)
        raise ModelError(
            f"the hull has {count} panels ({len(hull.corners)} to be solved for), allowed are "
            f"{FEWEST} to {MOST}: set the panel size to about {size * share:.2g} m"
        )
    notes = []
    if len(omega):
        # Capytaine's rule: eight panel radii in a wavelength.
        limit = np.sqrt(2 * np.pi * gravity / (PER_WAVELENGTH * np.percentile(hull.radius(), 90)))
        if omega.max() > limit:
            notes.append(
                f"the panels resolve waves up to {limit:.3g} rad/s, asked for are "
                f"{omega.max():.3g} rad/s: take smaller panels or fewer frequencies"
            )
    return notes


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Capytaine without its advice: resolution and irregular frequencies are handled here."""
    log = logging.getLogger("capytaine")
    level = log.level
    log.setLevel(logging.ERROR)
    try:
        yield
    finally:
        log.setLevel(level)


def solve(
    hull: Panels,
    lid: Panels | None = None,
    *,
    origin: Array | None = None,
    **options: Any,
) -> Solution:
    """Added mass, damping and wave loads of a body by the boundary element method.

    Args:
        hull: wetted panels, z = 0 is the still water surface.
        lid: panels in the waterplane against irregular frequencies.
        origin: (3,) centre of the rotations, m; default (0, 0, 0).
        **options: see `solve_bodies`.

    Raises:
        ModelError: see `solve_bodies`.
    """
    return solve_bodies([Part(hull, np.zeros(3) if origin is None else origin, lid)], **options)


def solve_bodies(
    bodies: Sequence[Part],
    *,
    omega: Array,
    directions: Array,
    density: float,
    gravity: float = 9.81,
    depth: float = np.inf,
    unbounded: bool = False,
    method: str = "direct",
    keep: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> Solution:
    """Coupled added mass, damping and wave loads of bodies by the boundary element method.

    Every body moves on its own in the waves that all of them scatter and radiate; with p bodies
    the matrices are (6 p, 6 p), loads 6 p. Bodies whose panels have the same mirrors are solved as
    halves (or quarters).

    Args:
        bodies: one or more.
        omega: (n,) rad/s; not used in an unbounded fluid.
        directions: (m,) rad.
        density: kg/m3.
        gravity: m/s2.
        depth: of the water, m.
        unbounded: no water surface and no bottom: only the added mass.
        method: "direct" (potentials; ten times as accurate on smooth hulls) or "indirect"
            (sources), the boundary integral equation.
        keep: keep Capytaine's results with the potentials on the panels.
        progress: called with (solved, all) frequencies.

    Raises:
        ModelError: there is no body, Capytaine is missing, the method is unknown, or see
            `check_panels`.
    """
    if not bodies:
        raise ModelError("bodies is empty; allowed are one or more")
    cpt = capytaine()
    if method not in METHODS:
        raise ModelError(f"method {method!r} does not exist, there are {', '.join(METHODS)}")
    omega = np.sort(np.asarray(omega, dtype=float)) if not unbounded else np.zeros(0)
    for part in bodies:
        check_panels(part.hull, omega, gravity)
    body, dofs = _joined(bodies)
    solver = cpt.BEMSolver(method=method)
    common = {"body": body, "rho": density, "g": gravity, "water_depth": depth}
    surface = {"free_surface": np.inf} if unbounded else {"free_surface": 0.0}
    if unbounded:
        common["water_depth"] = np.inf
    limits = [np.inf] if unbounded or np.isfinite(depth) else [0.0, np.inf]
    wanted = [*omega.tolist(), *limits]
    details: dict[tuple[float, Any], Any] = {}
    A, B, limit = [], [], {}
    loads: dict[str, list] = {"froude_krylov": [], "diffraction": []}

    def radiation(w: float) -> tuple[Array, Array]:
        """Added mass and damping (6 p, 6 p), rows are forces."""
        a, b = np.zeros((len(dofs), len(dofs))), np.zeros((len(dofs), len(dofs)))
        frequency = {"omega": w} if not unbounded else {"omega": 1.0}
        for j, dof in enumerate(dofs):
            problem = cpt.RadiationProblem(radiating_dof=dof, **frequency, **common, **surface)
            result = solver.solve(problem, keep_details=keep, _check_wavelength=False)
            a[:, j] = [result.added_masses[i] for i in dofs]
            b[:, j] = [result.radiation_dampings[i] for i in dofs]
            if keep:
                details[w, dof] = result
        return a, b

    with _quiet():
        for done, w in enumerate(wanted):
            if progress:
                progress(done, len(wanted))
            a, b = radiation(w)
            if w in limits:
                limit[w] = a
                continue
            A.append(a)
            B.append(b)
            rows: dict[str, list] = {name: [] for name in loads}
            for beta in np.asarray(directions, dtype=float).tolist():
                problem = cpt.DiffractionProblem(omega=w, wave_direction=beta, **common)
                result = solver.solve(problem, keep_details=keep, _check_wavelength=False)
                incident = cpt.bem.airy_waves.froude_krylov_force(problem)
                rows["froude_krylov"].append([incident[i] for i in dofs])
                rows["diffraction"].append([result.forces[i] for i in dofs])
                if keep:
                    details[w, beta] = result
            for name in loads:
                loads[name].append(rows[name])
    if progress:
        progress(len(wanted), len(wanted))

    added = np.array([*A, *limit.values()])
    asymmetry = float(np.abs(added - np.swapaxes(added, -1, -2)).max() / np.abs(added).max())
    shape = (len(omega), len(directions), len(dofs))
    return Solution(
        omega,
        np.asarray(directions, dtype=float),
        _symmetric(np.array(A).reshape(-1, len(dofs), len(dofs))),
        _symmetric(np.array(B).reshape(-1, len(dofs), len(dofs))),
        _symmetric(limit[np.inf]),
        _symmetric(limit[0.0]) if 0.0 in limit else None,
        np.array(loads["froude_krylov"], dtype=complex).reshape(shape),
        np.array(loads["diffraction"], dtype=complex).reshape(shape),
        asymmetry,
        details,
    )


def _symmetric(matrix: Array) -> Array:
    """Mean of a matrix and its transpose: both are right up to the panel error."""
    return 0.5 * (matrix + np.swapaxes(matrix, -1, -2))
