"""Reading and checking the hydrodynamic coefficients that stand in a vehicle's MJCF."""

from dataclasses import dataclass, field

import mujoco
import numpy as np

from marine_mj.errors import ModelError
from marine_mj.frames import Array, flip
from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.numerics import (
    FRAMED,
    collect,
    file_of,
    hull_mesh_of,
    matrix_of,
    of_actuators,
    values_and_frames,
)
from marine_mj.hydrodynamics.wind import WIND_TYPE, WindLoads, wind_loads

ZERO = np.zeros((6, 6))
ZERO.flags.writeable = False


@dataclass(frozen=True)
class Strips:
    """Equal slices of a slender body along its x axis.

    Attributes:
        first: x of the centre of the aftmost strip, m, body frame.
        length: length of a strip, m.
        weight: (n,) share of the displaced volume, sums to 1.
        drag: (2,) transverse quadratic drag per metre, sway and heave, N s2/m3.
        radius: radius of a circle of the mean cross-section, m (0 without displaced volume).
    """

    first: float
    length: float
    weight: Array
    drag: Array
    radius: float

    @property
    def x(self) -> Array:
        """(n,) centres of the strips, m."""
        return self.first + self.length * np.arange(len(self.weight), dtype=float)


@dataclass(frozen=True)
class Tank:
    """Liquid whose amount is the activation of an actuator: a point mass at a fixed place."""

    actuator: str
    density: float  # kg per unit of the activation
    position: Array  # (3,) m, FLU, from the body origin


@dataclass(frozen=True)
class BodyCoefficients:
    """Coefficients of one hydrodynamic body about its frame origin, in body axes FLU, SI units."""

    name: str
    added_mass: Array
    linear_damping: Array = field(default_factory=lambda: ZERO)
    quadratic_damping: Array = field(default_factory=lambda: ZERO)
    quadratic_damping_lumped: Array | None = None
    viscous_damping: Array = field(default_factory=lambda: ZERO)
    displaced_volume: float = 0.0
    buoyancy: float = 0.0
    center_of_buoyancy: Array = field(default_factory=lambda: np.zeros(3))
    submergence_height: float = 0.0
    strips: Strips | None = None
    restoring: Array | None = None
    equilibrium_height: float = 0.0
    hull_depth: float = 0.0
    wave_database: str | None = None
    shelter_database: str | None = None
    hull_mesh: str | None = None
    wind: WindLoads | None = None
    drift: Array | None = None  # (n, 4): omega, reflecting breadth, length [m] and couple [m2]
    tanks: tuple[Tank, ...] = ()
    thrust_loss: tuple[tuple[str, float], ...] = ()  # actuator, N^0.5 s/m
    reference_speed: Array = field(default_factory=lambda: np.array([2.0, 1.0]))


def check_added_mass(name: str, matrix: Array) -> None:
    """Raise unless the matrix (6, 6) is symmetric and positive semi-definite.

    Raises:
        ModelError: it is not; the message names the vehicle's body and the offending number.
    """
    scale = max(float(np.abs(matrix).max()), 1e-300)
    skewness = np.abs(matrix - matrix.T)
    if skewness.max() > 1e-9 * scale:
        i, j = np.unravel_index(skewness.argmax(), skewness.shape)
        raise ModelError(
            f"added mass of {name!r} is not symmetric: M_A[{i + 1},{j + 1}] = {matrix[i, j]:g} but "
            f"M_A[{j + 1},{i + 1}] = {matrix[j, i]:g} (FLU); an ideal fluid allows symmetric "
            "matrices only: use the mean of both, or give the upper triangle (21 numbers)"
        )
    smallest = float(np.linalg.eigvalsh(matrix)[0])
    if smallest < -1e-9 * scale:
        raise ModelError(
            f"added mass of {name!r} is not positive semi-definite: its smallest eigenvalue is "
            f"{smallest:g}; allowed is >= 0: check the signs (M_A = -X_udot ...) and the coupling "
            "terms"
        )


