"""What a mission asks of navigation, and navigation that knows everything."""

from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np
from marine_mj.controllers.kinematics import RigidState
from numpy.typing import NDArray

from marine_mj.errors import ScenarioError
from marine_mj.frames import Array


class Truth(NamedTuple):
    """True motion of both bodies at one moment.

    Attributes:
        vehicle: state of the vehicle, NWU/FLU.
        carrier: state of the body that carries the dock, NWU/FLU.
        vehicle_acceleration: (..., 6) mean acceleration of the vehicle's origin and rotation since
            the previous update, world axes NWU, m/s2, rad/s2; 0 at the start.
        carrier_acceleration: (..., 6) the same of the carrier.
    """

    vehicle: RigidState
    carrier: RigidState
    vehicle_acceleration: Array
    carrier_acceleration: Array


class Estimate(NamedTuple):
    """What navigation believes at one moment.

    Attributes:
        vehicle: state of the vehicle, NWU/FLU.
        carrier: state of the body that carries the dock, NWU/FLU.
        carrier_acceleration: (..., 6) of the carrier's origin and rotation, world axes NWU.
        state: memory of the navigator.
    """

    vehicle: RigidState
    carrier: RigidState
    carrier_acceleration: Array
    state: Any


class Navigator(Protocol):
    """From the truth of a simulation to what its controllers may know."""

    def initial(self, truth: Truth, seeds: NDArray[np.uint64], shape: tuple[int, ...] = ()) -> Any:
        """State at the start of runs with noise seeds (...,)."""

    def update(self, state: Any, truth: Truth, step: int) -> Estimate:
        """Estimate at a step.

        Args:
            state: state after the previous update.
            truth: true states at this step.
            step: number of the update: 0 at the start, then 1, 2, ...
        """


@dataclass(frozen=True)
class PerfectNavigation:
    """The truth."""

    def initial(self, truth: Truth, seeds: NDArray[np.uint64], shape: tuple[int, ...] = ()) -> None:
        """Nothing has to be remembered."""

    def update(self, state: None, truth: Truth, step: int) -> Estimate:
        """The true states."""
        return Estimate(truth.vehicle, truth.carrier, truth.carrier_acceleration, None)


def whole_steps(name: str, time: float, period: float, least: int = 1) -> int:
    """Number of periods in a time.

    Args:
        name: of the time, for the message.
        time: s.
        period: s.
        least: smallest number allowed.

    Raises:
        ScenarioError: it is not a whole number of periods, or too short.
    """
    steps = round(time / period)
    if steps < least or abs(time / period - steps) > 1e-6:
        raise ScenarioError(
            f"{name} = {time} s must be a whole multiple of the navigation period {period} s"
            f"{', at least one' if least else ''}"
        )
    return steps
