"""The docking task on arrays: one mission steers and judges one simulation or a thousand.

The dm_control task and the batch runner both use it, so they give the same bits. Everything has a
leading shape (...,): () for one simulation, (n,) for a batch.
"""

from dataclasses import dataclass, field, replace
from typing import Any

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from marine_mj import frames, hydrodynamics, rigid_loops
from marine_mj.controllers import (
    Allocator,
    DockingPilot,
    Latch,
    Limits,
    Phase,
    PilotState,
    RigidState,
    pose_error,
    relative_velocity,
)
from marine_mj.frames import Array
from marine_mj.scenario import Scenario
from marine_mj.scene import main_bodies, start_pose
from marine_mj.tasks.base import Flags, Mission, Signal, from_unit
from marine_mj.tasks.contact_log import ContactLog
from marine_mj.tasks.docking_controllers import docking_pilot
from marine_mj.tasks.docking_geometry import DockingGeometry, DockingView
from marine_mj.tasks.docking_navigation import DockingNavigation, docking_navigation
from marine_mj.tasks.docking_physics import DockingPhysics
from marine_mj.tasks.docking_settings import DockingSettings
from marine_mj.tasks.docking_state import CAPTURE, DockingState, docking_summary
from marine_mj.tasks.reader import BodyReader

#: Importance of the axes in contact, when the thrusters cannot give all of them
#: (`Allocator.axis_weight`): heave first, of which a vehicle that is pushed into a dock has too
#: little; the pads turn the push into more pitch moment than the thrusters would give directly. A
#: free vehicle has no pads: there attitude counts as much, or a lasting want of heave tips it over.
_CONTACT_WEIGHT = (1.0, 1.0, 3.0, 3.3, 3.3, 3.3)
#: Latest start on the wave record in episodes with a random start, s.
_LATEST_START = 600.0
#: "0 approach 1 under ...": phases by number, for logs.
_PHASES = " ".join(f"{phase.value} {phase.name.lower()}" for phase in Phase)


