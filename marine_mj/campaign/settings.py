"""Campaign files: what is varied, how often, what is measured and when it is enough."""

import re
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import Field, field_validator, model_validator

from marine_mj.campaign.conditions import TRANSFORMS, Condition
from marine_mj.campaign.distributions import quantile, value_type
from marine_mj.campaign.rare import COLUMNS, Rare
from marine_mj.settings import Settings
from marine_mj.settings_file import SettingsFile

#: Columns of the results that no factor or metric may be called.
RESERVED = (
    *("run", "cell", "replicate", "seed", "success", "failure", "error", "simulated_time"),
    *("wall_time", "summary", "scenario", "versions", "code", "git_revision"),
)


class Factor(Settings):
    """Something that is varied: exactly one of `grid`, `cases` and `distribution`.

    Attributes:
        key: dotted key of the scenario, such as `sea.sea_state`, or one number of a vector, such
            as `vehicles.auv.position_ned[2]`. Not with `cases`.
        grid: values, crossed with the other factors' values.
        cases: tables of several keys that change together, crossed as well; `label` names a case.
        distribution: name in `marine_mj.campaign.distributions.quantile`.
        parameters: of the distribution.
        sampling: "random", or "latin_hypercube": stratified over the runs of each cell.
    """

    key: str | None = None
    grid: Annotated[list[Any], Field(min_length=1)] | None = None
    cases: Annotated[list[dict[str, Any]], Field(min_length=1)] | None = None
    distribution: str | None = None
    parameters: dict[str, Any] = Field(default_factory=dict)
    sampling: Literal["random", "latin_hypercube"] = "random"

    @model_validator(mode="after")
    def _one_kind(self) -> "Factor":
        """Refuse a factor of no or of several kinds, and what does not belong to its kind."""
        kinds = [k for k in ("grid", "cases", "distribution") if getattr(self, k) is not None]
        if len(kinds) != 1:
            raise ValueError(
                "a factor has exactly one of grid, cases and distribution; given: "
                f"{', '.join(kinds) or 'none'}"
            )
        if (self.key is None) != (self.cases is not None):
            raise ValueError("grid and distribution need a key; the tables in cases name theirs")
        if self.key is not None and not re.fullmatch(r"[\w-]+(\.[\w-]+)*(\[\d+\])?", self.key):
            raise ValueError(
                f"key = {self.key!r} is not a dotted key such as sea.sea_state or "
                "vehicles.auv.position_ned[2]"
            )
        if self.distribution is not None:
            quantile(self.distribution, self.parameters)
        elif self.parameters or self.sampling != "random":
            raise ValueError("parameters and sampling belong to a distribution")
        levels = [repr(level) for level in self.levels]
        if len(set(levels)) < len(levels):
            raise ValueError(f"values stand twice: {', '.join(levels)}")
        return self

    @property
    def crossed(self) -> bool:
        """Whether the factor spans cells (grid, cases) rather than varying inside them."""
        return self.distribution is None

    @cached_property
    def levels(self) -> list[Any]:
        """What the column of a crossed factor shows: values of the grid, labels of the cases."""
        if self.cases is None:
            return self.grid or []
        return [
            str(case.get("label", ", ".join(f"{k}={v}" for k, v in self._changes(i).items())))
            for i, case in enumerate(self.cases)
        ]

    def changes(self, level: int) -> dict[str, Any]:
        """Values by dotted key at a level of a crossed factor."""
        if self.cases is None:
            return {str(self.key): self.levels[level]}
        return self._changes(level)

    def _changes(self, level: int) -> dict[str, Any]:
        assert self.cases is not None
        return flat({k: v for k, v in self.cases[level].items() if k != "label"})

    @property
    def keys(self) -> set[str]:
        """All dotted keys that the factor changes."""
        if self.cases is None:
            return {str(self.key)}
        return {key for i in range(len(self.cases)) for key in self._changes(i)}

    @property
    def examples(self) -> list[Any]:
        """Values of the factor's column, from which its type follows."""
        if self.distribution is not None:
            return value_type(self.distribution, self.parameters)
        return self.levels


class Metric(Settings):
    """A number taken from each run's results.

    Attributes:
        key: dotted key of the results, such as `capture.pitch_error`.
        transform: functions applied to it one after the other.
    """

    key: str
    transform: list[str] = Field(default_factory=list)

    @field_validator("transform", mode="before")
    @classmethod
    def _known(cls, value: Any) -> Any:
        """A single name is a list of one; refuse unknown names."""
        names = [value] if isinstance(value, str) else value
        for name in names if isinstance(names, list) else []:
            if name not in TRANSFORMS:
                raise ValueError(f"transform {name!r} does not exist; {', '.join(TRANSFORMS)} do")
        return names


class Record(Settings):
    """Trajectories to keep, one NetCDF file per chunk.

    Attributes:
        signals: names of log variables, such as `eta_ned`.
        decimation: keep every so manyth log entry.
    """

    signals: list[str] = Field(default_factory=list)
    decimation: Annotated[int, Field(ge=1)] = 1


class Stopping(Settings):
    """When it is enough: the interval of a metric is narrow in every cell.

    Attributes:
        metric: "success" (Wilson interval), or a metric (confidence interval of its mean).
        width: of the interval, upper minus lower end.
        confidence: of the interval.
        minimum: runs that each cell has at least.
        every: runs between two looks, a multiple of `chunk`; left out: `chunk`.
    """

    metric: str = "success"
    width: Annotated[float, Field(gt=0)]
    confidence: Annotated[float, Field(gt=0, lt=1)] = 0.95
    minimum: Annotated[int, Field(ge=2)] = 10
    every: Annotated[int, Field(ge=1)] | None = None


