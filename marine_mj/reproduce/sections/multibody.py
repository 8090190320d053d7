"""Figures 5.4 and 5.5: Scout and USV in the same waves, alone and one above the other."""

import numpy as np

from marine_mj.environment import wavenumber
from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.hydrodynamics.bem.rao import rao
from marine_mj.hydrodynamics.raos import DOFS
from marine_mj.reproduce.sections.base import Finding, Job, Outcome
from marine_mj.reproduce.sections.usv import DRAWN, Curve, Phasors, draw_raos
from marine_mj.validation.multibody import PANEL, cylinder_part, free_motions, usv_part

#: Depths of the Scout in the study, m.
_DEPTHS = (1.0, 2.0)
#: s; the sea states 1 to 12 have mean periods from 2.5 s on.
_PERIODS = np.array([12.0, 7.9, 5.7, 4.6, 3.8, 3.2, 2.8, 2.5, 2.2, 2.0, 1.8, 1.6])
_SEAS = 2.5
#: Of the USV, m, where not the study's whole mesh is asked for.
_COARSE = 0.15
#: A gain that changes by more (per wave amplitude or slope), or a phase by more [deg], would be
#: seen in a figure and counts as significant: ours.
_SEEN, _TURN = 0.05, 5.0
_NOT_SHOWN = "the study shows curves only"


def multibody_raos(job: Job) -> Outcome:
    """RAOs of the Scout and of the USV, each alone and with the other."""
    omega = 2 * np.pi / _PERIODS
    panel = PANEL if job.full else _COARSE
    try:
        usv = usv_part(panel)
        box = free_motions([usv], omega)
        alone = {d: free_motions([cylinder_part(d)], omega) for d in _DEPTHS}
        both = {d: free_motions([usv, cylinder_part(d)], omega) for d in _DEPTHS}
    except ModelError as error:
        stored = {dof: rao("dus_v5750_box.nc", omega, 0.0, dof) for dof in DRAWN}
        figure = draw_raos([("USV alone (stored)", omega, stored, "k-")])
        text = f"Only the USV alone, from the wave database of the package: {error}"
        return Outcome([], [job.save(figure, "usv_with_scout")], text)
    scout: list[Curve] = []
    findings: list[Finding] = []
    for color, depth in zip(("C0", "C3"), _DEPTHS, strict=True):
        beneath = both[depth][:, 6:]
        scout.append((f"at {depth:g} m, alone", omega, _by_dof(alone[depth]), f"{color}-"))
        scout.append((f"at {depth:g} m, below the USV", omega, _by_dof(beneath), f"{color}o--"))
        findings += _scout_findings(depth, alone[depth], beneath)
    curves: list[Curve] = [("USV alone", omega, _by_dof(box), "k-")]
    for style, depth in zip(("C0o--", "C3s:"), _DEPTHS, strict=True):
        curves.append((f"Scout at {depth:g} m below it", omega, _by_dof(both[depth]), style))
        findings += _usv_findings(depth, box, both[depth][:, :6])
    text = (
        "Both bodies free in the same head waves: the box of the USV and a cylinder, 1.9 x 0.2 m, "
        f"in the Scout's place (Capytaine, box on panels of {panel:g} m). Pitch per wave slope; "
        "the Scout's pitch rises in long waves towards its own period of 15 s. Changes count as "
        f"significant above {_SEEN:g} of a gain or {_TURN:g} deg of a phase, which is ours."
    )
    pictures = [
        job.save(draw_raos(scout, 1.5), "scout_with_usv"),
        job.save(draw_raos(curves), "usv_with_scout"),
    ]
    return Outcome(findings, pictures, text)


def _by_dof(motions: Phasors) -> dict[str, Phasors]:
    """RAOs (n,) by name, of motions (n, 6 or more) of which the first body counts."""
    return {dof: motions[:, DOFS.index(dof)] for dof in DRAWN}


def _change(other: Phasors, own: Phasors) -> Array:
    """Change (n, 3) of the gains of surge, heave and pitch, the last per wave slope."""
    columns = [DOFS.index(dof) for dof in DRAWN]
    scale = np.ones((len(_PERIODS), 3))
    scale[:, 2] = wavenumber(2 * np.pi / _PERIODS)
    return np.abs(np.abs(other[:, columns]) - np.abs(own[:, columns])) / scale


def _scout_findings(depth: float, own: Phasors, beneath: Phasors) -> list[Finding]:
    """Whether the USV changes the Scout's gains, in the waves of the seas and in shorter ones."""
    change, sea = _change(beneath, own), _PERIODS >= _SEAS
    return [
        _judged(f"gain of the Scout's {dof.lower()} at {depth:g} m, change by the USV, {label}",
                change[chosen, i].max())
        for i, dof in enumerate(DRAWN)
        for label, chosen in ((f"T {_SEAS:g} s and longer", sea), (f"T below {_SEAS:g} s", ~sea))
    ]  # fmt: skip


def _usv_findings(depth: float, own: Phasors, with_scout: Phasors) -> list[Finding]:
    """Whether the Scout changes the USV's gains, and the phase of its pitch."""
    change = _change(with_scout, own)
    found = [
        _judged(f"gain of the USV's {dof.lower()}, change by a Scout at {depth:g} m",
                change[:, i].max())
        for i, dof in enumerate(DRAWN)
    ]  # fmt: skip
    i = DOFS.index("Pitch")
    turn = float(np.degrees(np.abs(np.angle(with_scout[:, i] / own[:, i]))).max())
    note = (
        f"{_NOT_SHOWN}, and leaves open whether its solution was inaccurate; two bodies in "
        "potential flow give none"
    )
    verdict = "agrees" if turn > _TURN else "differs"
    what = f"phase of the USV's pitch, change by a Scout at {depth:g} m"
    return [*found, Finding(what, "significant", turn, "deg", verdict, note)]


def _judged(what: str, change: float) -> Finding:
    """Finding that agrees where a gain does not change visibly."""
    verdict = "agrees" if change < _SEEN else "differs"
    return Finding(what, "not significant", float(change), "1", verdict, _NOT_SHOWN)
