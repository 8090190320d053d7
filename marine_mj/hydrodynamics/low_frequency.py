"""The low-frequency place of bodies that wave loads push (kernels.low_frequency)."""

from itertools import pairwise

import mujoco
import numpy as np

from marine_mj.environment import Environment, WaveField
from marine_mj.frames import Array
from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.body_settings import BodySettings, motion_of
from marine_mj.hydrodynamics.coefficients import BodyCoefficients
from marine_mj.hydrodynamics.drift import Drift, drift_of
from marine_mj.hydrodynamics.excitation import excitation_of
from marine_mj.hydrodynamics.panels import uses_panels

#: Prefix of the actuators whose activations are the states of the low-frequency place.
LOW_FREQUENCY_PREFIX = "marine_mj/low_frequency/"
#: Cut-off over the sea's lowest peak frequency (ours): at 0.1 a free body keeps 0.2 to 3 % of the
#: mean force that the load at its oscillating position has, and follows what takes longer than
#: some ten wave periods.
CUTOFF = 0.1
#: Share of the sea's energy that makes a peak count (ours).
PEAK_SHARE = 0.05
#: Width of the kernel that smooths the energy over ln omega (ours): a JONSWAP peak is 0.08 wide.
_WIDTH = 0.15


def peak_frequency(waves: WaveField) -> float:
    """Lowest peak of a sea that holds over 5 % of its energy, rad/s.

    Peaks of the energy smoothed over ln omega; each has the energy between the minima beside it.
    The lowest component's frequency of a sea without height.

    Args:
        waves: wave field with at least one component.
    """
    place, energy = np.log(waves.omega), waves.amplitude**2
    if not energy.any():
        return float(waves.omega.min())
    grid = np.linspace(place.min() - _WIDTH, place.max() + _WIDTH, 400)
    density = np.exp(-0.5 * ((grid[:, None] - place) / _WIDTH) ** 2) @ energy
    inner = density[1:-1]
    peaks = 1 + np.flatnonzero((inner > density[:-2]) & (inner >= density[2:]))
    lows = [grid[a + np.argmin(density[a:b])] for a, b in pairwise(peaks)]
    owner = np.searchsorted(lows, place)
    shares = np.bincount(owner, energy, len(peaks)) / energy.sum()
    return float(np.exp(grid[peaks[np.flatnonzero(shares > PEAK_SHARE)[0]]]))


def drift_in(body: BodyCoefficients, settings: BodySettings, waves: WaveField) -> Drift:
    """Drift of a body in a sea: calm water needs no database, hull panels have their own.

    Raises:
        ModelError: drift is asked for and cannot be, see `drift_of`.
    """
    if settings.drift or (len(waves.omega) and not uses_panels(body, settings)):
        return drift_of(body, settings.drift, motion_of(body, settings))
    return "none"


def follows_waves(body: BodyCoefficients, settings: BodySettings) -> bool:
    """Whether wave loads act on a body at its low-frequency place.

    Not a matter of the sea: models in calm water and in waves have the same states.
    """
    motion = motion_of(body, settings)
    if motion == "dynamic" or excitation_of(body, settings) == "long waves":
        return True
    panels = uses_panels(body, settings) and not settings.drift
    return not panels and drift_of(body, settings.drift, motion) != "none"


def filter_entries(model: mujoco.MjModel, name: str, environment: Environment) -> Array:
    """Entries of a body's record from `B_LOW_FREQUENCY` (3,): address, cut-off, reach.

    Beyond half a length of the peak's waves the filter's place says nothing about the body's; then
    it starts anew. Zeros on a body without the states, and in calm water.
    """
    actuator = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_ACTUATOR, LOW_FREQUENCY_PREFIX + name)
    if actuator < 0 or not len(environment.waves.omega):
        return np.zeros(3)
    peak = peak_frequency(environment.waves)
    k = float(np.interp(peak, *_sorted(environment.waves)))
    return np.array([model.actuator_actadr[actuator] + 1, CUTOFF * peak, np.pi / k])


def states_before(model: mujoco.MjModel) -> int:
    """Number of activations in front of those of the low-frequency places, which stand last."""
    names = (model.actuator(i).name for i in range(model.nu))
    first = [i for i, name in enumerate(names) if name.startswith(LOW_FREQUENCY_PREFIX)]
    return int(model.actuator_actadr[first[0]]) if first else int(model.na)


def _sorted(waves: WaveField) -> tuple[Array, Array]:
    """Frequencies and wave numbers of a sea, rising."""
    order = np.argsort(waves.omega)
    return waves.omega[order], waves.wavenumber[order]


def filter_state(place: Array, speed: Array) -> Array:
    """States (LF_STATES,) of a filter whose body has moved so for long.

    Args:
        place: (3,) x, y [m] and yaw [rad], NWU.
        speed: (3,) their rates [m/s, m/s, rad/s].
    """
    states = np.zeros(t_.LF_STATES)
    states[t_.LF_SET] = 1.0
    states[t_.LF_X :: t_.LF_ORDER] = place
    states[t_.LF_X + 1 :: t_.LF_ORDER] = speed
    return states
