"""The whole validation table: every value within its tolerance, and its files."""

import json

import pytest

from marine_mj import validation

pytestmark = pytest.mark.validation


@pytest.fixture(scope="module")
def rows():
    """All rows, computed once; progress is reported in order."""
    calls = []
    rows = validation.run(lambda *call: calls.append(call))
    total = sum(len(part) for part in validation.CASES.values())
    assert [call[0] for call in calls] == list(range(total + 1))
    assert all(call[1] == total and call[2] for call in calls)
    return rows


def test_every_value_is_within_its_tolerance(rows):
    missed = [f"{r.name}: {r.measured:g}, not {r.expected:g} +- {r.tolerance:g}" for r in rows]
    assert not [text for text, r in zip(missed, rows, strict=True) if not r.ok]


def test_names_are_unique(rows):
    names = [row.name for row in rows]
    assert len(set(names)) == len(names)
    assert all(row.unit and row.source for row in rows)


def test_file(rows, tmp_path):
    path = validation.write(rows, tmp_path / "results")
    assert path == tmp_path / "results" / "validation.json"
    content = json.loads(path.read_text())
    assert len(content) == len(rows)
    keys = {"name", "measured", "expected", "tolerance", "unit", "source", "ok"}
    assert all(keys == set(entry) for entry in content)
    assert [p.name for p in path.parent.iterdir()] == ["validation.json"]


def test_page(rows):
    text = validation.markdown(rows)
    assert f"{len(rows)} of {len(rows)} values" in text
    assert text.count("\n| ") == len(rows) + 2
