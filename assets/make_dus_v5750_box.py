"""Wave database of the DUS V5750 box by Capytaine: `python assets/make_dus_v5750_box.py`.

Writes `assets/dus_v5750_box.nc`: added mass, radiation damping, wave excitation, hydrostatics,
motion RAOs, mean wave drift and the fitted radiation memory of a 5 x 1.5 m box at 0.3 m draft.
Needs the extra `bem`; takes a few minutes.

Conventions are Capytaine's: body axes x forward, y port, z up about the origin (mid-box on the
still water line, also the centre of mass), `wave_direction` the direction of travel in rad
counter-clockwise from x, phasors `x(t) = Re(X exp(-i omega t))` for an incident elevation
`zeta(t) = Re(exp(i (k (x cos b + y sin b) - omega t)))`, per metre of wave amplitude.
"""

from pathlib import Path

import capytaine as cpt
import numpy as np
import xarray as xr
from capytaine.io.xarray import assemble_dataset, problems_from_dataset

from marine_mj.hydrodynamics.bem.drift import mean_drift_force
from marine_mj.hydrodynamics.fit_database import store_memory

LENGTH, BEAM, DRAFT = 5.0, 1.5, 0.3  # m
WATER_DENSITY, GRAVITY = 1025.0, 9.81  # kg/m3, m/s2
MASS = 2306.0  # kg
INERTIA = (1040.0, 5412.0, 5237.0)  # kg m2 about the origin
CENTER_OF_BUOYANCY = -0.5 * DRAFT  # m, z of the centre of the displaced volume
PANEL = 0.1  # m
ROLL_DAMPING_RATIO = 0.07  # added viscous roll damping over critical
#: s; periods of the reference table, and more between them, densest at the roll resonance (2.3 s)
PERIODS = (
    *(1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7, 1.8, 1.9, 2.0, 2.1, 2.15, 2.2, 2.25, 2.3, 2.35),
    *(2.4, 2.5, 2.6, 2.7, 2.8, 3.0, 3.2, 3.5, 3.8, 4.0, 4.2, 4.6, 5.1, 5.7, 6.2, 6.7, 7.3, 7.9),
    *(8.8, 10.0, 12.0, 15.0, 20.0, 30.0),
)
DIRECTIONS = np.radians(np.arange(0.0, 360.0, 22.5))
DOFS = ["Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw"]


def rectangle(corner, side_a, side_b, count_a: int, count_b: int) -> cpt.Mesh:
    """Mesh of `count_a * count_b` quadrilaterals with normal along `side_a x side_b`."""
    corner, side_a, side_b = (np.asarray(v, dtype=float) for v in (corner, side_a, side_b))
    a, b = np.meshgrid(
        np.linspace(0.0, 1.0, count_a + 1), np.linspace(0.0, 1.0, count_b + 1), indexing="ij"
    )
    vertices = corner + a[..., None] * side_a + b[..., None] * side_b
    index = np.arange(vertices[..., 0].size).reshape(a.shape)
    faces = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1)
    return cpt.Mesh(vertices=vertices.reshape(-1, 3), faces=faces.reshape(-1, 4))


def symmetric(quarter: cpt.Mesh) -> cpt.ReflectionSymmetricMesh:
    """The whole mesh of the quarter at x > 0, y > 0."""
    half = cpt.ReflectionSymmetricMesh(half=quarter, plane="xOz")
    return cpt.ReflectionSymmetricMesh(half=half, plane="yOz")


def make_box() -> cpt.FloatingBody:
    """The wetted box and the lid (irregular frequencies) as a quarter mesh with two mirrors."""
    half_length, half_beam = 0.5 * LENGTH, 0.5 * BEAM
    n_x, n_y, n_z = (int(np.ceil(s / PANEL - 1e-9)) for s in (half_length, half_beam, DRAFT))
    quarter = (
        rectangle((0, 0, -DRAFT), (0, half_beam, 0), (half_length, 0, 0), n_y, n_x)
        + rectangle((0, half_beam, -DRAFT), (0, 0, DRAFT), (half_length, 0, 0), n_z, n_x)
        + rectangle((half_length, 0, -DRAFT), (0, half_beam, 0), (0, 0, DRAFT), n_y, n_z)
    )
    lid = rectangle((0, 0, 0), (0, half_beam, 0), (half_length, 0, 0), n_y, n_x)
    body = cpt.FloatingBody(
        mesh=symmetric(quarter),
        lid_mesh=symmetric(lid),
        dofs=cpt.rigid_body_dofs(rotation_center=(0.0, 0.0, 0.0)),
        center_of_mass=(0.0, 0.0, 0.0),
        name="dus_v5750_box",
    )
    volume = body.mesh.merged().volume
    assert abs(volume - LENGTH * BEAM * DRAFT) < 1e-6, volume  # also checks the normals
    return body


