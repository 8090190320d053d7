"""What the contacts between vehicles did so far: force, impulse, energy, penetration, duration."""

from dataclasses import dataclass, replace

import numpy as np

from marine_mj.frames import Array
from marine_mj.hydrodynamics import table
from marine_mj.tasks.base import Flags


@dataclass(frozen=True)
class ContactLog:
    """Sums over the contacts between different vehicles, for any leading shape (...,).

    Peak force, impulse, energy and duration stand for the impact: they are taken until the latch
    closes, after which the weld works against the pads: two constraints that hold the same thing
    share a load that neither would have alone. The others go on to the end.

    Attributes:
        force: largest sum of normal forces in the last control period, N.
        peak_force: the same since the start, N.
        impulse: time integral of the sum of normal forces, N s.
        energy: energy that the contacts took out of the motion, J: what is dissipated, and what
            contacts that still last hold as springs.
        penetration: deepest overlap of two geoms, m; the soft layer of a pad (its margin) is not
            overlap.
        duration: time with contact, s.
        crashed: bool, a forbidden geom was touched.
    """

    force: Array
    peak_force: Array
    impulse: Array
    energy: Array
    penetration: Array
    duration: Array
    crashed: Flags

    @classmethod
    def initial(cls, shape: tuple[int, ...] = ()) -> "ContactLog":
        """Log without any contact, for a leading shape."""
        zero = np.zeros(shape)
        return cls(zero, zero, zero, zero, zero, zero, np.zeros(shape, dtype=bool))

    def update(self, contacts: Array, timestep: float, latched: Flags) -> "ContactLog":
        """Log one control period later.

        Args:
            contacts: (..., steps, `table.CONTACT_VALUES`) contact sensor at every physics step.
            timestep: of the physics, s.
            latched: (...,) bool, closed before.
        """
        if not contacts.any():
            return replace(self, force=np.zeros_like(self.force))
        force = contacts[..., table.S_FORCE]
        most = np.max(force, axis=-1)
        open_ = np.where(latched, 0.0, timestep)
        return ContactLog(
            force=most,
            peak_force=np.maximum(self.peak_force, np.where(latched, 0.0, most)),
            impulse=self.impulse + open_ * _sum(force),
            energy=self.energy + open_ * _sum(contacts[..., table.S_POWER]),
            penetration=np.maximum(
                self.penetration, np.max(contacts[..., table.S_PENETRATION], axis=-1)
            ),
            duration=self.duration + open_ * _sum((force > 0).astype(float)),
            crashed=self.crashed | np.any(contacts[..., table.S_FORBIDDEN] > 0, axis=-1),
        )


def _sum(values: Array) -> Array:
    """Sum over the last axis, one after the other: the same bits for any leading shape."""
    return np.cumsum(values, axis=-1)[..., -1]
