"""Hydrodynamic coefficients, native kernels and the model loader."""

from marine_mj.hydrodynamics.body_settings import BodySettings
from marine_mj.hydrodynamics.check import Check, check_model
from marine_mj.hydrodynamics.coefficients import BodyCoefficients, read_coefficients
from marine_mj.hydrodynamics.loader import compile_spec, load, load_xml, write_environment
from marine_mj.hydrodynamics.memory import Memory
from marine_mj.hydrodynamics.memory_fit import fit_memory
from marine_mj.hydrodynamics.memory_store import database_memory
from marine_mj.hydrodynamics.mesh import HullMesh, read_mesh
from marine_mj.hydrodynamics.pack import pack_table
from marine_mj.hydrodynamics.prepare import prepare_hull
from marine_mj.hydrodynamics.start import start_in_waves

__all__ = [
    "BodyCoefficients",
    "BodySettings",
    "Check",
    "HullMesh",
    "Memory",
    "check_model",
    "compile_spec",
    "database_memory",
    "fit_memory",
    "load",
    "load_xml",
    "pack_table",
    "prepare_hull",
    "read_coefficients",
    "read_mesh",
    "start_in_waves",
    "write_environment",
]
