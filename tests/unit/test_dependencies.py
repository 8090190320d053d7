"""One-way dependencies between the parts (docs/architecture.md)."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FORBIDDEN = {
    "controllers": (
        "mujoco",
        "dm_control",
        "marine_mj.tasks",
        "marine_mj.simulation",
        "marine_mj.scene",
        "marine_mj.hydrodynamics",
    ),
    "marine_mj/hydrodynamics": ("dm_control", "marine_mj.tasks", "marine_mj.simulation"),
    "marine_mj/environment": ("mujoco", "dm_control", "marine_mj.tasks", "marine_mj.simulation"),
    "marine_mj/analysis": ("mujoco", "dm_control", "marine_mj.tasks", "marine_mj.simulation"),
    "marine_mj/simulation": ("marine_mj.campaign", "marine_mj.cli"),
    "marine_mj/campaign": (
        *("marine_mj.campaign_commands", "marine_mj.reproduce", "marine_mj.cli"),
    ),
    "marine_mj/reproduce": ("mujoco", "dm_control", "marine_mj.reproduce_command", "marine_mj.cli"),
    "marine_mj/tasks": ("marine_mj.cli", "marine_mj.simulation"),
}


def imports(path):
    """Names of all modules that a file imports."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


@pytest.mark.parametrize("part", FORBIDDEN)
def test_part_imports_nothing_above_it(part):
    files = sorted((ROOT / part).rglob("*.py"))
    assert files
    wrong = [
        f"{path.relative_to(ROOT)} imports {name}"
        for path in files
        for name in imports(path)
        if any(name == f or name.startswith(f"{f}.") for f in FORBIDDEN[part])
    ]
    assert not wrong
