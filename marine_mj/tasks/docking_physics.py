"""Physics with the vocabulary of docking: dock error, relative velocity, latch."""

from typing import Any

from marine_mj.controllers import RigidState
from marine_mj.frames import Array
from marine_mj.tasks.docking_geometry import DockingGeometry, DockingView
from marine_mj.tasks.physics import MarinePhysics


class DockingPhysics(MarinePhysics):
    """Vocabulary of docking. The pair of vehicle and carrier comes from the latch's weld."""

    def _reload_from_data(self, data: Any) -> None:
        """Find latch, vehicle, carrier and dock by name."""
        super()._reload_from_data(data)
        self.geometry = DockingGeometry.of(self.model.ptr)
        self.vehicle, self.carrier = self.geometry.vehicle, self.geometry.carrier
        self.dock_frames = self.geometry.frames

    @property
    def view(self) -> DockingView:
        """States and errors at this moment."""
        # copies: the view may outlive the next step
        return self.remember(
            "view", lambda: DockingView(self.geometry, self.data.qpos.copy(), self.data.qvel.copy())
        )

    def dock_states(self) -> tuple[RigidState, RigidState]:
        """States of the aperture frame and of the seat, NWU/FLU."""
        return self.view.dock

    def dock_error(self) -> Array:
        """Seat pose minus vehicle pose (6,), in the vehicle's FLU axes, m and rad."""
        return self.view.error.copy()

    def relative_velocity(self) -> Array:
        """Velocity (6,) of the vehicle relative to the seat, in the vehicle's FLU axes."""
        return self.view.relative_velocity.copy()

    def relative_energy(self) -> float:
        """Kinetic energy of the relative motion with the dry mass, J; see `DockingView`."""
        return float(self.view.relative_energy)

    def latched(self) -> bool:
        """Whether the latch is closed."""
        return bool(self.data.eq_active[self.geometry.weld])

    def close_latch(self) -> None:
        """Weld the vehicle to the dock in its present pose."""
        self.model.ptr.eq_data[self.geometry.weld, :10] = self.view.weld
        self.data.ptr.eq_active[self.geometry.weld] = 1

    def open_latch(self) -> None:
        """Let the vehicle go."""
        self.data.ptr.eq_active[self.geometry.weld] = 0
