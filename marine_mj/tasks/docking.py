"""Docking: a vehicle enters a dock under a moving carrier and is latched there."""

from dataclasses import replace
from typing import Any

import numpy as np
from dm_control.rl import control
from dm_control.utils import containers, rewards

from marine_mj import frames, hydrodynamics
from marine_mj.controllers import (
    Cpv,
    DockingGuidance,
    DockingPilot,
    DockingPlan,
    Limits,
    Phase,
    PosePid,
    RigidState,
    VehicleModel,
    cpv_gain_set,
)
from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.scenario import Scenario
from marine_mj.scene import Scene, compile_scene
from marine_mj.tasks.base import MarineTask, Signal, from_unit, symmetric_spec
from marine_mj.tasks.docking_physics import DockingPhysics
from marine_mj.tasks.docking_settings import DockingSettings
from marine_mj.weather import significant_height

SUITE = containers.TaggedTasks()

#: Reward falls to 10 % this far outside: distance m, angle rad, speed m/s.
_MARGINS = (3.0, 0.5, 1.0)
#: Pose errors at capture, in the aperture frame FRD, m and rad.
CAPTURE_ERRORS = tuple(
    f"{axis}_error" for axis in ("surge", "sway", "heave", "roll", "pitch", "yaw")
)
#: Importance of the axes when the thrusters cannot give all of them (`Allocator.axis_weight`):
#: heave first, of which a vehicle that is pushed into a dock has too little; the pads turn the push
#: into more pitch moment than the same thrusters would give directly.
_AXIS_WEIGHT = (1.0, 1.0, 3.0, 3.3, 3.3, 3.3)
#: Latest start on the wave record in episodes with a random start, s.
_LATEST_START = 600.0


