"""The packed table while it is being made."""

from collections.abc import Sequence

import numpy as np

from marine_mj.frames import Array


class TableBuilder:
    """A growing list of float64 with blocks at known offsets."""

    def __init__(self) -> None:
        self.values: list[Array] = []
        self.length = 0

    def add(self, *parts: Array | Sequence[float] | float) -> int:
        """Append the parts; returns the offset of the first."""
        offset = self.length
        for part in parts:
            block = np.atleast_1d(np.asarray(part, dtype=float)).ravel()
            self.values.append(block)
            self.length += block.size
        return offset

    def array(self) -> Array:
        """Everything as one array."""
        return np.concatenate(self.values)
