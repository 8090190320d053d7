"""The tuning scenario: tables 7.8 and 7.9, gains (7.10), prediction (7.11, 7.13), forces (7.15)."""

from typing import Any

import numpy as np

from marine_mj.frames import Array
from marine_mj.reproduce.sections.base import Finding, Job, Outcome, compare, panels
from marine_mj.simulation import run_batch
from marine_mj.tuning import (
    GRID_D,
    GRID_I,
    GRID_P,
    MISSES,
    rms_errors,
    station_errors,
    tune_docking,
)

_SCENARIO = "docking_tuning"
_COLUMNS = ("x", "z", "θ", "u", "w", "q")
#: Places of x, z, theta, u, w, q among pose and velocity errors (2, 6).
_PLANE = ((0, 0, 0, 1, 1, 1), (0, 2, 4, 0, 2, 4))
#: Table 7.9: settings and root mean square errors x, z, theta, u, w, q, sum.
_METHODS: dict[str, tuple[dict[str, Any], tuple[float, ...]]] = {
    "manual pose": ({"gains": "manual"}, (0.43, 0.45, 0.10, 0.50, 0.40, 0.17, 2.05)),
    "brute-force pose": ({"gains": "brute_force"}, (0.23, 0.40, 0.04, 0.26, 0.32, 0.06, 1.31)),
    "CPV": (
        {"controller": "cpv", "gains": "reference"},
        (0.29, 0.38, 0.06, 0.28, 0.28, 0.07, 1.37),
    ),
    "CPVA": (
        {"controller": "cpva", "gains": "reference"},
        (0.25, 0.36, 0.04, 0.21, 0.22, 0.04, 1.12),
    ),
    "kinematic prediction": (
        {"prediction": {"kind": "kinematic", "of": "both", "t_pred": 0.4}},
        (0.26, 0.35, 0.04, 0.19, 0.16, 0.05, 1.05),
    ),
    "polynomial prediction": (
        {"prediction": {"kind": "polynomial", "of": "both", "order": 1, "t_past": 0.03,
                        "t_pred": 0.9}},
        (0.27, 0.35, 0.04, 0.20, 0.17, 0.05, 1.07),
    ),
}  # fmt: skip
_OF = {"AUV": "vehicle", "USV": "carrier", "AUV and USV": "both"}
#: Table 7.8: best t_past and t_pred [s] and the sum they give, by vehicle and order.
_POLYNOMIAL = {
    ("AUV", 1): (0.04, 0.10, 1.17), ("AUV", 2): (0.04, 0.10, 1.18),
    ("USV", 1): (0.04, 0.10, 1.26), ("USV", 2): (0.03, 0.10, 1.26),
    ("AUV and USV", 1): (0.03, 0.90, 1.07), ("AUV and USV", 2): (0.04, 0.20, 1.18),
}  # fmt: skip
#: Table 7.5: P, I, D by axis (place among the six).
_GAINS = {"surge": (0, 2738.42, 0.0, 630.96), "heave": (2, 5011.87, 3.16, 0.0),
          "pitch": (4, 4097.32, 10.0, 1778.28)}  # fmt: skip
_START = "the study does not give the start"


def _changes(settings: dict[str, Any]) -> dict[str, Any]:
    """Dotted changes of the scenario."""
    return {f"task.settings.{key}": value for key, value in settings.items()}


def methods_table(job: Job) -> Outcome:
    """Errors and control forces of six methods."""
    changes = [_changes(settings) | {"log_period": 0.01} for settings, _ in _METHODS.values()]
    result = run_batch(_SCENARIO, changes, record=(*MISSES, "wrench_command"))
    assert result.signals is not None
    errors = rms_errors(result)[:, *_PLANE]
    findings = []
    for (name, (_, published)), found in zip(_METHODS.items(), errors, strict=True):
        for column, value, ours in zip(
            (*_COLUMNS, "sum"), published, (*found, found.sum()), strict=True
        ):
            unit = {"x": "m", "z": "m", "u": "m/s", "w": "m/s", "θ": "rad", "q": "rad/s"}
            findings.append(
                compare(f"{name}, {column}", value, ours, unit.get(column, "m, rad, m/s, rad/s"),
                        max(0.25 * value, 0.03), f"within a quarter or 0.03; {_START}")
            )  # fmt: skip
    figure, axes = panels(len(_METHODS), 3, (14, 12), sharex=True, sharey="col")
    time = result.signals["time"].values
    wrench = result.signals["wrench_command"].values[:, :, [0, 2, 4]] * [1, -1, -1]
    limits = ((-152, 192), (-68, 68), (-20, 20))
    for row, name, values in zip(axes, _METHODS, wrench, strict=True):
        for ax, value, (low, high) in zip(row, values.T, limits, strict=True):
            ax.plot(time[1:], value[1:], lw=0.6)
            for end in (low, high):
                ax.axhline(end, color="C3", ls="--", lw=1, label=None if end < 0 else "limits")
        row[0].set_ylabel(name)
    for ax, title in zip(axes[0], ("X [N]", "Z, down [N]", "M, bow up [N m]"), strict=True):
        ax.set_title(f"control wrench {title}")
    axes[0, 2].legend(fontsize="small", loc="upper right")
    for ax in axes[-1]:
        ax.set(xlabel="time [s]", xlim=(0, 15))
    text = (
        "Station 1 m below the goal in the regular wave of sea state 4, 30 s. The first 15 s of "
        "the control forces (figure 7.15): the stiff pose gains drive heave from limit to limit; "
        "with prediction they chatter in surge and pitch, as the study saw, too."
    )
    return Outcome(findings, [job.save(figure, "control_forces")], text)


