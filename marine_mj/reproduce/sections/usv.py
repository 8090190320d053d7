"""The USV: largest pitch (table 5.3), RAOs by mesh (5.2) and motion in waves (5.7)."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from marine_mj.environment import SEA_STATES, wavenumber
from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.hydrodynamics.raos import DOFS, database_path, read_responses
from marine_mj.reproduce.sections.base import Job, Outcome, compare, panels
from marine_mj.simulation import run_batch

Phasors = NDArray[np.complex128]
#: Label, frequencies (n,) rad/s, RAOs (n,) by degree of freedom, style of the line.
Curve = tuple[str, Array, dict[str, Phasors], str]
#: Degrees of freedom in head waves.
DRAWN = ("Surge", "Heave", "Pitch")

#: Largest pitch in regular waves of the sea states 1 to 12, deg (table 5.3).
_PITCH = (4.7, 5.3, 5.3, 6.1, 7.4, 9.0, 9.4, 9.0, 9.2, 9.6, 10.0, 10.8)
#: The vehicle waits deep under the USV: only the USV is looked at.
_ASIDE = {"vehicles.auv.position_ned": [0.0, 0.0, 40.0], "log_period": 0.02, "duration": 12.0}
#: Box of the study and what the panels of its mesh measure here, m.
_LENGTH, _BEAM, _DRAUGHT = 5.0, 1.5, 0.3
_MESHES = (0.5, 0.3, 0.2)
_MASS, _PITCH_INERTIA = 2306.0, 5412.0
_RHO, _G = 1025.0, 9.81
_PERIODS = (1.4, 1.6, 1.8, 2.0, 2.2, 2.5, 2.8, 3.2, 3.8, 4.6, 5.7, 7.9, 12.0, 20.0)


def largest_pitch(job: Job) -> Outcome:
    """Largest pitch of the USV in the regular wave of each sea state."""
    changes = [{**_ASIDE, "sea.sea_state": state.ss_bft} for state in SEA_STATES[1:]]
    signals = run_batch("docking_tuning", changes, record=("eta_ned",)).signals
    assert signals is not None
    ours = np.degrees(np.abs(signals["eta_ned"].values[:, :, 0, 4]).max(axis=1))
    slope = [0.5 * s.H_s * float(wavenumber(2 * np.pi / s.mean_period)) for s in SEA_STATES[1:]]
    findings = [
        compare(f"sea state {state.ss_bft}", published, value, "deg", 0.04 * published,
                "within 4 %: the study's BEM file is not published")
        for state, published, value in zip(SEA_STATES[1:], _PITCH, ours, strict=True)
    ]  # fmt: skip
    figure, axes = panels(1, 1, (7, 4.2))
    ax, states = axes[0, 0], np.arange(1, 13)
    ax.bar(states - 0.2, _PITCH, 0.38, color="0.7", label="published (table 5.3)")
    ax.bar(states + 0.2, ours, 0.38, color="C0", label="ours")
    ax.plot(states, np.degrees(slope), "k_", ms=14, label="wave slope k H / 2")
    ax.axhline(11.5, color="C3", ls="--", lw=1, label="small angles end (11.5 deg)")
    ax.set(xlabel="sea state", ylabel="largest pitch [deg]", xticks=states, ylim=(0, 16))
    ax.legend(fontsize="small", ncols=2)
    return Outcome(
        findings,
        [job.save(figure, "usv_pitch")],
        "RAO playback in regular waves of the sea state's height and mean period, 12 s.",
    )


def usv_motion(job: Job) -> Outcome:
    """USV at four places in the wave of the study's snapshot, and in sea state 4."""
    places = (0.0, 3.0, 6.0, 10.0)
    still = {**_ASIDE, "duration": 10.0}
    regular = {**still, "sea": {"spectrum": "regular", "height": 0.5, "period": 3.37}}
    irregular = {
        **still,
        "sea": {"spectrum": "docking_jonswap", "sea_state": 4, "components": 50,
                "frequency_sampling": "midpoint"},
    }  # fmt: skip
    figure, axes = panels(3, 2, (12, 8), sharex=True, sharey="row")
    for column, (sea, title) in enumerate(
        ((regular, "regular wave, T 3.37 s, amplitude 0.25 m"), (irregular, "sea state 4, seed 1"))
    ):
        changes = [{**sea, "vehicles.usv.position_ned": [x, 0.0, 0.0]} for x in places]
        signals = run_batch("docking_tuning", changes, record=("eta_ned",)).signals
        assert signals is not None
        eta, time = signals["eta_ned"].values[:, :, 0], signals["time"].values
        for i, x in enumerate(places):
            values = (eta[i, :, 0] - x, -eta[i, :, 2], np.degrees(eta[i, :, 4]))
            for ax, value in zip(axes[:, column], values, strict=True):
                ax.plot(time, value, lw=1.3, label=f"x = {x:g} m")
        axes[0, column].set_title(title)
        axes[-1, column].set_xlabel("time [s]")
    for ax, name in zip(
        axes[:, 0], ("surge [m]", "heave, up [m]", "pitch, bow up [deg]"), strict=True
    ):
        ax.set_ylabel(name)
    axes[0, 0].legend(fontsize="small", ncols=2)
    text = "The USV at the four places of the study: the same motion, later where x is larger."
    return Outcome([], [job.save(figure, "usv_motion")], text)


