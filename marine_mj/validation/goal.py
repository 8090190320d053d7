"""Motion of the docking goal under the prescribed USV, and the published numbers of operability."""

from collections.abc import Iterator

import mujoco
import numpy as np
from scipy.special import ndtr

from marine_mj.analysis import docking
from marine_mj.controllers import RigidState, acceleration_at
from marine_mj.controllers.kinematics import world_velocity
from marine_mj.environment import SEA_STATES, Environment, WaveField, irregular_sea, regular_wave
from marine_mj.frames import Array, eta_ned, flip
from marine_mj.hydrodynamics.loader import load
from marine_mj.scenario import Scenario
from marine_mj.scene import compile_scene
from marine_mj.tasks.docking_geometry import DockingGeometry
from marine_mj.tasks.reader import BodyReader
from marine_mj.validation.rows import Row, row
from marine_mj.weather import environment_of

DIGEST = "docking study"
#: Surge, heave and pitch in NED vectors of six.
PLANE = [0, 2, 4]


def _carrier(sea: WaveField, seconds: float, step: float = 0.01) -> RigidState:
    """States (time,) of the USV that plays back its motion RAOs at the world's origin."""
    model = load("dus_v5750", Environment(waves=sea), {"hull": {"motion": "rao"}}, timestep=step)
    data = mujoco.MjData(model)
    reader = BodyReader.of(model, model.body("hull").id)
    qpos, qvel = [], []
    for _ in range(round(seconds / step)):
        mujoco.mj_step(model, data)
        qpos.append(data.qpos.copy())
        qvel.append(data.qvel.copy())
    # the first steps come before the motion is prescribed
    return reader.state(np.array(qpos[10:]), np.array(qvel[10:]))


def _goal(carrier: RigidState) -> RigidState:
    """States of the aperture frame of the study's scenario."""
    scenario = Scenario.load("docking_thesis")
    model = compile_scene(scenario, environment_of(scenario), visual=False).model
    return DockingGeometry.of(model).frames.states(carrier)[0]


def _plane(motion: Array) -> Array:
    """Surge, heave, pitch (..., 3) NED of world vectors (..., 6) NWU."""
    return flip(motion)[..., PLANE]


def _rate(values: Array, step: float = 0.01) -> Array:
    """Central difference (n - 2, ...) along the first axis."""
    return (values[2:] - values[:-2]) / (2 * step)


def goal_kinematics() -> Iterator[Row]:
    """Goal velocity and acceleration beside differences of its pose (V22)."""
    state, step = SEA_STATES[6], 0.001
    sea = irregular_sea(state.H_s, state.T_p, components=50, seed=2)
    carrier = _carrier(sea, 30, step)
    goal = _goal(carrier)
    # the velocity after a step is the one that led there: no central difference
    speed = np.diff(goal.position, axis=0) / step
    inner = RigidState(*(v[1:-1] for v in (carrier.position, carrier.quaternion, carrier.velocity)))
    rate = _rate(world_velocity(carrier), step)
    truth = _rate(world_velocity(goal), step)
    for name, ours, difference in (
        ("velocity", goal.linear_velocity[1:], speed),
        ("acceleration", acceleration_at(inner, rate, goal.position[1:-1]), truth),
    ):
        gap = np.abs(ours - difference).max() / np.abs(difference).max()
        title = f"V22 goal, largest gap of the {name} over its largest value"
        yield row(title, gap, 0, "1", "differences of the pose", within=1e-4)


def goal_in_regular_waves() -> Iterator[Row]:
    """Amplitudes of the goal's motion in regular waves (digest 9, last tables)."""
    names = ("x", "z", "theta", "acceleration x", "acceleration z")
    units = ("m", "m", "deg", "m/s2", "m/s2")
    for number, expected in (
        (1, (0.287, 0.229, 4.58, 0.93, 0.74)),
        (4, (0.614, 0.534, 5.95, 1.15, 1.00)),
        (6, (1.357, 1.234, 8.86, 1.65, 1.50)),
        (8, (2.544, 2.417, 8.97, 1.61, 1.53)),
    ):
        state = SEA_STATES[number]
        sea = regular_wave(state.H_s, state.mean_period)
        goal = _goal(_carrier(sea, 2.2 * state.mean_period))
        place = eta_ned(goal.position, goal.quaternion)[:, PLANE]
        rates = _plane(_rate(world_velocity(goal)))[:, :2]
        half = [np.ptp(v, axis=0) / 2 for v in (place, rates)]
        measured = np.concatenate([half[0][:2], np.degrees(half[0][2:]), half[1]])
        for name, unit, ours, value in zip(names, units, measured, expected, strict=True):
            title = f"goal, sea state {number} regular, amplitude of {name}"
            yield row(title, ours, value, unit, DIGEST, percent=2)


def goal_in_irregular_waves() -> Iterator[Row]:
    """Standard deviations of the goal's motion in irregular seas (digest 9, last lines)."""
    names = ("x", "z", "theta", "u", "w", "q", "u'", "w'", "q'")
    units = ("m", "m", "rad", "m/s", "m/s", "rad/s", "m/s2", "m/s2", "rad/s2")
    for number, expected in (
        (4, (0.302, 0.263, 0.063, 0.42, 0.347, 0.131, 0.709, 0.527, 0.331)),
        (6, (0.67, 0.609, 0.103, 0.774, 0.667, 0.201, 1.148, 0.888, 0.498)),
        (8, (1.273, 1.206, 0.118, 1.079, 0.979, 0.211, 1.296, 1.045, 0.509)),
    ):
        state = SEA_STATES[number]
        sea = irregular_sea(
            state.H_s, state.T_p, seed=3,
            spectrum="docking_jonswap", components=50, sampling="midpoint",
        )  # fmt: skip
        # one repetition of the grid: the deviation does not depend on the phases
        goal = _goal(_carrier(sea, 51.73))
        motion = world_velocity(goal)
        place = eta_ned(goal.position, goal.quaternion)[:, PLANE]
        parts = (place, _plane(motion), _plane(_rate(motion)))
        measured = np.concatenate([part.std(axis=0) for part in parts])
        for name, unit, ours, value in zip(names, units, measured, expected, strict=True):
            title = f"goal, sea state {number} irregular, deviation of {name}"
            yield row(title, ours, value, unit, DIGEST, percent=3)


def operability() -> Iterator[Row]:
    """Success, economy and uptime of the study (V26, V29, V30)."""
    share = docking.COVERAGE**3
    yield row("V26 all three criteria hold", share, 0.991, "1", DIGEST, within=5e-4)
    for state, percent in ((1, 7.9), (2, 14.8), (3, 22.7), (4, 36.7), (5, 59.4), (6, 82.7)):
        yield row(
            f"V29 uptime, sea state {state}", 100 * docking.uptime(state), percent, "%", DIGEST,
            within=1e-6,
        )  # fmt: skip
    heights = np.array([s.H_s for s in SEA_STATES[1:9]])
    lognormal = ndtr((np.log(heights) - 0.306) / 0.679)
    gap = 100 * np.abs(docking.uptime_of_height(heights) - lognormal).max()
    source = "lognormal, mu 0.306, sigma 0.679"
    yield row("V30 uptime, largest gap to the lognormal", gap, 1.9, "pp", source, within=0.05)


CASES = (goal_kinematics, goal_in_regular_waves, goal_in_irregular_waves, operability)
