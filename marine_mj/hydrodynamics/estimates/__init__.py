"""Coefficients for a first model where nothing is published: closed forms, tables, strip theory.

Plain functions in SI units; nothing here is used while a simulation runs. Added mass is positive,
in SNAME order; angles, frames and sources stand in each docstring.
"""

from marine_mj.hydrodynamics.estimates.drag import (
    hoerner_cross_flow_coefficient,
    hull_resistance,
    ittc57_friction,
    morison_force,
    quadratic_drag,
    streamlined_form_factor,
)
from marine_mj.hydrodynamics.estimates.drag_fit import DragFit, fit_drag
from marine_mj.hydrodynamics.estimates.drift import plate_reflection, reflected_drift
from marine_mj.hydrodynamics.estimates.ellipsoids import (
    disc_added_mass,
    ellipsoid_added_mass,
    ellipsoid_coefficients,
    elliptic_plate_added_mass,
    move_added_mass,
    prolate_spheroid_added_mass,
    sphere_added_mass,
)
from marine_mj.hydrodynamics.estimates.proximity import cylinder_near_wall
from marine_mj.hydrodynamics.estimates.scaling import (
    froude_number,
    reynolds_number,
    scale_factor,
    scale_matrix,
)
from marine_mj.hydrodynamics.estimates.strips import cross_flow_damping, strip_added_mass
from marine_mj.hydrodynamics.estimates.tables import (
    cylinder_added_mass,
    finned_circle_added_mass,
    rectangular_plate_added_mass,
    section_added_inertia,
    section_added_mass,
    section_coefficient,
    square_prism_added_mass,
)

__all__ = [
    "DragFit",
    "cross_flow_damping",
    "cylinder_added_mass",
    "cylinder_near_wall",
    "disc_added_mass",
    "ellipsoid_added_mass",
    "ellipsoid_coefficients",
    "elliptic_plate_added_mass",
    "finned_circle_added_mass",
    "fit_drag",
    "froude_number",
    "hoerner_cross_flow_coefficient",
    "hull_resistance",
    "ittc57_friction",
    "morison_force",
    "move_added_mass",
    "plate_reflection",
    "prolate_spheroid_added_mass",
    "quadratic_drag",
    "rectangular_plate_added_mass",
    "reflected_drift",
    "reynolds_number",
    "scale_factor",
    "scale_matrix",
    "section_added_inertia",
    "section_added_mass",
    "section_coefficient",
    "sphere_added_mass",
    "square_prism_added_mass",
    "streamlined_form_factor",
    "strip_added_mass",
]
