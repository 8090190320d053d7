"""Episodes: runner and log."""

from marine_mj.simulation.log import Log
from marine_mj.simulation.runner import run

__all__ = ["Log", "run"]
