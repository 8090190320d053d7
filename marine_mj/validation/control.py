"""Controller cases: the published tuning scenario, and docking in a seaway."""

from collections.abc import Iterator
from typing import Any

from marine_mj.scenario import Scenario
from marine_mj.simulation import run_batch
from marine_mj.tuning import station_errors
from marine_mj.validation.rows import Row, row

#: Sums of the errors in table 7.9 of the docking study, and the settings of each line.
_TABLE: dict[str, tuple[float, dict[str, Any]]] = {
    "manual pose": (2.05, {"gains": "manual"}),
    "brute-force pose": (1.31, {"gains": "brute_force"}),
    "CPV": (1.37, {"controller": "cpv", "gains": "reference"}),
    "CPVA": (1.12, {"controller": "cpva", "gains": "reference"}),
    "kinematic prediction": (1.05, {"prediction": {"kind": "kinematic", "t_pred": 0.4}}),
    "polynomial prediction": (
        1.07,
        {"prediction": {"kind": "polynomial", "order": 1, "t_past": 0.03, "t_pred": 0.9}},
    ),
}


def tuning_scenario() -> Iterator[Row]:
    """Sums of six rms errors in the tuning scenario of the docking study (25 %: digest V31)."""
    variations = [
        {f"task.settings.{key}": value for key, value in changes.items()}
        for _, changes in _TABLE.values()
    ]
    sums = station_errors("docking_tuning", variations).sum(axis=(1, 2))
    for (name, (published, _)), found in zip(_TABLE.items(), sums, strict=True):
        yield row(
            f"tuning scenario, {name}, sum of rms errors", found, published, "m, rad, m/s, rad/s",
            "docking digest table 7.9", percent=25,
        )  # fmt: skip


def docking_in_a_seaway() -> Iterator[Row]:
    """Latched runs of 10 in sea state 4 with our gains of every controller."""
    base = Scenario.load("docking_demo").with_values({"duration": 90.0})
    for name in ("cpv", "cpva", "lqr", "sliding", "mpc"):
        chosen = {"task.settings.controller": name, "task.settings.gains": "extended"}
        rows = run_batch(base, [{"seed": seed, **chosen} for seed in range(21, 31)]).rows
        docked = sum(bool(r.get("docked")) for r in rows)
        yield row(f"docking, {name}, sea state 4, latched of 10", docked, 10, "1",
                  "requirement", within=0.5)  # fmt: skip
        hit = sum(bool(r.get("forbidden_contact")) for r in rows)
        yield row(f"docking, {name}, sea state 4, forbidden contacts", hit, 0, "1",
                  "requirement", within=0.5)  # fmt: skip


CASES = (tuning_scenario, docking_in_a_seaway)