class Campaign(SettingsFile):
    """Everything that defines a campaign.

    Attributes:
        name: of the folder of its results.
        description: one line for lists.
        scenario: name of a packaged scenario or path of one, also relative to the campaign file.
        set: changes of it, by dotted key or as tables, that hold for all runs.
        runs: per cell; a cell is one combination of the crossed factors. Not with `rare`.
        seed: of the campaign; the runs' seeds follow from it and their numbers.
        common_seeds: the same seas and random factors in all cells, to compare these.
        chunk: runs that are done and written together.
        factors: by the name of their column.
        metrics: by the name of their column: a dotted key, or a table.
        success: conditions that all have to hold; a run that ends with an error is no success.
        record: trajectories to keep.
        stopping: when to stop before all runs are done.
        rare: search for the probability of a rare event instead of a number of runs.
    """

    kind: ClassVar[str] = "campaign"

    name: str
    description: str = ""
    scenario: str
    set: dict[str, Any] = Field(default_factory=dict)
    runs: Annotated[int, Field(ge=1)] | None = None
    seed: Annotated[int, Field(ge=0)] = 0
    common_seeds: bool = False
    chunk: Annotated[int, Field(ge=1, le=10_000)] = 10
    factors: dict[str, Factor] = Field(default_factory=dict)
    metrics: dict[str, Metric] = Field(default_factory=dict)
    success: list[str] = Field(default_factory=list)
    record: Record = Record()
    stopping: Stopping | None = None
    rare: Rare | None = None

    @field_validator("metrics", mode="before")
    @classmethod
    def _short_metrics(cls, value: Any) -> Any:
        """A metric that is only a key."""
        if not isinstance(value, dict):
            return value
        return {k: {"key": v} if isinstance(v, str) else v for k, v in value.items()}

    @field_validator("success")
    @classmethod
    def _conditions(cls, value: list[str]) -> list[str]:
        """Refuse texts that are no conditions."""
        for text in value:
            Condition.parse(text)
        return value

    @model_validator(mode="after")
    def _fits_together(self) -> "Campaign":
        """Refuse names that cannot be columns, keys given twice and a rule without its metric."""
        if not re.fullmatch(r"[A-Za-z0-9_][\w.-]*", self.name):
            raise ValueError(f"name = {self.name!r} is not allowed: letters, digits, _ - . only")
        for name in (*self.factors, *self.metrics):
            if not name.isidentifier() or name in RESERVED:
                raise ValueError(
                    f"column {name!r} is not allowed: letters, digits and _ only, and none of "
                    f"{', '.join(RESERVED)}"
                )
        if both := [name for name in self.factors if name in self.metrics]:
            raise ValueError(f"{', '.join(both)} is the name of a factor and of a metric")
        seen: dict[str, str] = {"seed": "the campaign's seed"}
        for name, factor in self.factors.items():
            for key in sorted(factor.keys):
                if key in seen:
                    raise ValueError(f"key {key!r} of factor {name!r} is set by {seen[key]} too")
                seen[key] = f"factor {name!r}"
        self._check_rare()
        rule = self.stopping
        if rule is not None and rule.metric not in ("success", *self.metrics):
            raise ValueError(
                f"stopping.metric = {rule.metric!r} does not exist; there are "
                f"{', '.join(('success', *self.metrics))}"
            )
        if rule is not None and rule.every is not None and rule.every % self.chunk:
            raise ValueError(
                f"stopping.every = {rule.every} must be a multiple of chunk = {self.chunk}"
            )
        return self

    def _check_rare(self) -> None:
        """Refuse a campaign with neither `runs` nor `rare`, and what does not go with `rare`."""
        if self.rare is None:
            if self.runs is None:
                raise ValueError("runs is missing and has no default")
            return
        given = [name for name in ("runs", "stopping") if getattr(self, name) is not None]
        if given:
            raise ValueError(
                f"{' and '.join(given)} does not go with rare, which has samples, repetitions and "
                "most_levels: leave it out"
            )
        random = {name: f for name, f in self.factors.items() if not f.crossed}
        if not random and not self.rare.sea:
            raise ValueError(
                "rare has nothing to search in: give a factor with a distribution, or rare.sea = "
                "true"
            )
        for name, factor in self.factors.items():
            if factor.sampling != "random":
                raise ValueError(
                    f'factor {name!r} has sampling = "{factor.sampling}", with rare only "random" '
                    "is allowed: leave it out"
                )
            taken = ("sea.normals", "sea.components", "sea.spectrum")
            clash = [k for k in factor.keys if k.startswith(taken[: 3 if name in random else 1])]
            if self.rare.sea and clash:
                raise ValueError(
                    f"factor {name!r} changes {clash[0]}, which rare.sea = true needs for itself: "
                    "leave out one of them"
                )
        for name in (*self.factors, *self.metrics):
            if name in COLUMNS:
                raise ValueError(f"column {name!r} belongs to rare: choose another name")

    @property
    def conditions(self) -> list[Condition]:
        """The conditions of success."""
        return [Condition.parse(text) for text in self.success]

    @classmethod
    def load(cls, name: str | Path) -> Self:
        """Campaign from a TOML file, or a packaged one by its name; its scenario may lie beside it.

        Raises:
            ScenarioError: no such file or packaged campaign (the message lists them), or its
                content is not valid.
        """
        campaign = super().load(name)
        beside = cls.find(name).parent / campaign.scenario
        if beside.is_file():
            return campaign.changed(scenario=str(beside))
        return campaign


def flat(table: dict[str, Any], prefix: str = "") -> dict[str, Any]:
    """Nested tables as one table with dotted keys."""
    found: dict[str, Any] = {}
    for key, value in table.items():
        if isinstance(value, dict) and value:
            found |= flat(value, f"{prefix}{key}.")
        else:
            found[f"{prefix}{key}"] = value
    return found
