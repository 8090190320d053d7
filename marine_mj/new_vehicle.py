"""A new vehicle folder from the packaged template."""

import re
import shutil
from collections.abc import Sequence
from importlib import resources
from pathlib import Path
from typing import Any

from marine_mj.errors import ModelError
from marine_mj.frames import flip

_TEMPLATE = "_template"
#: Stands for the name in the template's files and in their names.
_PLACEHOLDER = "VEHICLE"
#: Sizes a coefficient may have: diagonal, upper triangle, full.
_SIZES = (6, 21, 36)


def new_vehicle(
    name: str,
    folder: str | Path = "models",
    *,
    mass: float | None = None,
    inertia: Sequence[float] | None = None,
    center_of_gravity: Sequence[float] | None = None,
    buoyancy: float | None = None,
    coefficients: dict[str, Sequence[float]] | None = None,
) -> Path:
    """Folder of a new vehicle, copied from the template with names and numbers filled in.

    Args:
        name: of the vehicle: letters, digits and _.
        folder: in which the vehicle's folder is made.
        mass: kg.
        inertia: (3,) about the centre of gravity, kg m2.
        center_of_gravity: (3,) from the body origin, m, FRD; the template's centre of buoyancy is
            at the origin.
        buoyancy: weight of the displaced water, N.
        coefficients: values of `hull.<key>` numerics, such as `added_mass_frd`.

    Raises:
        ModelError: the name is not allowed, the folder exists, or numbers have the wrong count.
    """
    if not name.isidentifier() or name.startswith("_"):
        raise ModelError(f"vehicle name {name!r} is not allowed: letters, digits and _ only")
    target = Path(folder) / name
    if target.exists():
        raise ModelError(f"{target} exists already: choose another name or remove it")
    if mass is not None and not mass > 0:
        raise ModelError(f"mass must be > 0 kg, got {mass}")
    if inertia is not None and (len(inertia) != 3 or min(inertia) <= 0):
        raise ModelError(f"inertia needs 3 values > 0 in kg m2, got {list(inertia)}")
    if center_of_gravity is not None and len(center_of_gravity) != 3:
        raise ModelError(
            f"center_of_gravity needs 3 values in m (FRD), got {list(center_of_gravity)}"
        )
    for key, values in (coefficients or {}).items():
        if len(values) not in _SIZES:
            raise ModelError(f"{key} needs 6, 21 or 36 values, got {len(values)}")
    source = Path(str(resources.files("marine_mj.models"))) / _TEMPLATE
    if not source.is_dir():
        raise ModelError(f"the template folder {source} is missing: reinstall marine_mj")
    shutil.copytree(source, target, ignore=shutil.ignore_patterns("__pycache__"))
    for path in sorted(target.rglob(f"*{_PLACEHOLDER}*")):
        path.rename(path.with_name(path.name.replace(_PLACEHOLDER, name)))
    for path in [*target.rglob("*.xml"), *target.rglob("*.md")]:
        text = path.read_text(encoding="utf-8").replace(_PLACEHOLDER, name)
        if path.suffix == ".xml":
            inertial: dict[str, Any] = {
                "mass": None if mass is None else [mass],
                "diaginertia": inertia,
                "pos": None if center_of_gravity is None else flip(center_of_gravity),
            }
            text = _filled(text, inertial, buoyancy, coefficients or {})
        path.write_text(text, encoding="utf-8")
    return target


def _filled(
    text: str,
    inertial: dict[str, Any],
    buoyancy: float | None,
    coefficients: dict[str, Sequence[float]],
) -> str:
    """MJCF text with the given numbers; comments and layout stay."""
    for key, given in inertial.items():
        if given is not None:
            values = " ".join(f"{v + 0.0:g}" for v in given)
            pattern = rf'(<inertial\b[^>]*\b{key}=")[^"]*'
            text = re.sub(pattern, rf"\g<1>{values}", text, count=1)
    numbers = dict(coefficients)
    if buoyancy is not None:
        numbers["buoyancy"] = [buoyancy]
        line = f'<numeric name="hull.buoyancy" data="{buoyancy:g}"/>'
        text = re.sub(r'<numeric name="hull\.displaced_volume"[^>]*/>', line, text)
    for key, value in numbers.items():
        line = f'<numeric name="hull.{key}" data="{" ".join(f"{v:g}" for v in value)}"/>'
        pattern = rf'<numeric name="hull\.{key}"[^>]*/>'
        if re.search(pattern, text):
            text = re.sub(pattern, line, text, count=1)
        else:
            text = text.replace("</custom>", f"  {line}\n  </custom>", 1)
    return text
