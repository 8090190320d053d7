"""The surface craft of docs/new-vehicle.md does what the page says."""

import re
from pathlib import Path

from marine_mj.hydrodynamics import check_model

PAGE = Path(__file__).parents[2] / "docs" / "new-vehicle.md"
PART = PAGE.read_text().partition("## A surface craft")[2]


def blocks(kind):
    """Code blocks of a kind in the page's part on surface craft."""
    return re.findall(rf"```{kind}\n(.*?)```", PART, re.DOTALL)


def test_the_page_is_right(tmp_path, monkeypatch, capsys):
    (xml,) = blocks("xml")
    folder = tmp_path / "models" / "skiff"
    folder.mkdir(parents=True)
    (folder / "skiff.xml").write_text(xml)
    monkeypatch.chdir(tmp_path)
    rows = {row.quantity: row.value for row in check_model("skiff")}
    told = re.findall(r"^    (\S.*?) +([\d.]+) {2,}", PART, re.MULTILINE)
    assert len(told) == 8
    for name, value in told:
        assert abs(rows[name] - float(value)) < 6e-3 * float(value), name
    matrix, heave = blocks("python")
    for code in (matrix, heave):
        exec(code, {})
        printed = capsys.readouterr().out.split()
        expected = re.findall(r"^# ([^:\n]*):", code, re.MULTILINE)
        assert " ".join(printed) == " ".join(" ".join(expected).split())
