"""MuJoCo's contact parameters for contact parts, by pair and wet effective mass.

MuJoCo's own parameters are accelerations, so that its force grows with the mass of whoever touches.
Here each pair of a part and a geom that it can meet gets the parameters that make the force
`k r + c v`, by the wet effective mass of that pair.

With R the regularisation of a contact and A the inverse effective mass, MuJoCo's force is
`(a_ref - a_0) / (A + R)` (computation chapter, constraint model). Where R is large beside A the
force hardly depends on A: not on where and in which direction a body is hit, nor on whether it
can give way. So the impedance `d = A / (A + R)` is chosen as low as the time step allows.
"""

import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import mujoco
import numpy as np

from marine_mj.errors import MarineMjWarning, ModelError
from marine_mj.hydrodynamics.contact_parts import contact_parts

#: Names of the pairs that the loader adds.
PREFIX = "marine_mj/contact/"
#: Ratio of friction to normal impedance: the friction of a soft contact stays that of a hard one.
#: With 1, sliding lifts a body off: 30 % more force at 0.3 m/s into and 0.5 m/s along a plane.
IMPRATIO = 100.0
#: Rate at which friction ends a slip that it can hold, 1/s: as MuJoCo's default solref of 0.02 s.
FRICTION_RATE = 100.0
#: Impedances: the lowest that is used, and the highest with which a model is still run.
LOWEST_IMPEDANCE, HIGHEST_IMPEDANCE = 0.02, 0.5
#: Largest `h c / m` and `h sqrt(k / m)` for a peak force within 5 %, and without a warning.
STEP_ACCURATE, STEP_WARNED = (0.05, 0.5), (0.1, 0.7)

_GEOM = mujoco.mjtGeom
#: Contact points of two geoms that lie flat on each other, by the names of their types; others: 1.
_POINTS = {
    ("plane", "capsule"): 2,
    ("plane", "cylinder"): 3,
    ("plane", "box"): 4,
    ("capsule", "box"): 2,
    ("box", "box"): 4,
}


@dataclass(frozen=True)
class ContactPair:
    """Two geoms of which one or both are contact parts.

    Attributes:
        number: of the pair in the model.
        geoms: their ids.
        mass: wet effective mass, kg: mean over all directions, at the bodies' centres of mass.
        stiffness: N/m.
        damping: N s/m.
        points: contact points that share them.
    """

    number: int
    geoms: tuple[int, int]
    mass: float
    stiffness: float
    damping: float
    points: int


def prepare_contacts(spec: mujoco.MjSpec) -> bool:
    """Make a spec ready for `add_contact_pairs`; False when it states no contact part.

    Names the geoms that have none, removes pairs of an earlier call, and sets the elliptic friction
    cone with impedances in which a soft contact keeps its friction.
    """
    for added in (*spec.pairs, *spec.excludes):
        if added.name.startswith(PREFIX):
            spec.delete(added)
    if not any(".contact_" in numeric.name for numeric in spec.numerics):
        return False
    number = 0
    for geom in spec.geoms:
        if not geom.name and (geom.contype or geom.conaffinity):
            geom.name, number = f"{PREFIX}geom{number}", number + 1
    if spec.option.cone != mujoco.mjtCone.mjCONE_ELLIPTIC:
        warnings.warn(
            "parts with a contact_stiffness need the elliptic friction cone, which is used instead "
            'of the pyramidal one; set <option cone="elliptic"/>, in a scenario '
            'friction_cone = "elliptic"',
            MarineMjWarning,
            stacklevel=3,
        )
        spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = max(spec.option.impratio, IMPRATIO)
    return True