def usv_raos(job: Job) -> Outcome:
    """Gain and phase of surge, heave and pitch in head waves for several meshes."""
    from marine_mj.hydrodynamics.bem.rao import rao

    omega = read_responses(database_path("dus_v5750_box.nc"), "motion")[0]
    stored = {dof: rao("dus_v5750_box.nc", omega, 0.0, dof) for dof in DRAWN}
    curves: list[Curve] = [("panels of 0.1 m (stored)", omega, stored, "k-")]
    text = "Wave database of the package (panels of 0.1 m, the study's mesh size)"
    try:
        for i, size in enumerate(_MESHES):
            w, found = _box_raos(size)
            curves.append((f"panels of {size:g} m", w, found, f"C{i}o--"))
        text += f", and Capytaine on {', '.join(f'{s:g}' for s in _MESHES)} m here."
    except ModelError as error:
        text += f". Coarser meshes are missing: {error}"
    fine = {dof: abs(complex(rao("dus_v5750_box.nc", 2 * np.pi / 12, 0.0, dof))) for dof in DRAWN}
    fine["Pitch"] /= float(wavenumber(2 * np.pi / 12))
    findings = [
        compare(f"gain of {dof.lower()} in long waves, T 12 s", 1.0, fine[dof], "1", 0.01,
                "the study gives the curves only as a figure; 1 is their limit")
        for dof in DRAWN
    ]  # fmt: skip
    return Outcome(findings, [job.save(draw_raos(curves), "usv_raos")], text)


def draw_raos(curves: Sequence[Curve], highest: float = 1.15) -> Figure:
    """Gains over lags of surge, heave and pitch over the wave period; gains up to `highest`."""
    figure, axes = panels(2, 3, (13, 6.5), sharex=True)
    for (top, bottom), dof in zip(axes.T, DRAWN, strict=True):
        for label, w, found, style in curves:
            value = found[dof] / (wavenumber(w) if dof == "Pitch" else 1.0)
            seen = np.abs(value) > 0.02
            angle = np.where(seen, np.degrees(np.angle(value)), np.nan)
            # A line over the jump from 180 to -180 would only confuse.
            angle[1:][np.abs(np.diff(angle)) > 180] = np.nan
            for ax, y in ((top, np.abs(value)), (bottom, angle)):
                ax.plot(2 * np.pi / w, y, style, ms=3, lw=1.2, label=label)
        unit = "rad per wave slope" if dof == "Pitch" else "m/m"
        top.set(ylabel=f"{dof.lower()}, gain [{unit}]", xscale="log", ylim=(0, highest))
        bottom.set(xlabel="wave period [s]", ylabel="lag [deg]", ylim=(-190, 190))
        bottom.set_yticks([-180, -90, 0, 90, 180])
        bottom.set_xticks([1, 2, 3, 5, 10, 20, 30], ["1", "2", "3", "5", "10", "20", "30"])
        bottom.set_xticks([], minor=True)
    axes[0, 0].legend(fontsize="small")
    return figure


def _box_raos(panel: float) -> tuple[Array, dict[str, Phasors]]:
    """Frequencies (n,) and motion RAOs (n,) in head waves of the box with panels of a size [m]."""
    from marine_mj.hydrodynamics.bem import motion_raos, solve
    from marine_mj.hydrodynamics.bem.panels import lid, rectangle
    from marine_mj.hydrodynamics.hydrostatics import hydrostatics

    x, y, z = 0.5 * _LENGTH, 0.5 * _BEAM, _DRAUGHT
    n_x, n_y, n_z = (max(int(np.ceil(side / panel - 1e-9)), 1) for side in (x, y, z))
    hull = (
        rectangle((0, 0, -z), (0, y, 0), (x, 0, 0), n_y, n_x)
        + rectangle((0, y, -z), (0, 0, z), (x, 0, 0), n_z, n_x)
        + rectangle((x, 0, -z), (0, y, 0), (0, 0, z), n_y, n_z)
    ).mirrored(1, 0)
    omega = np.sort(2 * np.pi / np.array(_PERIODS))
    found = solve(
        hull, lid(hull, panel), omega=omega, directions=np.zeros(1), density=_RHO, gravity=_G
    )
    still = hydrostatics(*hull.triangles())
    displaced = _RHO * still.volume
    stiffness = still.stiffness(_RHO, _G, displaced, np.zeros(3), np.zeros(3))
    # Only surge, heave and pitch are looked at; roll and yaw inertias do not couple into them.
    rigid = np.diag([_MASS, _MASS, _MASS, 1040.0, _PITCH_INERTIA, 5237.0])
    force = found.froude_krylov + found.diffraction
    raos = motion_raos(omega, rigid + found.added_mass, found.damping, stiffness, force)
    return omega, {dof: raos[:, 0, DOFS.index(dof)] for dof in ("Surge", "Heave", "Pitch")}
