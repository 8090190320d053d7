"""The one judgement of the contact phase."""

import pytest

from marine_mj.analysis.docking import Entries
from marine_mj.contact_success import FORCE_LIMIT, contact_success
from marine_mj.errors import AnalysisError

GOOD = {"docked": True, "forbidden_contact": False, "peak_contact_force": 4000.0}


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({}, True),
        ({"docked": False}, False),
        ({"forbidden_contact": True}, False),
        ({"peak_contact_force": FORCE_LIMIT}, False),
        ({"peak_contact_force": 0.999 * FORCE_LIMIT}, True),
        ({"peak_contact_force": None}, False),
    ],
)
def test_latched_unharmed_and_gentle(changes, expected):
    assert contact_success(GOOD | changes) is expected


def test_a_run_with_an_error_is_no_success():
    assert contact_success({"error": "diverged"}) is False


def test_the_limit_is_ten_g_on_the_dry_mass():
    assert pytest.approx(10 * 9.81 * 61.5, rel=0.01) == FORCE_LIMIT  # 6033 N


def test_the_limit_is_a_setting_of_the_evaluation():
    assert contact_success(GOOD, 3000.0) is False
    assert Entries.of([GOOD], 3000.0).docked.tolist() == [False]
    assert Entries.of([GOOD]).docked.tolist() == [True]
    with pytest.raises(AnalysisError, match=r"force_limit is 0, allowed is > 0 \(N\)"):
        contact_success(GOOD, 0)
