"""Added mass of ellipsoids against closed forms, quadrature and MuJoCo."""

import mujoco
import numpy as np
import pytest
from conftest import model_error
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from marine_mj.hydrodynamics.estimates import (
    disc_added_mass,
    ellipsoid_added_mass,
    ellipsoid_coefficients,
    elliptic_plate_added_mass,
    move_added_mass,
    prolate_spheroid_added_mass,
    sphere_added_mass,
)

RHO = 1025.0
SIZE = st.floats(0.05, 20)


@pytest.mark.parametrize(
    "axes, k, J",
    [
        ((1, 1, 1), (0.5, 0.5, 0.5), (0, 0, 0)),
        ((1, 0.5, 0.5), (0.210015, 0.704210, 0.704210), (0, 0.062681, 0.062681)),
        ((1, 0.2, 0.2), (0.059121, 0.894261, 0.894261), (0, 0.0243903, 0.0243903)),
        # The hull of REMUS as a spheroid.
        ((0.8, 0.095, 0.095), (0.027036, 0.948702, 0.948702), (0, 0.00333939, 0.00333939)),
        ((1, 0.1, 0.1), (0.020706, 0.960235, 0.960235), (0, 0.00747593, 0.00747593)),
        ((1, 0.5, 0.25), (0.126571, 0.398172, 1.518061), (0.0132928, 0.108441, 0.0190041)),
    ],
)
def test_lambs_ellipsoid(axes, k, J):
    # Largest difference: half a unit of the last printed digit (5e-7 in k, 4e-6 relative in J).
    np.testing.assert_allclose(ellipsoid_coefficients(*axes)[:3], k, atol=6e-7)
    M = ellipsoid_added_mass(*axes, RHO)
    np.testing.assert_allclose(np.diag(M)[3:] / RHO, J, rtol=8e-6, atol=1e-12)
    assert np.count_nonzero(M - np.diag(np.diag(M))) == 0


def test_integrals_by_quadrature():
    a, b, c = 1.3, 0.4, 0.7

    def integral(s):
        def f(u):
            return a * b * c / ((s * s + u) * np.sqrt((a * a + u) * (b * b + u) * (c * c + u)))

        return quad(f, 0, np.inf, epsabs=1e-13, epsrel=1e-12)[0]

    alpha = np.array([integral(s) for s in (a, b, c)])
    assert alpha.sum() == pytest.approx(2, abs=1e-10)
    # Measured: 3e-12.
    np.testing.assert_allclose(ellipsoid_coefficients(a, b, c)[:3], alpha / (2 - alpha), rtol=1e-9)


@settings(max_examples=30, deadline=None)
@given(a=SIZE, b=SIZE, c=SIZE)
def test_mujoco_knows_the_same_ellipsoid(a, b, c):
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><worldbody><body><freejoint/><geom type="ellipsoid" size="{a!r} {b!r} {c!r}"
        fluidshape="ellipsoid"/></body></worldbody></mujoco>"""
    )
    ours = np.diag(ellipsoid_added_mass(a, b, c, 1.0))
    # MuJoCo integrates numerically: measured 1e-6 of the largest at 4 : 1, 5e-3 at 400 : 1.
    slender = max(a, b, c) / min(a, b, c)
    for part in (slice(0, 3), slice(3, 6)):
        theirs = model.geom_fluid[0, 6:12][part]
        limit = (1e-5 if slender < 10 else 2e-2) * max(theirs.max(), 1e-9)
        np.testing.assert_allclose(ours[part], theirs, atol=limit)


@settings(max_examples=60, deadline=None)
@given(a=SIZE, ratio=st.floats(0.01, 1))
def test_prolate_closed_form_is_lambs(a, ratio):
    closed = np.diag(prolate_spheroid_added_mass(a, a * ratio, RHO))
    # Measured: 7e-12 just above e = 0.1, where the closed form begins to cancel.
    np.testing.assert_allclose(
        closed, np.diag(ellipsoid_added_mass(a, a * ratio, a * ratio, RHO)), rtol=1e-9
    )


def test_spheroid_of_the_scout():
    # Lobster Scout, 1.9 m, 0.061 m3: 1.950 kg, 58.85 kg, 9.523 kg m2 (docking study, corrected).
    b = np.sqrt(3 * 0.061 / (4 * np.pi * 0.95))
    M = np.diag(prolate_spheroid_added_mass(0.95, b, RHO))
    # Measured: 1.9496, 58.855, 9.5230.
    np.testing.assert_allclose(M[[0, 1, 2, 4, 5]], [1.950, 58.85, 58.85, 9.523, 9.523], rtol=3e-4)


def test_a_permutation_turns_the_axes():
    k = ellipsoid_coefficients(3, 1, 2)
    np.testing.assert_allclose(
        ellipsoid_coefficients(1, 2, 3), np.concatenate([k[[1, 2, 0]], k[[4, 5, 3]]]), rtol=1e-12
    )


def test_thin_limits():
    np.testing.assert_allclose(
        ellipsoid_added_mass(1, 1, 1, RHO), sphere_added_mass(1, RHO), rtol=1e-12
    )
    thin = ellipsoid_added_mass(0.7, 0.7, 1e-6, RHO)
    # Measured: 4e-7 (heave, turning about a diameter).
    np.testing.assert_allclose(
        np.diag(thin)[2:5], np.diag(disc_added_mass(0.7, RHO))[2:5], rtol=1e-5
    )
    assert np.diag(thin)[0] / np.diag(thin)[2] < 1e-5
    # An elliptic plate is the thin limit of the triaxial ellipsoid, the disc its round case.
    assert elliptic_plate_added_mass(0.4, 0.9, RHO) == pytest.approx(
        ellipsoid_added_mass(0.9, 0.4, 1e-7, RHO)[2, 2], rel=1e-5
    )
    assert elliptic_plate_added_mass(0.7, 0.7, RHO) == pytest.approx(
        disc_added_mass(0.7, RHO)[2, 2], rel=1e-12
    )
    # A long spheroid is a 2-D circle at each section.
    k = ellipsoid_coefficients(1000, 1, 1)
    assert k[1] == pytest.approx(1, abs=2e-5)
    assert k[0] == pytest.approx(0, abs=1e-5)


@settings(max_examples=60, deadline=None)
@given(a=SIZE, b=SIZE, c=SIZE, scale=st.floats(1e-3, 1e3))
def test_ellipsoids_depend_on_the_shape_only(a, b, c, scale):
    k = ellipsoid_coefficients(a, b, c)
    assert (k >= 0).all()
    np.testing.assert_allclose(
        ellipsoid_coefficients(a * scale, b * scale, c * scale), k, rtol=1e-6
    )


@pytest.mark.parametrize(
    "call, parts",
    [
        (lambda: ellipsoid_added_mass(1, 0, 1, RHO), ["b = 0", "above 0"]),
        (lambda: sphere_added_mass(1, np.nan), ["density = nan", "above 0"]),
        (lambda: prolate_spheroid_added_mass(1, 2, RHO), ["b = 2 m", "ellipsoid_added_mass"]),
        (lambda: move_added_mass(np.eye(3), [0, 0, 0]), ["(3, 3)", "(6, 6)"]),
        (lambda: move_added_mass(np.eye(6), [0, 0]), ["(2,)", "(3,)"]),
    ],
)
def test_refusals(call, parts):
    with model_error(*parts):
        call()
