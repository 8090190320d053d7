"""Navigation of the docking task: from what is true to what guidance and controller believe."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from marine_mj import frames
from marine_mj.controllers import RigidState, pose_error
from marine_mj.controllers.kinematics import world_velocity
from marine_mj.controllers.navigation import Estimate, Navigator, PerfectNavigation, Truth
from marine_mj.controllers.navigation.noise import as_seeds
from marine_mj.errors import ScenarioError
from marine_mj.frames import Array
from marine_mj.scenario import Scenario
from marine_mj.tasks.base import Signal
from marine_mj.tasks.docking_geometry import DockingView
from marine_mj.tasks.docking_physics import DockingPhysics
from marine_mj.tasks.docking_settings import DockingSettings


@dataclass(frozen=True)
class NavigationState:
    """Memory of the navigation of a mission.

    Attributes:
        memory: of the navigator; None before the first look.
        step: number of looks so far.
        seeds: (...,) of the noise.
        velocity: (..., 2, 6) true velocities of vehicle and carrier at the last look, world axes;
            NaN before the first one.
        vehicle, carrier: estimated states at the last look; NaN before the first one.
        error: (..., 2, 12) estimated minus true pose and velocity, true body axes FLU.
        relative: (..., 3) error of the carrier's position from the vehicle, NWU, m.
        squares: (..., 27) sums of the squared errors: vehicle, carrier, relative.
    """

    memory: Any
    step: int
    seeds: NDArray[np.uint64]
    velocity: Array
    vehicle: RigidState
    carrier: RigidState
    error: Array
    relative: Array
    squares: Array


@dataclass(frozen=True)
class DockingNavigation:
    """Looks at vehicle and carrier once in every control period.

    Attributes:
        navigator: how the states are estimated.
        period: control period, s.
    """

    navigator: Navigator
    period: float

    signal_specs = {  # noqa: RUF012
        "estimated_eta_ned": Signal(("dof",), "m, rad", "NED", "believed pose of the vehicle"),
        "estimated_carrier_eta_ned": Signal(
            ("dof",), "m, rad", "NED", "believed pose of the carrier"
        ),
        "navigation_error": Signal(
            ("dof",), "m, rad", "vehicle FLU", "estimated minus true pose of the vehicle"
        ),
        "navigation_velocity_error": Signal(
            ("dof",), "m/s, rad/s", "vehicle FLU", "estimated minus true velocity of the vehicle"
        ),
        "carrier_navigation_error": Signal(
            ("dof",), "m, rad", "carrier FLU", "estimated minus true pose of the carrier"
        ),
        "relative_navigation_error": Signal(
            ("axis",), "m", "NED", "error of the carrier's position seen from the vehicle"
        ),
    }

    @property
    def perfect(self) -> bool:
        """Whether estimates are the truth."""
        return isinstance(self.navigator, PerfectNavigation)

    def initial(self, shape: tuple[int, ...], seeds: ArrayLike) -> NavigationState:
        """State before the first look, for a leading shape and noise seeds (...,)."""
        unknown = RigidState(*(np.full((*shape, size), np.nan) for size in (3, 4, 6)))
        return NavigationState(
            memory=None,
            step=0,
            seeds=as_seeds(seeds, shape),
            velocity=np.full((*shape, 2, 6), np.nan),
            vehicle=unknown,
            carrier=unknown,
            error=np.full((*shape, 2, 12), np.nan),
            relative=np.full((*shape, 3), np.nan),
            squares=np.zeros((*shape, 27)),
        )

    def look(self, state: NavigationState, view: DockingView) -> tuple[Estimate, NavigationState]:
        """What is believed now, and the next state.

        Args:
            state: state after the previous look, one control period ago.
            view: true states.
        """
        vehicle, carrier = view.vehicle, view.carrier
        velocity = np.stack([world_velocity(vehicle), world_velocity(carrier)], axis=-2)
        known = ~np.isnan(state.velocity)
        gained = np.where(known, (velocity - state.velocity) / self.period, 0.0)
        truth = Truth(vehicle, carrier, gained[..., 0, :], gained[..., 1, :])
        memory = state.memory
        if state.step == 0:
            shape = state.seeds.shape
            memory = self.navigator.initial(truth, state.seeds, shape)
        estimate = self.navigator.update(memory, truth, state.step)
        if self.perfect:
            error, relative = np.zeros_like(state.error), np.zeros_like(state.relative)
            squares = state.squares
        else:
            error = np.stack(
                [_error(estimate.vehicle, vehicle), _error(estimate.carrier, carrier)], axis=-2
            )
            believed = estimate.carrier.position - estimate.vehicle.position
            relative = believed - (carrier.position - vehicle.position)
            flat = [error[..., 0, :], error[..., 1, :], relative]
            squares = state.squares + np.square(np.concatenate(flat, axis=-1))
        return estimate, NavigationState(
            memory=estimate.state,
            step=state.step + 1,
            seeds=state.seeds,
            velocity=velocity,
            vehicle=estimate.vehicle,
            carrier=estimate.carrier,
            error=error,
            relative=relative,
            squares=squares,
        )

    def signals(self, state: NavigationState) -> dict[str, Array]:
        """Signals (..., k) of the last look, for the log; NaN before the first one."""
        vehicle, carrier = state.vehicle, state.carrier
        return {
            "estimated_eta_ned": frames.eta_ned(vehicle.position, vehicle.quaternion),
            "estimated_carrier_eta_ned": frames.eta_ned(carrier.position, carrier.quaternion),
            "navigation_error": state.error[..., 0, :6],
            "navigation_velocity_error": state.error[..., 0, 6:],
            "carrier_navigation_error": state.error[..., 1, :6],
            "relative_navigation_error": frames.flip(state.relative),
        }

    def rmse(self, state: NavigationState) -> dict[str, Any] | None:
        """Root mean square errors of one run so far; None without a look or when perfect."""
        if self.perfect or state.step == 0:
            return None
        mean = state.squares / state.step

        def lengths(values: Array) -> dict[str, float]:
            names = ("position", "attitude", "velocity", "rate")
            return {
                name: float(np.sqrt(values[3 * i : 3 * i + 3].sum()))
                for i, name in enumerate(names)
            }

        return {
            "vehicle": lengths(mean[:12]),
            "carrier": lengths(mean[12:24]),
            "relative_position": float(np.sqrt(mean[24:].sum())),
        }


def _error(estimate: RigidState, true: RigidState) -> Array:
    """Estimated minus true pose and velocity (..., 12), true body axes."""
    return np.concatenate([pose_error(estimate, true), estimate.velocity - true.velocity], axis=-1)


def docking_navigation(
    scenario: Scenario, settings: DockingSettings, physics: DockingPhysics
) -> DockingNavigation:
    """The navigation that the settings ask for.

    Raises:
        ScenarioError: planar navigation of a vehicle that is not planar.
    """
    if settings.navigation.kind == "thesis" and not scenario.vehicles[physics.vehicle].planar:
        raise ScenarioError(
            f'navigation kind = "thesis" knows the vertical plane only: set planar = true for '
            f'vehicle {physics.vehicle!r}, or kind = "inertial"'
        )
    navigator = settings.navigation.navigator(
        scenario.control_period,
        float(-physics.model.opt.gravity[2]),
        physics.dock_frames.seat,
    )
    return DockingNavigation(navigator, scenario.control_period)