def rigid_body() -> tuple[np.ndarray, np.ndarray]:
    """Mass matrix and hydrostatic stiffness (6, 6) about the origin, centre of mass there."""
    mass = np.diag([MASS, MASS, MASS, *INERTIA])
    volume = LENGTH * BEAM * DRAFT
    weight = WATER_DENSITY * GRAVITY * volume
    stiffness = np.zeros((6, 6))
    stiffness[2, 2] = WATER_DENSITY * GRAVITY * LENGTH * BEAM
    stiffness[3, 3] = weight * (LENGTH * BEAM**3 / 12 / volume + CENTER_OF_BUOYANCY)
    stiffness[4, 4] = weight * (BEAM * LENGTH**3 / 12 / volume + CENTER_OF_BUOYANCY)
    return mass, stiffness


def viscous_roll_damping(omega, added_mass, mass, stiffness) -> float:
    """`ROLL_DAMPING_RATIO` of critical [N m s] at the roll natural frequency."""
    inertia = mass[3, 3] + added_mass[:, 3, 3]
    natural = omega[np.argmin(np.abs(omega - np.sqrt(stiffness[3, 3] / inertia)))]
    inertia = inertia[omega == natural][0]
    return float(2 * ROLL_DAMPING_RATIO * np.sqrt(stiffness[3, 3] * inertia))


def motion(omega, added_mass, damping, excitation, mass, stiffness) -> np.ndarray:
    """Complex motion RAO (omega, direction, 6) in m/m and rad/m."""
    w = omega[:, None, None]
    impedance = -(w**2) * (mass + added_mass) - 1j * w * damping + stiffness
    return np.linalg.solve(impedance[:, None], excitation[..., None])[..., 0]


