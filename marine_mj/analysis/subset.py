"""Subset simulation (Au, Beck 2001): small probabilities as products of larger ones."""

import json
import os
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from marine_mj.analysis import _checks as check
from marine_mj.analysis.rare import RareEventEstimate, Score, check_threshold, evaluate
from marine_mj.errors import AnalysisError
from marine_mj.frames import Array

Proposal = Literal["elliptical", "metropolis"]

#: Acceptance that the step size of the elliptical proposal is steered to (Papaioannou 2015).
_ACCEPTANCE = 0.44
#: Levels after which `subset_simulation` gives up.
_MAX_LEVELS = 30
_SETTINGS = ("dimension", "threshold", "samples", "p0", "proposal", "seed")


@dataclass(frozen=True, eq=False)
class SubsetState:
    """Subset simulation between two levels: all that is needed to go on, here or elsewhere.

    Each level draws from a generator seeded by (seed, level), so a state that was saved and loaded
    goes on bit for bit as if nothing had happened.

    Attributes:
        dimension: d, number of standard normals.
        threshold: the event is score >= threshold.
        samples: n, samples of each level.
        p0: share that goes on to the next level.
        proposal: "elliptical" or "metropolis".
        seed: integer.
        u: (n, d) samples of the present level: standard normal, given score > levels[-1].
        score: (n,) their scores.
        ancestor: (n,) which sample of the first level each one descends from.
        levels: (j,) scores passed so far.
        factors: (j,) share of samples that passed each.
        acceptance: (j,) share of proposals accepted above each.
        step_size: s of the elliptical proposal.
        evaluations: scores evaluated so far.
    """

    dimension: int
    threshold: float
    samples: int
    p0: float
    proposal: str
    seed: int
    u: Array
    score: Array
    ancestor: NDArray[np.int64]
    levels: Array
    factors: Array
    acceptance: Array
    step_size: float
    evaluations: int

    @classmethod
    def start(
        cls,
        score: Score,
        dimension: int,
        threshold: float,
        *,
        samples: int = 1000,
        p0: float = 0.1,
        proposal: Proposal = "elliptical",
        seed: int = 0,
    ) -> "SubsetState":
        """The first level: `samples` independent standard normal inputs and their scores.

        Args, Raises: as `subset_simulation`.
        """
        dimension = check.whole("dimension", dimension, 1, "count the standard normals of one run")
        samples = check.whole("samples", samples, 2, "1000 give a cov of about 0.3 at 1e-4")
        seed = check.whole("seed", seed, 0, "give one, so that the result can be repeated")
        check.choice("proposal", proposal, get_args(Proposal))
        p0 = check.level("p0", p0)
        chains, length = round(samples * p0), round(1 / p0)
        if chains < 2 or length < 2 or chains * length != samples or abs(p0 * length - 1) > 1e-9:
            raise AnalysisError(
                f"p0 is {p0:g} with samples {samples}, allowed are 1/p0 whole, >= 2, and samples a "
                "multiple of it, twice or more: 0.1 with 1000 samples is usual"
            )
        u = np.random.default_rng([seed, 0]).standard_normal((samples, dimension))
        values = np.concatenate([evaluate(score, part) for part in np.split(u, length)])
        none = np.empty(0)
        settings = (dimension, check_threshold(threshold), samples, p0, proposal, seed)
        return cls(
            *settings, u, values, np.arange(samples), none, none, none, step_size=0.5,
            evaluations=samples,
        )  # fmt: skip

    @property
    def finished(self) -> bool:
        """Whether more than a share p0 of the samples make the event: time for `estimate`."""
        return self._level() >= self.threshold

    def _level(self) -> float:
        """The score that at most a share p0 of the samples exceed."""
        # One more than the survivors: the estimate is unbiased only if the level itself is out
        # (Brehier et al. 2015); keeping it in adds 3 % at 1000 samples and 2e-4.
        place = self.samples - round(self.samples * self.p0) - 1
        return float(np.partition(self.score, place)[place])

    def advance(self, score: Score) -> "SubsetState":
        """The state one level higher; `score` is called 1/p0 - 1 times with p0 n rows.

        Raises:
            AnalysisError: the state is finished, the score does not distinguish the best samples,
                or `score` gives NaN or a wrong shape.
        """
        if self.finished:
            raise AnalysisError(
                f"the event was reached after {len(self.levels)} levels, allowed are states that "
                "are not finished: call estimate"
            )
        level = self._level()
        above = np.flatnonzero(self.score > level)
        if not len(above):
            raise AnalysisError(
                f"score is {level:g} for the best {(self.score == level).sum()} of {self.samples} "
                "samples, allowed is a score that grows towards the event: use a distance to "
                "failure rather than a yes or no"
            )
        rng = np.random.default_rng([self.seed, len(self.levels) + 1])
        chains, length = round(self.samples * self.p0), round(1 / self.p0)
        # Samples that a rejected proposal doubled fall together with the level, so that there may
        # be fewer than `chains`; some then start two.
        starts = np.resize(rng.permutation(above), chains)
        us, scores = [self.u[starts]], [self.score[starts]]
        step, accepted = self.step_size, 0
        for i in range(1, length):
            u, old = us[-1], scores[-1]
            candidate = self._propose(rng, u, step)
            new = evaluate(score, candidate)
            inside = new > level
            us.append(np.where(inside[:, None], candidate, u))
            scores.append(np.where(inside, new, old))
            accepted += int(inside.sum())
            # Smaller and smaller changes: the chains keep their distribution.
            step *= float(np.exp((inside.mean() - _ACCEPTANCE) / np.sqrt(i)))
            step = min(max(step, 1e-3), 1.0)
        made = chains * (length - 1)
        return replace(
            self,
            u=np.concatenate(us),
            score=np.concatenate(scores),
            ancestor=np.tile(self.ancestor[starts], length),
            levels=np.append(self.levels, level),
            factors=np.append(self.factors, len(above) / self.samples),
            acceptance=np.append(self.acceptance, accepted / made),
            step_size=step,
            evaluations=self.evaluations + made,
        )

    def _propose(self, rng: np.random.Generator, u: Array, step: float) -> Array:
        """Candidates with the standard normal as stationary distribution."""
        if self.proposal == "elliptical":
            return np.sqrt(1 - step**2) * u + step * rng.standard_normal(u.shape)
        candidate = u + rng.uniform(-1, 1, u.shape)
        odds = np.exp(np.minimum(0.5 * (u**2 - candidate**2), 0))
        return np.where(rng.uniform(size=u.shape) < odds, candidate, u)

    def estimate(self) -> RareEventEstimate:
        """Probability of the event from a finished state.

        `p = product of the factors * share of events at the last level`. The coefficient of
        variation comes from the family trees (Chan, Lai 2013; Lee, Whiteley 2018): with n_i of the
        N events descending from sample i of the first level, `cov^2 = sum (n_i / N)^2 - 1 / n`.
        It holds the correlation of chains and levels, which the usual sum over the levels leaves
        out.

        Raises:
            AnalysisError: the state is not finished.
        """
        if not self.finished:
            raise AnalysisError(
                f"the best share of {self.p0:g} has reached the score {self._level():g} after "
                f"{len(self.levels)} levels, allowed are finished states ({self.threshold:g}): "
                "call advance"
            )
        event = self.score >= self.threshold
        count = int(event.sum())
        share = np.bincount(self.ancestor[event], minlength=self.samples) / count
        cov = float(np.sqrt(max((share**2).sum() - 1 / self.samples, 0.0)))
        passed = np.cumprod(np.append(self.factors, count / self.samples))
        return RareEventEstimate(
            float(passed[-1]),
            cov,
            self.evaluations,
            np.append(self.levels, self.threshold),
            passed,
            self.u[event],
            None if len(self.levels) else (count, self.samples),
        )

    def save(self, path: str | Path) -> None:
        """Write the state to an .npz file: the old file stays until the new one is complete."""
        path = Path(path)
        arrays = ("u", "score", "ancestor", "levels", "factors", "acceptance")
        numbers = {name: getattr(self, name) for name in (*_SETTINGS, "step_size", "evaluations")}
        handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=path.name, suffix=".part")
        try:
            with os.fdopen(handle, "wb") as file:
                values = {name: getattr(self, name) for name in arrays}
                np.savez(file, numbers=np.array(json.dumps(numbers)), **values)
                file.flush()
                os.fsync(file.fileno())
            os.replace(temporary, path)
        except BaseException:
            os.unlink(temporary)
            raise

    @classmethod
    def load(cls, path: str | Path) -> "SubsetState":
        """The state in an .npz file that `save` wrote.

        Raises:
            AnalysisError: the file is no such state.
            FileNotFoundError: there is no file.
        """
        try:
            with np.load(path, allow_pickle=False) as file:
                content: dict[str, Any] = {name: file[name] for name in file.files}
            return cls(**json.loads(str(content.pop("numbers"))), **content)
        except FileNotFoundError:
            raise
        except Exception as error:
            raise AnalysisError(
                f"{path} is not a saved subset simulation ({error}), allowed are files of "
                "SubsetState.save: choose another name"
            ) from None


