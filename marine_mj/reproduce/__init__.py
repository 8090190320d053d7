"""Published studies done again, every number beside its own."""

from marine_mj.reproduce.docking import CONFIGURATIONS, TABLES, Configuration, Row, rows_of
from marine_mj.reproduce.judgement import Judged, judge
from marine_mj.reproduce.report import write_report
from marine_mj.reproduce.runner import Cells, run_configurations
from marine_mj.reproduce.sections import SECTIONS, choose, run_sections

__all__ = [
    "CONFIGURATIONS",
    "SECTIONS",
    "TABLES",
    "Cells",
    "Configuration",
    "Judged",
    "Row",
    "choose",
    "judge",
    "rows_of",
    "run_configurations",
    "run_sections",
    "write_report",
]
