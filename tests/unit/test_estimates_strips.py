"""Added mass and cross-flow damping of slender hulls by strips, against hand calculations."""

from itertools import pairwise

import numpy as np
import pytest
from conftest import model_error
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from marine_mj.frames import FLIP6, flip_matrix
from marine_mj.hydrodynamics.estimates import (
    cross_flow_damping,
    move_added_mass,
    prolate_spheroid_added_mass,
    strip_added_mass,
)

RHO = 1025.0


def test_a_uniform_hull_by_hand():
    L, a22, a33, a44, z = 4.0, 30.0, 50.0, 2.0, 0.3
    M = strip_added_mass([-1, 3], a22, a33, roll=a44, z=z, surge=7)
    expected = np.zeros((6, 6))
    expected[0, 0] = 7
    expected[1, 1], expected[2, 2] = a22 * L, a33 * L
    expected[3, 3] = (a44 + z**2 * a22) * L
    expected[4, 4], expected[5, 5] = a33 * 28 / 3, a22 * 28 / 3
    expected[1, 5] = expected[5, 1] = a22 * L  # mean x is 1 m
    expected[2, 4] = expected[4, 2] = -a33 * L
    expected[1, 3] = expected[3, 1] = -z * a22 * L
    expected[3, 5] = expected[5, 3] = -z * a22 * L
    np.testing.assert_allclose(M, expected, atol=1e-12)


def test_signs_are_those_of_a_moved_body():
    # The same hull, described at its centre and moved: two ways to the couplings.
    x = np.linspace(-2, 2, 9)
    a22, a33, a44 = 3 + np.cos(x), 5 + np.sin(x), 0.1 + 0.01 * x**2
    centred = strip_added_mass(x, a22, a33, roll=a44)
    r = np.array([1.5, 0, -0.4])
    moved = strip_added_mass(x + r[0], a22, a33, roll=a44, z=r[2])
    np.testing.assert_allclose(moved, move_added_mass(centred, r), atol=1e-12)


def test_frames():
    x = [-1, 0.5, 2]
    frd = strip_added_mass(x, [1, 2, 3], [3, 2, 1], roll=1, sway_roll=[0.1, 0.2, 0.3], z=0.2)
    flu = strip_added_mass(x, [1, 2, 3], [3, 2, 1], roll=1, sway_roll=[-0.1, -0.2, -0.3], z=-0.2)
    np.testing.assert_allclose(flip_matrix(frd), flu, atol=1e-12)
    assert FLIP6[1] * FLIP6[3] == -1


def test_kinetic_energy_of_the_strips():
    rng = np.random.default_rng(4)
    x = np.sort(rng.uniform(-3, 3, 12))
    a22, a33 = rng.uniform(0, 5, (2, 12))
    M = strip_added_mass(x, a22, a33)
    v, w, p, q, r = rng.normal(size=5)
    nu = np.array([0.3, v, w, p, q, r])

    def energy(s):
        sway, heave = np.interp(s, x, a22), np.interp(s, x, a33)
        return 0.5 * (sway * (v + s * r) ** 2 + heave * (w - s * q) ** 2)

    parts = [quad(energy, *pair)[0] for pair in pairwise(x)]
    assert 0.5 * nu @ M @ nu == pytest.approx(sum(parts), rel=1e-10)


@settings(max_examples=80, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), n=st.integers(2, 12))
def test_strips_are_symmetric_and_positive(seed, n):
    rng = np.random.default_rng(seed)
    x = np.cumsum(rng.uniform(0.05, 1, n)) + rng.uniform(-5, 5)
    a22, a33, a44 = rng.uniform(0.1, 50, (3, n))
    a24 = rng.uniform(-0.99, 0.99, n) * np.sqrt(a22 * a44)
    z = rng.uniform(-1, 1, n)
    M = strip_added_mass(x, a22, a33, roll=a44, sway_roll=a24, z=z, surge=1)
    np.testing.assert_array_equal(M, M.T)
    assert np.linalg.eigvalsh(M).min() > -1e-9 * np.abs(M).max()