def add_contact_pairs(spec: mujoco.MjSpec, plain: mujoco.MjModel) -> None:
    """Add a pair for every contact part and geom that it can meet, with MuJoCo's own friction.

    Where bodies meet of which one has a contact part, all their geoms get pairs, with MuJoCo's own
    parameters where none is stated, and the bodies are excluded from the general search: a geom
    pair is looked for once then, instead of twice (11.6 instead of 15.8 us a step in the cradle).

    Args:
        spec: as `prepare_contacts` left it.
        plain: compiled from it.
    """
    parts = contact_parts(plain)
    meetings: dict[tuple[int, int], list[tuple[int, int]]] = {}
    for first, second in combinations(range(plain.ngeom), 2):
        if _can_meet(plain, first, second):
            body1, body2 = sorted(int(b) for b in plain.geom_bodyid[[first, second]])
            meetings.setdefault((body1, body2), []).append((first, second))
    explicit = {frozenset(p) for p in zip(plain.pair_geom1, plain.pair_geom2, strict=True)}
    for bodies, pairs in meetings.items():
        if not any(geom in parts for pair in pairs for geom in pair):
            continue
        for first, second in pairs:
            if {first, second} not in explicit:
                spec.add_pair(
                    name=f"{PREFIX}{first}-{second}",
                    geomname1=plain.geom(first).name,
                    geomname2=plain.geom(second).name,
                    **_shared(plain, first, second),
                )
        name1, name2 = (plain.body(body).name for body in bodies)
        if name1 and name2:
            name = f"{PREFIX}{bodies[0]}-{bodies[1]}"
            spec.add_exclude(name=name, bodyname1=name1, bodyname2=name2)


def _can_meet(model: mujoco.MjModel, first: int, second: int) -> bool:
    """Whether MuJoCo looks for contacts of two geoms (its rules of selection)."""
    type1, type2 = model.geom_contype[[first, second]]
    affinity1, affinity2 = model.geom_conaffinity[[first, second]]
    if not (type1 & affinity2 or type2 & affinity1):
        return False
    body1, body2 = sorted(int(b) for b in model.geom_bodyid[[first, second]])
    if (body1 << 16) + body2 in model.exclude_signature:
        return False
    weld = model.body_weldid
    weld1, weld2 = weld[body1], weld[body2]
    if weld1 == weld2:
        return False
    parents = weld[model.body_parentid[weld1]], weld[model.body_parentid[weld2]]
    filtered = not model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_FILTERPARENT
    return not (filtered and weld1 and weld2 and (weld1 == parents[1] or weld2 == parents[0]))


def _shared(model: mujoco.MjModel, first: int, second: int) -> dict[str, Any]:
    """Contact parameters of two geoms as MuJoCo combines them (modelling chapter, contact)."""
    pair = [first, second]
    ranks, solmix = model.geom_priority[pair], model.geom_solmix[pair]
    solref, solimp = model.geom_solref[pair], model.geom_solimp[pair]
    condim, friction = model.geom_condim[pair].max(), model.geom_friction[pair].max(axis=0)
    weights = solmix / solmix.sum() if solmix.sum() > mujoco.mjMINVAL else np.full(2, 0.5)
    if ranks[0] != ranks[1]:
        chosen = pair[int(np.argmax(ranks))]
        condim, friction = model.geom_condim[chosen], model.geom_friction[chosen]
        weights = (ranks == ranks.max()).astype(float)
    direct = bool((solref[:, 0] <= 0).any()) and ranks[0] == ranks[1]
    return {
        "condim": int(condim),
        "friction": friction[[0, 0, 1, 2, 2]],
        "solref": solref.min(axis=0) if direct else weights @ solref,
        "solimp": weights @ solimp,
        "margin": float(model.geom_margin[pair].sum()),
        "gap": float(model.geom_gap[pair].sum()),
    }


def contact_pairs(model: mujoco.MjModel) -> Iterator[ContactPair]:
    """The pairs that hold stated stiffnesses, with their present wet masses.

    Two parts that meet are springs in series; each damps its share of the compression.
    """
    parts = contact_parts(model)
    for number in range(model.npair):
        if not model.pair(number).name.startswith(PREFIX):
            continue
        geoms = int(model.pair_geom1[number]), int(model.pair_geom2[number])
        members = [parts[g] for g in geoms if g in parts]
        inverse = model.body_invweight0[model.geom_bodyid[list(geoms)], 0].sum()
        if not members or inverse < mujoco.mjMINVAL:  # nothing stated, or nothing can move
            continue
        mass = float(1 / inverse)
        stiffness = 1 / sum(1 / part.stiffness for part in members)
        damping = sum(p.damper(mass) * (stiffness / p.stiffness) ** 2 for p in members)
        kinds = sorted(int(model.geom_type[g]) for g in geoms)
        names = tuple(_GEOM(kind).name.removeprefix("mjGEOM_").lower() for kind in kinds)
        points = _POINTS.get((names[0], names[1]), 1)
        yield ContactPair(number, geoms, mass, stiffness, damping, points)