class Docking(MarineTask):
    """Latch a vehicle into the dock of a carrier.

    Args:
        scene: the compiled scene.
        settings: settings of the task.
        closed_loop: attach guidance and controller; the action shifts the goal. Otherwise the
            action is the raw command of the vehicle's actuators, scaled to [-1, 1].
        random: seed or RandomState of the episodes' random starts.
    """

    signal_specs = {  # noqa: RUF012
        "dock_error": Signal(("dof",), "m, rad", "vehicle FLU", "seat pose minus vehicle pose"),
        "relative_velocity": Signal(
            ("dof",), "m/s, rad/s", "vehicle FLU", "vehicle velocity relative to the seat"
        ),
        "target_ned": Signal(("axis",), "m", "NED", "position the controller steers to"),
        "wrench_command": Signal(
            ("dof",), "N, N m", "vehicle FLU", "wrench the thrusters were asked for"
        ),
        "phase": Signal((), "1", "", "0 approach 1 under 2 wait 3 enter 4 contact 5 latched"),
        "latched": Signal((), "1", "", "1 when the latch is closed"),
        "contact_force": Signal((), "N", "", "largest sum of normal forces in the control period"),
    }

    def __init__(
        self,
        scene: Scene,
        settings: DockingSettings,
        closed_loop: bool,
        random: np.random.RandomState | int | None = None,
    ) -> None:
        super().__init__(random=random)
        self.scenario, self.settings, self.closed_loop = scene.scenario, settings, closed_loop
        self._pilot: DockingPilot | None = None

    @property
    def control_period(self) -> float:
        """Time between two actions, s."""
        return self.scenario.control_period

    def _prepare(self, physics: DockingPhysics) -> None:
        """Make controller, allocation and latch monitor for this model."""
        settings, vehicle = self.settings, self.scenario.vehicles[physics.vehicle]
        self._ids = physics.actuators(physics.vehicle)
        self._allocator = replace(
            physics.allocator(physics.vehicle), axis_weight=np.array(_AXIS_WEIGHT)
        )
        low, high = frames.flip(vehicle.wrench_low_frd), frames.flip(vehicle.wrench_high_frd)
        limits = Limits(np.minimum(low, high), np.maximum(low, high))
        guidance = DockingGuidance(settings.plan.plan())
        controller = self._controller(physics, limits)
        self._pilot = DockingPilot(controller, physics.dock_frames, self.control_period, guidance)
        self._latch = settings.latch.latch()

    def _controller(self, physics: DockingPhysics, limits: Limits) -> PosePid | Cpv:
        """The controller that the settings ask for."""
        settings, period = self.settings, self.control_period
        statics = physics.hydrostatics(physics.vehicle, self.scenario.water_density)
        if settings.controller == "cpv":
            model = None
            if settings.gain_set == "extended":
                lag = physics.thruster_lag(physics.vehicle)
                model = VehicleModel(physics.inertia(physics.vehicle), lag)
            return Cpv.from_gains(cpv_gain_set(settings.gain_set), limits, period, statics, model)
        error_limit = np.inf if settings.error_limit is None else settings.error_limit
        return PosePid.from_name(settings.gain_set, limits, period, statics, error_limit)

    def initialize_episode(self, physics: DockingPhysics) -> None:
        """Place the vehicles, open the latch and forget the last episode."""
        if self._pilot is None:
            self._prepare(physics)
        assert self._pilot is not None
        self._pilot_state = self._pilot.initial()
        self._latch_state = self._latch.initial()
        self._wrench, self._target = np.zeros(6), np.zeros(3)
        self._capture: dict[str, float] = {}
        self._peak, self._latch_time = 0.0, np.inf
        self._crashed, self._height, self._entries = False, -np.inf, 0
        self._start_time = 0.0
        if self.settings.random_start_time:
            self._start_time = self.random.uniform(0.0, _LATEST_START)
        physics.data.time = self._start_time
        for instance in physics.vehicles:
            self._place(physics, instance)
        hydrodynamics.start_in_waves(physics.model.ptr, physics.data.ptr)
        super().initialize_episode(physics)

    def _place(self, physics: DockingPhysics, instance: str) -> None:
        """Put a vehicle at its start, scattered if the settings ask for it."""
        start = physics.vehicle_state(instance)
        position, quaternion = start.position, start.quaternion
        if instance == physics.vehicle:
            scatter = self.settings.start_spread * self.random.normal(size=3)
            position = position + np.clip(scatter, -2.0, 2.0)
            turn = np.deg2rad(self.settings.start_heading_spread_deg) * self.random.normal()
            turned = frames.quaternion_from_euler([0.0, 0.0, turn])
            quaternion = frames.quaternion_multiply(turned, quaternion)
        velocity = frames.flip(self.scenario.vehicles[instance].velocity_frd)
        state = RigidState(position, quaternion, velocity)
        physics.reader(instance).write(physics.data.qpos, physics.data.qvel, state)

    def action_spec(self, physics: DockingPhysics) -> Any:
        """Goal shift (3,), nothing (0,), or one command per actuator, all in [-1, 1]."""
        if self.closed_loop:
            return symmetric_spec(3 if self.settings.goal_offset > 0 else 0, "goal_offset")
        return symmetric_spec(len(physics.actuators(physics.vehicle)), "thrusters")

    def before_step(self, action: Array, physics: DockingPhysics) -> None:
        """Command the actuators; the latch closes here when its limits were kept."""
        assert self._pilot is not None
        vehicle = physics.vehicle_state(physics.vehicle)
        carrier = physics.vehicle_state(physics.carrier)
        command = physics.data.ctrl.copy()
        if self.closed_loop:
            offset = np.zeros(3)
            if self.settings.goal_offset > 0:
                offset = self.settings.goal_offset * np.asarray(action, dtype=float)
            wrench, order, self._pilot_state = self._pilot.update(
                self._pilot_state, vehicle, carrier, np.asarray(physics.latched()), offset
            )
            command[self._ids], self._wrench = self._allocator.allocate(wrench)
            self._pilot_state = self._pilot.applied(self._pilot_state, self._wrench)
            self._target = order.target.position
        else:
            limits = self._allocator.limits
            command[self._ids] = from_unit(action, limits.low, limits.high)
            if physics.latched():
                command[self._ids] = 0.0
            self._wrench = self._allocator.effectiveness @ command[self._ids]
        physics.set_control(command)

    def after_step(self, physics: DockingPhysics) -> None:
        """Watch contact, capture and latch."""
        self._peak = max(self._peak, physics.peak_contact_force())
        self._crashed |= physics.forbidden_contact()
        self._watch_aperture(physics)
        self._latch_state = self._latch.update(
            self._latch_state,
            physics.dock_error(),
            physics.relative_velocity(),
            self.control_period,
        )
        if self._latch_state.closed and not physics.latched():
            physics.close_latch()
            self._latch_time = physics.data.time
        super().after_step(physics)

    def _watch_aperture(self, physics: DockingPhysics) -> None:
        """Record pose and energy when the aperture plane is crossed from below (digest 7.0)."""
        pose = physics.aperture_pose()
        plan = self._plan()
        height, self._height = self._height, pose[2]
        # The closed loop arms the crossing at waypoint 2; an open policy has no waypoints.
        armed = not self.closed_loop or self._pilot_state.guidance.phase >= Phase.WAIT
        within = bool(np.all(np.abs(pose[:2]) <= plan.aperture))
        if not armed or not within or not (height < 0 <= pose[2]):
            return
        self._entries += 1
        if self._capture:
            return
        error = dict(zip(CAPTURE_ERRORS, frames.flip(pose), strict=True))
        self._capture = {
            "time": physics.data.time - self._start_time,
            **error,
            "relative_speed": float(np.linalg.norm(physics.relative_velocity()[:3])),
            "relative_kinetic_energy": physics.relative_energy(),
        }

    def _plan(self) -> DockingPlan:
        assert self._pilot is not None
        return self._pilot.guidance.plan

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
        if physics.data.act.size:
            observation["thrusters"] = physics.data.act.copy()
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
        """0 when the vehicle has been latched for `hold` seconds (or has entered)."""
        if self.settings.end_at_capture and self._capture:
            return 0.0
        held = physics.data.time - self._latch_time
        return 0.0 if physics.latched() and held >= self.settings.hold - 1e-9 else None

    def signals(self, physics: DockingPhysics) -> dict[str, Array | float]:
        """Signals for the log."""
        return {
            "dock_error": physics.dock_error(),
            "relative_velocity": physics.relative_velocity(),
            "target_ned": frames.flip(self._target),
            "wrench_command": self._wrench,
            "phase": float(self._pilot_state.guidance.phase) if self.closed_loop else np.nan,
            "latched": float(physics.latched()),
            "contact_force": physics.peak_contact_force(),
        }

    def summary(self, physics: DockingPhysics) -> dict[str, Any]:
        """Whether and how the vehicle docked."""
        capture = self._capture or None
        latched = physics.latched()
        height, period = significant_height(self.scenario.sea)
        return {
            "docked": latched,
            "sea_state": {"H_s": height, "T_p": period, "number": self.scenario.sea.sea_state},
            "capture": capture,
            "capture_time": capture["time"] if capture else None,
            "latch_time": self._latch_time - self._start_time if latched else None,
            "peak_contact_force": self._peak,
            "forbidden_contact": self._crashed,
            "attempts": self._entries,
            "controller": self.settings.controller if self.closed_loop else None,
            "gains": self.settings.gain_set if self.closed_loop else None,
        }


