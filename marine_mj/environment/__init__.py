"""Sea, current and wind as frozen, seeded realisations: pure functions of position and time.

All arrays are in the world frame NWU (x north, y west, z up from still water) and SI units;
directions are those of travel, rad, counter-clockwise from north.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from marine_mj.environment._checks import Frozen, number
from marine_mj.environment.current import (
    Current,
    fluctuating_current,
    no_current,
    uniform_current,
)
from marine_mj.environment.dispersion import group_speed, phase_speed, wavenumber
from marine_mj.environment.sea_states import SEA_STATES, SeaState, sea_state, uptime_percent
from marine_mj.environment.seas import calm, gaussian_sea, irregular_sea, regular_wave
from marine_mj.environment.series import gauss_markov
from marine_mj.environment.spectra import (
    SPECTRA,
    Spectrum,
    bretschneider,
    docking_jonswap,
    jonswap,
    period_ratios,
    pierson_moskowitz,
    spreading_density,
    tabulated,
)
from marine_mj.environment.waves import WaveField
from marine_mj.environment.wind import (
    Wind,
    gust_density,
    gusty_wind,
    height_factor,
    no_wind,
    steady_wind,
    wandering_wind,
    wind_series,
)
from marine_mj.errors import SeaError
from marine_mj.frames import Array

__all__ = [
    "SEA_STATES",
    "SPECTRA",
    "Current",
    "Environment",
    "SeaState",
    "Spectrum",
    "WaveField",
    "Wind",
    "bretschneider",
    "calm",
    "docking_jonswap",
    "fluctuating_current",
    "gauss_markov",
    "gaussian_sea",
    "group_speed",
    "gust_density",
    "gusty_wind",
    "height_factor",
    "irregular_sea",
    "jonswap",
    "no_current",
    "no_wind",
    "period_ratios",
    "phase_speed",
    "pierson_moskowitz",
    "regular_wave",
    "sea_state",
    "spreading_density",
    "steady_wind",
    "tabulated",
    "uniform_current",
    "uptime_percent",
    "wandering_wind",
    "wavenumber",
    "wind_series",
]


@dataclass(frozen=True, eq=False)
class Environment(Frozen):
    """Everything around the vehicles; the default is still water and still air.

    Attributes:
        waves: wave field.
        current: current; added to the orbital velocity, waves are not refracted by it.
        wind: wind.
        water_density: rho, kg/m3.
        gravity: g, m/s2; the wave field has to be made with the same.

    Raises:
        SeaError: a part has the wrong type, a value is out of range, or waves and environment
            disagree about gravity.
    """

    waves: WaveField = field(default_factory=calm)
    current: Current = field(default_factory=no_current)
    wind: Wind = field(default_factory=no_wind)
    water_density: float = 1025.0
    gravity: float = 9.81

    def __post_init__(self) -> None:
        """Check and freeze."""
        for name, kind in (("waves", WaveField), ("current", Current), ("wind", Wind)):
            if not isinstance(getattr(self, name), kind):
                raise SeaError(
                    f"{name} is a {type(getattr(self, name)).__name__}, allowed is "
                    f"{kind.__name__}: make one with marine_mj.environment"
                )
        density = number(
            "water_density", self.water_density, "kg/m3", "1025 for sea water", above=0
        )
        gravity = number("gravity", self.gravity, "m/s2", "9.81 on Earth", above=0)
        object.__setattr__(self, "water_density", density)
        object.__setattr__(self, "gravity", gravity)
        if len(self.waves.omega) and self.waves.gravity != gravity:
            raise SeaError(
                f"gravity is {gravity:g} m/s2 but the waves were made with {self.waves.gravity:g}, "
                "allowed is the same: pass gravity to both"
            )

    def water_velocity(self, x: ArrayLike, y: ArrayLike, z: ArrayLike, t: ArrayLike) -> Array:
        """Velocity of waves plus current (..., 3) [m/s, NWU] at x, y, z (m, NWU) and t (s)."""
        return self.waves.velocity(x, y, z, t) + self.current.velocity_at(z, t)

    def water_acceleration(self, x: ArrayLike, y: ArrayLike, z: ArrayLike, t: ArrayLike) -> Array:
        """Local acceleration of waves plus current (..., 3) [m/s2, NWU]; see `water_velocity`."""
        return np.add(self.waves.acceleration(x, y, z, t), self.current.acceleration_at(z, t))