def test_a_spheroid_by_strips():
    # Strips see no ends: k2 = 1 instead of 0.8943 (a = 5 b), 0.9602 (10), 0.9866 (20).
    for ratio, exact in ((5, 0.8943), (10, 0.9602), (20, 0.9866)):
        x = np.linspace(-1, 1, 801)
        section = [np.pi * RHO * (1 - s * s) / ratio**2 for s in x]
        M = strip_added_mass(x, section, section)
        lamb = prolate_spheroid_added_mass(1, 1 / ratio, RHO)
        assert lamb[1, 1] / M[1, 1] == pytest.approx(exact, abs=1e-4)
        # Pitch the same way, and further off: 0.728 at a = 5 b.
        assert lamb[4, 4] / M[4, 4] < exact


def test_cross_flow_damping_by_hand():
    D = cross_flow_damping([-1, 2], 10, 20)
    assert D[1, 1] == pytest.approx(30)
    assert D[2, 2] == pytest.approx(60)
    assert D[5, 5] == pytest.approx(10 * (1 + 16) / 4)
    assert D[4, 4] == pytest.approx(20 * (1 + 16) / 4)
    assert D[1, 5] == pytest.approx(10 * (8 - 1) / 3)
    assert D[5, 1] == pytest.approx(10 * (4 - 1) / 2)
    assert D[2, 4] == pytest.approx(-20 * (8 - 1) / 3)
    assert D[4, 2] == pytest.approx(-20 * (4 - 1) / 2)


def test_cross_flow_of_the_viknes():
    # 143.7 N s2/m3 over 7.2 m: Y = -1034.6 |v| v, N = -12068 |r| r.
    D = cross_flow_damping([-3.6, 3.6], 143.7, 0)
    assert D[1, 1] == pytest.approx(1034.6, abs=0.05)
    assert D[5, 5] == pytest.approx(12068, abs=1)


@settings(max_examples=40, deadline=None)
@given(axis=st.sampled_from([1, 2, 4, 5]), value=st.floats(-2, 2), seed=st.integers(0, 1000))
def test_cross_flow_damping_is_the_strips_in_one_axis(axis, value, seed):
    rng = np.random.default_rng(seed)
    x = np.sort(rng.uniform(-3, 3, 6))
    k_y, k_z = rng.uniform(0, 5, (2, 6))
    nu = np.zeros(6)
    nu[axis] = value

    def wrench(s):
        sway, heave = nu[1] + s * nu[5], nu[2] - s * nu[4]
        Y = -np.interp(s, x, k_y) * abs(sway) * sway
        Z = -np.interp(s, x, k_z) * abs(heave) * heave
        return np.array([0, Y, Z, 0, -s * Z, s * Y])

    grid = np.linspace(x[0], x[-1], 2001)
    force = sum(wrench(s) for s in 0.5 * (grid[:-1] + grid[1:])) * (grid[1] - grid[0])
    ours = -cross_flow_damping(x, k_y, k_z) @ (np.abs(nu) * nu)
    # Measured: 7e-5 of the largest, the error of the midpoint rule.
    np.testing.assert_allclose(ours, force, atol=5e-4 * max(np.abs(force).max(), 1e-6))


@pytest.mark.parametrize(
    "call, parts",
    [
        (lambda: strip_added_mass([0], 1, 1), ["(1,)", "n >= 2"]),
        (lambda: strip_added_mass([0, 1, 1], 1, 1), ["ascending", "aft to fore"]),
        (lambda: strip_added_mass([0, 1], [1, 2, 3], 1), ["sway", "(3,)", "(2,)"]),
        (lambda: strip_added_mass([0, 1], 1, [1, -2]), ["heave = -2", "x = 1 m", "positive"]),
        (lambda: strip_added_mass([0, 1], 1, np.inf), ["heave", "not finite"]),
        (lambda: strip_added_mass([0, 1], 1, 1, sway_roll=1), ["sway_roll^2", "semidefinite"]),
        (lambda: strip_added_mass([0, 1], 1, 1, surge=-1), ["surge = -1", "at least 0"]),
        (lambda: cross_flow_damping([0, 1], -1, 1), ["-1", "negative"]),
    ],
)
def test_refusals(call, parts):
    with model_error(*parts):
        call()
