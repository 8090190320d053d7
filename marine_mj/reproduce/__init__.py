"""Published studies done again, every number beside its own."""

from marine_mj.reproduce.docking import CONFIGURATIONS, TABLES, Configuration, Row, rows_of
from marine_mj.reproduce.judgement import Judged, judge
from marine_mj.reproduce.report import write_report
from marine_mj.reproduce.runner import Cells, run_configurations

__all__ = [
    "CONFIGURATIONS",
    "TABLES",
    "Cells",
    "Configuration",
    "Judged",
    "Row",
    "judge",
    "rows_of",
    "run_configurations",
    "write_report",
]
