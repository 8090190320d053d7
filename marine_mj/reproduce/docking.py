"""The docking study's result tables (7.12 to 7.17, 8.9 to 8.16) as data."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from marine_mj.errors import AnalysisError

#: Scenario that all configurations change.
SCENARIO = "docking_thesis"
#: Longest run of the study: 120 s, with the waiting strategy 300 s (digest 7.0).
_SHORT, _LONG = 120.0, 300.0


@dataclass(frozen=True)
class Configuration:
    """What flies: controller, prediction, waiting, navigation.

    Attributes:
        name: of its folder and in the figures.
        changes: of the scenario `SCENARIO`, by dotted key.
    """

    name: str
    changes: dict[str, Any]

    @property
    def structure(self) -> str:
        """Configurations of one structure differ in numbers only: they can share a batch."""
        prediction = dict(self.changes.get(_PREDICTION, {}), t_pred=None)
        navigation = self.changes.get(f"{_NAVIGATION}.kind")
        return f"{self.changes['task.settings.controller']}, {prediction}, {navigation}"


@dataclass(frozen=True)
class Row:
    """One line of a published table: maximum operational sea states.

    Attributes:
        table: number in the study.
        line: of the study's text, for the digest.
        label: the line's name in the table.
        configuration: name in `CONFIGURATIONS`.
        surge, pitch, energy, total: highest sea state; None: not even the lowest ("-").
        uptime: %.
        first, last: sea states of the table's campaign.
        printed: values that the study misprints, by column: they contradict its own columns.
    """

    table: str
    line: int
    label: str
    configuration: str
    surge: int | None
    pitch: int | None
    energy: int | None
    total: int | None
    uptime: float
    first: int
    last: int
    printed: dict[str, float] = field(default_factory=dict)

    @property
    def noise(self) -> str | None:
        """Scenario of the navigation; None: perfect."""
        changes = CONFIGURATIONS[self.configuration].changes
        return changes.get(f"{_NAVIGATION}.scenario")

    def published(self, column: str) -> float | None:
        """Corrected value of a column: surge, pitch, energy, total or uptime (%)."""
        return {
            "surge": self.surge,
            "pitch": self.pitch,
            "energy": self.energy,
            "total": self.total,
            "uptime": self.uptime,
        }[column]


def _controller(name: str, gains: str) -> dict[str, Any]:
    """Changes for a controller and a gain set."""
    return {"task.settings.controller": name, "task.settings.gains": gains}


_BRUTE = _controller("pose_pid", "brute_force")
_CASCADES = {"cpv": _controller("cpv", "reference"), "cpva": _controller("cpva", "reference")}
_PREDICTION = "task.settings.prediction"
_NAVIGATION = "task.settings.navigation"
_WAIT = "task.settings.plan.wait_speed"
#: Scenario of the navigation by the name of a line (digest 5.2); None: perfect.
_PERIODS = {f"t_z {t} s": "base" if t == "0.2" else f"period_{float(t):g}"
            for t in ("2.0", "1.0", "0.5", "0.2", "0.1", "0.04")}  # fmt: skip
_FIXES = {"pose and velocity best": "fix_best", "base": "base",
          "pose and velocity worst": "fix_worst"}  # fmt: skip
_ACCELERATIONS = {"acceleration best": "acceleration_best", "base": "base",
                  "acceleration worst": "acceleration_worst"}  # fmt: skip


def _configurations() -> dict[str, Configuration]:
    """All configurations by name."""
    wait_1 = {**_CASCADES["cpv"], _WAIT: 1.0, "duration": _LONG}
    found: dict[str, dict[str, Any]] = {
        "manual": _controller("pose_pid", "manual") | {"duration": _SHORT},
        "brute_force": {**_BRUTE, "duration": _SHORT},
        **{name: {**changes, "duration": _SHORT} for name, changes in _CASCADES.items()},
    }
    for ahead in (0.4, 1.0, 2.0):
        prediction = {"kind": "kinematic", "of": "both", "t_pred": ahead}
        found[f"kinematic_{ahead:g}"] = {**found["brute_force"], _PREDICTION: prediction}
    # The best of table 7.8: samples of 0.03 and 0.04 s, 0.90 and 0.20 s ahead.
    for order, past, ahead in ((1, 0.03, 0.9), (2, 0.04, 0.2)):
        prediction = {
            "kind": "polynomial", "of": "both", "order": order, "t_past": past, "t_pred": ahead,
        }  # fmt: skip
        found[f"polynomial_{order}"] = {**found["brute_force"], _PREDICTION: prediction}
    for name, changes in {"brute_force": _BRUTE, **_CASCADES}.items():
        found[f"{name}_wait_any"] = {**changes, "duration": _LONG}
        for speed in (0.5, 0.7, 1.0):
            found[f"{name}_wait_{speed}"] = {**changes, _WAIT: speed, "duration": _LONG}
    for kind in dict.fromkeys((*_PERIODS.values(), *_FIXES.values(), *_ACCELERATIONS.values())):
        navigation = {f"{_NAVIGATION}.kind": "thesis", f"{_NAVIGATION}.scenario": kind}
        found[f"brute_force_{kind}"] = {**found["brute_force"], **navigation}
        # The study did not fly this one.
        if kind != "period_2":
            found[f"cpv_wait_1.0_{kind}"] = {**wait_1, **navigation}
    return {name: Configuration(name, changes) for name, changes in found.items()}


#: By name.
CONFIGURATIONS = _configurations()

_Values = tuple[int | None, int | None, int | None, int | None, float]


def _table(
    table: str, line: int, first: int, last: int, entries: Iterable[tuple[str, str, _Values]]
) -> list[Row]:
    """Rows of a table whose first one stands in a line of the study's text."""
    return [
        Row(table, line + i, label, configuration, *values, first, last)
        for i, (label, configuration, values) in enumerate(entries)
    ]


