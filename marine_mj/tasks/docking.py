"""Docking: a vehicle enters a dock under a moving carrier and is latched there."""

from typing import Any, Literal

import mujoco
import numpy as np
from dm_control.rl import control
from dm_control.utils import containers, rewards

from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.scenario import Scenario
from marine_mj.scene import Scene, compile_scene
from marine_mj.tasks.base import MarineTask, symmetric_spec
from marine_mj.tasks.docking_mission import DockingMission
from marine_mj.tasks.docking_physics import DockingPhysics
from marine_mj.tasks.docking_settings import DockingSettings

SUITE = containers.TaggedTasks()

#: Gain set and actuation (None: the scenario's) of each controller in the suite. The published
#: gains of the pose PID are for an ideal wrench.
CONTROLLERS: dict[str, tuple[str, str | None]] = {
    "pose_pid": ("brute_force", "wrench"),
    "cpv": ("extended", None),
    "cpva": ("extended", None),
    "lqr": ("extended", None),
    "sliding": ("extended", None),
    "mpc": ("extended", None),
}
#: Sea states of the enumerated tasks.
SUITE_SEA_STATES = tuple(range(9))

#: Reward falls to 10 % this far outside: distance m, angle rad, speed m/s.
_MARGINS = (3.0, 0.5, 1.0)


class Docking(MarineTask):
    """Latch a vehicle into the dock of a carrier.

    Args:
        scene: the compiled scene.
        settings: settings of the task.
        closed_loop: attach guidance and controller; the action shifts the goal. Otherwise the
            action is the raw command of the vehicle's actuators, scaled to [-1, 1].
        random: seed or RandomState of the episodes' random starts.
    """

    signal_specs = DockingMission.signal_specs

    def __init__(
        self,
        scene: Scene,
        settings: DockingSettings,
        closed_loop: bool,
        random: np.random.RandomState | int | None = None,
    ) -> None:
        super().__init__(random=random)
        self.scenario, self.settings, self.closed_loop = scene.scenario, settings, closed_loop
        self._mission: DockingMission | None = None

    @property
    def control_period(self) -> float:
        """Time between two actions, s."""
        return self.scenario.control_period

    @property
    def mission(self) -> DockingMission:
        """What steers and judges the episode; there is none before the first reset."""
        assert self._mission is not None
        return self._mission

    def initialize_episode(self, physics: DockingPhysics) -> None:
        """Place the vehicles, the latch open or closed, and forget the last episode."""
        if self._mission is None:
            self._mission = _mission(self.scenario, self.settings, physics)
        self.mission.place(self.scenario, physics.model.ptr, physics.data.ptr, self.random)
        seed = self.mission.noise_seed(self.random)
        self._state = self.mission.initial(physics.data.time, (), seed)

    def action_spec(self, physics: DockingPhysics) -> Any:
        """Goal shift (3,), nothing (0,), or one command per actuator, all in [-1, 1]."""
        if self.closed_loop:
            return symmetric_spec(3 if self.settings.goal_offset > 0 else 0, "goal_offset")
        return symmetric_spec(len(physics.actuators(physics.vehicle)), "thrusters")

    def before_step(self, action: Array, physics: DockingPhysics) -> None:
        """Command the actuators."""
        command, self._state = self.mission.command(
            self._state, physics.view, np.asarray(physics.latched()), np.asarray(action)
        )
        physics.set_control(command)

    def after_step(self, physics: DockingPhysics) -> None:
        """Watch contact, capture and latch, which closes and opens here."""
        latched = physics.latched()
        self._state, closed = self.mission.observe(
            self._state, physics.view, physics.data.time, np.asarray(latched), physics.contacts()
        )
        if closed and not latched:
            physics.close_latch()
        elif latched and not closed:
            physics.open_latch()

    def undock(self, physics: DockingPhysics) -> None:
        """Ask for the latch to open at the end of the next step; the pilot then leaves the dock.

        Without effect on a vehicle that is not latched.
        """
        self._state = self.mission.undock(self._state, physics.data.time)

    def get_observation(self, physics: DockingPhysics) -> dict[str, Array]:
        """Pose and velocity relative to the seat, own motion, motion of the carrier."""
        vehicle = physics.vehicle_state(physics.vehicle)
        carrier = physics.vehicle_state(physics.carrier)
        observation = {
            "dock_error": physics.dock_error(),
            "relative_velocity": physics.relative_velocity(),
            "velocity": vehicle.velocity.copy(),
            "up": vehicle.rotation[2].copy(),
            "depth": -vehicle.position[2:].copy(),
            "carrier_velocity": carrier.velocity.copy(),
        }
        if states := physics.observed_states:
            observation["thrusters"] = physics.data.act[:states].copy()
        return observation

    def get_reward(self, physics: DockingPhysics) -> float:
        """1 when latched, else the product of closeness in position, attitude and speed."""
        if physics.latched():
            return 1.0
        error, velocity = physics.dock_error(), physics.relative_velocity()
        limits = self.settings.latch
        values = (
            (np.linalg.norm(error[:3]), limits.position, _MARGINS[0]),
            (np.linalg.norm(error[3:]), np.deg2rad(limits.attitude_deg), _MARGINS[1]),
            (np.linalg.norm(velocity[:3]), limits.speed, _MARGINS[2]),
        )
        near, level, slow = (
            rewards.tolerance(v, bounds=(0.0, bound), margin=margin) for v, bound, margin in values
        )
        return float(near * (1.0 + level + slow) / 3.0)

    def get_termination(self, physics: DockingPhysics) -> float | None:
        """0 when the mission is over; see `DockingMission.finished`."""
        latched = np.asarray(physics.latched())
        return 0.0 if self.mission.finished(self._state, physics.data.time, latched) else None

    def signals(self, physics: DockingPhysics) -> dict[str, Array | float]:
        """Signals for the log."""
        return dict(self.mission.signals(self._state, physics.view, np.asarray(physics.latched())))

    def summary(self, physics: DockingPhysics) -> dict[str, Any]:
        """Whether and how the vehicle docked."""
        return self.mission.summary(self.scenario, self._state, physics.latched())


