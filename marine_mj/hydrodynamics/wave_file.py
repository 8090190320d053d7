"""What a wave database says of its water, its hull and its directions, and how it is used.

Public databases come from several programs: directions over half of the circle (the hull is
symmetric) or in degrees, water of another density or depth. Here such a file becomes one that the
rest of the package reads alike, or is refused with what to do.
"""

import re
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.hydrodynamics.netcdf import read_attributes

HullSymmetry = Literal["none", "xz", "xz yz"]
SYMMETRIES = get_args(HullSymmetry)
#: Signs of surge, sway, heave, roll, pitch, yaw under a mirror plane: xz (port for starboard; the
#: direction b becomes -b) and yz (bow for stern; b becomes pi - b).
PLANES = {"xz": (1.0, -1.0, 1.0, -1.0, 1.0, -1.0), "yz": (-1.0, 1.0, 1.0, 1.0, -1.0, -1.0)}
#: Largest angle between two wave directions, rad (ours): wider gaps hold no information of what
#: lies between, for any hull.
LARGEST_GAP = np.radians(60.0)
#: Directions as close as this are the same, rad.
SAME = 1e-4
#: Density of a file that does not say its own, kg/m3 (ours: sea water, Capytaine's is 1000).
UNSTATED_DENSITY = 1025.0
#: Half length over radius of gyration of a waterplane (ours: 1.73 for a box, 2 for an ellipse).
_HALF_LENGTH = 1.9


class WaveDatabase(str):
    """Name of a wave database, with the water and the symmetry with which a body uses it.

    A plain name stands for the water of the file and the symmetry that the file states.

    Attributes:
        water_density: of the environment, kg/m3; None: that of the file.
        hull_symmetry: instead of the file's attribute; None: that.
    """

    water_density: float | None
    hull_symmetry: HullSymmetry | None

    def __new__(
        cls,
        name: str,
        water_density: float | None = None,
        hull_symmetry: HullSymmetry | None = None,
    ) -> "WaveDatabase":
        """A name; without choices it takes those of `name`, if that has any."""
        self = super().__new__(cls, name)
        self.water_density = water_density or getattr(name, "water_density", None)
        self.hull_symmetry = hull_symmetry or getattr(name, "hull_symmetry", None)
        return self

    def __str__(self) -> str:
        """Itself: `str(name)` keeps the choices."""
        return self


@dataclass(frozen=True)
class Facts:
    """What a file says of itself; None where it says nothing.

    Attributes:
        density: rho of its water, kg/m3.
        gravity: m/s2.
        depth: m, infinity in deep water.
        symmetry: mirror planes of the hull.
        radius: largest horizontal distance of the wetted hull from the origin, m; where the file
            does not state it, an estimate from the waterplane in `hydrostatic_stiffness`.
    """

    density: float | None
    gravity: float | None
    depth: float | None
    symmetry: HullSymmetry | None
    radius: float | None


def _number(values: dict, *names: str) -> float | None:
    """First of the named values that is a number."""
    for name in names:
        if name in values:
            try:
                return float(np.ravel(values[name])[0])
            except (TypeError, ValueError):
                continue
    return None


def _in_text(text: str, pattern: str) -> float | None:
    """Number in a text, of files made before the attributes stood as numbers."""
    found = re.search(pattern, text)
    return float(found.group(1)) if found else None


def _radius(stiffness: Array | None) -> float | None:
    """Estimate of the hull's radius from the restoring (6, 6) of heave and pitch."""
    if stiffness is None or stiffness.shape != (6, 6) or not stiffness[2, 2] > 0:
        return None
    centre = abs(stiffness[2, 4] / stiffness[2, 2])
    gyration = max(stiffness[4, 4] / stiffness[2, 2] - centre**2, 0.0)
    return float(centre + _HALF_LENGTH * np.sqrt(gyration)) or None


#: Range in which a file's numbers must lie, and their unit: water from spirit to mercury, planets,
#: hulls.
_RANGES = {
    "water_density": (100.0, 20000.0, "kg/m3"),
    "gravity": (0.1, 100.0, "m/s2"),
    "hull_radius": (1e-3, 1e4, "m"),
}


