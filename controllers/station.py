"""Guidance that keeps station below a dock: the tuning scenario of the reference (digest 7.1)."""

from dataclasses import dataclass, field

import numpy as np
from marine_mj.controllers.docking_plan import DockingPlan
from marine_mj.controllers.kinematics import RigidState
from marine_mj.controllers.waypoints import GuidanceCommand, GuidanceState, Phase

from marine_mj.frames import Array


@dataclass(frozen=True)
class StationGuidance:
    """The goal moved down, with the attitude and velocity of the dock there.

    Attributes:
        depth: how far below the goal of `plan`, along the dock's vertical, m.
        plan: its overshoot and aperture count.
    """

    depth: float = 1.0
    plan: DockingPlan = field(default_factory=DockingPlan)

    def initial(self, shape: tuple[int, ...] = ()) -> GuidanceState:
        """State at the start, for a leading shape."""
        zero = np.zeros(shape)
        attempts = np.zeros(shape, dtype=int)
        phase = np.full(shape, int(Phase.ENTER))
        return GuidanceState(phase, np.full(shape, -np.inf), zero, attempts, zero, zero, zero, zero)

    def update(
        self,
        state: GuidanceState,
        vehicle: RigidState,
        carrier: RigidState,
        aperture: RigidState,
        seat: RigidState,
        latched: Array,
        period: float,
    ) -> tuple[GuidanceCommand, GuidanceState]:
        """Command for the controller, and the state, which never changes; see `DockingGuidance`."""
        ones = np.ones_like(vehicle.velocity)
        command = GuidanceCommand(
            target=self.target(state, carrier, aperture, seat),
            scale=ones,
            push=np.zeros_like(vehicle.position),
            entered=np.zeros(vehicle.position.shape[:-1], dtype=bool),
            follow=ones,
        )
        return command, state

    def target(
        self, state: GuidanceState, carrier: RigidState, aperture: RigidState, seat: RigidState
    ) -> RigidState:
        """State to reach for (predicted) states of the carrier; see `DockingGuidance.target`."""
        above = np.asarray(self.plan.overshoot - np.asarray(self.depth))[..., None]
        return aperture.attached(above * np.array([0.0, 0.0, 1.0]))
