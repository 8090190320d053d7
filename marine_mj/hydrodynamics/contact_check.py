"""What a contact part does to something that hits it: rows of `check-model`."""

from collections.abc import Iterator
from fnmatch import fnmatchcase

import mujoco

from marine_mj.hydrodynamics.contact_laws import contact_time, deepest, peak_force
from marine_mj.hydrodynamics.contact_pairs import accurate_step
from marine_mj.hydrodynamics.contact_parts import ContactPart, contact_parts

#: The nominal hit: a free mass, kg, that arrives at a speed, m/s, squarely.
NOMINAL_MASS, NOMINAL_SPEED = 100.0, 0.5


def hits(model: mujoco.MjModel) -> Iterator[tuple[str, float, str]]:
    """Quantity, value and unit of the nominal hit, once for geoms that are stated together."""
    names = [model.numeric(i).name for i in range(model.nnumeric)]
    owners = [n.removesuffix(".contact_stiffness") for n in names if n.endswith("_stiffness")]
    parts = contact_parts(model)
    told: set[ContactPart] = set()
    for geom, part in parts.items():
        if part in told:
            continue
        told.add(part)
        alike = {model.geom(g).name for g, other in parts.items() if other == part}
        label = " ".join(o for o in owners if any(fnmatchcase(name, o) for name in alike))
        yield from _hit(label or model.geom(geom).name, part)


def _hit(label: str, part: ContactPart) -> Iterator[tuple[str, float, str]]:
    """Rows of one part."""
    mass, speed, k = NOMINAL_MASS, NOMINAL_SPEED, part.stiffness
    c = part.damper(mass)
    yield f"contact {label}: stiffness", k, "N/m"
    yield "damping", c, "N s/m"
    hit = f"{mass:g} kg at {speed:g} m/s"
    yield f"{hit}: peak force", peak_force(mass, speed, k, c), "N"
    yield f"{hit}: force at first touch", c * speed, "N"
    yield f"{hit}: compression", deepest(mass, speed, k, c), "m"
    yield f"{hit}: time of contact", contact_time(mass, k, c), "s"
    yield f"{mass:g} kg: time step for the peak within 5 %", accurate_step(mass, k, c), "s"
