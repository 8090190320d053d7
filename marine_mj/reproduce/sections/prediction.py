"""Figures 7.12 and 7.14: predicted beside true states in irregular waves."""

import numpy as np

from marine_mj import frames
from marine_mj.controllers import KinematicPredictor, PolynomialPredictor, Predictor, RigidState
from marine_mj.frames import Array
from marine_mj.reproduce.sections.base import Job, Outcome, panels
from marine_mj.simulation import run_batch

_PERIOD = 0.01
_NAMES = ("x [m]", "z [m]", "θ [rad]", "u [m/s]", "w [m/s]", "q [rad/s]")
_PLANE = [0, 2, 4]
#: What is shown, s. The run begins at 0.
_SHOWN = (6.0, 12.0)
_METHODS = {
    "kinematic, 0.5 s": {"kind": "kinematic", "of": "both", "t_pred": 0.5},
    "kinematic, 1.0 s": {"kind": "kinematic", "of": "both", "t_pred": 1.0},
    "first order, 0.9 s": {
        "kind": "polynomial", "of": "both", "order": 1, "t_past": 0.03, "t_pred": 0.9,
    },
}  # fmt: skip


def bodies(eta_ned: Array, nu_frd: Array) -> RigidState:
    """States of a vehicle from its logged poses and velocities (..., 6)."""
    position, quaternion = frames.pose_from_eta(eta_ned)
    return RigidState(position, quaternion, frames.flip(nu_frd))


def predicted_states(job: Job) -> Outcome:
    """Vehicle and carrier as three predictors saw them coming."""
    changes = [
        {"task.settings.prediction": p, "task.settings.end_at_capture": False,
         "task.settings.station": 1.0, "vehicles.auv.position_ned": [10.0, 0.0, 3.0],
         "duration": _SHOWN[1] + 1.0, "log_period": _PERIOD}
        for p in _METHODS.values()
    ]  # fmt: skip
    signals = run_batch("docking_thesis", changes, record=("eta_ned", "nu_frd")).signals
    assert signals is not None
    time = signals["time"].values
    names = []
    text = []
    for vehicle, (index, turning) in {"AUV": (1, True), "USV": (0, False)}.items():
        figure, axes = panels(6, len(_METHODS), (14, 12), sharex=True, sharey="row")
        for column, (name, settings) in enumerate(_METHODS.items()):
            eta = signals["eta_ned"].values[column, :, index]
            nu = signals["nu_frd"].values[column, :, index]
            ahead = float(settings["t_pred"])  # type: ignore[arg-type]
            predictor: Predictor = (
                KinematicPredictor(_PERIOD, "zero", turning)
                if settings["kind"] == "kinematic"
                else PolynomialPredictor(_PERIOD, 1, 0.03)
            )
            true = _plane(eta, nu)
            seen = _predicted(predictor, bodies(eta, nu), ahead)
            shift = round(ahead / _PERIOD)
            inside = (time >= _SHOWN[0]) & (time <= _SHOWN[1])
            wrong = (seen[:-shift] - true[shift:])[inside[shift:]]
            rms = np.sqrt(np.mean(wrong**2, axis=0))
            for k, ax in enumerate(axes[:, column]):
                ax.plot(time, true[:, k], "k", lw=1.4, label="true")
                ax.plot(time + ahead, seen[:, k], "C3", lw=0.9, label="predicted for then")
                ax.text(0.02, 0.05, f"rms {rms[k]:.2g}", transform=ax.transAxes, fontsize="small")
                middle, half = np.median(true[inside, k]), np.ptp(true[inside, k])
                ax.set_ylim(middle - 1.1 * half - 1e-3, middle + 1.1 * half + 1e-3)
            axes[0, column].set(title=f"{vehicle}: {name}", xlim=_SHOWN)
            axes[-1, column].set_xlabel("time [s]")
            if vehicle == "USV":
                text.append(f"{name}: rms of surge {rms[0]:.2f} m, of heave {rms[1]:.2f} m")
        for ax, label in zip(axes[:, 0], _NAMES, strict=True):
            ax.set_ylabel(label)
        axes[0, 0].legend(fontsize="small", loc="upper right")
        names.append(job.save(figure, f"predicted_{vehicle.lower()}"))
    about = (
        "Station below the goal in irregular waves, sea state 4, brute-force pose PID that acts on "
        "these predictions; each is drawn at the time it is for. Of the USV, "
    )
    return Outcome([], names, about + "; ".join(text) + ".")


def _plane(eta: Array, nu: Array) -> Array:
    """x, z, theta, u, w, q (n, 6) of poses and velocities, all in world axes NED."""
    _, quaternion = frames.pose_from_eta(eta)
    rotation = frames.rotation_from_quaternion(quaternion)
    linear = frames.flip(frames.apply(rotation, frames.flip(nu)[..., :3]))
    return np.concatenate([eta[:, _PLANE], linear[:, [0, 2]], nu[:, [4]]], axis=1)


def _predicted(predictor: Predictor, body: RigidState, ahead: float) -> Array:
    """x, z, theta, u, w, q (n, 6) that a predictor gives for `ahead` s later at every sample."""
    state = predictor.initial()
    found = []
    for i in range(len(body.position)):
        now = RigidState(body.position[i], body.quaternion[i], body.velocity[i])
        state = predictor.update(state, now)
        then = predictor.ahead(state, now, ahead)
        eta = frames.eta_ned(then.position, then.quaternion)
        found.append(np.concatenate([eta, frames.flip(then.velocity)]))
    values = np.array(found)
    return _plane(values[:, :6], values[:, 6:])
