"""Hydrodynamics from geometry: hydrostatics, radiation and wave loads of a hull mesh.

`marine-mj hydro` uses it (docs/hydrodynamics.md). Mesh checks and hydrostatics need no Capytaine;
`analyse` and `convergence` need the extra `bem`. Nothing here is used while a simulation runs.
"""

from marine_mj.hydrodynamics.bem.convergence import Convergence, convergence, richardson
from marine_mj.hydrodynamics.bem.database import save_database, wave_database
from marine_mj.hydrodynamics.bem.find import find_hull
from marine_mj.hydrodynamics.bem.rao import motion_raos, natural_periods, rao
from marine_mj.hydrodynamics.bem.response import Response, analyse, database_of, respond, shelter_of
from marine_mj.hydrodynamics.bem.settings import Settings
from marine_mj.hydrodynamics.bem.solver import Part, Solution, solve, solve_bodies
from marine_mj.hydrodynamics.bem.study import Hull, read_hull
from marine_mj.hydrodynamics.hydrostatics import Hydrostatics, hydrostatics
from marine_mj.hydrodynamics.mesh import read_mesh

__all__ = [
    "Convergence",
    "Hull",
    "Hydrostatics",
    "Part",
    "Response",
    "Settings",
    "Solution",
    "analyse",
    "convergence",
    "database_of",
    "find_hull",
    "hydrostatics",
    "motion_raos",
    "natural_periods",
    "rao",
    "read_hull",
    "read_mesh",
    "respond",
    "richardson",
    "save_database",
    "shelter_of",
    "solve",
    "solve_bodies",
    "wave_database",
]
