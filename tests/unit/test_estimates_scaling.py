"""Scaling of models by Froude and Reynolds."""

import numpy as np
import pytest
from conftest import model_error
from hypothesis import given, settings
from hypothesis import strategies as st

from marine_mj.hydrodynamics.estimates import (
    ellipsoid_added_mass,
    froude_number,
    reynolds_number,
    scale_factor,
    scale_matrix,
)

RHO = 1025.0


def test_factors():
    for quantity, power in {
        "length": 1, "speed": 0.5, "time": 0.5, "acceleration": 0, "mass": 3, "inertia": 5,
        "force": 3, "moment": 4, "power": 3.5, "angular_rate": -0.5, "pressure": 1,
    }.items():  # fmt: skip
        assert scale_factor(quantity, 4) == pytest.approx(4**power)
    # Reynolds, a 1:6 model: 0.7 m/s becomes 0.11667 m/s, time x 36, force x 1, moment x 6.
    assert 0.7 * scale_factor("speed", 6, "reynolds") == pytest.approx(0.116667, abs=1e-6)
    assert scale_factor("time", 6, "reynolds") == pytest.approx(36)
    assert scale_factor("force", 6, "reynolds") == pytest.approx(1)
    assert scale_factor("moment", 6, "reynolds") == pytest.approx(6)
    assert scale_factor("acceleration", 6, "reynolds") == pytest.approx(6**-3)
    assert scale_factor("mass", 2, density_ratio=1.025) == pytest.approx(8.2)


def test_matrices_by_block():
    ones = np.ones((6, 6))
    M, D_L, D_Q, G = (
        scale_matrix(ones, kind, 4)
        for kind in ("added_mass", "linear_damping", "quadratic_damping", "restoring")
    )
    np.testing.assert_allclose([M[0, 0], M[0, 3], M[3, 0], M[3, 3]], 4.0 ** np.array([3, 4, 4, 5]))
    np.testing.assert_allclose([D_L[0, 0], D_L[0, 3], D_L[3, 3]], 4.0 ** np.array([2.5, 3.5, 4.5]))
    np.testing.assert_allclose(
        [D_Q[0, 0], D_Q[0, 3], D_Q[3, 0], D_Q[3, 3]], 4.0 ** np.array([2, 4, 3, 5])
    )
    np.testing.assert_allclose([G[2, 2], G[2, 4], G[3, 3]], 4.0 ** np.array([2, 3, 4]))
    # 1:8.45666 of the ALERD study: 9096.9 N m s becomes 1.352970e8.
    assert scale_matrix(np.full(6, 9096.9), "linear_damping", 80 / 9.46)[5] == pytest.approx(
        1.352970e8, rel=1e-5
    )


@settings(max_examples=60, deadline=None)
@given(
    scale=st.floats(0.05, 50),
    ratio=st.floats(0.5, 2),
    law=st.sampled_from(["froude", "reynolds"]),
    kind=st.sampled_from(["added_mass", "linear_damping", "quadratic_damping"]),
)
def test_there_and_back(scale, ratio, law, kind):
    rng = np.random.default_rng(2)
    matrix = rng.normal(size=(6, 6))
    there = scale_matrix(matrix, kind, scale, law, ratio)
    np.testing.assert_allclose(
        scale_matrix(there, kind, 1 / scale, law, 1 / ratio), matrix, rtol=1e-10
    )
    np.testing.assert_allclose(
        scale_matrix(matrix.diagonal(), kind, scale, law, ratio), there.diagonal(), rtol=1e-12
    )
    speed, length = scale_factor("speed", scale, law), scale_factor("length", scale, law)
    number = froude_number if law == "froude" else lambda u, L: reynolds_number(u, L, 1e-6)
    assert number(speed * 1.3, length * 2.0) == pytest.approx(number(1.3, 2.0), rel=1e-10)


def test_a_scaled_ellipsoid_is_an_ellipsoid():
    small = ellipsoid_added_mass(0.3, 0.2, 0.1, 1000)
    large = ellipsoid_added_mass(3, 2, 1, RHO)
    np.testing.assert_allclose(
        scale_matrix(small, "added_mass", 10, density_ratio=1.025), large, rtol=1e-12
    )


@pytest.mark.parametrize(
    "call, parts",
    [
        (lambda: scale_factor("colour", 2), ["'colour'", "length", "power"]),
        (lambda: scale_factor("mass", 2, "euler"), ["'euler'", "froude, reynolds"]),
        (lambda: scale_factor("mass", 0), ["scale = 0"]),
        (lambda: scale_matrix(np.eye(6), "drag", 2), ["'drag'", "quadratic_damping"]),
        (lambda: scale_matrix(np.eye(6), "restoring", 2, "reynolds"), ["restoring", "gravity"]),
        (lambda: scale_matrix(np.eye(5), "added_mass", 2), ["(5, 5)", "(6,)"]),
    ],
)
def test_refusals(call, parts):
    with model_error(*parts):
        call()
