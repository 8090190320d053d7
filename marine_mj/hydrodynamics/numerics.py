"""Numerics and texts `BODY.QUANTITY` of an MJCF: names, sizes and frames (docs/architecture.md)."""

import difflib
from collections.abc import Iterator
from pathlib import Path

import mujoco
import numpy as np

from marine_mj.errors import ModelError
from marine_mj.frames import Array, flip_matrix
from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.contact_parts import QUANTITIES as OF_GEOMS
from marine_mj.hydrodynamics.wind import WIND_TYPE

#: Quantities whose axes are named by a suffix, with the sizes that are allowed.
FRAMED = {
    "added_mass": (6, 21, 36),
    "linear_damping": (6, 36),
    "quadratic_damping": (6, 36),
    "quadratic_damping_lumped": (6, 36),
    "viscous_damping": (6, 36),
    "restoring": (6, 36),
    "strip_drag": (2,),
}
#: Scalars and lists without axes.
PLAIN = {
    "displaced_volume": (1,),
    "buoyancy": (1,),
    "submergence_height": (1,),
    "strips": (3,),
    "strip_area": tuple(range(1, t_.MAX_STRIPS + 1)),
    "equilibrium_height": (1,),
    "hull_depth": (1,),
    "wind": (4, 7),
    "wind_table": tuple(range(8, 501, 4)),
    "wind_roll": tuple(range(2, 126)),
    "wind_lever": (1,),
    "drift": tuple(range(4, 501, 4)),
    "reference_speed": (2,),
}
#: Quantities that a factor makes larger or smaller as a whole.
SCALABLE = (*FRAMED, "displaced_volume", "buoyancy")
QUANTITIES = sorted(
    [f"{name}_{frame}" for name in FRAMED for frame in ("frd", "flu")]
    + list(PLAIN)
    + ["tank", "thrust_loss"]
)
#: Quantities `BODY.QUANTITY.ACTUATOR`.
OF_ACTUATORS = ("tank.", "thrust_loss.")
#: Texts `BODY.QUANTITY` that name a file.
TEXTS = ("wave_database", "shelter_database", "hull_mesh")


def collect(spec: mujoco.MjSpec) -> dict[str, dict[str, Array]]:
    """Numerics `BODY.QUANTITY` by body and quantity.

    Raises:
        ModelError: a quantity or its body is unknown, or a value is not finite.
    """
    bodies = {body.name for body in spec.bodies}
    found: dict[str, dict[str, Array]] = {}
    for numeric in spec.numerics:
        owner, dot, quantity = numeric.name.partition(".")
        if not dot or quantity in OF_GEOMS:
            continue
        known = quantity in QUANTITIES or quantity.startswith(OF_ACTUATORS)
        if owner not in bodies:
            if known:
                raise ModelError(
                    f"numeric {numeric.name!r} belongs to the body {owner!r}, which does not "
                    f"exist; bodies are {sorted(bodies - {'world'})}"
                )
            continue
        if not known:
            near = difflib.get_close_matches(quantity, QUANTITIES, 1, 0.5)
            hint = f"did you mean {near[0]!r}? " if near else ""
            raise ModelError(
                f"numeric {numeric.name!r}: unknown quantity {quantity!r}; {hint}known are "
                f"{', '.join(QUANTITIES)}"
            )
        data = np.array(numeric.data, dtype=float)
        if not np.isfinite(data).all():
            raise ModelError(f"numeric {numeric.name!r} holds {data}; allowed are finite numbers")
        found.setdefault(owner, {})[quantity] = data
    for text in spec.texts:
        owner, _, quantity = text.name.partition(".")
        if quantity in (*TEXTS, WIND_TYPE) and owner not in found:
            raise ModelError(
                f"text {text.name!r} belongs to the body {owner!r}, which has no hydrodynamic "
                f"coefficients; bodies that have are {sorted(found)}"
            )
    return found


def values_and_frames(name: str, raw: dict[str, Array]) -> tuple[dict[str, Array], dict[str, str]]:
    """Values by quantity without the frame suffix, and the frames: "frd", "flu" or "".

    Raises:
        ModelError: the number of values is wrong, or both frames are given.
    """
    values: dict[str, Array] = {}
    frames: dict[str, str] = {}
    for quantity, data in raw.items():
        if quantity.startswith(OF_ACTUATORS):
            continue
        stem, _, frame = quantity.rpartition("_")
        framed = stem in FRAMED and frame in ("frd", "flu")
        key = stem if framed else quantity
        sizes = FRAMED[stem] if framed else PLAIN[quantity]
        if key in values:
            raise ModelError(f"{key} of {name!r} is given in both frames, allowed is one of them")
        if data.size not in sizes:
            allowed = " or ".join(map(str, sizes[:4])) + (" ..." if len(sizes) > 4 else "")
            raise ModelError(
                f"numeric '{name}.{quantity}' has {data.size} values; allowed are {allowed}"
            )
        values[key] = data
        frames[key] = frame if framed else ""
    return values, frames


def of_actuators(
    name: str, raw: dict[str, Array], spec: mujoco.MjSpec, kind: str
) -> Iterator[tuple[str, str, Array]]:
    """Numeric, actuator and values of the numerics `BODY.kind.ACTUATOR`.

    Raises:
        ModelError: there is no such actuator.
    """
    prefix = name[: name.rfind("/") + 1]
    actuators = [actuator.name for actuator in spec.actuators]
    for quantity, data in raw.items():
        if not quantity.startswith(f"{kind}."):
            continue
        actuator = prefix + quantity.removeprefix(f"{kind}.")
        if actuator not in actuators:
            raise ModelError(
                f"numeric '{name}.{quantity}' names the actuator {actuator!r}, which does not "
                f"exist; actuators are {actuators}"
            )
        yield f"{name}.{quantity}", actuator, data


def matrix_of(values: Array, frame: str) -> Array:
    """Matrix (6, 6) in FLU of 6, 21 or 36 numbers in the named frame."""
    if values.size == 6:
        matrix = np.diag(values)
    elif values.size == 21:
        matrix = np.zeros((6, 6))
        matrix[np.triu_indices(6)] = values
        matrix = matrix + np.triu(matrix, 1).T
    else:
        matrix = values.reshape(6, 6)
    return flip_matrix(matrix) if frame == "frd" else matrix


def file_of(spec: mujoco.MjSpec, name: str, quantity: str) -> str | None:
    """File (or vessel type) that the text `BODY.QUANTITY` names, None without one."""
    return next((t.data for t in spec.texts if t.name == f"{name}.{quantity}"), None)


def hull_mesh_of(spec: mujoco.MjSpec, name: str) -> str | None:
    """File of the hull mesh as `find_mesh` finds it; the vehicle's own assets go first."""
    text = file_of(spec, name, "hull_mesh")
    if text is None or not spec.modelfiledir:
        return text
    own = Path(spec.modelfiledir, spec.meshdir or "assets", text)
    return str(own.resolve()) if own.is_file() else text
