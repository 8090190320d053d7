"""Sea states by Beaufort-based index `ss_bft`, as the docking study uses them.

The index is not the WMO sea state. Heights and mean periods are Table 3.2 of the docking study,
wind speeds those of the same table (knots), uptime its Table 7.1 (North Sea).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from marine_mj.errors import SeaError
from marine_mj.frames import Array

#: m/s in one knot (1852 m / 3600 s).
KNOT = 1852.0 / 3600.0
#: Peak period over mean period T_1 of JONSWAP with gamma 3.3 (docking study, 3.3).
PEAK_OVER_MEAN = 1.199


@dataclass(frozen=True)
class SeaState:
    """One row of the sea-state table.

    Attributes:
        ss_bft: index, 0 to 12.
        name: name of the wind force.
        H_s: significant wave height, m.
        mean_period: `T_1`, s.
        wind_speed: m/s; the ends of the scale (< 1 kn, > 64 kn) are 0 and 64 kn.
        uptime_percent: share of time with this sea state or a lower one, %.
    """

    ss_bft: int
    name: str
    H_s: float
    mean_period: float
    wind_speed: float
    uptime_percent: float

    @property
    def T_p(self) -> float:
        """Peak period [s], `1.199 T_1`."""
        return PEAK_OVER_MEAN * self.mean_period


_ROWS = [
    # name, H_s m, T_1 s, wind kn, uptime %
    ("calm", 0.00, 1.0, 0.0, 0.0),
    ("light air", 0.50, 3.5, 2.0, 7.9),
    ("light breeze", 0.65, 3.8, 5.0, 14.8),
    ("gentle breeze", 0.80, 4.2, 8.0, 22.7),
    ("moderate breeze", 1.10, 4.6, 13.5, 36.7),
    ("fresh breeze", 1.65, 5.1, 19.0, 59.4),
    ("strong breeze", 2.50, 5.7, 24.5, 82.7),
    ("near gale", 3.60, 6.7, 30.5, 93.6),
    ("gale", 4.85, 7.9, 37.0, 98.3),
    ("strong gale", 6.10, 8.8, 44.0, 100.0),
    ("storm", 7.45, 9.5, 51.5, 100.0),
    ("violent storm", 8.70, 10.0, 59.5, 100.0),
    ("hurricane", 10.25, 10.5, 64.0, 100.0),
]

#: All sea states; `SEA_STATES[i].ss_bft == i`.
SEA_STATES = tuple(
    SeaState(i, name, H_s, T_1, wind * KNOT, uptime)
    for i, (name, H_s, T_1, wind, uptime) in enumerate(_ROWS)
)


def sea_state(ss_bft: int) -> SeaState:
    """Sea state of index `ss_bft` (0 to 12).

    Raises:
        SeaError: no such index.
    """
    whole = isinstance(ss_bft, int | np.integer) and not isinstance(ss_bft, bool)
    if not whole or not 0 <= ss_bft < len(SEA_STATES):
        raise SeaError(
            f"ss_bft is {ss_bft!r}, allowed are whole numbers from 0 to {len(SEA_STATES) - 1}: "
            "give the Beaufort-based index (not the WMO sea state), or H_s and T_p"
        )
    return SEA_STATES[ss_bft]


def uptime_percent(H_s: ArrayLike) -> Array:
    """Share of time [%] with waves up to `H_s` (m): linear through the table, 100 beyond SS 9."""
    heights = [state.H_s for state in SEA_STATES]
    return np.interp(
        np.asarray(H_s, dtype=float), heights, [state.uptime_percent for state in SEA_STATES]
    )