def subset_simulation(
    score: Score,
    dimension: int,
    threshold: float,
    *,
    samples: int = 1000,
    p0: float = 0.1,
    proposal: Proposal = "elliptical",
    seed: int = 0,
    checkpoint: str | Path | None = None,
) -> RareEventEstimate:
    """Probability that `score(u) >= threshold` for standard normal u, also where it is tiny.

    Level by level the share p0 of samples with the highest scores starts Markov chains that stay
    above (Au, Beck 2001). It takes `n (1 + (1 - p0) J)` evaluations with J about log p / log p0
    rounded down: 3700 for 2e-4 with n = 1000, where cov is 0.27; cov falls as 1/sqrt(n).

    "elliptical" proposes `sqrt(1 - s^2) u + s xi` (preconditioned Crank-Nicolson, Papaioannou et
    al. 2015), which does not depend on d or on the axes; s is steered to 44 % acceptance.
    "metropolis" is the component-wise proposal of the original, uniform +-1.

    Args:
        score: (m,) scores of (m, dimension) inputs, a deterministic function; always called with
            m = p0 n rows. It should grow towards the event.
        dimension: d, >= 1.
        threshold: the event is score >= threshold; finite.
        samples: n of each level; a multiple of 1/p0.
        p0: share that goes on, 1 / whole number.
        proposal: "elliptical" or "metropolis".
        seed: integer >= 0.
        checkpoint: .npz file written after every level; if it exists, the run goes on from it.

    Raises:
        AnalysisError: an argument is out of range, the checkpoint belongs to other settings, the
            score is NaN, has a wrong shape or does not grow towards the event, or the event was
            not reached in 30 levels.
    """
    asked = (dimension, check_threshold(threshold), samples, p0, proposal, seed)
    state = None
    if checkpoint is not None and Path(checkpoint).exists():
        state = SubsetState.load(checkpoint)
        for name, value in zip(_SETTINGS, asked, strict=True):
            if getattr(state, name) != value:
                raise AnalysisError(
                    f"{name} is {value!r}, allowed is {getattr(state, name)!r} as in {checkpoint}: "
                    "take that, or another checkpoint"
                )
    if state is None:
        state = SubsetState.start(
            score, dimension, threshold, samples=samples, p0=p0, proposal=proposal, seed=seed
        )
        if checkpoint is not None:
            state.save(checkpoint)
    while not state.finished:
        if len(state.levels) >= _MAX_LEVELS:
            raise AnalysisError(
                f"the score has reached {state.levels[-1]:g} after {_MAX_LEVELS} levels, allowed "
                f"is the threshold {state.threshold:g}: the event is impossible or rarer than "
                f"{state.p0**_MAX_LEVELS:.0e}; lower it"
            )
        state = state.advance(score)
        if checkpoint is not None:
            state.save(checkpoint)
    return state.estimate()