def _checked(path: Path, name: str, value: float | None) -> float | None:
    """A number of the file within its range, or None where it has none."""
    low, high, unit = _RANGES[name]
    if value is not None and not low <= value <= high:
        raise ModelError(
            f"{name} of {path.name} is {value:g} {unit}, allowed are {low:g} to {high:g} {unit}: "
            "correct the attribute, or remove it to take the usual one"
        )
    return value


@lru_cache(maxsize=32)
def facts(path: Path) -> Facts:
    """What the file says of itself: attributes, or the scalars rho, g, water_depth of Capytaine.

    Raises:
        ModelError: the file cannot be read, or states a symmetry that there is not or a number
            out of its range.
    """
    scalars = ("rho", "g", "water_depth", "hydrostatic_stiffness")
    try:
        values = read_attributes(path, scalars)
    except (OSError, ValueError) as error:
        raise ModelError(f"{path.name} is not a wave database ({error})") from error
    text = str(values.get("water", ""))
    depth = _number(values, "water_depth")
    if depth is None and "infinite depth" in text:
        depth = float("inf")
    symmetry = values.get("hull_symmetry")
    if symmetry is not None and symmetry not in SYMMETRIES:
        raise ModelError(
            f"{path.name} has the attribute hull_symmetry = {symmetry!r}; allowed are "
            f"{', '.join(map(repr, SYMMETRIES))}"
        )
    stiffness = values.get("hydrostatic_stiffness")
    density, gravity = _number(values, "water_density", "rho"), _number(values, "gravity", "g")
    if density is None:
        density = _in_text(text, r"rho ([\d.]+)")
    if gravity is None:
        gravity = _in_text(text, r"g ([\d.]+) m/s2")
    radius = _number(values, "hull_radius")
    if radius is None:
        radius = _radius(None if stiffness is None else np.asarray(stiffness, dtype=float))
    return Facts(
        _checked(path, "water_density", density),
        _checked(path, "gravity", gravity),
        _in_text(text, r"depth ([\d.]+) m") if depth is None else depth,
        symmetry,
        _checked(path, "hull_radius", radius),
    )


def density_ratio(name: str, path: Path) -> float:
    """Factor on everything of the file that is proportional to the density of the water."""
    wanted = getattr(name, "water_density", None)
    if wanted is None:
        return 1.0
    return float(wanted / (facts(path).density or UNSTATED_DENSITY))


@dataclass(frozen=True)
class Circle:
    """Wave directions all around the hull, and where in the file each comes from.

    Attributes:
        angle: (m,) rising, 0 <= angle < 2 pi.
        column: (m,) place in the file.
        xz, yz: (m,) whether it is a mirror image about that plane.
    """

    angle: Array
    column: NDArray[np.intp]
    xz: NDArray[np.bool_]
    yz: NDArray[np.bool_]

    @property
    def gap(self) -> float:
        """Largest angle between neighbours, rad."""
        return float(np.diff(self.angle, append=self.angle[0] + 2 * np.pi).max())

    @property
    def even(self) -> bool:
        """Whether the directions are equally spaced."""
        step = 2 * np.pi / len(self.angle)
        return bool(
            np.abs(self.angle - self.angle[0] - step * np.arange(len(self.angle))).max() < SAME
        )

    def take(self, table: NDArray, axes: tuple[int, ...] | None) -> NDArray:
        """Columns of a table (n, directions, entries) all around, with the signs of the mirrors.

        Args:
            table: as in the file.
            axes: degree of freedom (0 surge ... 5 yaw) of each entry; None: never mirrored.
        """
        around = table[:, self.column]
        if axes is None:
            return around
        for plane, mirrored in (("xz", self.xz), ("yz", self.yz)):
            signs = np.array(PLANES[plane])[list(axes)]
            around = np.where(mirrored[:, None], around * signs, around)
        return around


