"""Errors that marine_mj raises: each names the thing, its value, what is allowed and the fix."""

from typing import Any


class MarineMjError(Exception):
    """Base of every error that marine_mj raises on purpose."""


class MarineMjWarning(UserWarning):
    """Something can be simulated as given, but not as exactly as it looks."""


class ModelError(MarineMjError):
    """A vehicle, scene or its coefficients cannot be simulated as given."""


class ScenarioError(MarineMjError):
    """A scenario, campaign or controller setting is not valid."""


class CampaignError(MarineMjError):
    """A campaign cannot be started, gone on with or read as it stands."""


class SeaError(MarineMjError):
    """A sea, current or wind description is not valid."""


class SimulationError(MarineMjError):
    """A running simulation left the range where its numbers mean anything.

    Attributes:
        log: what was recorded until then (`simulation.Log`), None outside `simulation.run`.
    """

    log: Any = None


class LogError(MarineMjError):
    """A log file cannot be read or does not hold what was asked for."""


class RenderError(MarineMjError):
    """Pictures cannot be made on this machine as it is."""


class AnalysisError(MarineMjError):
    """Samples or settings of a statistical analysis do not allow the answer asked for."""
