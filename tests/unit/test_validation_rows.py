"""Rows of the validation table."""

import json

from marine_mj import validation
from marine_mj.validation.rows import row

GOOD = row("good", 1.01, 1.0, "m", "closed form", within=0.02)
BAD = row("bad", 1.05, 1.0, "m", "closed form", percent=2)
LOST = row("lost", float("nan"), 1.0, "m", "closed form", percent=2)


def test_tolerance():
    assert GOOD.ok
    assert not BAD.ok
    assert BAD.tolerance == 0.02
    assert not LOST.ok
    assert row("exact", 0, 0, "1", "bits", within=0).ok


def test_json_holds_finite_numbers(tmp_path):
    content = json.loads(validation.write([GOOD, LOST], tmp_path).read_text())
    assert content[0]["ok"] is True
    assert content[1]["measured"] is None
    assert content[1]["ok"] is False


def test_page_names_what_was_missed():
    text = validation.markdown([GOOD, BAD])
    assert "1 of 2 values are within their tolerance. Missed: bad." in text
    assert "| bad | 1.05 | 1 | 0.02 | m | closed form | **no** |" in text


def test_bars_do_not_end_a_cell():
    text = validation.markdown([row("drag", 1, 1, "N", "D v |v|", within=0)])
    assert r"| D v \|v\| |" in text
