"""Episodes: runners and log."""

from marine_mj.simulation.batch import BatchResult, run_batch
from marine_mj.simulation.log import Log
from marine_mj.simulation.runner import run

__all__ = ["BatchResult", "Log", "run", "run_batch"]
