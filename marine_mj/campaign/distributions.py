"""Random distributions of factors, by name and parameters."""

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from scipy import stats

#: Largest and smallest uniform number: quantiles stay finite.
_EDGE = 2.0**-53

_BUILD: dict[str, tuple[tuple[str, ...], Callable[..., Any]]] = {
    "uniform": (("low", "high"), lambda low, high: stats.uniform(low, high - low)),
    "normal": (("mean", "std"), lambda mean, std: stats.norm(mean, std)),
    "truncated_normal": (
        ("mean", "std", "low", "high"),
        lambda mean, std, low, high: stats.truncnorm(
            (low - mean) / std, (high - mean) / std, mean, std
        ),
    ),
    "lognormal": (("median", "sigma"), lambda median, sigma: stats.lognorm(sigma, scale=median)),
    "gamma": (("shape", "scale"), lambda shape, scale: stats.gamma(shape, scale=scale)),
    "integers": (("low", "high"), lambda low, high: stats.randint(low, high + 1)),
}


def quantile(name: str, parameters: Mapping[str, Any]) -> Callable[[float], Any]:
    """The function from a uniform number in [0, 1) to a value of the distribution.

    Args:
        name: `uniform` (low, high), `normal` (mean, std), `truncated_normal` (mean, std, low,
            high), `lognormal` (median, sigma of the logarithm), `gamma` (shape, scale), `integers`
            (low, high; both included), `choice` (values, optionally weights), or any other
            distribution of scipy.stats with scipy's own arguments.
        parameters: by these names.

    Raises:
        ValueError: unknown name, missing or unknown parameter, or one that is not allowed.
    """
    if name == "choice":
        return _choice(parameters)
    given = ", ".join(f"{k} = {v!r}" for k, v in parameters.items()) or "none"
    frozen = _frozen(name, parameters, given)
    if not all(math.isfinite(float(frozen.ppf(u))) for u in (_EDGE, 0.5, 1 - _EDGE)):
        raise ValueError(
            f"distribution {name!r} has no values with the parameters {given}: widths and scales "
            "must be > 0, low < high"
        )
    whole = isinstance(frozen.dist, stats.rv_discrete)

    def value(u: float) -> Any:
        drawn = float(frozen.ppf(min(max(u, _EDGE), 1 - _EDGE)))
        return round(drawn) if whole else drawn

    return value


def value_type(name: str, parameters: Mapping[str, Any]) -> list[Any]:
    """Examples of the values of a valid distribution, from which a column's type follows."""
    if name == "choice":
        return list(parameters["values"])
    return [quantile(name, parameters)(0.5)]


def _frozen(name: str, parameters: Mapping[str, Any], given: str) -> Any:
    """The scipy distribution with its parameters."""
    if name in _BUILD:
        wanted, build = _BUILD[name]
        if set(parameters) != set(wanted):
            raise ValueError(
                f"distribution {name!r} takes the parameters {', '.join(wanted)}; given: {given}"
            )
    else:
        build = getattr(stats, name, None)  # type: ignore[assignment]
        if not isinstance(build, stats.rv_continuous | stats.rv_discrete):
            raise ValueError(
                f"distribution {name!r} does not exist; there are {', '.join(_BUILD)}, choice, and "
                "those of scipy.stats with their arguments there"
            )
    try:
        return build(**{key: _number(key, value) for key, value in parameters.items()})
    except TypeError as error:
        raise ValueError(f"distribution {name!r} (scipy.stats), given {given}: {error}") from None
    except ZeroDivisionError:
        raise ValueError(f"distribution {name!r}: std = 0 is not allowed, > 0 is") from None


def _number(key: str, value: Any) -> float:
    """A parameter, if it is a finite number."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ValueError(f"parameter {key} = {value!r} is not a finite number")
    return value


def _choice(parameters: Mapping[str, Any]) -> Callable[[float], Any]:
    """Quantile function of a choice between given values."""
    values = parameters.get("values")
    if not isinstance(values, list) or not values or not set(parameters) <= {"values", "weights"}:
        raise ValueError("distribution 'choice' takes values = [...] and, if wanted, weights")
    weights = parameters.get("weights", [1.0] * len(values))
    good = isinstance(weights, list) and len(weights) == len(values)
    if not good or min(_number("weights", w) for w in weights) < 0 or sum(weights) <= 0:
        raise ValueError(
            f"weights = {weights!r} must be {len(values)} numbers >= 0 of which one is > 0"
        )
    edges = np.cumsum(weights) / np.sum(weights)

    def value(u: float) -> Any:
        return values[min(int(np.searchsorted(edges, u, side="right")), len(values) - 1)]

    return value
