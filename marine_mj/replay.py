"""States of a finished run, at the instants that pictures need them."""

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from marine_mj.errors import RenderError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class States:
    """What a picture needs of a run: MuJoCo's raw state at n instants.

    Attributes:
        time: (n,) s, ascending.
        qpos: (n, nq).
        act: (n, na); may be empty.
        eq_active: (n, neq); may be empty.
    """

    time: Array
    qpos: Array
    act: Array
    eq_active: Array

    def __len__(self) -> int:
        return len(self.time)


def states_from_log(data: Any) -> States:
    """States of a log dataset (docs/architecture.md, section Log).

    Raises:
        RenderError: the dataset has no `qpos`.
    """
    if "qpos" not in data:
        raise RenderError(
            f"the log has no 'qpos', which pictures are made of; it has {', '.join(data)}"
        )
    time = np.asarray(data["time"], float)

    def values(name: str) -> Array:
        return np.asarray(data[name], float) if name in data else np.zeros((len(time), 0))

    return States(time, values("qpos"), values("act"), values("eq_active"))


def interpolate(model: mujoco.MjModel, states: States, times: ArrayLike) -> States:
    """States at `times` (m,): positions linear, quaternions along the great arc, switches held.

    Times outside the run give its first or last state.

    Raises:
        RenderError: the states are of another model.
    """
    if states.qpos.shape[1] != model.nq:
        raise RenderError(
            f"the log has {states.qpos.shape[1]} positions (qpos), the model {model.nq}: it was"
            " recorded with another scene"
        )
    wanted = np.clip(np.asarray(times, float), states.time[0], states.time[-1])
    before, after, share = bracket(states.time, wanted)
    weight = share[:, None]
    qpos = states.qpos[before] * (1 - weight) + states.qpos[after] * weight
    for joint in range(model.njnt):
        kind, start = model.jnt_type[joint], int(model.jnt_qposadr[joint])
        if kind == mujoco.mjtJoint.mjJNT_FREE:
            start += 3
        elif kind != mujoco.mjtJoint.mjJNT_BALL:
            continue
        part = slice(start, start + 4)
        qpos[:, part] = slerp(states.qpos[before, part], states.qpos[after, part], weight[:, 0])
    act = states.act[before] * (1 - weight) + states.act[after] * weight
    return States(wanted, qpos, act, states.eq_active[before])


def bracket(time: Array, wanted: ArrayLike) -> tuple[NDArray, NDArray, Array]:
    """Samples before and after the times `wanted` (m,), and the weight (m,) of those after.

    Times outside `time` (n,) give its first or last sample.
    """
    inside = np.clip(np.asarray(wanted, float), time[0], time[-1])
    before = np.clip(np.searchsorted(time, inside, side="right") - 1, 0, len(time) - 1)
    after = np.minimum(before + 1, len(time) - 1)
    span = np.where(after > before, time[after] - time[before], 1.0)
    return before, after, (inside - time[before]) / span


def slerp(a: ArrayLike, b: ArrayLike, weight: ArrayLike) -> Array:
    """Unit quaternions (n, 4) from `a` (weight 0) to `b` (weight 1), the shorter way."""
    a, b, weight = np.asarray(a, float), np.asarray(b, float), np.asarray(weight, float)
    cosine = np.sum(a * b, axis=-1)
    b = np.where(cosine[:, None] < 0, -b, b)
    angle = np.arccos(np.clip(np.abs(cosine), 0, 1))
    sine = np.sin(angle)
    near = sine < 1e-6
    safe = np.where(near, 1.0, sine)
    left = np.where(near, 1 - weight, np.sin((1 - weight) * angle) / safe)
    right = np.where(near, weight, np.sin(weight * angle) / safe)
    result = left[:, None] * a + right[:, None] * b
    return result / np.linalg.norm(result, axis=-1, keepdims=True)


def place(model: mujoco.MjModel, data: mujoco.MjData, states: States, i: int) -> None:
    """Put `data` into state `i`, as far as pictures go (no dynamics)."""
    data.time = states.time[i]
    data.qpos[:] = states.qpos[i]
    if states.act.shape[1] == model.na:
        data.act[:] = states.act[i]
    if states.eq_active.shape[1] == model.neq:
        data.eq_active[:] = states.eq_active[i] > 0.5
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_camlight(model, data)
    mujoco.mj_tendon(model, data)
