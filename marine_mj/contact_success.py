"""Whether the contact phase of a docking run was a success: the one definition of it."""

from collections.abc import Mapping
from typing import Any

from marine_mj.errors import AnalysisError

#: Largest contact force that counts as gentle, N: 10 g on the Scout's 61.5 kg, ours. The reason
#: stands in models/cradle/README.md.
FORCE_LIMIT = 6000.0


def contact_success(row: Mapping[str, Any], force_limit: float = FORCE_LIMIT) -> bool:
    """True when a run latched, touched nothing forbidden and stayed below the force limit.

    The binary judgement of the docking study (digest 6.2.2, 7.8); pose within the tolerance for
    the dwell time is what closes the latch.

    Args:
        row: results of a run: `docked`, `forbidden_contact`, `peak_contact_force` (N). A run that
            ended with an error has none of them and is no success.
        force_limit: N; the peak must be below it.

    Raises:
        AnalysisError: the limit is not positive.
    """
    if not force_limit > 0:
        raise AnalysisError(
            f"force_limit is {force_limit}, allowed is > 0 (N): {FORCE_LIMIT:g} is 10 g on 61.5 kg"
        )
    peak = row.get("peak_contact_force")
    gentle = peak is not None and peak < force_limit
    return bool(row.get("docked")) and gentle and not row.get("forbidden_contact")
