"""Refusals shared by the estimates."""

import math

from marine_mj.errors import ModelError


def positive(**values: float) -> None:
    """Raise a ModelError for the first value that is not finite and above zero."""
    for name, value in values.items():
        if not (math.isfinite(value) and value > 0):
            raise ModelError(f"{name} = {value} is not allowed, it must be finite and above 0")


def not_negative(**values: float) -> None:
    """Raise a ModelError for the first value that is not finite and at least zero."""
    for name, value in values.items():
        if not (math.isfinite(value) and value >= 0):
            raise ModelError(f"{name} = {value} is not allowed, it must be finite and at least 0")