def _check_passive(name: str, quantity: str, matrix: Array) -> None:
    """Raise if a damping matrix feeds energy: its symmetric part has a negative eigenvalue."""
    smallest = float(np.linalg.eigvalsh(0.5 * (matrix + matrix.T))[0])
    if smallest < -1e-9 * max(float(np.abs(matrix).max()), 1e-300):
        raise ModelError(
            f"{quantity} of {name!r} feeds energy into the body: the smallest eigenvalue of its "
            f"symmetric part is {smallest:g}, allowed is >= 0 (force = -D nu_r): check the signs"
        )


def _check_drag(name: str, quantity: str, matrix: Array) -> None:
    """Raise if quadratic damping pushes along with the motion: a negative diagonal entry."""
    diagonal = np.diag(matrix)
    if diagonal.min() < 0:
        i = int(diagonal.argmin()) + 1
        raise ModelError(
            f"{quantity} of {name!r} feeds energy into the body: D_Q[{i},{i}] = "
            f"{diagonal.min():g}, allowed is >= 0 (force = -D_Q |nu_r| nu_r): check the signs"
        )


def _drift(name: str, values: Array) -> Array:
    """Drift coefficients (n, 4) from their numeric."""
    rows = values.reshape(-1, 4)
    wrong = [i for i, row in enumerate(rows) if row[:3].min() < 0 or row[0] == 0]
    wrong += [i for i in range(1, len(rows)) if rows[i, 0] <= rows[i - 1, 0]]
    if wrong:
        raise ModelError(
            f"drift of {name!r} has the row {rows[wrong[0]]}; allowed are rows of omega (rad/s, "
            "> 0 and rising from row to row), D_x and D_y (m, >= 0) and D_n (m2)"
        )
    return rows


def _strips(name: str, values: dict[str, Array], volume: float) -> Strips:
    """Strips from their numerics."""
    number, aft, fore = values["strips"]
    count = round(float(number))
    if not 2 <= count <= t_.MAX_STRIPS or count != number or fore <= aft:
        raise ModelError(
            f"strips of {name!r} is [{number:g} {aft:g} {fore:g}]; allowed are a whole number of "
            f"strips from 2 to {t_.MAX_STRIPS}, then x of the aft and of the fore end with "
            "aft < fore"
        )
    length = (fore - aft) / count
    area = values.get("strip_area", np.ones(count))
    if area.size != count or (area < 0).any() or area.sum() <= 0:
        raise ModelError(
            f"strip_area of {name!r} has {area.size} values {area}; allowed are {count} areas "
            ">= 0 m2, one for each strip"
        )
    drag = values.get("strip_drag", np.zeros(2))
    if (drag < 0).any():
        raise ModelError(f"strip_drag of {name!r} is {drag}; allowed is >= 0 N s2/m3")
    radius = float(np.sqrt(volume / (fore - aft) / np.pi))
    return Strips(aft + 0.5 * length, length, area / area.sum(), drag, radius)


def _tanks(name: str, raw: dict[str, Array], spec: mujoco.MjSpec) -> tuple[Tank, ...]:
    """Tanks from numerics `BODY.tank.ACTUATOR` = x y z (FRD, m), kg per unit."""
    tanks = []
    for numeric, actuator, data in of_actuators(name, raw, spec, "tank"):
        if data.size != 4 or data[3] <= 0:
            raise ModelError(
                f"numeric {numeric!r} is {data}; allowed are 4 numbers: x y z in FRD (m) "
                "and the mass per unit of the activation (kg, > 0)"
            )
        tanks.append(Tank(actuator, float(data[3]), flip(data[:3])))
    return tuple(tanks)


def _thrust_loss(
    name: str, raw: dict[str, Array], spec: mujoco.MjSpec
) -> tuple[tuple[str, float], ...]:
    """Losses from numerics `BODY.thrust_loss.ACTUATOR` = c (N^0.5 s/m)."""
    found = []
    for numeric, actuator, data in of_actuators(name, raw, spec, "thrust_loss"):
        if data.size != 1 or data[0] < 0:
            raise ModelError(
                f"numeric {numeric!r} is {data}; allowed is one number >= 0: thrust lost per "
                "square root of the thrust and per m/s of advance speed (N^0.5 s/m)"
            )
        found.append((actuator, float(data[0])))
    return tuple(found)