def _settings(scenario: Scenario) -> DockingSettings:
    """Settings of the task of a scenario, its roles checked.

    Raises:
        ScenarioError: a setting of the task is unknown or not allowed.
        ModelError: the scenario lacks a vehicle that the task needs.
    """
    settings = DockingSettings.parse(scenario.task.settings, "task.settings")
    for role in (settings.vehicle, settings.carrier):
        if role not in scenario.vehicles:
            raise ModelError(
                f"the docking task needs vehicle {role!r}; the scenario has: "
                f"{', '.join(scenario.vehicles)}"
            )
    return settings


def mission(scenario: Scenario, model: mujoco.MjModel) -> DockingMission:
    """Mission of a docking scenario in its compiled scene, for the batch runner.

    Raises:
        ScenarioError: a setting of the task is unknown or not allowed.
    """
    return _mission(scenario, _settings(scenario), DockingPhysics.from_mjmodel(model))


def _mission(
    scenario: Scenario, settings: DockingSettings, physics: DockingPhysics
) -> DockingMission:
    """Mission whose controller knows the vehicle without the factors of the scenario's scales."""
    nominal = scenario.nominal
    if nominal is not scenario:
        physics = DockingPhysics.from_mjmodel(compile_scene(nominal, visual=False).model)
    return DockingMission.of(scenario, settings, physics, _closed_loop(scenario))


def _closed_loop(scenario: Scenario) -> bool:
    """Whether guidance and controller are attached."""
    return scenario.task.name != "dock_open"