def _radians(path: Path, direction: Array, units: str | None) -> Array:
    """Directions in rad; converted where the file says degrees, refused where they must be."""
    unit = "rad" if units is None else str(units).strip().lower()
    if unit.startswith("deg") or unit == "°":
        return np.radians(direction)
    if unit and not unit.startswith("rad"):
        raise ModelError(
            f"wave_direction of {path.name} has the units {units!r}, allowed are 'rad' and "
            "'degrees': convert it"
        )
    largest = float(np.abs(direction).max()) if len(direction) else 0.0
    if not largest <= 2 * np.pi + SAME:
        raise ModelError(
            f"wave_direction of {path.name} reaches {largest:g}, allowed are radians from -2 pi to "
            '2 pi: these look like degrees; convert them, or set the attribute units = "degrees" '
            "of wave_direction"
        )
    return direction


def _sorted(angle: Array, column: NDArray, xz: NDArray, yz: NDArray) -> Circle:
    """Circle of directions, doubles left out: the first of them stays."""
    turned = np.mod(angle, 2 * np.pi)
    turned = np.where(turned > 2 * np.pi - SAME, turned - 2 * np.pi, turned)
    order = np.argsort(turned, kind="stable")
    keep: list[int] = []
    for place in order:
        near = keep and turned[place] - turned[keep[-1]] < SAME
        if near and place < keep[-1]:
            keep[-1] = place
        elif not near:
            keep.append(place)
    places = np.array(keep, dtype=int)
    return Circle(np.maximum(turned[places], 0.0), column[places], xz[places], yz[places])


def whole_circle(direction: Array, symmetry: HullSymmetry) -> Circle:
    """Directions (m,) [rad] all around, mirrored where that fills gaps; may still leave some."""
    count = len(direction)
    no = np.zeros(count, dtype=bool)
    own = _sorted(direction, np.arange(count), no, no)
    if symmetry == "none":
        return own
    images = [(direction, no, no), (-direction, ~no, no)]
    if symmetry == "xz yz":
        images += [(np.pi - direction, no, ~no), (np.pi + direction, ~no, ~no)]
    angle, xz, yz = (np.concatenate(parts) for parts in zip(*images, strict=True))
    full = _sorted(angle, np.tile(np.arange(count), len(images)), xz, yz)
    return full if full.gap < own.gap - SAME else own


def circle_of(
    path: Path, direction: Array, symmetry: HullSymmetry | None, mirrors: bool = True
) -> Circle:
    """The directions of a file as a whole circle.

    Args:
        path: the file; its own symmetry counts where `symmetry` is None.
        direction: (m,) `wave_direction` as in the file.
        symmetry: of the hull.
        mirrors: False for what has no mirror images (the modes of a shelter database).

    Raises:
        ModelError: the directions are degrees without saying so, or leave a gap on the circle that
            no symmetry fills.
    """
    units = read_attributes(path, (), of="wave_direction").get("units")
    if not (len(direction) and np.isfinite(direction).all()):
        raise ModelError(f"wave_direction of {path.name} is {direction}; allowed are finite angles")
    stated: HullSymmetry = symmetry or facts(path).symmetry or "none"
    circle = whole_circle(_radians(path, direction, units), stated if mirrors else "none")
    if circle.gap <= LARGEST_GAP + SAME:
        return circle
    raise ModelError(f"{path.name}: {missing_directions(circle, stated if mirrors else None)}")


def missing_directions(circle: Circle, symmetry: HullSymmetry | None) -> str:
    """What a list of wave directions lacks, and what to do; symmetry None: no mirrors help."""
    ends = np.append(circle.angle, circle.angle[0] + 2 * np.pi)
    place = int(np.diff(ends).argmax())
    gap = f"{np.degrees(ends[place]):.4g} to {np.degrees(ends[place + 1]):.4g} deg"
    advice = "compute the directions that are missing"
    if symmetry == "none":
        advice = (
            "if the hull is symmetric about its xz plane say so, by the attribute hull_symmetry = "
            '"xz" of the file or the setting hull_symmetry = "xz" of the body '
            "(vehicles.NAME.hull_symmetry in a scenario); else " + advice
        )
    mirrored = f" (with the hull symmetry {symmetry!r})" if symmetry not in (None, "none") else ""
    return (
        f"wave_direction leaves the circle open from {gap}{mirrored}, allowed are gaps up to "
        f"{np.degrees(LARGEST_GAP):.0f} deg: {advice}"
    )
