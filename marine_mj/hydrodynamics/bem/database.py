"""Wave databases: NetCDF files with Capytaine's names, as `marine_mj.hydrodynamics.raos` reads."""

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.hydrodynamics.bem.solver import Solution
from marine_mj.hydrodynamics.hydrostatics import Hydrostatics
from marine_mj.hydrodynamics.raos import DOFS

if TYPE_CHECKING:
    import xarray as xr

#: Steps that may add variables to a database before it is written, in this order.
POST_PROCESSING: list[Callable[["xr.Dataset"], "xr.Dataset"]] = []

_PAIR = ("influenced_dof", "radiating_dof")
#: Symmetric matrices keep the order of Capytaine's own files.
_RADIATION = ("radiating_dof", "influenced_dof")
_LOADS = ("complex", "omega", "wave_direction", "influenced_dof")
_MOTIONS = ("complex", "omega", "wave_direction", "radiating_dof")
CONVENTION = {
    "frame": "body axes x forward, y port, z up, heading 0; moments about the origin",
    "convention": "x(t) = Re(X exp(-i omega t)), zeta = Re(exp(i (k s - omega t)))",
}


def wave_database(
    solution: Solution,
    stiffness: Array,
    rigid: Array,
    wavenumber: Array,
    viscous: Mapping[str, tuple[Array | float, str]],
    motions: NDArray[np.complex128] | None,
    attributes: Mapping[str, Any],
    stiffness_source: str = "the hull's mesh",
) -> "xr.Dataset":
    """Dataset of a hull's linear response, Capytaine's variable names and conventions.

    Args:
        solution: see `solve`.
        stiffness: (6, 6) hydrostatic stiffness.
        rigid: (6, 6) inertia matrix.
        wavenumber: (n,) rad/m.
        viscous: value (scalar or (6, 6)) and description by variable name (`viscous_...`).
        motions: (n, m, 6) motion RAOs, None in an unbounded fluid.
        attributes: of the dataset; `CONVENTION` is added.
        stiffness_source: where the stiffness comes from.
    """
    import xarray as xr

    mass = {"units": "kg, kg m, kg m2"}
    load = {"units": "N/m, N m/m"}
    force = solution.froude_krylov + solution.diffraction
    variables: dict[str, Any] = {
        "infinite_added_mass": (_RADIATION, solution.infinite, mass),
        "inertia_matrix": (_PAIR, rigid, {"units": "kg, kg m2"}),
    }
    if motions is not None:
        variables |= {
            "added_mass": (("omega", *_RADIATION), solution.added_mass, mass),
            "radiation_damping": (
                ("omega", *_RADIATION),
                solution.damping,
                {"units": "kg/s ... kg m2/s"},
            ),
            "hydrostatic_stiffness": (
                _PAIR,
                stiffness,
                {"units": "N/m, N, N m", "source": stiffness_source},
            ),
            "excitation_force": (_LOADS, _split(force), load),
            "Froude_Krylov_force": (_LOADS, _split(solution.froude_krylov), load),
            "diffraction_force": (_LOADS, _split(solution.diffraction), load),
        }
        names = ", ".join(viscous) or "no viscous damping"
        about = {"units": "m/m, rad/m", "description": f"with {names}"}
        variables["RAO"] = (_MOTIONS, _split(motions), about)
    if solution.zero is not None:
        variables["zero_frequency_added_mass"] = (_RADIATION, solution.zero, mass)
    for name, (value, description) in viscous.items():
        dims = _PAIR if np.ndim(value) else ()
        units = "N s/m ... N m s" if dims else "N m s"
        variables[name] = (dims, value, {"units": units, "description": description})
    omega = solution.omega
    coordinates: dict[str, Any] = {"radiating_dof": DOFS, "influenced_dof": DOFS}
    if motions is not None:
        coordinates |= {
            "omega": ("omega", omega, {"units": "rad/s"}),
            "period": ("omega", 2 * np.pi / omega, {"units": "s"}),
            "wavenumber": ("omega", wavenumber, {"units": "rad/m"}),
            "wave_direction": (
                "wave_direction",
                solution.directions,
                {"units": "rad", "description": "direction of travel, ccw from x"},
            ),
            "complex": ["re", "im"],
        }
    data = xr.Dataset(variables, coords=coordinates, attrs={**attributes, **CONVENTION})
    for step in POST_PROCESSING:
        data = step(data)
    return data


def water_attributes(
    density: float,
    gravity: float,
    depth: float,
    hull_symmetry: str = "none",
    hull_radius: float | None = None,
) -> dict[str, Any]:
    """What every reader of a database has to know of its water and hull, as numbers.

    Args:
        density: kg/m3.
        gravity: m/s2.
        depth: m, infinity in deep water.
        hull_symmetry: mirror planes through the origin: "none", "xz" (port and starboard) or
            "xz yz" (bow and stern, too); see `hydrodynamics.wave_file`.
        hull_radius: largest horizontal distance of the wetted hull from the origin, m.
    """
    attributes: dict[str, Any] = {
        "water_density": float(density),
        "gravity": float(gravity),
        "water_depth": float(depth),
        "hull_symmetry": hull_symmetry,
    }
    if hull_radius is not None:
        attributes["hull_radius"] = float(hull_radius)
    return attributes


def hydrostatic_variables(
    still: Hydrostatics, center_of_mass: Array, origin: Array
) -> dict[str, Any]:
    """Scalars and vectors of the hydrostatics by Capytaine's names, lengths from the origin."""
    transverse, longitudinal = still.metacentric_heights(center_of_mass)
    variables: dict[str, Any] = {
        "disp_volume": ((), still.volume, {"units": "m3"}),
        "wet_surface_area": ((), still.wetted_surface, {"units": "m2"}),
        "center_of_buoyancy": ("xyz", still.center_of_buoyancy - origin, {"units": "m"}),
        "center_of_mass": ("xyz", center_of_mass - origin, {"units": "m"}),
        "draught": ((), still.draught, {"units": "m"}),
        "transversal_metacentric_height": ((), transverse, {"units": "m"}),
        "longitudinal_metacentric_height": ((), longitudinal, {"units": "m"}),
    }
    if still.waterplane_area > 0:
        variables |= {
            "waterplane_area": ((), still.waterplane_area, {"units": "m2"}),
            "waterplane_center": ("xy", still.waterplane_center - origin[:2], {"units": "m"}),
        }
    return variables


def save_database(data: "xr.Dataset", path: str | Path) -> Path:
    """File of a database, written beside its place and then moved there; complex as re and im.

    Raises:
        ModelError: the file cannot be written.
    """
    path = Path(path)
    encoding = {
        name: {"zlib": True, "complevel": 9, "shuffle": True}
        for name in data.data_vars
        if data[name].ndim
    }
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with NamedTemporaryFile(dir=path.parent, suffix=".tmp", delete=False) as file:
            temporary = Path(file.name)
        try:
            data.to_netcdf(temporary, engine="h5netcdf", encoding=encoding)
            temporary.chmod(0o644)
            os.replace(temporary, path)
        finally:
            temporary.unlink(missing_ok=True)
    except OSError as error:
        raise ModelError(f"{path} cannot be written ({error}): choose another place") from error
    return path


def _split(values: NDArray[np.complex128]) -> NDArray[np.float32]:
    """Real and imaginary part (2, ...)."""
    return np.stack([values.real, values.imag]).astype(np.float32)