def polynomial_table(job: Job) -> Outcome:
    """Sum of the errors over t_past and t_pred for vehicles and orders."""
    ahead = np.linspace(0.1, 1.0, 10)
    past = np.linspace(0.03, 0.12, 10) if job.full else np.array([0.03, 0.04, 0.08])
    sums = {}
    for key in _POLYNOMIAL:
        changes = [
            {"task.settings.prediction": {
                "kind": "polynomial", "of": _OF[key[0]], "order": key[1],
                "t_past": round(float(p), 2), "t_pred": round(float(t), 2)}}
            for p in past for t in ahead
        ]  # fmt: skip
        sums[key] = _sums(changes).reshape(len(past), len(ahead))
    none = float(_sums([{}])[0])
    figure, axes = panels(2, 3, (13, 7.5), sharex=True, sharey=True)
    findings = []
    for (vehicle, order), published in _POLYNOMIAL.items():
        ax = axes[order - 1, list(_OF).index(vehicle)]
        found = sums[vehicle, order]
        for i, p in enumerate(past):
            ax.plot(
                ahead, found[i], "o-", ms=3, lw=1.1, color=f"C{i}", label=f"$t_{{past}}$ {p:.2f} s"
            )
        ax.axhline(none, color="k", ls="--", lw=1, label="no prediction")
        ax.plot(published[1], published[2], "k*", ms=11, label="published best")
        ax.set_title(f"{vehicle}, order {order}")
        i, j = divmod(int(np.argmin(found)), len(ahead))
        best = f"ours is best at t_past {past[i]:.2f} s, t_pred {ahead[j]:.1f} s"
        note = f"within a quarter; {best}; {_START}"
        findings.append(
            compare(f"{vehicle}, order {order}, least sum", published[2], found[i, j], "1",
                    0.25 * published[2], note)
        )  # fmt: skip
        k, m = (
            int(np.argmin(np.abs(past - published[0]))),
            int(np.argmin(np.abs(ahead - published[1]))),
        )
        there = (
            f"t_past {published[0]:g} s, t_pred {published[1]:g} s; without prediction ours is "
            f"{none:.2f}"
        )
        findings.append(
            compare(f"{vehicle}, order {order}, sum at the study's optimum", published[2],
                    found[k, m], "1", 0.25 * published[2], there)
        )  # fmt: skip
    for ax in axes[1]:
        ax.set_xlabel("$t_{pred}$ [s]")
    for ax in axes[:, 0]:
        ax.set(ylabel="sum of the six rms errors", ylim=(0.8, 6), yscale="log")
        ax.set_yticks([1, 1.5, 2, 3, 5], ["1", "1.5", "2", "3", "5"])
        ax.set_yticks([], minor=True)
    axes[0, 0].legend(fontsize="small")
    grid = "the study's ten" if job.full else "three of the study's ten"
    text = (
        f"Polynomial prediction with the brute-force pose PID (figure 7.13), {grid} t_past. The "
        "second order goes wrong here where the vehicle is predicted from a few samples: the "
        "parabola holds the acceleration of the last commands, the gains answer it, and the loop "
        "chatters (docs/reproduce.md)."
    )
    return Outcome(findings, [job.save(figure, "polynomial_prediction")], text)


