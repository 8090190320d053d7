"""Fits the radiation memory of a wave database and stores it in the file.

`python -m marine_mj.hydrodynamics.fit_database FILE.nc [--band LOW HIGH] [--symmetrise]`.
A database without a stored fit works too: it is then fitted in every process that loads it, which
takes about half a second.
"""

import argparse
from pathlib import Path

import numpy as np

from marine_mj.hydrodynamics.memory import Memory
from marine_mj.hydrodynamics.memory_fit import fit_memory
from marine_mj.hydrodynamics.memory_store import VARIABLES, forget, read_radiation


def store_memory(
    path: str | Path, *, band: tuple[float, float] | None = None, symmetrise: bool = False
) -> Memory:
    """Fit the radiation memory of a wave database and write it into the file; returns it.

    Everything else in the file stays as it is.

    Args:
        path: the file.
        band, symmetrise: see `fit_memory`. The band is stored, too: the fit is checked against the
            data inside it only.

    Raises:
        ModelError: see `fit_memory`.
    """
    import xarray as xr

    path = Path(path)
    forget()  # the file may have changed since
    data, _ = read_radiation(path.resolve())
    memory = fit_memory(
        *(data["omega"], data["added_mass"], data["radiation_damping"], data["infinite"]),
        band=band,
        symmetrise=symmetrise,
    )
    with xr.open_dataset(path, engine="h5netcdf") as file:
        contents = file.load().drop_vars(list(VARIABLES), errors="ignore")
    units = {"memory_poles": "rad/s", "memory_residues": "N/m, N, N m"}
    values = {"memory_poles": memory.poles, "memory_residues": memory.residues}
    for name, axes in VARIABLES.items():
        parts = np.stack([values[name].real, values[name].imag])
        about = "K(s) = sum 1/2 (r / (s - p) + r* / (s - p*)) = B + s (A - A(inf))"
        contents[name] = (axes, parts, {"units": units[name], "description": about})
        if band is not None:
            contents[name].attrs["band"] = np.asarray(band, dtype=float)
        contents[name].encoding = {"zlib": True, "complevel": 9, "shuffle": True}
    temporary = path.with_suffix(".tmp")
    contents.to_netcdf(temporary, engine="h5netcdf")
    temporary.replace(path)
    forget()
    return memory


def main() -> None:
    """The command; see the module."""
    parser = argparse.ArgumentParser(prog="python -m marine_mj.hydrodynamics.fit_database")
    parser.add_argument("file", help="wave database (NetCDF)")
    parser.add_argument("--band", nargs=2, type=float, metavar=("LOW", "HIGH"), help="rad/s")
    parser.add_argument("--symmetrise", action="store_true", help="fit (A + A') / 2")
    chosen = parser.parse_args()
    band = None if chosen.band is None else (chosen.band[0], chosen.band[1])
    store_memory(chosen.file, band=band, symmetrise=chosen.symmetrise)


if __name__ == "__main__":
    main()