def _matrices(name: str, values: dict[str, Array], frames: dict[str, str]) -> dict[str, Array]:
    """Checked matrices (6, 6) in FLU by quantity."""
    matrices: dict[str, Array] = {}
    for quantity in FRAMED:
        if quantity in values and quantity != "strip_drag":
            matrices[quantity] = matrix_of(values[quantity], frames[quantity])
    check_added_mass(name, matrices.setdefault("added_mass", np.zeros((6, 6))))
    for quantity in ("linear_damping", "viscous_damping"):
        if quantity in matrices:
            _check_passive(name, quantity, matrices[quantity])
    for quantity in ("quadratic_damping", "quadratic_damping_lumped"):
        if quantity in matrices:
            _check_drag(name, quantity, matrices[quantity])
    return matrices


def _center(spec: mujoco.MjSpec, name: str) -> Array:
    """Centre of buoyancy (3,) of a body, FLU, m, from its site."""
    site = spec.site(f"{name}.center_of_buoyancy")
    if site is None:
        raise ModelError(
            f"{name!r} has buoyancy but no site '{name}.center_of_buoyancy': add one to the "
            "body at its centre of buoyancy"
        )
    if site.parent.name != name:
        raise ModelError(
            f"site '{site.name}' lies in the body {site.parent.name!r}, allowed is {name!r}"
        )
    return np.array(site.pos, dtype=float)


def _one_body(spec: mujoco.MjSpec, name: str, raw: dict[str, Array]) -> BodyCoefficients:
    """Checked coefficients of one body."""
    values, frames = values_and_frames(name, raw)
    matrices = _matrices(name, values, frames)
    for quantity in ("displaced_volume", "buoyancy", "submergence_height", "hull_depth"):
        if quantity in values and values[quantity][0] <= 0:
            raise ModelError(f"{quantity} of {name!r} is {values[quantity][0]:g}, allowed is > 0")
    volume, buoyancy = (float(values.get(q, [0.0])[0]) for q in ("displaced_volume", "buoyancy"))
    given = [q for q in ("displaced_volume", "buoyancy", "restoring") if q in values]
    if len(given) > 1:
        raise ModelError(
            f"{name!r} has {' and '.join(given)}; allowed is one of displaced_volume, buoyancy "
            "(submerged body) and restoring (floating body)"
        )
    if "hull_depth" in values and "restoring" not in values:
        raise ModelError(
            f"{name!r} has hull_depth but no restoring, whose lift it limits: allowed is "
            "submergence_height on a submerged body, and neither on hull panels; leave it out"
        )
    strips = None
    if "strips" in values:
        strips = _strips(name, values, volume or buoyancy / (1025 * 9.81))
    elif {"strip_drag", "strip_area"} & set(values):
        raise ModelError(
            f"{name!r} has strip_drag or strip_area but no strips: add '{name}.strips'"
        )
    return BodyCoefficients(
        name=name,
        **matrices,
        displaced_volume=volume,
        buoyancy=buoyancy,
        center_of_buoyancy=_center(spec, name) if volume or buoyancy else np.zeros(3),
        submergence_height=float(values.get("submergence_height", [0.0])[0]),
        strips=strips,
        equilibrium_height=float(values.get("equilibrium_height", [0.0])[0]),
        hull_depth=float(values.get("hull_depth", [0.0])[0]),
        wave_database=file_of(spec, name, "wave_database"),
        shelter_database=file_of(spec, name, "shelter_database"),
        hull_mesh=hull_mesh_of(spec, name),
        wind=wind_loads(name, values, file_of(spec, name, WIND_TYPE)),
        drift=_drift(name, values["drift"]) if "drift" in values else None,
        tanks=_tanks(name, raw, spec),
        thrust_loss=_thrust_loss(name, raw, spec),
        reference_speed=values.get("reference_speed", np.array([2.0, 1.0])),
    )


def read_coefficients(spec: mujoco.MjSpec) -> list[BodyCoefficients]:
    """Coefficients of every hydrodynamic body of a spec, in the order of its bodies.

    A body is hydrodynamic when the spec has a `<numeric name="BODY.QUANTITY">` for it
    (docs/architecture.md lists the quantities). Nothing is returned for a plain model.

    Raises:
        ModelError: a quantity is unknown, has the wrong number of values, or cannot be physical.
    """
    found = collect(spec)
    return [_one_body(spec, b.name, found[b.name]) for b in spec.bodies if b.name in found]