def build(
    scenario: Scenario,
    random: np.random.RandomState | int | None = None,
    environment_kwargs: dict[str, Any] | None = None,
) -> control.Environment:
    """dm_control environment of a docking scenario.

    Raises:
        ScenarioError: a setting of the task is unknown or not allowed.
    """
    settings = _settings(scenario)
    scene = compile_scene(scenario)
    physics = DockingPhysics.from_mjmodel(scene.model)
    task = Docking(scene, settings, _closed_loop(scenario), random)
    options = {"time_limit": scenario.duration, **(environment_kwargs or {})}
    return control.Environment(
        physics,
        task,
        control_timestep=scenario.control_period,
        legacy_step=False,
        **options,
    )


def _suite_scenario(name: str, scenario: str, sea_state: int, changes: dict[str, Any]) -> Scenario:
    """A packaged scenario with random starts, for learning and testing; changes by dotted key."""
    base = Scenario.load(scenario)
    spread = {"start_spread": 0.5, "start_heading_spread_deg": 10.0, "random_start_time": True}
    return base.with_values(
        {
            "sea.sea_state": sea_state,
            "task.name": name,
            "task.settings": base.task.settings | spread | changes,
        }
    )


@SUITE.add("benchmarking", "closed_loop")
def dock(
    sea_state: int = 4,
    controller: str | None = None,
    scenario: str = "docking_demo",
    actuation: Literal["thrusters", "wrench"] | None = None,
    random: np.random.RandomState | int | None = None,
    environment_kwargs: dict[str, Any] | None = None,
    **settings: Any,
) -> control.Environment:
    """Closed-loop docking: guidance and controller attached, the action shifts the goal.

    Args:
        sea_state: number of the sea state, 0 to 12.
        controller: what flies, a key of `CONTROLLERS`, whose preset gives gains and actuation;
            default: what the scenario says.
        scenario: packaged scenario to change.
        actuation: of the vehicle: "thrusters", or "wrench" for ideal forces at the CG.
        random: seed or RandomState of the random starts.
        environment_kwargs: of `dm_control.rl.control.Environment`.
        settings: other settings of the task (`DockingSettings`).
    """  # fmt: skip
    preset: dict[str, Any] = {"goal_offset": 0.2}
    usual = None
    if controller is not None:
        gains, usual = CONTROLLERS.get(controller, (None, None))
        preset |= {"controller": controller, "gains": gains}
    settings = preset | settings
    changed = _suite_scenario("dock", scenario, sea_state, settings)
    vehicle = DockingSettings.parse(changed.task.settings, "task.settings").vehicle
    if actuation or usual:
        changed = changed.with_values({f"vehicles.{vehicle}.actuation": actuation or usual})
    return build(changed, random, environment_kwargs)


@SUITE.add("benchmarking", "closed_loop")
def dock_pose_pid(**kwargs: Any) -> control.Environment:
    """Closed-loop docking with the reference's pose PID, on its ideal wrench at the CG."""
    return dock(**{"controller": "pose_pid"} | kwargs)


@SUITE.add("benchmarking", "open_loop")
def dock_open(
    sea_state: int = 4,
    scenario: str = "docking_demo",
    random: np.random.RandomState | int | None = None,
    environment_kwargs: dict[str, Any] | None = None,
    **settings: Any,
) -> control.Environment:
    """Open docking: the action is the raw thruster command."""
    return build(
        _suite_scenario("dock_open", scenario, sea_state, settings), random, environment_kwargs
    )


def _variants() -> dict[str, tuple[str, dict[str, Any]]]:
    """Tasks by controller and sea state: name, and the task and keywords that it stands for."""
    found: dict[str, tuple[str, dict[str, Any]]] = {}
    for state in SUITE_SEA_STATES:
        for name in CONTROLLERS:
            keywords = {"controller": name, "sea_state": state}
            found[f"dock_{name}_ss{state}"] = ("dock", keywords)
        found[f"dock_open_ss{state}"] = ("dock_open", {"sea_state": state})
    return found


#: Names for keywords of tasks: `dock_cpva_ss4` is `dock` with controller "cpva" at sea state 4.
VARIANTS = _variants()