def _needed_impedance(pair: ContactPair, step: float) -> float:
    """Impedance from which on the contact is stable however light the body is where it is hit.

    An explicit spring and damper on a mass m is stable for `h c / m + h^2 k / (2 m) < 2`;
    regularisation bounds 1 / m by `1 / (m d)`. A tenth is left.
    """
    return step * (pair.damping + 0.5 * step * pair.stiffness) / (1.8 * pair.mass)


def convert_contacts(model: mujoco.MjModel) -> None:
    """Set the parameters of the pairs for the wet masses in `body_invweight0`.

    To be called after every change of these.
    """
    step = model.opt.timestep
    for pair in contact_pairs(model):
        d = float(np.clip(_needed_impedance(pair, step), LOWEST_IMPEDANCE, HIGHEST_IMPEDANCE))
        # n points with R each: n f = n a_ref / (n A + R), to be k r for a body that is free
        share = (pair.points * d + 1 - d) / (pair.points * pair.mass)
        # MuJoCo: a_ref = -(k' / d) r - (b' / d) v for solref = (-k', -b')
        solref = -pair.stiffness * share, -max(pair.damping * share, mujoco.mjMINVAL)
        # friction rows have R / impratio; MuJoCo divides by d
        softness = 1 + (1 - d) / d / model.opt.impratio
        rate = min(FRICTION_RATE, 0.5 / step) * softness * d
        model.pair_solref[pair.number] = solref
        model.pair_solreffriction[pair.number] = 0.0, -rate
        model.pair_solimp[pair.number] = d, d, 0.001, 0.5, 2.0


def accurate_step(mass: float, stiffness: float, damping: float) -> float:
    """Time step, s, up to which a peak force is within 5 % wherever in a step a contact begins.

    Measured for `implicitfast` and Euler: a damper that is not yet there while a step goes on
    leaves up to `h c / m` too much, a spring alone `(h^2 k / m) / 10`.
    """
    damper, spring = STEP_ACCURATE
    bounds = [spring * np.sqrt(mass / stiffness)]
    if damping > 0:
        bounds.append(damper * mass / damping)
    return float(min(bounds))


def check_contact_step(model: mujoco.MjModel) -> None:
    """Warn about, or refuse, a time step that is too long for a contact part.

    Raises:
        ModelError: the contact would be far from its stated stiffness.
    """
    step, worst = model.opt.timestep, None
    for pair in contact_pairs(model):
        damper = step * pair.damping / pair.mass / STEP_WARNED[0]
        spring = step * np.sqrt(pair.stiffness / pair.mass) / STEP_WARNED[1]
        share = max(damper, spring)
        if worst is None or share > worst[0]:
            worst = share, pair
    if worst is None or worst[0] <= 1:
        return
    pair = worst[1]
    first, second = (model.geom(g).name for g in pair.geoms)
    limit = accurate_step(pair.mass, pair.stiffness, pair.damping)
    what = (
        f"timestep is {step:g} s, but {first!r} and {second!r} meet with {pair.stiffness:.4g} N/m "
        f"and {pair.damping:.4g} N s/m at {pair.mass:.4g} kg: a peak force within 5 % needs "
        f"{limit:.2g} s or less"
    )
    if _needed_impedance(pair, step) > HIGHEST_IMPEDANCE:
        raise ModelError(f"{what}, and this step is not stable; lower the timestep")
    warnings.warn(f"{what}; lower the timestep", MarineMjWarning, stacklevel=3)


def compile_dry(spec: mujoco.MjSpec) -> mujoco.MjModel:
    """A compiled spec without hydrodynamic bodies, with its contact parts if it has some."""
    if not prepare_contacts(spec):
        return spec.compile()
    add_contact_pairs(spec, spec.compile())
    model = spec.compile()
    convert_contacts(model)
    check_contact_step(model)
    return model
