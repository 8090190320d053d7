"""Navigation: measurements, sensors and filters; arrays in, arrays out. See docs/navigation.md."""

from marine_mj.controllers.navigation.carrier import CarrierNavigation
from marine_mj.controllers.navigation.consistency import chi_square_bounds, nees
from marine_mj.controllers.navigation.error_state import ErrorState, ErrorStateFilter
from marine_mj.controllers.navigation.inertial import Aid, InertialNavigation
from marine_mj.controllers.navigation.kernels import kalman_update
from marine_mj.controllers.navigation.navigator import Estimate, Navigator, PerfectNavigation, Truth
from marine_mj.controllers.navigation.noise import NoiseStream
from marine_mj.controllers.navigation.planar import (
    PLANAR_SCENARIOS,
    PlanarFilter,
    PlanarNavigation,
    PlanarNoise,
    planar_scenario,
)
from marine_mj.controllers.navigation.relative_sensors import Camera, Spherical, Usbl
from marine_mj.controllers.navigation.sensors import (
    Compass,
    Dvl,
    GaussMarkov,
    Gnss,
    Imu,
    Pressure,
    Timing,
)

__all__ = [
    "PLANAR_SCENARIOS",
    "Aid",
    "Camera",
    "CarrierNavigation",
    "Compass",
    "Dvl",
    "ErrorState",
    "ErrorStateFilter",
    "Estimate",
    "GaussMarkov",
    "Gnss",
    "Imu",
    "InertialNavigation",
    "Navigator",
    "NoiseStream",
    "PerfectNavigation",
    "PlanarFilter",
    "PlanarNavigation",
    "PlanarNoise",
    "Pressure",
    "Spherical",
    "Timing",
    "Truth",
    "Usbl",
    "chi_square_bounds",
    "kalman_update",
    "nees",
    "planar_scenario",
]
