"""Sections done in a folder, each once: what is finished there is read instead."""

import hashlib
import json
from collections.abc import Callable, Iterable
from concurrent.futures import FIRST_EXCEPTION, Executor, wait
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import marine_mj
from marine_mj.campaign.code import fingerprint
from marine_mj.campaign.pools import open_pool
from marine_mj.demo import write_json
from marine_mj.errors import AnalysisError, CampaignError
from marine_mj.reproduce.docking import TABLES
from marine_mj.reproduce.sections.base import Finding, Job, Outcome
from marine_mj.reproduce.sections.catalogue import SECTIONS
from marine_mj.scenario import Scenario

#: Parts of the package that only sections use, beside what decides the numbers of a run.
_SOURCES = ("analysis", "reproduce", "validation")


@dataclass(frozen=True)
class Done:
    """A finished section.

    Attributes:
        name: in `SECTIONS`.
        outcome: its numbers and figures; the pictures lie in `sections/NAME`.
    """

    name: str
    outcome: Outcome

    @property
    def title(self) -> str:
        """Heading in the report."""
        return SECTIONS[self.name].title


def choose(names: Iterable[str] | None = None) -> tuple[list[str], list[str]]:
    """Tables of sea states, and sections, of a choice in the study's order; None: all.

    Args:
        names: numbers of tables and names of figures.

    Raises:
        AnalysisError: one does not exist, or none is named.
    """
    known = [*TABLES, *SECTIONS]
    wanted = known if names is None else [name.strip() for name in names]
    unknown = [name for name in wanted if name not in known]
    if unknown or not wanted:
        raise AnalysisError(
            f"table {', '.join(map(repr, unknown)) or '(none)'} is not among those of the docking "
            f"study; there are {', '.join(TABLES)}, and the sections {', '.join(SECTIONS)}"
        )
    return [t for t in TABLES if t in wanted], [s for s in SECTIONS if s in wanted]


def run_sections(
    names: Iterable[str],
    folder: str | Path,
    runs: int = 60,
    *,
    full: bool = False,
    highest: int | None = None,
    workers: int | None = None,
    executor: Executor | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> list[Done]:
    """Sections in the order of their names, done in `folder`/sections/NAME.

    A section that is finished there, by the same code and settings, is not done again. Workers take
    one section after the other; results do not depend on their number.

    Args:
        names: of sections, see `choose`.
        folder: of the reproduction.
        runs: per sea state, for sections with campaigns.
        full: the study's whole grids (tables 7.8, figure 7.10).
        highest: last sea state of campaigns; None: that of the tables.
        workers, executor: see `open_pool`.
        progress: called with the number of finished sections and of all.

    Raises:
        CampaignError: the folder cannot be written, or a worker was killed.
        MarineMjError: see the sections.
    """
    chosen, base = list(names), Path(folder)
    found: dict[str, Outcome] = {}
    keys = {name: _key(name, runs, full, highest) for name in chosen}
    for name in chosen:
        kept = _read(base, name, keys[name])
        if kept is not None:
            found[name] = kept
    missing = [name for name in chosen if name not in found]
    if progress is not None:
        progress(len(found), len(chosen))
    if missing:
        with open_pool(workers, executor=executor) as pool:
            futures = {
                pool.submit(do_section, name, base, runs, full, highest, keys[name]): name
                for name in missing
            }
            waiting = set(futures)
            while waiting:
                done, waiting = wait(waiting, timeout=0.5, return_when=FIRST_EXCEPTION)
                for future in done:
                    try:
                        found[futures[future]] = future.result()
                    except pool.died:
                        raise CampaignError(
                            f"a worker was killed in section {futures[future]!r} or beside it (out "
                            "of memory?): give the same command again, it goes on with what is "
                            "missing"
                        ) from None
                if progress is not None:
                    progress(len(found), len(chosen))
    return [Done(name, found[name]) for name in chosen]


def do_section(
    name: str, base: Path, runs: int, full: bool, highest: int | None, key: str
) -> Outcome:
    """Outcome of a section, written to its folder; the work of a worker."""
    place = base / "sections" / name
    try:
        place.mkdir(parents=True, exist_ok=True)
        outcome = SECTIONS[name].run(Job(place, runs, full, base, highest))
        write_json(place / "section.json", {"key": key, **asdict(outcome)})
    except OSError as error:
        raise CampaignError(
            f"cannot write section {name!r} to {str(place)!r}: {error}. Make room or set the "
            "permissions, then give the same command again"
        ) from None
    return outcome


def _read(base: Path, name: str, key: str) -> Outcome | None:
    """Outcome that stands in a folder; None if there is none, or of other code or settings."""
    place = base / "sections" / name
    try:
        stored: dict[str, Any] = json.loads((place / "section.json").read_text(encoding="utf-8"))
        if stored["key"] != key or not all((place / f).is_file() for f in stored["figures"]):
            return None
        findings = []
        for row in stored["findings"]:
            span = row["interval"]
            findings.append(Finding(**row | {"interval": None if span is None else tuple(span)}))
        return Outcome(findings, stored["figures"], stored["text"])
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _key(name: str, runs: int, full: bool, highest: int | None) -> str:
    """Hash of the code and the settings that decide a section."""
    digest = hashlib.sha256(fingerprint([Scenario.load("docking_thesis")]).encode())
    package = Path(marine_mj.__file__).parent
    for part in _SOURCES:
        for path in sorted((package / part).rglob("*.py")):
            digest.update(path.relative_to(package).as_posix().encode() + b"\0")
            digest.update(path.read_bytes())
    if SECTIONS[name].scaled:
        digest.update(repr((runs, full, highest)).encode())
    return digest.hexdigest()