def main() -> None:
    cpt.set_logging("WARNING")
    body = make_box()
    omega = np.sort(2 * np.pi / np.asarray(PERIODS))
    grid = xr.Dataset(
        coords={
            "omega": [*omega, np.inf],
            "radiating_dof": DOFS,
            "water_depth": [np.inf],
            "rho": [WATER_DENSITY],
        }
    )
    solver = cpt.BEMSolver()
    results = solver.solve_all(problems_from_dataset(grid, body), progress_bar=False)
    radiation = assemble_dataset(results).squeeze(drop=True)
    grid = xr.Dataset(
        coords={
            "omega": omega,
            "wave_direction": DIRECTIONS,
            "water_depth": [np.inf],
            "rho": [WATER_DENSITY],
        }
    )
    scattered = solver.solve_all(problems_from_dataset(grid, body), progress_bar=False)
    diffraction = assemble_dataset(scattered).squeeze(drop=True)

    pair = ("radiating_dof", "influenced_dof")
    order = {"radiating_dof": DOFS, "influenced_dof": DOFS}
    radiation = radiation[["added_mass", "radiation_damping"]].sel(order).transpose("omega", *pair)
    added_mass = radiation["added_mass"].sel(omega=omega).values
    infinite = radiation["added_mass"].sel(omega=np.inf).values
    damping = radiation["radiation_damping"].sel(omega=omega).values
    # Radiating dof first in Capytaine; both matrices are symmetric up to the panel error.
    added_mass, infinite, damping = (
        0.5 * (a + np.swapaxes(a, -1, -2)) for a in (added_mass, infinite, damping)
    )
    loads = {
        name: diffraction[name]
        .sel(influenced_dof=DOFS)
        .transpose("omega", "wave_direction", "influenced_dof")
        .values
        for name in ("Froude_Krylov_force", "diffraction_force")
    }
    excitation = loads["Froude_Krylov_force"] + loads["diffraction_force"]
    mass, stiffness = rigid_body()
    roll_damping = viscous_roll_damping(omega, added_mass, mass, stiffness)
    total_damping = damping + np.diag([0, 0, 0, roll_damping, 0, 0])
    rao = motion(omega, added_mass, total_damping, excitation, mass, stiffness)

    moving = xr.DataArray(
        rao,
        dims=("omega", "wave_direction", "radiating_dof"),
        coords={"omega": omega, "wave_direction": DIRECTIONS, "radiating_dof": DOFS},
    )
    drift = mean_drift_force([*results, *scattered], moving)

    def split(values: np.ndarray) -> np.ndarray:
        return np.stack([values.real, values.imag]).astype(np.float32)

    load_dims = ("complex", "omega", "wave_direction", "influenced_dof")
    data = xr.Dataset(
        {
            "added_mass": (("omega", *pair), added_mass, {"units": "kg, kg m, kg m2"}),
            "radiation_damping": (("omega", *pair), damping, {"units": "kg/s ... kg m2/s"}),
            "infinite_added_mass": (pair, infinite, {"units": "kg, kg m, kg m2"}),
            "hydrostatic_stiffness": (
                ("influenced_dof", "radiating_dof"),
                stiffness,
                {"units": "N/m, N, N m", "source": "closed form of the box"},
            ),
            "inertia_matrix": (("influenced_dof", "radiating_dof"), mass, {"units": "kg, kg m2"}),
            "viscous_roll_damping": (
                (),
                roll_damping,
                {
                    "units": "N m s",
                    "description": f"{ROLL_DAMPING_RATIO:.0%} of critical at the roll natural "
                    "frequency; in RAO, not in radiation_damping",
                },
            ),
            "excitation_force": (load_dims, split(excitation), {"units": "N/m, N m/m"}),
            **{
                name: (load_dims, split(values), {"units": "N/m, N m/m"})
                for name, values in loads.items()
            },
            "RAO": (
                ("complex", "omega", "wave_direction", "radiating_dof"),
                split(rao),
                {"units": "m/m, rad/m", "description": "with viscous_roll_damping"},
            ),
            "mean_drift_force": drift.astype(np.float32),
        },
        coords={
            "omega": ("omega", omega, {"units": "rad/s"}),
            "period": ("omega", 2 * np.pi / omega, {"units": "s"}),
            "wavenumber": ("omega", omega**2 / GRAVITY, {"units": "rad/m"}),
            "wave_direction": (
                "wave_direction",
                DIRECTIONS,
                {"units": "rad", "description": "direction of travel, ccw from x"},
            ),
            "radiating_dof": DOFS,
            "influenced_dof": DOFS,
            "complex": ["re", "im"],
        },
        attrs={
            "title": "Linear wave response of a box like the DUS V5750",
            "geometry": f"box {LENGTH} x {BEAM} m, draft {DRAFT} m, centre of mass at the origin "
            "(mid-box on the still water line)",
            "mesh": f"{body.mesh.nb_faces} wetted panels of about {PANEL} m and "
            f"{body.lid_mesh.nb_faces} lid panels against irregular frequencies, two mirror planes",
            "frame": "body axes x forward, y port, z up, heading 0; moments about the origin",
            "convention": "x(t) = Re(X exp(-i omega t)), zeta = Re(exp(i (k s - omega t)))",
            "water": f"infinite depth, rho {WATER_DENSITY} kg/m3, g {GRAVITY} m/s2, zero speed",
            "software": f"capytaine {cpt.__version__}, numpy {np.__version__}",
            "script": "assets/make_dus_v5750_box.py",
        },
    )
    path = Path(__file__).with_name("dus_v5750_box.nc")
    encoding = {
        name: {"zlib": True, "complevel": 9, "shuffle": True}
        for name in data.data_vars
        if data[name].ndim
    }
    data.to_netcdf(path, engine="h5netcdf", encoding=encoding)
    store_memory(path)
    print(f"{path.name}: {path.stat().st_size / 1e3:.0f} kB")


if __name__ == "__main__":
    main()
