"""Named values of a run's row and conditions on them, such as `peak_contact_force < 5000`."""

import math
import operator
import re
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from marine_mj.errors import CampaignError

#: Functions that a metric may apply to its value.
TRANSFORMS: dict[str, Callable[[float], float]] = {
    "abs": abs,
    "rad2deg": math.degrees,
    "square": lambda value: value * value,
    "negate": operator.neg,
}

_COMPARE: dict[str, Callable[[Any, Any], bool]] = {
    "==": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}
_FORM = re.compile(r"\s*([A-Za-z_][\w.]*)\s*(==|!=|<=|>=|<|>)\s*(\S.*?)\s*")


@dataclass(frozen=True)
class Condition:
    """A comparison of a row's value with a constant.

    Attributes:
        key: name of a metric, or dotted key of the row.
        sign: ==, !=, <, <=, > or >=.
        value: number, text or truth value.
    """

    key: str
    sign: str
    value: bool | int | float | str

    @classmethod
    def parse(cls, text: str) -> "Condition":
        """The condition of a text `KEY SIGN VALUE`; the value is written as in TOML.

        Raises:
            ValueError: another form, or a value that cannot be compared so.
        """
        match = _FORM.fullmatch(text)
        try:
            if match is None:
                raise tomllib.TOMLDecodeError
            value = tomllib.loads(f"value = {match[3]}")["value"]
        except tomllib.TOMLDecodeError:
            raise ValueError(
                f"{text!r} is not of the form KEY SIGN VALUE, such as 'docked == true' or "
                f"'peak_contact_force < 5000'; signs: {', '.join(_COMPARE)}"
            ) from None
        ordered = match[2] not in ("==", "!=")
        number = isinstance(value, int | float) and not isinstance(value, bool)
        if not (number and math.isfinite(value)) and (ordered or not isinstance(value, bool | str)):
            raise ValueError(
                f"{text!r}: {match[3]} cannot be compared by {match[2]}; allowed are finite "
                'numbers and, with == and !=, true, false and "text"'
            )
        return cls(match[1], match[2], value)

    def holds(self, found: Any) -> bool:
        """Whether the row's value `found` fulfils the condition; a missing one never does."""
        if found is None or (isinstance(found, str) and self.sign not in ("==", "!=")):
            return False
        return bool(_COMPARE[self.sign](found, self.value))

    def __str__(self) -> str:
        shown = str(self.value).lower() if isinstance(self.value, bool) else repr(self.value)
        return f"{self.key} {self.sign} {shown}"


def look_up(row: Mapping[str, Any], key: str, what: str) -> Any:
    """The value of a dotted key; None when a table on the way to it is None.

    Args:
        row: of a run that ended without an error.
        key: such as `capture.pitch_error`.
        what: what asks for it, for the message.

    Raises:
        CampaignError: rows have no such key; the message lists those that they have.
    """
    value: Any = row
    for part in key.split("."):
        if value is None:
            return None
        if not isinstance(value, Mapping) or part not in value:
            raise CampaignError(
                f"{what} asks for {key!r}, which a run's results do not have; they have "
                f"{', '.join(keys(row))}. Correct the campaign file and start with a new --out"
            )
        value = value[part]
    return value


def keys(row: Mapping[str, Any], prefix: str = "") -> list[str]:
    """Dotted keys of the values of a row."""
    found: list[str] = []
    for key, value in row.items():
        if isinstance(value, Mapping):
            found += keys(value, f"{prefix}{key}.")
        else:
            found.append(f"{prefix}{key}")
    return found


def transformed(value: Any, transforms: Sequence[str], what: str) -> float | None:
    """A metric as a number: true is 1, false is 0, missing or not finite is None.

    Raises:
        CampaignError: the value is no number.
    """
    if value is None:
        return None
    if not isinstance(value, int | float):
        raise CampaignError(
            f"{what} is {value!r}; a metric has to be a number or a truth value. A text can stand "
            "in `success`, and is in the column `summary`"
        )
    number = float(value)
    for name in transforms:
        number = float(TRANSFORMS[name](number))
    return number if math.isfinite(number) else None
