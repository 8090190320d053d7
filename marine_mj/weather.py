"""From a scenario's settings to the frozen environment of one run."""

from typing import Any

import numpy as np

from marine_mj.environment import (
    Current,
    Environment,
    WaveField,
    Wind,
    calm,
    fluctuating_current,
    gaussian_sea,
    gusty_wind,
    irregular_sea,
    regular_wave,
    sea_state,
    steady_wind,
)
from marine_mj.frames import Array
from marine_mj.scenario import Scenario, Sea

#: Levels of a power-law current profile: dense where it bends.
_PROFILE_LEVELS = 12


def environment_of(scenario: Scenario, margin: float = 0.0) -> Environment:
    """Waves, current and wind of a scenario, drawn from its seed.

    Args:
        scenario: validated scenario.
        margin: time beyond the scenario's duration for which series are drawn, s.

    Raises:
        SeaError: the sea is steeper than waves can be.
    """
    seeds = np.random.SeedSequence(scenario.seed).spawn(3)
    duration = scenario.duration + margin
    return Environment(
        waves=_waves(scenario.sea, seeds[0]),
        current=_current(scenario, duration, seeds[1]),
        wind=_wind(scenario, duration, seeds[2]),
        water_density=scenario.water_density,
    )


def significant_height(sea: Sea) -> tuple[float, float]:
    """Significant height (m) and peak period (s) that a sea asks for; zeros when calm."""
    if sea.spectrum == "none" or sea.sea_state == 0:
        return 0.0, 0.0
    if sea.spectrum == "regular":
        if sea.height is not None and sea.period is not None:
            return sea.height, sea.period
        # A regular wave of sea state n has H = H_s and T = mean period (digest 4.2).
        state = sea_state(sea.sea_state or 0)
        return state.H_s, state.mean_period
    if sea.sea_state is not None:
        state = sea_state(sea.sea_state)
        return state.H_s, state.T_p
    return sea.significant_wave_height or 0.0, sea.peak_period or 0.0


def _waves(sea: Sea, seed: np.random.SeedSequence) -> WaveField:
    """Wave field of the settings."""
    depth = np.inf if sea.depth is None else sea.depth
    direction = _direction(sea.direction_deg)
    height, period = significant_height(sea)
    if height == 0.0:
        return calm(depth)
    if sea.spectrum == "regular":
        return regular_wave(height, period, direction, depth=depth, stretching=sea.stretching)
    shape: dict[str, Any] = {
        "direction": direction,
        "spectrum": sea.spectrum,
        "gamma": sea.peak_enhancement,
        "seed": seed,
        "sampling": sea.frequency_sampling,
        "spreading": sea.spreading,
        "depth": depth,
        "stretching": sea.stretching,
    }
    if sea.normals is not None:
        return gaussian_sea(sea.normals, height, period or None, **shape)
    return irregular_sea(height, period or None, components=sea.components, **shape)


def _current(scenario: Scenario, duration: float, seed: np.random.SeedSequence) -> Current:
    """Current profile with its fluctuation."""
    settings = scenario.current
    surface = settings.speed * _unit(settings.direction_deg)
    levels, share = np.zeros(1), np.ones(1)
    if settings.profile == "power":
        share = np.linspace(0.0, 1.0, _PROFILE_LEVELS)
        levels = settings.profile_depth * (share**7 - 1.0)
    velocity = share[:, None] * surface
    if settings.fluctuation == 0.0:
        return Current(levels, velocity)
    return fluctuating_current(
        velocity,
        settings.fluctuation,
        settings.time_constant,
        duration,
        levels=levels,
        seed=seed,
    )


def _wind(scenario: Scenario, duration: float, seed: np.random.SeedSequence) -> Wind:
    """Steady or gusty wind."""
    settings = scenario.wind
    exponent = settings.height_exponent
    direction = _direction(settings.direction_deg)
    if settings.gusts and settings.speed > 0:
        return gusty_wind(settings.speed, direction, duration, seed=seed, height_exponent=exponent)
    return steady_wind(settings.speed, direction, height_exponent=exponent)


def _direction(direction_deg: float) -> float:
    """NWU direction of travel [rad, counter-clockwise] of a compass direction [deg]."""
    return -np.deg2rad(direction_deg)


def _unit(direction_deg: float) -> Array:
    """Unit vector (3,) NWU of a compass direction [deg]."""
    angle = _direction(direction_deg)
    return np.array([np.cos(angle), np.sin(angle), 0.0])
