"""Tables and figures of the docking study beside those of its campaigns."""

from marine_mj.reproduce.sections.base import Finding, Outcome, Section
from marine_mj.reproduce.sections.catalogue import SECTIONS
from marine_mj.reproduce.sections.runner import Done, choose, run_sections

__all__ = ["SECTIONS", "Done", "Finding", "Outcome", "Section", "choose", "run_sections"]
