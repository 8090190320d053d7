"""Validated settings: a pydantic base whose errors name the key, the value and what is allowed."""

import difflib
import types
import typing
from typing import Any, Self

from pydantic import BaseModel, ConfigDict, ValidationError

from marine_mj.errors import ScenarioError


class Settings(BaseModel):
    """Base of all settings: unknown keys are refused, values do not change."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    @classmethod
    def parse(cls, values: dict[str, Any], where: str = "") -> Self:
        """Settings from plain values.

        Args:
            values: nested dictionary, as read from TOML.
            where: what the values belong to, for messages, such as `scenario demo.toml`.

        Raises:
            ScenarioError: a key is unknown or a value is not allowed; the message lists every
                problem with key, value and what is allowed.
        """
        try:
            return cls.model_validate(values)
        except ValidationError as error:
            raise ScenarioError(describe(error, cls, where)) from None

    def changed(self, **values: Any) -> Self:
        """A validated copy with some fields replaced."""
        return self.parse(self.model_dump() | values)


def describe(error: ValidationError, model: type[BaseModel], where: str = "") -> str:
    """One line per problem: key, value, what is allowed."""
    lines = []
    for problem in error.errors():
        location = [str(part) for part in problem["loc"]]
        key, value = ".".join(location) or "settings", problem["input"]
        if problem["type"] == "extra_forbidden":
            allowed = sorted(_fields(model, location[:-1]))
            near = difflib.get_close_matches(location[-1], allowed, 1)
            hint = f" Did you mean {near[0]!r}?" if near else ""
            lines.append(
                f"{key} = {value!r}: unknown key {location[-1]!r}.{hint} "
                f"Allowed here: {', '.join(allowed)}"
            )
        elif problem["type"] == "missing":
            lines.append(f"{key} is missing and has no default")
        elif problem["type"] in ("value_error", "assertion_error"):
            lines.append(f"{key}: {problem['ctx']['error']}" if location else _plain(problem))
        else:
            lines.append(f"{key} = {value!r}: {problem['msg'].lower()}")
    prefix = f"{where}: " if where else ""
    return prefix + ("; ".join(lines) if len(lines) == 1 else "\n  ".join(["", *lines]))


def _plain(problem: Any) -> str:
    """Message of a check over several fields."""
    return str(problem["ctx"]["error"])


def _fields(model: Any, location: list[str]) -> list[str]:
    """Field names of the (nested) settings at a location."""
    for part in location:
        model = _child(model, part)
        if model is None:
            return []
    return list(model.model_fields) if _is_settings(model) else []


def _child(model: Any, part: str) -> Any:
    """Type of the field or entry `part` of a settings class or a dictionary of them."""
    if _is_settings(model):
        field = model.model_fields.get(part)
        return None if field is None else _unwrap(field.annotation)
    if typing.get_origin(model) is dict:
        return _unwrap(typing.get_args(model)[1])
    return None


def _unwrap(annotation: Any) -> Any:
    """`X` of `X | None`; other annotations unchanged."""
    if typing.get_origin(annotation) in (typing.Union, types.UnionType):
        inner = [a for a in typing.get_args(annotation) if a is not type(None)]
        return inner[0] if len(inner) == 1 else annotation
    return annotation


def _is_settings(annotation: Any) -> bool:
    return isinstance(annotation, type) and issubclass(annotation, BaseModel)
