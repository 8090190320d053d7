"""The runs of a campaign: cells, seeds, factor values and scenarios, by run number."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from scipy import special
from scipy.stats import qmc

from marine_mj.campaign.distributions import quantile
from marine_mj.campaign.settings import Campaign, flat
from marine_mj.errors import MarineMjError, ScenarioError
from marine_mj.frames import Array
from marine_mj.scenario import Scenario
from marine_mj.simulation.recorder import COMMON
from marine_mj.tasks.base import MarineTask

#: First entries of the spawn keys: streams of runs, Latin hypercubes and searches.
_RUNS, _HYPERCUBES, _SEARCHES = 0, 1, 2


@dataclass(frozen=True)
class Run:
    """One run of a campaign.

    Attributes:
        number: 0, 1, ...; consecutive runs go through all cells before a cell gets its next run.
        cell: index of the combination of the crossed factors.
        replicate: how manyth run of its cell.
        seed: of the scenario.
        factors: value (or label) of every factor.
        variation: changes of the base scenario by dotted key, the seed among them.
    """

    number: int
    cell: int
    replicate: int
    seed: int
    factors: dict[str, Any]
    variation: dict[str, Any]


class Plan:
    """What a campaign runs. Nothing here depends on how the runs are carried out.

    Attributes:
        campaign: its settings.
        base: the scenario that all runs share, with `set` applied.
        cells: number of combinations of the crossed factors.
        total: number of runs; 0 for a search for rare events, which finds out as it goes.
    """

    def __init__(self, campaign: Campaign, base: Scenario | None = None) -> None:
        """Plan of a campaign; the base scenario is loaded unless it is given.

        Raises:
            ScenarioError: there is no such scenario, or `set` or a factor has a key or value that
                the scenario does not allow.
        """
        self.campaign = campaign
        if base is None:
            base = Scenario.load(campaign.scenario)
            if campaign.set:
                base = base.with_values(flat(campaign.set))
        self.base = base
        self._crossed = {k: f for k, f in campaign.factors.items() if f.crossed}
        self._random = {k: f for k, f in campaign.factors.items() if not f.crossed}
        self._shape = tuple(len(f.levels) for f in self._crossed.values())
        self._quantiles = {
            name: quantile(factor.distribution or "", factor.parameters)
            for name, factor in self._random.items()
        }
        self.cells = math.prod(self._shape)
        self.total = self.cells * (campaign.runs or 0)
        self.scenario(0)

    @classmethod
    def load(cls, name: str | Path) -> "Plan":
        """Plan of a campaign file or a packaged campaign.

        Raises:
            ScenarioError: the campaign or its scenario is not valid.
        """
        return cls(Campaign.load(name))

    @property
    def hypercube(self) -> bool:
        """Whether a factor is drawn from a Latin hypercube, which fixes the number of runs."""
        return any(f.sampling == "latin_hypercube" for f in self._random.values())

    def cell_factors(self, cell: int) -> dict[str, Any]:
        """Values and labels of the crossed factors in a cell."""
        levels = self._levels(cell)
        return {
            name: factor.levels[level]
            for (name, factor), level in zip(self._crossed.items(), levels, strict=True)
        }

    def run(self, number: int) -> Run:
        """The run of a number from 0 to `total` - 1."""
        replicate, cell = divmod(number, self.cells)
        stream = self._stream(_RUNS, replicate, cell)
        seed = int(stream.generate_state(1)[0])
        units = np.random.default_rng(stream.spawn(1)[0]).random(len(self._random))
        for column, factor in enumerate(self._random.values()):
            if factor.sampling == "latin_hypercube":
                row = 0 if self.campaign.common_seeds else cell
                units[column] = self._hypercubes[row, replicate, column]
        factors, variation = self.at(units, cell)
        return Run(number, cell, replicate, seed, factors, {"seed": seed, **variation})

    def at(self, units: Sequence[float] | Array, cell: int = 0) -> tuple[dict, dict]:
        """Values of all factors, and the changes of the base scenario that they mean.

        This is the map from independent uniform numbers to scenarios; studies that choose the
        points themselves, such as subset simulation, use it with `evaluate`.

        Args:
            units: (number of random factors,) uniform numbers in [0, 1), in the file's order.
            cell: which combination of the crossed factors.
        """
        values: dict[str, Any] = {}
        changes: dict[str, Any] = {}
        levels = dict(zip(self._crossed, self._levels(cell), strict=True))
        drawn = dict(zip(self._random, units, strict=True))
        for name, factor in self.campaign.factors.items():
            if name in levels:
                values[name] = factor.levels[levels[name]]
                parts = factor.changes(levels[name])
            else:
                values[name] = self._quantiles[name](float(drawn[name]))
                parts = {str(factor.key): values[name]}
            for key, value in parts.items():
                self._set(changes, key, value)
        return values, changes

    def search_seed(self, replicate: int, cell: int) -> int:
        """Seed of the Markov chains of a search for rare events."""
        return int(self._stream(_SEARCHES, replicate, cell).generate_state(1)[0])

    def dimension(self, cell: int) -> int:
        """Number of standard normals that make a run of a cell in a search for rare events.

        One for each random factor; with `rare.sea` two more for each component of the sea.
        """
        rare, factors = self.campaign.rare, len(self._random)
        if rare is None or not rare.sea:
            return factors
        _, variation = self.at(np.full(factors, 0.5), cell)
        return factors + 2 * self.base.with_values(variation).sea.components

    def at_normals(self, u: Array, number: int, cell: int, replicate: int) -> Run:
        """The run that standard normals mean: quantiles of the factors, then the sea.

        All runs of a replicate have one seed, so that they differ by `u` only.

        Args:
            u: (`dimension`,) standard normals.
            number: of the run.
            cell: which combination of the crossed factors.
            replicate: how manyth search of the cell.
        """
        factors = len(self._random)
        values, variation = self.at(special.ndtr(u[:factors]), cell)
        if len(u) > factors:
            variation["sea.normals"] = [float(x) for x in u[factors:]]
        seed = int(self._stream(_RUNS, replicate, cell).generate_state(1)[0])
        return Run(number, cell, replicate, seed, values, {"seed": seed, **variation})

    def scenario(self, number: int) -> Scenario:
        """The whole scenario of a run."""
        return self.base.with_values(self.run(number).variation)

    def chunks(self, totals: Sequence[int]) -> Iterator[tuple[int, int]]:
        """First run and end of each chunk: multiples of `chunk`, and the ends in `totals`."""
        size, ends, first = self.campaign.chunk, sorted(totals), 0
        while first < ends[-1]:
            end = min((first // size + 1) * size, *(e for e in ends if e > first))
            yield first, end
            first = end

    def check(self) -> None:
        """Build, without simulating, the scenario of every level of every crossed factor.

        Raises:
            ScenarioError, ModelError: one of them cannot be built; the message names the factors.
            ScenarioError: a signal to record does not exist.
        """
        from marine_mj.tasks import build_environment

        for cell in self.levels_one_at_a_time():
            try:
                scenario = self.scenario(cell)
                if self.campaign.rare is not None:
                    run = self.at_normals(np.ones(self.dimension(cell)), 0, cell, 0)
                    scenario = self.base.with_values(run.variation)
                self._check_signals(build_environment(scenario, random=0).task)
            except MarineMjError as error:
                shown = ", ".join(f"{k} = {v!r}" for k, v in self.cell_factors(cell).items())
                raise type(error)(f"{shown + ': ' if shown else ''}{error}") from None

    def _check_signals(self, task: MarineTask) -> None:
        """Refuse signals that the log of this task does not have."""
        there = [*COMMON, *task.signal_specs]
        for name in self.campaign.record.signals:
            if name not in there:
                raise ScenarioError(
                    f"record.signals: {name!r} does not exist; there are {', '.join(there)}"
                )

    def levels_one_at_a_time(self) -> list[int]:
        """Cells in which one crossed factor at most is not at its first level."""
        cells = {0}
        for axis, size in enumerate(self._shape):
            for level in range(1, size):
                index = [0] * len(self._shape)
                index[axis] = level
                cells.add(int(np.ravel_multi_index(index, self._shape)))
        return sorted(cells)

    def _levels(self, cell: int) -> tuple[int, ...]:
        """Level of each crossed factor; the last factor changes fastest."""
        return tuple(int(i) for i in np.unravel_index(cell, self._shape)) if self._shape else ()

    def _stream(self, kind: int, replicate: int, cell: int) -> np.random.SeedSequence:
        """Random numbers of a replicate, the same in all cells where these share them."""
        number = replicate if self.campaign.common_seeds else replicate * self.cells + cell
        return np.random.SeedSequence(self.campaign.seed, spawn_key=(kind, number))

    @cached_property
    def _hypercubes(self) -> Array:
        """Uniform numbers (cells, or 1 when these share them; runs; random factors)."""
        count = 1 if self.campaign.common_seeds else self.cells
        cubes = []
        for cell in range(count):
            key = np.random.SeedSequence(self.campaign.seed, spawn_key=(_HYPERCUBES, cell))
            sampler = qmc.LatinHypercube(len(self._random), rng=np.random.default_rng(key))
            cubes.append(sampler.random(self.campaign.runs or 0))
        return np.array(cubes)

    def _set(self, changes: dict[str, Any], key: str, value: Any) -> None:
        """Enter a change; `vector[i]` changes one number of a vector of the base scenario."""
        name, bracket, index = key.partition("[")
        if not bracket:
            changes[key] = value
            return
        vector = changes.get(name)
        if vector is None:
            vector = self.base.model_dump()
            for part in name.split("."):
                vector = vector.get(part) if isinstance(vector, dict) else None
        i = int(index[:-1])
        if not isinstance(vector, list | tuple) or i >= len(vector):
            raise ScenarioError(
                f"key {key!r}: the scenario's {name} is {vector!r}, not a vector with entry {i}"
            )
        changes[name] = [*vector[:i], value, *vector[i + 1 :]]