def _waiting(table: str, line: int, name: str, values: Iterable[_Values]) -> list[Row]:
    """Rows of a table of the waiting strategy."""
    speeds = ("any", "0.5", "0.7", "1.0")
    labels = [f"{speed} m/s" if speed != "any" else "any" for speed in speeds]
    names = [f"{name}_wait_{speed}" for speed in speeds]
    return _table(table, line, 1, 12, zip(labels, names, values, strict=True))


def _navigation(
    table: str, line: int, flown: str, scenarios: dict[str, str], values: Iterable[_Values]
) -> list[Row]:
    """Rows of a table of navigation: perfect, then the scenarios."""
    labels = ("perfect", *scenarios)
    names = (flown, *(f"{flown}_{kind}" for kind in scenarios.values()))
    return _table(table, line, 0, 8, zip(labels, names, values, strict=True))


def _corrected(row: Row, **printed: float) -> Row:
    """A row with what the study misprints."""
    return Row(**{**row.__dict__, "printed": printed})


def _rows() -> list[Row]:
    """All lines, in the study's order."""
    found = [
        *_table("7.12", 2573, 1, 12, [
            ("manual pose", "manual", (2, 5, 4, 2, 14.8)),
            ("brute-force pose", "brute_force", (6, 8, 6, 6, 82.7)),
            ("CPV", "cpv", (6, 8, 5, 5, 59.4)),
            ("CPVA", "cpva", (7, 8, 6, 6, 82.7)),
        ]),
        *_table("7.13", 2591, 1, 12, [
            ("kinematic 0.0 s", "brute_force", (6, 8, 6, 6, 82.7)),
            ("kinematic 0.4 s", "kinematic_0.4", (6, 8, 7, 6, 82.7)),
            ("kinematic 1.0 s", "kinematic_1", (6, 9, 7, 6, 82.7)),
            ("kinematic 2.0 s", "kinematic_2", (5, 6, 7, 5, 59.4)),
        ]),
        *_table("7.14", 2613, 1, 12, [
            ("no prediction", "brute_force", (6, 8, 6, 6, 82.7)),
            ("polynomial, first order", "polynomial_1", (6, 9, 6, 6, 82.7)),
            ("polynomial, second order", "polynomial_2", (7, 8, 6, 6, 82.7)),
        ]),
        *_waiting("7.15", 2630, "brute_force", [
            (6, 8, 6, 6, 82.7), (5, 5, 5, 5, 59.4), (6, 6, 6, 6, 82.7), (8, 6, 6, 6, 82.7),
        ]),
        *_waiting("7.16", 2647, "cpv", [
            (6, 8, 5, 5, 59.4), (5, 5, 5, 5, 59.4), (7, 7, 7, 7, 93.6), (8, 7, 7, 7, 93.6),
        ]),
        *_waiting("7.17", 2661, "cpva", [
            (7, 8, 6, 6, 82.7), (6, 6, 6, 6, 82.7), (7, 6, 6, 6, 82.7), (7, 7, 7, 7, 93.6),
        ]),
        *_navigation("8.9", 3163, "brute_force", _PERIODS, [
            (6, 8, 6, 6, 82.7), (None, 0, 0, None, 0.0), (None, 6, 6, None, 0.0),
            (None, 6, 4, None, 0.0), (4, 8, 6, 4, 36.7), (6, 6, 6, 6, 82.7), (5, 8, 6, 5, 59.4),
        ]),
        *_navigation(
            "8.10", 3184, "cpv_wait_1.0",
            {label: kind for label, kind in _PERIODS.items() if kind != "period_2"}, [
            (8, 7, 7, 7, 93.6), (None, 7, 7, None, 0.0), (None, 6, 7, None, 0.0),
            (5, 6, 7, 5, 59.4), (6, 7, 7, 6, 82.7), (8, 8, 8, 8, 98.3),
        ]),
        *_navigation("8.12", 3215, "brute_force", _FIXES, [
            (6, 8, 6, 6, 82.7), (5, 8, 5, 5, 59.4), (4, 5, 5, 4, 36.7), (None, None, 2, None, 0.0),
        ]),
        *_navigation("8.13", 3233, "cpv_wait_1.0", _FIXES, [
            (8, 7, 7, 7, 93.6), (7, 7, 7, 7, 93.6), (4, 6, 6, 4, 36.7), (None, None, 6, None, 0.0),
        ]),
        *_navigation("8.15", 3262, "brute_force", _ACCELERATIONS, [
            (6, 8, 6, 6, 82.7), (4, 6, 5, 4, 36.7), (4, 8, 5, 4, 36.7), (2, 8, 5, 2, 14.8),
        ]),
        *_navigation("8.16", 3280, "cpv_wait_1.0", _ACCELERATIONS, [
            (8, 7, 7, 7, 93.6), (5, 6, 7, 5, 59.4), (4, 6, 6, 4, 36.7), (0, 7, 6, 0, 0.0),
        ]),
    ]  # fmt: skip
    misprints = {2630: {"total": 5.0}, 3262: {"total": 5.0, "uptime": 59.4}}
    return [_corrected(r, **misprints[r.line]) if r.line in misprints else r for r in found]


#: Rows by number of the table.
TABLES: dict[str, list[Row]] = {}
for _row in _rows():
    TABLES.setdefault(_row.table, []).append(_row)


def rows_of(tables: Iterable[str] | None = None) -> list[Row]:
    """Rows of the named tables in the study's order; None: of all.

    Raises:
        AnalysisError: there is no such table, or none is named.
    """
    wanted = list(TABLES) if tables is None else [name.strip() for name in tables]
    unknown = [name for name in wanted if name not in TABLES]
    if unknown or not wanted:
        raise AnalysisError(
            f"table {', '.join(map(repr, unknown)) or '(none)'} is not among those of the docking "
            f"study; there are {', '.join(TABLES)}"
        )
    return [row for table, rows in TABLES.items() if table in wanted for row in rows]
