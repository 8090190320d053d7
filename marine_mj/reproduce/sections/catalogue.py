"""All sections of the docking study, in its order."""

from marine_mj.reproduce.sections.base import Section
from marine_mj.reproduce.sections.design import design_example, sample_size, uptime_table
from marine_mj.reproduce.sections.distributions import distributions
from marine_mj.reproduce.sections.multibody import multibody_raos
from marine_mj.reproduce.sections.navigation import filter_table
from marine_mj.reproduce.sections.prediction import predicted_states
from marine_mj.reproduce.sections.scout import added_mass, drag_fit, passive_responses
from marine_mj.reproduce.sections.tuning import (
    kinematic_tuning,
    methods_table,
    pid_grid,
    polynomial_table,
)
from marine_mj.reproduce.sections.usv import largest_pitch, usv_motion, usv_raos
from marine_mj.reproduce.sections.waves import jonswap_sampling
from marine_mj.reproduce.sections.waypoints import waypoint_test

#: By name.
SECTIONS = {
    section.name: section
    for section in (
        Section("waves", "JONSWAP sampling (figure 3.4)", jonswap_sampling),
        Section("added_mass", "Added mass of the Scout (figures 4.5 to 4.7)", added_mass),
        Section("drag", "Drag fit (figure 4.9)", drag_fit),
        Section("passive", "Passive responses of the Scout (table 4.5)", passive_responses),
        Section("raos", "RAOs of the USV by mesh (figure 5.2)", usv_raos),
        Section("multibody", "Scout below the USV (figures 5.4, 5.5)", multibody_raos, True),
        Section("usv_motion", "Motion of the USV (figure 5.7)", usv_motion),
        Section("5.3", "Table 5.3, largest pitch of the USV", largest_pitch),
        Section("design", "Design example (figure 6.5)", design_example),
        Section("sample_size", "Cohen's d of sub-samples (figure 6.7)", sample_size),
        Section("7.1", "Table 7.1, uptime (figure 6.6)", uptime_table),
        Section("pid_grid", "Grid search of the pose PID (figure 7.10)", pid_grid, True),
        Section("kinematic", "Tuning of kinematic prediction (figure 7.11)", kinematic_tuning),
        Section("predicted", "Predicted states (figures 7.12, 7.14)", predicted_states),
        Section("7.8", "Table 7.8, polynomial prediction (figure 7.13)", polynomial_table, True),
        Section("7.9", "Table 7.9, tuning scenario (figure 7.15)", methods_table),
        Section("7.11", "Table 7.11, waypoint test", waypoint_test),
        Section("distributions", "Distributions by sea state (figure 7.17)", distributions, True),
        Section("8.8", "Table 8.8, filters (figures 8.3 to 8.6)", filter_table),
    )
}  # fmt: skip
