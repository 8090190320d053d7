"""Checks that a wheel holds the whole package and nothing outside `marine_mj/`.

Usage: python scripts/check_wheel.py dist/marine_mj-*.whl
"""

import subprocess
import sys
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
#: Folder in the repository -> folder in the wheel (the package-dir table of pyproject.toml).
MAPPING = {
    "marine_mj": "marine_mj",
    "controllers": "marine_mj/controllers",
    "models": "marine_mj/models",
    "assets": "marine_mj/assets",
}


def expected_names() -> set[str]:
    """Wheel paths of the files of the mapped folders that Git tracks."""
    listing = subprocess.run(
        ["git", "ls-files", "--", *MAPPING], cwd=ROOT, check=True, capture_output=True, text=True
    )
    names = set()
    for line in listing.stdout.splitlines():
        top, _, rest = line.partition("/")
        if (ROOT / line).is_file():
            names.add(f"{MAPPING[top]}/{rest}")
    return names


def main(wheel: str) -> int:
    """Exit code: 0 when the wheel is complete and clean."""
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
    files = {name for name in names if ".dist-info/" not in name}
    problems = [
        f"outside marine_mj/: {name}" for name in sorted(files) if not name.startswith("marine_mj/")
    ]
    problems += [f"bytecode: {name}" for name in sorted(files) if "__pycache__" in name]
    problems += [f"missing: {name}" for name in sorted(expected_names() - files)]
    if not any(name.endswith(".dist-info/licenses/LICENSE") for name in names):
        problems.append("missing: LICENSE")
    for problem in problems:
        print(f"{Path(wheel).name}: {problem}", file=sys.stderr)
    print(f"{Path(wheel).name}: {len(files)} files, {len(problems)} problems")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
