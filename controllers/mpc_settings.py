"""Weights and horizon of the model-predictive controller."""

from collections.abc import Sequence
from dataclasses import dataclass

from marine_mj.controllers.pid import hold_positive

from marine_mj.errors import ScenarioError
from marine_mj.frames import Array


@dataclass(frozen=True)
class MpcSettings:
    """What counts as equally bad in each axis (`Q = 1 / value^2`), and the horizon.

    Attributes:
        pose: (6,) pose error, m and rad.
        velocity: (6,) relative velocity, m/s and rad/s.
        wrench: (6,) wrench beyond what cancels the disturbance, N and N m.
        change: (6,) change of the wrench from one move to the next, N and N m.
        terminal: weight of the last step relative to the others.
        step: of the horizon and between two plans, s.
        moves: how many steps each move lasts; their sum is the horizon.
        sweep: shortest time in which the wrench may go from limit to limit, s.
        clearance: how far the vehicle stays below the aperture plane until it may enter, m.
        error_limit: longest position error that a plan sees, m.
    """

    pose: Array | Sequence[float]
    velocity: Array | Sequence[float]
    wrench: Array | Sequence[float]
    change: Array | Sequence[float]
    terminal: float = 4.0
    step: float = 0.1
    moves: tuple[int, ...] = (1, 1, 1, 2, 2, 3, 4, 6)
    sweep: float = 0.3
    clearance: float = 0.3
    error_limit: float = 1.0

    def __post_init__(self) -> None:
        """Raise ScenarioError for a value that is not positive."""
        hold_positive(self, "MPC", "pose", "velocity", "wrench", "change")
        for name in ("terminal", "step", "sweep", "error_limit"):
            if not getattr(self, name) > 0:
                raise ScenarioError(f"MPC: {name} must be > 0, got {getattr(self, name)}")
        if not self.moves or min(self.moves) < 1:
            raise ScenarioError(f"MPC: moves must be whole numbers >= 1, got {self.moves}")

    @property
    def steps(self) -> int:
        """Steps of the horizon."""
        return sum(self.moves)


MPC_SETTINGS = {
    # Ours: a pose error of 5 cm is as bad as 10 cm/s; twice these let a vehicle with thruster lag
    # stray half as far again from a target that heaves.
    "extended": MpcSettings(
        pose=[0.05, 0.05, 0.05, 0.08, 0.05, 0.05],
        velocity=[0.1, 0.1, 0.1, 0.2, 0.1, 0.1],
        wrench=[150.0, 150.0, 150.0, 5.0, 40.0, 40.0],
        change=[60.0, 40.0, 40.0, 3.0, 12.0, 12.0],
    ),
}
