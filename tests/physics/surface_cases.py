"""Bodies for the tests of the surface, how wet they are and what energy they have."""

import mujoco
import numpy as np
from conftest import numeric

from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.native import report
from marine_mj.hydrodynamics.wrenches import added_mass_of

RHO, G = 1025.0, 9.81
SEMI_IMPLICIT = ("Euler", "implicit", "implicitfast")

RADIUS, VOLUME = 0.3, 4 / 3 * np.pi * 0.3**3
SPHERE = numeric("displaced_volume", repr(VOLUME))
CENTER = '<site name="a.center_of_buoyancy"/>'
COEFFICIENTS = (
    numeric("linear_damping_flu", "20 30 40 5 6 7")
    + numeric("quadratic_damping_flu", "9 9 9 1 1 1"),
    numeric("submergence_height", RADIUS),
)
#: The USV's box afloat, and 1.3 m deep in all.
BOX = numeric("restoring_flu", "0 0 75414 10745 153703 0") + numeric("hull_depth", 1.3)
BOX_MASS, BOX_INERTIA = 2306.0, (1040.0, 5412.0, 5237.0)
BOX_ADDED = np.diag([327.0, 1293, 3875, 391, 7305, 2020])
STRIPS = numeric("strips", "8 -2 2") + numeric("strip_drag_flu", "50 80")
BODIES = {
    "sphere": SPHERE + COEFFICIENTS[0] + COEFFICIENTS[1],
    "volume alone": SPHERE + COEFFICIENTS[0],
    "strips": numeric("displaced_volume", 0.11) + STRIPS + COEFFICIENTS[0],
    "floating": BOX + COEFFICIENTS[0],
    "floating, strips": BOX + STRIPS + COEFFICIENTS[0],
}


def share_of(model, data):
    """Wet share of the first body, by the added mass that acts on it."""
    acting = report(model, data)[0][6 * len(t_.CAUSES) :][:36].reshape(6, 6)
    whole = added_mass_of(model, 1)
    i, j = np.unravel_index(np.abs(whole).argmax(), whole.shape)
    np.testing.assert_allclose(acting, acting[i, j] / whole[i, j] * whole, atol=1e-12)
    return acting[i, j] / whole[i, j]


def bounces(model, data, M, duration):
    """Mechanical energy (n,) [J] at every step at which the first body is in the air."""
    energies = []
    for _ in range(round(duration / model.opt.timestep)):
        mujoco.mj_step1(model, data)
        if share_of(model, data) == 0.0:
            R = data.xmat[1].reshape(3, 3)
            nu = np.r_[R.T @ data.qvel[:3], data.qvel[3:]]
            energies.append(0.5 * nu @ M @ nu + M[0, 0] * G * data.qpos[2])
        mujoco.mj_step2(model, data)
    return np.array(energies)