@dataclass(frozen=True)
class DockingMission(Mission):
    """Guidance, control and judgement of docking.

    Attributes:
        settings: settings of the task; a stacked mission does not look at them.
        closed_loop: guidance and controller steer; otherwise the action is the raw command.
        geometry: who docks where.
        pilot: guidance and controller.
        navigation: what they know of vehicle and carrier; judgement knows the truth.
        allocator: from wrenches to the vehicle's actuators.
        contact_allocator: the same while the vehicle is pushed against the dock.
        actuators: (m,) their ids.
        nu: number of actuators of the scene.
        latch: when the latch closes.
        period: time between two commands, s.
        goal_offset: largest shift of the goal by the action, m.
        hold: time a mission goes on after the latch has closed or the vehicle is away again, s.
        end_at_capture: a mission ends when the aperture is entered.
        undock_after: time for which the latch stays closed, s; inf: until it is asked to open.
        docked: the vehicle starts latched in the dock.
        sea: what the summary says of the sea: H_s, T_p, number.
    """

    settings: DockingSettings = field(metadata={"stack": "first"})
    closed_loop: bool
    geometry: DockingGeometry
    pilot: DockingPilot
    navigation: DockingNavigation
    allocator: Allocator = field(metadata={"stack": "same"})
    contact_allocator: Allocator = field(metadata={"stack": "same"})
    actuators: Array
    nu: int
    latch: Latch
    period: float
    goal_offset: float
    hold: float
    end_at_capture: bool
    undock_after: float = np.inf
    docked: bool = False

    signal_specs = {  # noqa: RUF012
        "dock_error": Signal(("dof",), "m, rad", "vehicle FLU", "seat pose minus vehicle pose"),
        "relative_velocity": Signal(
            ("dof",), "m/s, rad/s", "vehicle FLU", "vehicle velocity relative to the seat"
        ),
        "target_ned": Signal(("axis",), "m", "NED", "position the controller steers to"),
        "target_error": Signal(("dof",), "m, rad", "NED", "target pose minus vehicle pose"),
        "target_rate": Signal(("dof",), "m/s, rad/s", "NED", "target velocity minus vehicle's"),
        "wrench_command": Signal(
            ("dof",), "N, N m", "vehicle FLU", "wrench the thrusters were asked for"
        ),
        "phase": Signal((), "1", "", _PHASES),
        "latched": Signal((), "1", "", "1 when the latch is closed"),
        "contact_force": Signal((), "N", "", "largest sum of normal forces in the control period"),
        **DockingNavigation.signal_specs,
    }

    @classmethod
    def of(
        cls,
        scenario: Scenario,
        settings: DockingSettings,
        physics: DockingPhysics,
        closed_loop: bool,
    ) -> "DockingMission":
        """Mission of a scenario, with what the compiled scene says of its vehicle."""
        vehicle = scenario.vehicles[physics.vehicle]
        low, high = frames.flip(vehicle.wrench_low_frd), frames.flip(vehicle.wrench_high_frd)
        limits = Limits(np.minimum(low, high), np.maximum(low, high))
        period = scenario.control_period
        return cls(
            settings=settings,
            closed_loop=closed_loop,
            geometry=physics.geometry,
            pilot=docking_pilot(scenario, settings, physics, limits),
            navigation=docking_navigation(scenario, settings, physics),
            allocator=physics.allocator(physics.vehicle),
            contact_allocator=replace(
                physics.allocator(physics.vehicle), axis_weight=np.array(_CONTACT_WEIGHT)
            ),
            actuators=physics.actuators(physics.vehicle),
            nu=physics.model.nu,
            latch=settings.latch.latch(),
            period=period,
            goal_offset=settings.goal_offset,
            hold=settings.hold,
            end_at_capture=settings.end_at_capture,
            undock_after=np.inf if settings.undock_after is None else settings.undock_after,
            docked=settings.start_docked,
        )

    def place(
        self,
        scenario: Scenario,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        random: np.random.RandomState,
    ) -> None:
        """Put all vehicles at their start, scattered if the settings ask for it.

        Args:
            scenario: what is run.
            model: compiled scene.
            data: just reset; time, positions and velocities are written.
            random: of the random start.
        """
        settings = self.settings
        if settings.random_start_time:
            data.time = random.uniform(0.0, _LATEST_START)
        for instance, body in main_bodies(model).items():
            vehicle = scenario.vehicles[instance]
            position, quaternion = start_pose(vehicle)
            if instance == self.geometry.vehicle:
                scatter = settings.start_spread * random.normal(size=3)
                position = position + np.clip(scatter, -2.0, 2.0)
                turn = np.deg2rad(settings.start_heading_spread_deg) * random.normal()
                turned = frames.quaternion_from_euler([0.0, 0.0, turn])
                quaternion = frames.quaternion_multiply(turned, quaternion)
            velocity = frames.flip(vehicle.velocity_frd)
            state = RigidState(position, quaternion, velocity)
            BodyReader.of(model, body).write(data.qpos, data.qvel, state)
        hydrodynamics.start_in_waves(model, data)
        if self.docked:
            reader, weld = self.geometry.vehicle_reader, self.geometry.weld
            reader.write(data.qpos, data.qvel, self.view(data.qpos, data.qvel).dock[1])
            model.eq_data[weld, :10] = self.view(data.qpos, data.qvel).weld
            data.eq_active[weld] = 1

    def noise_seed(self, random: np.random.RandomState) -> int:
        """Seed of a run's noise, drawn after `place`; 0 (nothing drawn) without noise."""
        return 0 if self.navigation.perfect else int(random.randint(2**63 - 1, dtype=np.int64))

    def initial(
        self, time: Array | float, shape: tuple[int, ...] = (), seeds: ArrayLike = 0
    ) -> DockingState:
        """State at the start, at `time` (...,) s, for a leading shape and noise seeds (...,)."""
        start = np.broadcast_to(np.asarray(time, dtype=float), shape).copy()
        return DockingState(
            pilot=self.pilot.initial(shape),
            navigation=self.navigation.initial(shape, seeds),
            latch=self.latch.initial(shape),
            wrench=np.zeros((*shape, 6)),
            target=RigidState.at_rest(shape),
            vehicle=RigidState.at_rest(shape),
            start_time=start,
            latch_time=start if self.docked else np.full(shape, np.inf),
            undock_at=start + self.undock_after if self.docked else np.full(shape, np.inf),
            undock_time=np.full(shape, np.inf),
            clear_time=np.full(shape, np.inf),
            away_time=np.full(shape, np.inf),
            contact=ContactLog.initial(shape),
            departure=ContactLog.initial(shape),
            height=np.full(shape, np.inf if self.docked else -np.inf),
            entries=np.zeros(shape, dtype=int),
            capture=np.full((*shape, len(CAPTURE)), np.nan),
        )

    def view(self, qpos: Array, qvel: Array) -> DockingView:
        """States and errors for generalised coordinates (..., nq) and (..., nv)."""
        return DockingView(self.geometry, qpos, qvel)

    @property
    def welds(self) -> tuple[int, ...]:
        """Equality constraints that the mission may close."""
        return (self.geometry.weld,)

    def command(
        self, state: DockingState, view: DockingView, latched: Flags, action: Array | None = None
    ) -> tuple[Array, DockingState]:
        """Commands (..., nu) of all actuators, and the next state.

        Args:
            state: state after the previous look.
            view: present states.
            latched: (...,) bool.
            action: (..., k) of the task, each in [-1, 1]; None: no change of the goal, no thrust.
        """
        latched = np.asarray(latched, dtype=bool)
        commands = np.zeros((*latched.shape, self.nu))
        if not self.closed_loop:
            given = np.zeros((*latched.shape, len(self.actuators))) if action is None else action
            limits = self.allocator.limits
            raw = from_unit(given, limits.low, limits.high)
            raw = np.where(latched[..., None], 0.0, raw)
            commands[..., self.actuators] = raw
            effect = self.allocator.effectiveness
            return commands, replace(state, wrench=frames.apply(effect, raw))
        offset: Array | float = 0.0
        if action is not None and np.shape(action)[-1]:
            offset = self.goal_offset * np.asarray(action, dtype=float)
        known, navigation = self.navigation.look(state.navigation, view)
        wrench, order, pilot = self.pilot.update(
            state.pilot, known.vehicle, known.carrier, latched, offset, known.carrier_acceleration
        )
        commands[..., self.actuators], given = self._allocate(pilot, wrench)
        pilot = self.pilot.applied(pilot, given)
        return commands, replace(
            state,
            pilot=pilot,
            navigation=navigation,
            wrench=given,
            target=order.target,
            vehicle=view.vehicle,
        )

    def _allocate(self, pilot: PilotState, wrench: Array) -> tuple[Array, Array]:
        """Thruster commands (..., m) and the wrench (..., 6) that they give."""
        guidance = pilot.guidance
        # A dock that comes down on a waiting vehicle is to be left as fast as can be.
        plan = self.pilot.guidance.plan
        deepest = np.asarray(plan.wait_depth) + plan.retreat
        near = (guidance.phase == Phase.WAIT) & (guidance.height > -deepest)
        heave = np.asarray(near | (guidance.phase == Phase.CONTACT))
        commands, given = np.empty((*heave.shape, len(self.actuators))), np.empty_like(wrench)
        for rows, allocator in ((heave, self.contact_allocator), (~heave, self.allocator)):
            if np.any(rows):
                commands[rows], given[rows] = allocator.allocate(wrench[rows])
        return commands, given

    def observe(
        self,
        state: DockingState,
        view: DockingView,
        time: Array | float,
        latched: Flags,
        contacts: Array,
    ) -> tuple[DockingState, Flags]:
        """Next state, and in which simulations (...,) the latch is closed from now on.

        Args:
            state: state after the last command.
            view: states one control period later.
            time: (...,) simulated time there, s.
            latched: (...,) bool, closed before.
            contacts: (..., steps, 4) contact sensor at every physics step of the control period.
        """
        time, latched = np.asarray(time, dtype=float), np.asarray(latched, dtype=bool)
        height, entries, capture = self._aperture(state, view, time)
        latch = self.latch.update(state.latch, view.error, view.relative_velocity, self.period)
        released = np.isfinite(state.undock_time)
        closing = latch.closed & ~latched & ~released
        opening = latched & (time >= state.undock_at - 1e-9) & self._quiet(state, time)
        clear = released & self.pilot.guidance.plan.clear(height)
        away = released & (state.pilot.guidance.phase == Phase.AWAY) if self.closed_loop else clear
        timestep = self.period / contacts.shape[-2]
        following = replace(
            state,
            latch=latch,
            latch_time=np.where(closing, time, state.latch_time),
            undock_at=np.where(closing, time + self.undock_after, state.undock_at),
            undock_time=np.where(opening, time, state.undock_time),
            clear_time=np.where(clear, np.minimum(state.clear_time, time), state.clear_time),
            away_time=np.where(away, np.minimum(state.away_time, time), state.away_time),
            contact=state.contact.update(contacts, timestep, latched | released),
            departure=state.departure.update(
                np.where(released[..., None, None], contacts, 0.0), timestep, ~released
            ),
            height=height,
            entries=entries,
            capture=capture,
        )
        return following, (latched & ~opening) | closing

    def _quiet(self, state: DockingState, time: Array) -> Flags:
        """Where (...,) the dock is quiet enough to leave it; an open policy decides by itself."""
        if not self.closed_loop:
            return np.ones(time.shape, dtype=bool)
        waited = np.where(time > state.undock_at, time - state.undock_at, 0.0)
        return self.pilot.guidance.plan.quiet(state.pilot.guidance.turning, waited)

    def undock(self, state: DockingState, time: Array | float) -> DockingState:
        """State in which closed latches (...,) are to open at `time` s."""
        latched = np.isfinite(state.latch_time) & np.isinf(state.undock_time)
        return replace(state, undock_at=np.where(latched, time, state.undock_at))

    def _aperture(
        self, state: DockingState, view: DockingView, time: Array
    ) -> tuple[Array, Array, Array]:
        """Height, entries and capture when the aperture is crossed from below (digest 7.0)."""
        pose, plan = view.aperture_pose, self.pilot.guidance.plan
        height, across = plan.split(pose[..., :3])
        # The closed loop arms the crossing at waypoint 2; an open policy has no waypoints.
        armed = np.asarray(state.pilot.guidance.phase >= Phase.WAIT) | (not self.closed_loop)
        armed &= np.isinf(state.undock_time)
        within = np.all(np.abs(across) <= np.asarray(plan.aperture), axis=-1)
        crossed = armed & within & (state.height < 0) & (height >= 0)
        entries, capture = state.entries + crossed, state.capture
        first = crossed & np.isnan(capture[..., 0])
        if np.any(first):
            now = np.concatenate(
                [
                    (time - state.start_time)[..., None],
                    frames.flip(pose),
                    np.linalg.norm(view.relative_velocity[..., :3], axis=-1)[..., None],
                    view.relative_energy[..., None],
                ],
                axis=-1,
            )
            capture = np.where(first[..., None], now, capture)
        return height, entries, capture

    def finished(self, state: DockingState, time: Array | float, latched: Flags) -> Flags:
        """Where (...,) the vehicle has been docked for `hold` seconds (or has entered).

        With undocking: where it has been away again for as long.
        """
        docked = np.asarray(latched, dtype=bool) & np.isinf(state.undock_at)
        held = docked & (time - state.latch_time >= self.hold - 1e-9)
        held |= time - state.away_time >= self.hold - 1e-9
        return held | (self.end_at_capture & ~np.isnan(state.capture[..., 0]))

    def signals(self, state: DockingState, view: DockingView, latched: Flags) -> dict[str, Array]:
        """Signals (..., ...) for the log, by name; `signal_specs` describes them."""
        phase = np.asarray(state.pilot.guidance.phase, dtype=float)
        error, rate = _miss(state.target, state.vehicle)
        return {
            "dock_error": view.error,
            "relative_velocity": view.relative_velocity,
            "target_ned": frames.flip(state.target.position),
            "target_error": frames.flip(error),
            "target_rate": frames.flip(rate),
            "wrench_command": state.wrench,
            "phase": phase if self.closed_loop else np.full_like(phase, np.nan),
            "latched": np.asarray(latched, dtype=float),
            "contact_force": state.contact.force,
            **self.navigation.signals(state.navigation),
        }

    def summary(self, scenario: Scenario, state: DockingState, latched: bool) -> dict[str, Any]:
        """Whether and how the vehicle of one simulation docked.

        Args:
            scenario: what was run.
            state: of that simulation, shape ().
            latched: whether its latch is closed.

        `docked` says whether the latch has closed, even if it has opened again since; times are
        counted from the start.
        """
        navigation = self.navigation.rmse(state.navigation)
        return docking_summary(
            scenario, self.settings, self.closed_loop, state, latched, navigation
        )


def _miss(target: RigidState, vehicle: RigidState) -> tuple[Array, Array]:
    """Pose and velocity (..., 6) of the target minus those of the vehicle, world axes NWU."""
    own = (pose_error(target, vehicle), -relative_velocity(vehicle, target))
    error, rate = (rigid_loops.world_velocity(vehicle.quaternion, part) for part in own)
    return error, rate
