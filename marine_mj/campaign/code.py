"""What code computes the numbers: versions, sources, models, git revision."""

import hashlib
import subprocess
from collections.abc import Iterable, Sequence
from functools import lru_cache
from pathlib import Path

import scipy

import marine_mj
import marine_mj.controllers
from marine_mj.errors import ModelError
from marine_mj.library import assets_folder, attached_models, find_model
from marine_mj.scenario import Scenario
from marine_mj.simulation.recorder import versions

#: Parts of the package that only plan, show and check; all others may decide a run's numbers.
_BYSTANDERS = {
    *(
        "analysis",
        "campaign",
        "campaign_commands",
        "validation",
        "benchmark",
        "cameras",
        "cli",
        "demo",
        "headless",
        "hydro_command",
        "reproduce",
        "reproduce_command",
    ),
    *("new_vehicle", "overlay", "plotting", "render_jobs", "render_worker", "rendering"),
    *("replay", "textures", "video", "water", "water_shading"),
}


@lru_cache(maxsize=1)
def all_versions() -> dict[str, str]:
    """Versions of the packages that decide a run's numbers."""
    return versions() | {"scipy": scipy.__version__}


@lru_cache(maxsize=1)
def code_digest() -> str:
    """Hash of the versions, sources and wave databases that decide a run's numbers."""
    package = Path(marine_mj.__file__).parent
    controllers = Path(marine_mj.controllers.__file__).parent
    sources = [
        path
        for path in package.rglob("*.py")
        if path.relative_to(package).parts[0].removesuffix(".py") not in _BYSTANDERS
        and not path.is_relative_to(controllers)
        and path.parent.name not in ("models", "assets")
    ]
    digest = hashlib.sha256(repr(sorted(all_versions().items())).encode())
    _add(digest, package, sources)
    _add(digest, controllers, controllers.rglob("*.py"))
    assets = assets_folder()
    _add(digest, assets, assets.glob("*.nc"))
    return digest.hexdigest()


@lru_cache(maxsize=256)
def _model_digest(name: str) -> str:
    """Hash of all files of a vehicle or dock and of the models that it attaches.

    Of nothing when it does not exist (its runs fail).
    """
    try:
        xml = find_model(name)
    except ModelError:
        return "missing"
    digest = hashlib.sha256()
    for folder in (xml.parent, *(path.parent for path in attached_models(xml))):
        _add(digest, folder, (path for path in folder.rglob("*") if path.is_file()))
    return digest.hexdigest()


def fingerprint(scenarios: Sequence[Scenario]) -> str:
    """Hash of the code and of all vehicles and docks of these scenarios."""
    vehicles = [v for scenario in scenarios for v in scenario.vehicles.values()]
    names = {v.model for v in vehicles} | {v.dock for v in vehicles if v.dock}
    digest = hashlib.sha256(code_digest().encode())
    for name in sorted(names):
        digest.update(f"{name} {_model_digest(name)}".encode())
    return digest.hexdigest()


@lru_cache(maxsize=1)
def git_revision() -> str | None:
    """Revision of the checkout that the package is used from, with `+changes`; None outside one."""
    root = Path(marine_mj.__file__).resolve().parent.parent
    if not (root / ".git").exists():
        return None
    try:
        revision = _git(root, "rev-parse", "HEAD")
        changed = _git(root, "status", "--porcelain", "--untracked-files=no")
    except (OSError, subprocess.SubprocessError):
        return None
    return f"{revision}+changes" if changed else revision


def _git(folder: Path, *arguments: str) -> str:
    """Output of a git command."""
    done = subprocess.run(
        ["git", "-C", str(folder), *arguments], capture_output=True, text=True, check=True
    )
    return done.stdout.strip()


def _add(digest, root: Path, paths: Iterable[Path]) -> None:
    """Add names and contents of files, in the order of their names."""
    for path in sorted(paths):
        if "__pycache__" not in path.parts:
            digest.update(path.relative_to(root).as_posix().encode() + b"\0")
            digest.update(hashlib.sha256(path.read_bytes()).digest())