def kinematic_tuning(job: Job) -> Outcome:
    """Sum of the errors over the prediction time, at sea states 4 and 8."""
    times = np.linspace(0.0, 2.0, 40)
    figure, axes = panels(1, 2, (12, 4.6))
    best: dict[tuple[int, str], tuple[float, float]] = {}
    sums: dict[tuple[int, str], Array] = {}
    states = (4, 8)
    for vehicle, of in _OF.items():
        changes = [
            {"sea.sea_state": state,
             "task.settings.prediction": {"kind": "kinematic", "of": of, "t_pred": float(t)}}
            for state in states for t in times[1:]
        ]  # fmt: skip
        found = _sums(changes).reshape(len(states), -1)
        for state, row in zip(states, found, strict=True):
            sums[state, vehicle] = row
            best[state, vehicle] = float(times[1 + np.argmin(row)]), float(row.min())
    none = _sums([{"sea.sea_state": state} for state in states])
    for ax, state, start in zip(axes[0], states, none, strict=True):
        for i, vehicle in enumerate(_OF):
            t, value = best[state, vehicle]
            label = f"{vehicle}: least {value:.2f} at {t:.2f} s"
            ax.plot(times, [start, *sums[state, vehicle]], f"C{i}", lw=1.3, label=label)
            ax.plot(t, value, f"C{i}o", ms=5)
        ax.axhline(start, color="k", ls="--", lw=1, label=f"no prediction: {start:.2f}")
        ax.set(title=f"sea state {state}", xlabel="$t_{pred}$ [s]", xlim=(0, 2))
        ax.set_ylim(0.9 * min(b[1] for k, b in best.items() if k[0] == state), 3.2 * start)
        ax.legend(fontsize="small", loc="upper left")
    axes[0, 0].set_ylabel("sum of the six rms errors")
    winner = [min(_OF, key=lambda v, s=state: best[s, v][1]) for state in states]  # type: ignore[misc]
    shorter = best[8, "AUV and USV"][0] < best[4, "AUV and USV"][0]
    both = "AUV and USV"
    findings = [
        Finding("best vehicles to predict", both, " / ".join(winner), "1",
                "agrees" if set(winner) == {both} else "differs", "sea state 4 / 8"),
        Finding("best prediction time at sea state 8 against 4", "shorter",
                "shorter" if shorter else "not shorter", "1", "agrees" if shorter else "differs",
                f"{best[8, both][0]:.2f} s against {best[4, both][0]:.2f} s"),
    ]  # fmt: skip
    text = "Kinematic prediction with the brute-force pose PID, 40 prediction times (figure 7.11)."
    return Outcome(findings, [job.save(figure, "kinematic_prediction")], text)


def pid_grid(job: Job) -> Outcome:
    """Scores of gain triples by axis, as a cloud of points."""
    if job.full:
        grids = (GRID_P, GRID_I, GRID_D)
    else:
        grids = (
            np.logspace(1.5, 4, 6),
            np.array([0.0, 3.16, 31.6]),
            np.r_[0, np.logspace(1, 3.5, 6)],
        )
    tuning = tune_docking(_SCENARIO, *grids)
    known = station_errors(_SCENARIO, [{"task.settings.gains": "brute_force"}]).sum(axis=1)[0]
    figure, _ = panels(1, 1, (15, 5.4))
    figure.clear()
    findings = []
    # Zero has no place on a logarithmic axis: it stands one step below the least.
    logs = [np.log10(np.where(v > 0, v, 10**0.5)) for v in tuning.triples.T]
    for k, (name, (axis, *published)) in enumerate(_GAINS.items()):
        scores = tuning.scores[:, axis]
        order = np.argsort(scores)
        ax: Any = figure.add_subplot(1, 3, k + 1, projection="3d")
        shown = np.clip(scores, None, np.quantile(scores[np.isfinite(scores)], 0.8))
        points = ax.scatter(*logs, c=shown, cmap="viridis_r", s=14)
        ax.scatter(*(x[order[:5]] for x in logs), s=70, facecolors="none", edgecolors="C3",
                   label="five best")  # fmt: skip
        mark = [np.log10(v) if v > 0 else 0.5 for v in published]
        ax.scatter(*mark, color="k", marker="*", s=90, label="published")
        ax.set(xlabel="log P", ylabel="log I", zlabel="log D", title=name)
        figure.colorbar(points, ax=ax, shrink=0.6, pad=0.14, label="rms pose + velocity (clipped)")
        ax.legend(fontsize="small", loc="upper left")
        best = tuning.triples[order[0]]
        good = scores[order[0]] <= known[axis]
        note = (
            f"best at P {best[0]:.0f}, I {best[1]:.3g}, D {best[2]:.0f}; the published gains have "
            f"{known[axis]:.3f} on our model; agrees when not worse"
        )
        findings.append(
            Finding(f"{name}: least rms of pose plus velocity", None, float(scores[order[0]]),
                    "m, m/s; rad, rad/s", "agrees" if good else "differs", note)
        )  # fmt: skip
    text = (
        f"{len(tuning.triples)} gain triples on all axes at once (figure 7.10"
        f"{'' if job.full else '; --full flies the 1000 of the study'}). log 0.5 stands for 0. "
        "The study's ranges are not published."
    )
    return Outcome(findings, [job.save(figure, "pid_grid")], text)


def _sums(changes: list[dict[str, Any]]) -> Array:
    """Sums (n,) of the six errors."""
    return station_errors(_SCENARIO, changes)[:, *_PLANE].sum(axis=1)
