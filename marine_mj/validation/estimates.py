"""Estimated coefficients against closed forms, tables and panel calculations."""

from collections.abc import Iterator

import numpy as np

from marine_mj.hydrodynamics.estimates import (
    cross_flow_damping,
    cylinder_added_mass,
    ellipsoid_added_mass,
    hoerner_cross_flow_coefficient,
    hull_resistance,
    ittc57_friction,
    prolate_spheroid_added_mass,
    section_added_inertia,
    section_added_mass,
    square_prism_added_mass,
    streamlined_form_factor,
    strip_added_mass,
)
from marine_mj.validation.rows import Row, row

RHO = 1025.0


def ellipsoids() -> Iterator[Row]:
    """Lamb's ellipsoids: 1 x 0.5 x 0.25 m, the hulls of REMUS and Scout."""
    triaxial = np.diag(ellipsoid_added_mass(1, 0.5, 0.25, RHO)) / RHO
    # k V and J / rho of Lamb's integrals, six digits.
    volume = 4 / 3 * np.pi * 0.125
    k = (0.126571, 0.398172, 1.518061)
    cases = zip(("surge", "sway", "heave"), triaxial[:3] / volume, k, strict=True)
    for axis, ours, expected in cases:
        name = f"Ellipsoid 1 x 0.5 x 0.25 m, k in {axis}"
        yield row(name, ours, expected, "1", "Lamb's integrals", within=1e-6)
    turning = (0.0132928, 0.108441, 0.0190041)
    for axis, ours, expected in zip(("roll", "pitch", "yaw"), triaxial[3:], turning, strict=True):
        name = f"Ellipsoid 1 x 0.5 x 0.25 m, J / rho in {axis}"
        yield row(name, ours, expected, "m5", "Lamb's integrals", percent=1e-3)
    remus = np.diag(prolate_spheroid_added_mass(0.8, 0.095, RHO)) / RHO
    volume = 4 / 3 * np.pi * 0.8 * 0.095**2
    yield row("REMUS hull, k in sway", remus[1] / volume, 0.948702, "1", "Lamb", within=1e-6)
    yield row("REMUS hull, J / rho in yaw", remus[5], 0.00333939, "m5", "Lamb", percent=1e-3)
    scout = np.diag(prolate_spheroid_added_mass(0.95, np.sqrt(3 * 0.061 / (4 * np.pi * 0.95)), RHO))
    source = "docking study, 3.3, Lamb's factors with its misprints corrected"
    yield row("Scout as a spheroid, surge", scout[0], 1.950, "kg", source, percent=0.3)
    yield row("Scout as a spheroid, sway", scout[1], 58.85, "kg", source, percent=0.3)
    yield row("Scout as a spheroid, pitch", scout[4], 9.523, "kg m2", source, percent=0.3)


def tables() -> Iterator[Row]:
    """Rows of DNV-RP-C205 against panel calculations, and the 2 m cube of a panel-code study."""
    cube = square_prism_added_mass(2, 2, RHO)
    strips = 2 * section_added_mass("rectangle", 1, 1, RHO)
    turning = cube / strips * 2 * section_added_inertia("rectangle", 1, 1, RHO)
    study = "Minerva 2 study, 4.1"
    yield row("2 m cube, added mass", cube, 5576.0, "kg", study, within=1e-6)
    yield row("2 m cube, 3-D over strips", cube / strips, 0.57338, "1", study, within=1e-4)
    yield row("2 m cube, added inertia by its method", turning, 864.10, "kg m2", study, within=0.1)
    panels = "panels without a free surface; tolerance: digits and spread of the table"
    for ratio, expected in ((1.2, 0.632), (2.5, 0.782), (5, 0.880), (9, 0.930)):
        ours = cylinder_added_mass(0.5, ratio, 1) / (np.pi / 4 * ratio)
        yield row(f"Cylinder across, L / D {ratio:g}, C_A", ours, expected, "1", panels, percent=5)
    for ratio, expected in ((1, 0.64), (2, 0.348), (3, 0.237), (4, 0.180), (5, 0.145)):
        ours = square_prism_added_mass(1, ratio, 1) / ratio
        yield row(f"Square prism, b / a {ratio:g}, C_A", ours, expected, "1", panels, percent=8)


def slender_bodies() -> Iterator[Row]:
    """Strip theory against Lamb, cross-flow and hull drag of two digests."""
    x = np.linspace(-1, 1, 801)
    section = np.pi * RHO * (1 - x**2) / 400
    ours = strip_added_mass(x, section, section)[1, 1]
    lamb = prolate_spheroid_added_mass(1, 0.05, RHO)[1, 1]
    # Strips see no ends: 1.4 % too much at a slenderness of 20.
    yield row("Spheroid 20 : 1, strips over Lamb", ours / lamb, 1.0, "1", "Lamb", percent=2)
    source = "ALERD study, 3.5"
    speed, reynolds = 8.5 * 1852 / 3600, 2.58362e8
    friction = ittc57_friction(reynolds)
    yield row("ALERD, C_F at 8.5 kn", friction, 1.82408e-3, "1", source, percent=1e-3)
    form = 1.1 * streamlined_form_factor(8.5, 80)
    ours = hull_resistance(speed, 80, 3900, RHO, speed * 80 / reynolds, form_factor=form)
    yield row("ALERD, hull resistance at 8.5 kn", ours, 81.31e3, "N", source, percent=0.05)
    ours = hoerner_cross_flow_coefficient(20, 8.5)
    yield row("ALERD, cross-flow C_D", ours, 0.7881, "1", source, within=1e-4)
    yaw = cross_flow_damping([-3.6, 3.6], 143.7, 0)[5, 5]
    yield row("Viknes, N of r |r|, cross-flow", yaw, 12068, "N m s2", "Viknes study", within=1)


CASES = (ellipsoids, tables, slender_bodies)
