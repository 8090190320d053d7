"""One line of the validation: a measured number beside the one it should be."""

import math
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Row:
    """A measured value, what it should be, and how far it may be off.

    Attributes:
        name: unique name of the case.
        measured: our value.
        expected: value of the source or the closed form.
        tolerance: largest allowed |measured - expected|, same unit.
        unit: "1" for ratios.
        source: where the expected value comes from.
    """

    name: str
    measured: float
    expected: float
    tolerance: float
    unit: str
    source: str

    @property
    def ok(self) -> bool:
        """Whether the measured value lies within the tolerance."""
        return bool(abs(self.measured - self.expected) <= self.tolerance)

    def as_dict(self) -> dict[str, float | str | bool | None]:
        """The row as docs/contracts.md lists it; a value that is not finite is None."""
        numbers = {
            key: float(value) if math.isfinite(value) else None
            for key, value in (
                ("measured", self.measured),
                ("expected", self.expected),
                ("tolerance", self.tolerance),
            )
        }
        return {
            "name": self.name,
            **numbers,
            "unit": self.unit,
            "source": self.source,
            "ok": self.ok,
        }


def row(
    name: str,
    measured: Any,
    expected: Any,
    unit: str,
    source: str,
    *,
    within: float | None = None,
    percent: float | None = None,
) -> Row:
    """A row with an absolute tolerance (`within`) or one in percent of the expected value."""
    tolerance = within if within is not None else abs(expected) * (percent or 0.0) / 100
    return Row(name, float(measured), float(expected), float(tolerance), unit, source)
