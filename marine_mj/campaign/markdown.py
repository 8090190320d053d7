"""Tables of a report as Markdown."""

from collections.abc import Iterable, Sequence
from typing import Any


def markdown(found: dict[str, Any]) -> str:
    """The page of a report (`marine_mj.campaign.report.report`)."""
    whole = found["success"]
    parts = [
        f"# Campaign {found['campaign']}",
        f"Scenario {found['scenario']}: {found['runs']} of {found['planned']} runs, "
        f"{found['errors']} ended with an error. Success in {whole['successes']}: probability "
        f"{shown(whole['probability'])}, 95 % Wilson interval {shown(whole['low'])} to "
        f"{shown(whole['high'])}.",
        "## Success by cell",
        table(
            ["cell", *_names(found), "runs", "successes", "probability", "low", "high", "errors"],
            (
                [
                    *(c["cell"], *c["factors"].values(), c["n"], c["successes"]),
                    *(c["probability"], c["low"], c["high"], c["errors"]),
                ]
                for c in found["cells"]
            ),
        ),
    ]
    metrics = list(found["cells"][0]["metrics"])
    for metric in metrics:
        columns = ["n", "mean", "mean_low", "mean_high", "std", "min", "median", "q95", "max"]
        rows = [
            [c["cell"], *(c["metrics"][metric].get(k) for k in columns)] for c in found["cells"]
        ]
        parts += [f"## {metric}", table(["cell", *columns], rows)]
        fitted = [
            [c["cell"], kind, *_fit(c["metrics"][metric][kind])]
            for c in found["cells"]
            for kind in ("normal", "gamma")
            if kind in c["metrics"][metric]
        ]
        if fitted:
            heads = ["cell", "fit", "parameters", "95 % from", "to"]
            parts.append(table(heads, fitted))
    parts += _effects(found["effects"])
    if found["failures"]:
        rows = [[f["run"], f["cell"], f["reason"]] for f in found["failures"]]
        parts += ["## Runs without success", table(["run", "cell", "reason"], rows)]
    parts += [f"![{name}]({name})" for name in found["figures"]]
    return "\n\n".join(parts) + "\n"


def _effects(found: Sequence[dict[str, Any]]) -> list[str]:
    """Tables of the factors' effects."""
    crossed = [
        [e["factor"], e["output"], level["level"], level["mean"], level["effect"], e["share"]]
        for e in found
        for level in e.get("levels", ())
    ]
    random = [
        [e["factor"], e["output"], e["n"], e["correlation"], e["p_value"]]
        for e in found
        if "correlation" in e
    ]
    parts = []
    if crossed:
        heads = ["factor", "output", "level", "mean", "effect", "share of variance"]
        parts += ["## Effects of levels", table(heads, crossed)]
    if random:
        heads = ["factor", "output", "n", "rank correlation", "p"]
        parts += ["## Effects of random factors", table(heads, random)]
    return parts


def _names(found: dict[str, Any]) -> list[str]:
    """Names of the crossed factors."""
    return list(found["cells"][0]["factors"])


def _fit(fit: dict[str, Any]) -> list[Any]:
    """Parameters and interval of a fit."""
    parameters = ", ".join(f"{k} {shown(v)}" for k, v in fit.items() if k not in ("low", "high"))
    return [parameters, fit["low"], fit["high"]]


def table(heads: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """A table with these heads."""
    lines = [heads, ["---"] * len(heads), *([shown(v) for v in row] for row in rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def shown(value: Any) -> str:
    """A value as text for one cell of a table; None is empty."""
    if value is None:
        return ""
    text = f"{value:.4g}" if isinstance(value, float) else str(value)
    return " ".join(text.replace("|", "\\|").split())
