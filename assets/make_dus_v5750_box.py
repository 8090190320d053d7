"""Wave database of the DUS V5750 box by Capytaine: `python assets/make_dus_v5750_box.py`.

Writes `assets/dus_v5750_box.nc`: added mass, radiation damping, wave excitation, hydrostatics and
motion RAOs of a 5 x 1.5 m box at 0.3 m draft. Needs the extra `bem`; takes a few minutes.

Conventions are Capytaine's: body axes x forward, y port, z up about the origin (mid-box on the
still water line, also the centre of mass), `wave_direction` the direction of travel in rad
counter-clockwise from x, phasors `x(t) = Re(X exp(-i omega t))` for an incident elevation
`zeta(t) = Re(exp(i (k (x cos b + y sin b) - omega t)))`, per metre of wave amplitude.
"""

from importlib.metadata import version
from pathlib import Path

import numpy as np

from marine_mj.environment import wavenumber
from marine_mj.hydrodynamics.bem.database import (
    save_database,
    water_attributes,
    wave_database,
)
from marine_mj.hydrodynamics.bem.drift import database_drift
from marine_mj.hydrodynamics.bem.panels import Panels, lid, rectangle
from marine_mj.hydrodynamics.bem.rao import motion_raos, viscous_damping
from marine_mj.hydrodynamics.bem.rigid_body import RigidBody
from marine_mj.hydrodynamics.bem.solver import solve
from marine_mj.hydrodynamics.fit_database import store_memory
from marine_mj.hydrodynamics.hydrostatics import hydrostatics

LENGTH, BEAM, DRAFT = 5.0, 1.5, 0.3  # m
WATER_DENSITY, GRAVITY = 1025.0, 9.81  # kg/m3, m/s2
MASS = 2306.0  # kg
INERTIA = (1040.0, 5412.0, 5237.0)  # kg m2 about the origin
PANEL = 0.1  # m
ROLL_DAMPING_RATIO = 0.07  # added viscous roll damping over critical
#: s; periods of the reference table, and more between them, densest at the roll resonance (2.3 s)
PERIODS = (
    *(1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7, 1.8, 1.9, 2.0, 2.1, 2.15, 2.2, 2.25, 2.3, 2.35),
    *(2.4, 2.5, 2.6, 2.7, 2.8, 3.0, 3.2, 3.5, 3.8, 4.0, 4.2, 4.6, 5.1, 5.7, 6.2, 6.7, 7.3, 7.9),
    *(8.8, 10.0, 12.0, 15.0, 20.0, 30.0),
)
#: Half the circle, the hull is symmetric. In waves of 1 s, 1.5 m long, the wave loads have
#: harmonics of the direction up to about 16: two directions for each over the circle.
DIRECTIONS = np.radians(np.arange(0.0, 180.1, 11.25))


def box() -> Panels:
    """A quarter of the wetted box with two mirrors."""
    half_length, half_beam = 0.5 * LENGTH, 0.5 * BEAM
    n_x, n_y, n_z = (int(np.ceil(s / PANEL - 1e-9)) for s in (half_length, half_beam, DRAFT))
    quarter = (
        rectangle((0, 0, -DRAFT), (0, half_beam, 0), (half_length, 0, 0), n_y, n_x)
        + rectangle((0, half_beam, -DRAFT), (0, 0, DRAFT), (half_length, 0, 0), n_z, n_x)
        + rectangle((half_length, 0, -DRAFT), (0, half_beam, 0), (0, 0, DRAFT), n_y, n_z)
    )
    return quarter.mirrored(1, 0)


def main() -> None:
    omega = np.sort(2 * np.pi / np.asarray(PERIODS))
    hull = box()
    cover = lid(hull, PANEL)
    result = solve(
        hull,
        cover,
        omega=omega,
        directions=DIRECTIONS,
        density=WATER_DENSITY,
        gravity=GRAVITY,
        method="indirect",  # as the reference tables were made; drift needs its sources
        keep=True,
    )
    body = RigidBody(MASS, np.zeros(3), np.diag(INERTIA))
    rigid = body.matrix(np.zeros(3))
    still = hydrostatics(*hull.triangles())
    # The published mass is 0.01 % less than the displaced one: the weight is the buoyancy.
    displaced = WATER_DENSITY * still.volume
    stiffness = still.stiffness(WATER_DENSITY, GRAVITY, displaced, np.zeros(3), np.zeros(3))
    viscous = viscous_damping(
        omega, result.added_mass, rigid, stiffness, {"Roll": ROLL_DAMPING_RATIO}
    )
    force = result.froude_krylov + result.diffraction
    rao = motion_raos(omega, rigid + result.added_mass, result.damping + viscous, stiffness, force)
    about = (
        f"{ROLL_DAMPING_RATIO:.0%} of critical at the roll natural frequency; in RAO, not in "
        "radiation_damping"
    )
    data = wave_database(
        result,
        stiffness,
        rigid,
        wavenumber(omega, gravity=GRAVITY),
        {"viscous_roll_damping": (float(viscous[3, 3]), about)},
        rao,
        {
            "title": "Linear wave response of a box like the DUS V5750",
            "geometry": f"box {LENGTH} x {BEAM} m, draft {DRAFT} m, centre of mass at the origin "
            "(mid-box on the still water line)",
            "mesh": f"{len(hull)} wetted panels of about {PANEL} m and "
            f"{0 if cover is None else len(cover)} lid panels against irregular frequencies, two "
            "mirror planes",
            "water": f"infinite depth, rho {WATER_DENSITY} kg/m3, g {GRAVITY} m/s2, zero speed",
            **water_attributes(
                WATER_DENSITY, GRAVITY, np.inf, "xz yz", float(np.hypot(0.5 * LENGTH, 0.5 * BEAM))
            ),
            "software": f"capytaine {version('capytaine')}, numpy {np.__version__}",
            "script": "assets/make_dus_v5750_box.py",
        },
    )
    data["mean_drift_force"] = database_drift(result, rao)
    path = save_database(data, Path(__file__).with_name("dus_v5750_box.nc"))
    store_memory(path)
    print(f"{path.name}: {path.stat().st_size / 1e3:.0f} kB")


if __name__ == "__main__":
    main()
