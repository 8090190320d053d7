"""Wind loads of a body: its areas, and coefficients over the angle of the relative wind."""

from dataclasses import dataclass

import numpy as np

from marine_mj.environment import height_factor
from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.hydrodynamics import table as t_

#: Text `BODY.wind_type` that names one of `VESSEL_TYPES`.
WIND_TYPE = "wind_type"
#: Vessel types of Blendermann (1994) in the Viknes study: CD_t, CD_lAF for wind from ahead and from
#: astern, delta.
VESSEL_TYPES = {
    "offshore_supply_vessel": (0.90, 0.55, 0.80, 0.55),
    "cargo_vessel_loaded": (0.85, 0.65, 0.55, 0.40),
}


@dataclass(frozen=True, eq=False)
class WindLoads:
    """What the wind acts on, and how (Fossen 2021, sec. 10.1).

    Attributes:
        front, lateral: areas above water A_F and A_L, m2.
        length: L_oa, m.
        height: of the centroid of the lateral area above the body origin, m.
        law: `WIND_CONSTANT`, `WIND_TABLE` or `WIND_BLENDERMANN` of `table`.
        data: numbers of the law as the kernel reads them.
        roll: whether the law has a roll coefficient; without, Y acts at `height`.
    """

    front: float
    lateral: float
    length: float
    height: float
    law: float
    data: Array
    roll: bool = False

    def centroid(self, equilibrium_height: float) -> float:
        """Height [m] of the lateral centroid above still water when the body floats at rest.

        `equilibrium_height` (m): of the body origin. Where that puts the centroid under water, the
        half height of a rectangle of that area and length (0 without an area).
        """
        height = equilibrium_height + self.height
        if height > 0:
            return height
        return 0.5 * self.lateral / self.length if self.length > 0 else 0.0

    def element(self, equilibrium_height: float, exponent: float) -> Array:
        """Parameters of the body's wind element.

        Args:
            equilibrium_height: of the body origin above still water, m.
            exponent: of the wind's height profile, see `environment.height_factor`.
        """
        height = self.centroid(equilibrium_height)
        share = float(height_factor(height, exponent)) if height > 0 else 1.0
        head = [self.front, self.lateral, self.length, self.height, share, self.law, self.roll]
        return np.concatenate([head, self.data])


def wind_loads(name: str, values: dict[str, Array], vessel_type: str | None) -> WindLoads | None:
    """Wind loads of a body from its numerics, None without any.

    Args:
        name: of the body.
        values: numerics by quantity: "wind", "wind_table", "wind_roll", "wind_lever".
        vessel_type: one of `VESSEL_TYPES`, or None.

    Raises:
        ModelError: a value is missing, superfluous or out of range.
    """
    given = set(values) | ({WIND_TYPE} if vessel_type is not None else set())
    extra = sorted(given & {"wind_table", "wind_roll", "wind_lever", WIND_TYPE})
    if "wind" not in values:
        if extra:
            raise ModelError(
                f"{name!r} has {', '.join(extra)} but no numeric '{name}.wind': add A_front, "
                "A_lateral, L_oa and the height of the lateral centroid above the origin"
            )
        return None
    numbers = values["wind"]
    if (numbers[:3] < 0).any():
        raise ModelError(f"wind of {name!r} is {numbers}; areas and length must be >= 0")
    front, lateral, length, height = (float(number) for number in numbers[:4])

    def loads(law: float, data: Array, roll: bool = False) -> WindLoads:
        return WindLoads(front, lateral, length, height, law, data, roll)

    laws = [len(numbers) == 7, "wind_table" in values, vessel_type is not None]
    if sum(laws) != 1:
        raise ModelError(
            f"wind of {name!r} has {sum(laws)} laws, allowed is one: c_x, c_y, c_n at the "
            f"end of 7 numbers of '{name}.wind', or 4 numbers there and '{name}.wind_table', or 4 "
            f"numbers and the text '{name}.wind_type'"
        )
    for key, owner, used in (("roll", "table", laws[1]), ("lever", "type", laws[2])):
        if f"wind_{key}" in values and not used:
            raise ModelError(f"wind_{key} of {name!r} belongs to wind_{owner}: leave it out")
    if laws[0]:
        return loads(t_.WIND_CONSTANT, numbers[4:])
    if vessel_type is not None:
        lever = float(values.get("wind_lever", np.zeros(1))[0])
        size = [front, lateral, length]
        return loads(t_.WIND_BLENDERMANN, _blendermann(name, vessel_type, size, lever))
    rows = _circle(name, values["wind_table"].reshape(-1, 4), values.get("wind_roll"))
    data = np.concatenate([[len(rows)], rows.ravel()])
    return loads(t_.WIND_TABLE, data, "wind_roll" in values)


def _blendermann(name: str, vessel_type: str, size: list[float], lever: float) -> Array:
    """Numbers of Blendermann's law (7,)."""
    if vessel_type not in VESSEL_TYPES:
        raise ModelError(
            f"wind_type of {name!r} is {vessel_type!r}; allowed are {', '.join(VESSEL_TYPES)}, or "
            "coefficients of your own in a wind_table"
        )
    front, lateral, length = size
    if min(front, lateral, length) <= 0:
        raise ModelError(
            f"wind of {name!r} is {size} with a wind_type; areas and length must be > 0"
        )
    transverse, *along, delta = VESSEL_TYPES[vessel_type]
    ratio = front / lateral
    return np.array([transverse, *(ratio * c for c in along), *along, delta, lever / length])


def _circle(name: str, rows: Array, roll: Array | None) -> Array:
    """Rows gamma [rad], C_X, C_Y, C_N, C_K over the whole circle, from those of `wind_table`."""
    if roll is not None and len(roll) != len(rows):
        raise ModelError(
            f"wind_roll of {name!r} has {len(roll)} values, allowed are {len(rows)}: one C_K for "
            "each row of wind_table"
        )
    table = np.column_stack([rows, np.zeros(len(rows)) if roll is None else roll])
    angle = table[:, 0]
    if angle[0] != 0 or angle[-1] not in (180, 360) or (np.diff(angle) <= 0).any():
        raise ModelError(
            f"wind_table of {name!r} has the angles {angle} deg; allowed are rising ones from 0 "
            "(wind from ahead) to 180 for a hull that is the same on both sides, or to 360 "
            "(90: from port)"
        )
    if angle[-1] == 180:
        if table[[0, -1], 2:].any():
            raise ModelError(
                f"wind_table of {name!r} ends at 180 deg, but C_Y, C_N or C_K are not 0 at 0 or "
                f"180 deg: {table[[0, -1]]}; set them to 0, or give the circle up to 360 deg"
            )
        mirrored = table[-2::-1] * [-1, 1, -1, -1, -1] + [360, 0, 0, 0, 0]
        table = np.concatenate([table, mirrored])
    elif (table[0, 1:] != table[-1, 1:]).any():
        raise ModelError(
            f"wind_table of {name!r} has other coefficients at 360 deg than at 0: "
            f"{table[[0, -1]]}; make them the same"
        )
    table[:, 0] = np.radians(table[:, 0])
    return table
