"""Contact parts: geoms that state a stiffness in N/m and a damping, as numerics of an MJCF.

`GEOM.contact_stiffness` (N/m) with `GEOM.contact_damping` (N s/m) or `GEOM.contact_restitution`;
GEOM may hold `*`. `contact_pairs` makes MuJoCo's contact parameters of them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from fnmatch import fnmatchcase

import mujoco
import numpy as np

from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.hydrodynamics.contact_laws import LOWEST_RESTITUTION, damping_ratio

#: Quantities `GEOM.QUANTITY` of an MJCF.
QUANTITIES = ("contact_stiffness", "contact_damping", "contact_restitution")


@dataclass(frozen=True)
class ContactPart:
    """A geom with a stiffness of its own.

    Attributes:
        stiffness: N/m, of all contact points together when two geoms lie flat on each other.
        damping: N s/m; None where `restitution` says it.
        restitution: speed after over speed before a free impact, 1; None where `damping` says it.
    """

    stiffness: float
    damping: float | None
    restitution: float | None

    def damper(self, mass: float) -> float:
        """Damping, N s/m, for an effective mass, kg."""
        if self.restitution is None:
            return self.damping or 0.0
        return 2 * damping_ratio(self.restitution) * float(np.sqrt(self.stiffness * mass))


def _numerics(model: mujoco.MjModel) -> dict[str, Array]:
    """Numerics of a compiled model by name."""
    found = {}
    for i in range(model.nnumeric):
        start = model.numeric_adr[i]
        found[model.numeric(i).name] = model.numeric_data[start : start + model.numeric_size[i]]
    return found


def _value(name: str, quantity: str, data: Array) -> float:
    """A number of a numeric, checked."""
    allowed = {
        "contact_stiffness": "one number above 0 (N/m)",
        "contact_damping": "one number of 0 or more (N s/m)",
        "contact_restitution": f"one number from {LOWEST_RESTITUTION:g} to 1",
    }[quantity]
    value = float(data[0]) if len(data) == 1 else np.nan
    fine = {
        "contact_stiffness": value > 0,
        "contact_damping": value >= 0,
        "contact_restitution": LOWEST_RESTITUTION <= value <= 1,
    }[quantity]
    if not (fine and np.isfinite(value)):
        raise ModelError(f"numeric {name!r} is {np.asarray(data)}; allowed is {allowed}")
    return value


def contact_parts(model: mujoco.MjModel) -> dict[int, ContactPart]:
    """Contact parts of a compiled model by the id of their geom.

    Raises:
        ModelError: a quantity, its geom or its value is not allowed.
    """
    geoms = [model.geom(i).name for i in range(model.ngeom)]
    stated = _stated(_numerics(model), geoms)
    found = {}
    for geom, values in stated.items():
        name = geoms[geom]
        if "contact_stiffness" not in values:
            raise ModelError(
                f"geom {name!r} has {' and '.join(values)} but no contact_stiffness; add "
                f'<numeric name="{name}.contact_stiffness" data="..."/> (N/m)'
            )
        if len(values) == 3:
            raise ModelError(
                f"geom {name!r} has contact_damping = {values['contact_damping']:g} and "
                f"contact_restitution = {values['contact_restitution']:g}; allowed is one of them, "
                "leave the other out"
            )
        if not (model.geom_contype[geom] or model.geom_conaffinity[geom]):
            raise ModelError(
                f"geom {name!r} has a contact_stiffness but contype and conaffinity 0: it touches "
                "nothing; set one of them or remove the numeric"
            )
        found[geom] = ContactPart(
            values["contact_stiffness"],
            values.get("contact_damping"),
            values.get("contact_restitution"),
        )
    return found


def _stated(numerics: Mapping[str, Array], geoms: Sequence[str]) -> dict[int, dict[str, float]]:
    """Values by quantity of every geom that a numeric names."""
    stated: dict[int, dict[str, float]] = {}
    for name, data in numerics.items():
        owner, _, quantity = name.rpartition(".")
        if not owner or not quantity.startswith("contact_"):
            continue
        if quantity not in QUANTITIES:
            near = get_close_matches(quantity, QUANTITIES, 1, 0.5)
            hint = f"did you mean {near[0]!r}? " if near else ""
            raise ModelError(
                f"numeric {name!r}: unknown quantity {quantity!r}; {hint}known are "
                f"{', '.join(QUANTITIES)}"
            )
        value = _value(name, quantity, data)
        chosen = [i for i, geom in enumerate(geoms) if geom and fnmatchcase(geom, owner)]
        if not chosen:
            near = get_close_matches(owner, [geom for geom in geoms if geom], 3, 0.5)
            hint = f"nearest are {near}" if near else "name the geom"
            raise ModelError(
                f"numeric {name!r} belongs to the geom {owner!r}, which does not exist; {hint}"
            )
        for i in chosen:
            if quantity in stated.setdefault(i, {}):
                raise ModelError(
                    f"geom {geoms[i]!r} has {quantity} from two numerics, one of them {name!r}; "
                    "allowed is one: make the names with * narrower"
                )
            stated[i][quantity] = value
    return stated


def scale_stiffness(spec: mujoco.MjSpec, factor: float) -> None:
    """Multiply every stiffness of a spec's contact parts, at the same damping ratios."""
    if factor == 1:
        return
    for numeric in spec.numerics:
        if numeric.name.endswith(".contact_stiffness"):
            numeric.data = factor * np.asarray(numeric.data)
        elif numeric.name.endswith(".contact_damping"):
            numeric.data = np.sqrt(factor) * np.asarray(numeric.data)
