"""What it takes a vehicle to follow a floating carrier in heave: an estimate of its actuator limit.

Frequency domain, head seas: the carrier heaves by its RAO `H`, the water around the vehicle by
`exp(-k d)`. A vehicle that keeps its distance to the carrier moves against the water by the
difference and needs, with the displaced mass `m` and added mass `A` (Morison),

    F = (m + A) (a_c - a_w) + D (w_c - w_w) abs(w_c - w_w).
"""

from dataclasses import dataclass

import numpy as np

from marine_mj.environment import WaveField
from marine_mj.errors import AnalysisError
from marine_mj.frames import Array


@dataclass(frozen=True)
class HeaveDemand:
    """Demand for following a carrier.

    Attributes:
        speed: standard deviation of the speed through the water, m/s.
        acceleration: standard deviation of the acceleration against the water, m/s2.
        beyond: share of the time in which the force exceeds the limit.
    """

    speed: float
    acceleration: float
    beyond: float


def heave_demand(
    waves: WaveField, rao: Array, depth: float, mass: float, drag: float, limit: float
) -> HeaveDemand:
    """Demand for a vehicle that keeps its distance to a carrier.

    Speed and acceleration of a Gaussian process are independent, which gives `beyond` as an
    integral over both; the vehicle is small against the waves.

    Args:
        waves: components of the sea, deep water.
        rao: (n,) complex heave of the carrier per wave amplitude, phases relative to the wave.
        depth: of the vehicle below the carrier's water line, m.
        mass: displaced plus added mass in heave, kg.
        drag: quadratic damping in heave, N s2/m2.
        limit: largest heave force, N.

    Raises:
        AnalysisError: a depth, mass, drag or limit that cannot be.
    """
    for name, value in (("depth", depth), ("mass", mass), ("drag", drag), ("limit", limit)):
        if not value >= 0:
            raise AnalysisError(f"{name} is {value}, allowed is >= 0: give it in SI units")
    relative = np.abs(np.asarray(rao) - np.exp(-waves.wavenumber * depth)) * waves.amplitude
    speed = float(np.sqrt(0.5 * np.sum((waves.omega * relative) ** 2)))
    acceleration = float(np.sqrt(0.5 * np.sum((waves.omega**2 * relative) ** 2)))
    from scipy.special import ndtr

    x = np.linspace(-8.0, 8.0, 4001)  # standard normal speeds
    resistance = drag * speed**2 * x * np.abs(x)
    spread = max(mass * acceleration, 1e-300)
    outside = ndtr(-(limit - resistance) / spread) + ndtr(-(limit + resistance) / spread)
    density = np.exp(-0.5 * x**2) / np.sqrt(2 * np.pi)
    return HeaveDemand(speed, acceleration, float(np.trapezoid(outside * density, x)))
