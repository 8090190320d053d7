"""Hydrodynamic coefficients, native kernels and the model loader."""

from marine_mj.hydrodynamics.coefficients import BodyCoefficients, read_coefficients
from marine_mj.hydrodynamics.loader import compile_spec, load, load_xml, write_environment
from marine_mj.hydrodynamics.pack import BodySettings, pack_table

__all__ = [
    "BodyCoefficients",
    "BodySettings",
    "compile_spec",
    "load",
    "load_xml",
    "pack_table",
    "read_coefficients",
    "write_environment",
]
