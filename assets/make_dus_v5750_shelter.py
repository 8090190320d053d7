"""Shelter database of the DUS V5750 box by Capytaine: `python assets/make_dus_v5750_shelter.py`.

Writes `assets/dus_v5750_shelter.nc`: the water motion that the floating box adds to the waves at a
grid around and below it (`marine_mj.hydrodynamics.bem.shelter`), with the panels and motion RAOs of
`dus_v5750_box.nc`. Needs the extra `bem`; takes a few minutes.
"""

from importlib.metadata import version
from pathlib import Path

import numpy as np
from make_dus_v5750_box import (
    BEAM,
    DRAFT,
    GRAVITY,
    LENGTH,
    PANEL,
    PERIODS,
    WATER_DENSITY,
    box,
)

from marine_mj.hydrodynamics.bem.database import save_database, water_attributes
from marine_mj.hydrodynamics.bem.panels import lid
from marine_mj.hydrodynamics.bem.shelter import shelter_database, shelter_grid
from marine_mj.hydrodynamics.bem.solver import Solution, solve
from marine_mj.hydrodynamics.raos import read_responses

HERE = Path(__file__).parent


def solution(directions: np.ndarray) -> Solution:
    """Diffraction and radiation of the box with their sources; wave directions in rad."""
    return solve(
        box(),
        lid(box(), PANEL),
        omega=2 * np.pi / np.asarray(PERIODS),
        directions=directions,
        density=WATER_DENSITY,
        gravity=GRAVITY,
        method="indirect",
        keep=True,
    )


def main() -> None:
    # all around: the modes have no mirror images
    _, directions, motions = read_responses(HERE / "dus_v5750_box.nc", "motion")
    about = {
        **water_attributes(
            WATER_DENSITY, GRAVITY, np.inf, "xz yz", float(np.hypot(0.5 * LENGTH, 0.5 * BEAM))
        ),
        "title": "Water motion around a floating box like the DUS V5750",
        "geometry": f"box 5 x 1.5 m, draft {DRAFT} m, motion RAOs of dus_v5750_box.nc",
        "software": f"capytaine {version('capytaine')}, numpy {np.__version__}",
        "script": "assets/make_dus_v5750_shelter.py",
    }
    points = box().whole().reshape(-1, 3)
    grid = shelter_grid(points.min(axis=0), points.max(axis=0), PANEL)
    data = shelter_database(solution(directions), motions, grid, about)
    path = save_database(data, HERE / "dus_v5750_shelter.nc")
    print(f"{path.name}: {data.sizes['mode']} modes, {path.stat().st_size / 1e3:.0f} kB")


if __name__ == "__main__":
    main()
