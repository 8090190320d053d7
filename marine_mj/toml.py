"""TOML text of nested dictionaries (the standard library only reads it), and values as texts."""

import json
import math
import tomllib
from collections.abc import Iterable
from typing import Any

from marine_mj.errors import ScenarioError


def dump(values: dict[str, Any]) -> str:
    """TOML text of a nested dictionary; entries that are None are left out."""
    return "\n".join(_table(values, ())).strip() + "\n"


def value(text: str) -> Any:
    """The value that a text is in TOML, else the text."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text


def assignments(pairs: Iterable[str]) -> dict[str, Any]:
    """Values by dotted key of KEY=VALUE texts; values as in TOML, else plain text.

    Raises:
        ScenarioError: a text is not KEY=VALUE.
    """
    changes = {}
    for pair in pairs:
        key, separator, text = pair.partition("=")
        if not separator or not key:
            raise ScenarioError(f"--set {pair!r} is not KEY=VALUE, such as sea.sea_state=3")
        changes[key.strip()] = value(text)
    return changes


def _table(values: dict[str, Any], path: tuple[str, ...]) -> list[str]:
    """Lines of one table: its own keys first, then its tables."""
    plain = {k: v for k, v in values.items() if v is not None and not isinstance(v, dict)}
    lines = [f"{_key(k)} = {_value(v)}" for k, v in plain.items()]
    if path and (plain or not values):
        lines = ["", f"[{'.'.join(map(_key, path))}]", *lines]
    for key, value in values.items():
        if isinstance(value, dict):
            lines += _table(value, (*path, key))
    return lines


def _key(key: str) -> str:
    """A bare key where TOML allows it, else a quoted one."""
    bare = key.replace("_", "").replace("-", "")
    return key if bare.isalnum() and bare.isascii() else json.dumps(key)


def _value(value: Any) -> str:
    """One value on one line."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value)
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        if math.isfinite(value):
            return repr(value)
        return "nan" if math.isnan(value) else ("inf" if value > 0 else "-inf")
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_value(v) for v in value) + "]"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_key(k)} = {_value(v)}" for k, v in value.items()) + "}"
    raise TypeError(f"no TOML form for {type(value).__name__}: {value!r}")
