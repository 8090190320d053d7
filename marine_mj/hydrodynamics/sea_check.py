"""Whether a wave database holds what a given sea asks of it: frequencies, depth, directions."""

import warnings

import numpy as np

from marine_mj.environment import Environment, WaveField, wavenumber
from marine_mj.errors import MarineMjWarning, ModelError
from marine_mj.frames import Array
from marine_mj.hydrodynamics.raos import coarse_directions, database_path, read_responses
from marine_mj.hydrodynamics.wave_file import UNSTATED_DENSITY, facts

#: Share of the sea's energy that the file may miss: above the first a warning, above the second an
#: error.
WARN, REFUSE = 0.01, 0.10
#: k R at the lowest frequency of a file (R: radius of the hull), below which still lower ones are
#: long waves, whose response needs no table (ours: at the USV box loads there differ from their
#: limit by 4 % in heave and less in other axes).
LONG = 0.1
#: k h from which the bottom is not felt.
DEEP = np.pi
#: Relative difference of densities or gravities that is told.
_DIFFERENT = 1e-3


def missed_energy(name: str, response: str, waves: WaveField) -> tuple[float, Array]:
    """Share of the sea's energy for which a database has no response; its omega (n,), rad/s.

    Missed are components above the highest frequency: there the response is zero. Components below
    the lowest one get the limit of long waves (`raos.LONG_WAVES`). They count as missed only where
    waves of that lowest frequency are not long beside the hull, or its size is not known.

    Args:
        name: wave database.
        response: see `raos.responses`.
        waves: the sea.
    """
    path = database_path(name)
    omega = read_responses(path, response, getattr(name, "hull_symmetry", None))[0]
    energy = waves.amplitude**2
    missed = waves.omega > omega[-1] * (1 + 1e-9)
    radius = facts(path).radius
    k = float(wavenumber(omega[0], waves.depth, waves.gravity))
    if radius is None or k * radius > LONG:
        missed |= waves.omega < omega[0] * (1 - 1e-9)
    return float(energy[missed].sum() / max(energy.sum(), 1e-300)), omega


def check_sea(body: str, name: str, response: str, environment: Environment) -> None:
    """Tell what a database lacks in this sea.

    Warns where it misses over 1 % of the sea's energy, is of another depth, gravity or an unknown
    density, or has directions too coarse for its frequencies.

    Args:
        body: name of the body, for messages.
        name: its wave database.
        response: that is used, see `raos.responses`.
        environment: sea and water.

    Raises:
        ModelError: the database misses over 10 % of the sea's energy, or see `read_responses`.
    """
    waves = environment.waves
    if not len(waves.omega) or not waves.amplitude.any():
        return
    _check_energy(body, name, response, waves)
    _check_water(body, name, environment)
    check_directions(body, name, response)


def check_directions(body: str, name: str, response: str) -> None:
    """Warn where the directions of a database are too coarse; arguments as in `check_sea`."""
    coarse = coarse_directions(name, response)
    if coarse:
        _warn(f"wave database of {body!r}: {coarse}")


def _warn(message: str) -> None:
    """A warning that points at the caller of the loader at least roughly."""
    warnings.warn(message, MarineMjWarning, stacklevel=4)


def _check_energy(body: str, name: str, response: str, waves: WaveField) -> None:
    """The part of `check_sea` on frequencies."""
    share, omega = missed_energy(name, response, waves)
    if share <= WARN:
        return
    energetic = waves.omega[waves.amplitude > 0]
    message = (
        f"the wave database {database_path(name).name} of {body!r} goes from {omega[0]:.3g} to "
        f"{omega[-1]:.3g} rad/s, the sea from {energetic.min():.3g} to {energetic.max():.3g}: "
        f"{100 * share:.3g} % of the sea's energy lies outside and does not act"
    )
    if share > REFUSE:
        raise ModelError(
            f"{message}, allowed are {100 * REFUSE:.0f} %: compute the database for the "
            "frequencies of the sea (marine-mj hydro --omega), or choose another sea"
        )
    _warn(message)


def _check_water(body: str, name: str, environment: Environment) -> None:
    """The part of `check_sea` on depth, gravity and density."""
    path = database_path(name)
    about, waves = facts(path), environment.waves
    if about.depth is not None and about.depth != waves.depth:
        energy = np.cumsum(waves.amplitude[order := np.argsort(waves.omega)] ** 2)
        longest = waves.omega[order][int(np.searchsorted(energy, WARN * energy[-1]))]
        shallow = min(about.depth, waves.depth)
        if float(wavenumber(longest, shallow, waves.gravity)) * shallow < DEEP:
            _warn(
                f"the wave database {path.name} of {body!r} is for a depth of {about.depth:g} m, "
                f"the sea is {waves.depth:g} m deep, and its waves feel the bottom: wave loads, "
                "added mass and damping are those of the file's depth; compute one for this depth "
                "(marine-mj hydro --depth)"
            )
    if about.gravity and abs(about.gravity / environment.gravity - 1) > _DIFFERENT:
        _warn(
            f"the wave database {path.name} of {body!r} is for g = {about.gravity:g} m/s2, the "
            f"environment has {environment.gravity:g}: its loads are not converted"
        )
    if about.density is None and abs(environment.water_density / UNSTATED_DENSITY - 1) > _DIFFERENT:
        _warn(
            f"the wave database {path.name} of {body!r} does not state its density, taken is "
            f"{UNSTATED_DENSITY:g} kg/m3 (the environment has {environment.water_density:g}): "
            "give the file the attribute water_density"
        )