def build(
    scenario: Scenario,
    random: np.random.RandomState | int | None = None,
    environment_kwargs: dict[str, Any] | None = None,
) -> control.Environment:
    """dm_control environment of a docking scenario.

    Raises:
        ScenarioError: a setting of the task is unknown or not allowed.
    """
    settings = DockingSettings.parse(scenario.task.settings, "task.settings")
    for role in (settings.vehicle, settings.carrier):
        if role not in scenario.vehicles:
            raise ModelError(
                f"the docking task needs vehicle {role!r}; the scenario has: "
                f"{', '.join(scenario.vehicles)}"
            )
    scene = compile_scene(scenario)
    physics = DockingPhysics.from_mjmodel(scene.model)
    task = Docking(scene, settings, scenario.task.name != "dock_open", random)
    options = {"time_limit": scenario.duration, **(environment_kwargs or {})}
    return control.Environment(
        physics,
        task,
        control_timestep=scenario.control_period,
        legacy_step=False,
        **options,
    )


def _suite_scenario(name: str, scenario: str, sea_state: int, settings: dict[str, Any]) -> Scenario:
    """A packaged scenario with random starts, for learning and testing."""
    base = Scenario.load(scenario)
    spread = {"start_spread": 0.5, "start_heading_spread_deg": 10.0, "random_start_time": True}
    return base.with_values(
        {
            "sea.sea_state": sea_state,
            "task.name": name,
            "task.settings": base.task.settings | spread | settings,
        }
    )


@SUITE.add("benchmarking", "closed_loop")
def dock(
    sea_state: int = 4,
    scenario: str = "docking_demo",
    random: np.random.RandomState | int | None = None,
    environment_kwargs: dict[str, Any] | None = None,
    **settings: Any,
) -> control.Environment:
    """Closed-loop docking: guidance and controller attached, the action shifts the goal."""
    settings = {"goal_offset": 0.2, **settings}
    changed = _suite_scenario("dock", scenario, sea_state, settings)
    return build(changed, random, environment_kwargs)


@SUITE.add("benchmarking", "closed_loop")
def dock_pose_pid(
    sea_state: int = 4,
    scenario: str = "docking_demo",
    random: np.random.RandomState | int | None = None,
    environment_kwargs: dict[str, Any] | None = None,
    **settings: Any,
) -> control.Environment:
    """Closed-loop docking with the reference's pose PID, on its ideal wrench at the CG."""
    reference = {"controller": "pose_pid", "gains": "brute_force", "goal_offset": 0.2}
    changed = _suite_scenario("dock", scenario, sea_state, reference | settings)
    vehicle = DockingSettings.parse(changed.task.settings, "task.settings").vehicle
    changed = changed.with_values({f"vehicles.{vehicle}.actuation": "wrench"})
    return build(changed, random, environment_kwargs)


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
