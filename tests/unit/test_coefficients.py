"""Reading coefficients from MJCF: values, frames and refusals."""

import mujoco
import numpy as np
import pytest
from conftest import model_error, numbers, numeric, one_body, random_added_mass

from marine_mj.errors import ModelError
from marine_mj.hydrodynamics import read_coefficients

CB = '<site name="a.center_of_buoyancy" pos="0 0 0.01"/>'


def read(*numerics, **options):
    """Coefficients of the body `a` with these numerics."""
    spec = mujoco.MjSpec.from_string(one_body(numerics="".join(numerics), **options))
    return read_coefficients(spec)[0]


def refused(*numerics, parts, **options):
    """Expect a ModelError with all parts in its message."""
    with model_error(*parts):
        read(*numerics, **options)


def test_sizes_of_a_matrix():
    full = random_added_mass(1)
    upper = full[np.triu_indices(6)]
    np.testing.assert_array_equal(read(numeric("added_mass_flu", numbers(full))).added_mass, full)
    half = read(numeric("added_mass_flu", numbers(upper))).added_mass
    np.testing.assert_array_equal(np.triu(half), np.triu(full))
    np.testing.assert_array_equal(half, half.T)
    diagonal = read(numeric("added_mass_flu", "1 2 3 4 5 6")).added_mass
    np.testing.assert_array_equal(diagonal, np.diag([1.0, 2, 3, 4, 5, 6]))


@pytest.mark.parametrize("quantity", ["added_mass", "linear_damping", "restoring"])
def test_frd_is_turned_about_x(quantity):
    T = np.diag([1.0, -1, -1, 1, -1, -1])
    full = random_added_mass(2)
    turned = getattr(read(numeric(f"{quantity}_frd", numbers(full))), quantity)
    np.testing.assert_allclose(turned, T @ full @ T, atol=0)


def test_plain_model_has_none():
    assert read_coefficients(mujoco.MjSpec.from_string(one_body())) == []


def test_numerics_of_others_are_left_alone():
    other = '<numeric name="my.setting" data="1"/><numeric name="my_number" data="2"/>'
    body = read(other, numeric("added_mass_flu", "1 1 1 1 1 1"))
    assert body.name == "a"


# Added mass and damping


def test_asymmetric_added_mass():
    M = np.diag([1.0, 2, 3, 4, 5, 6])
    M[1, 5], M[5, 1] = 0.5, 0.3
    refused(
        numeric("added_mass_flu", numbers(M)),
        parts=["'a' is not symmetric", "M_A[2,6] = 0.5", "M_A[6,2] = 0.3"],
    )


def test_indefinite_added_mass():
    M = np.diag([1.0, 2, 3, 4, 5, 6])
    M[1, 5] = M[5, 1] = 4.0  # eigenvalues of [[2, 4], [4, 6]]: 4 +- sqrt(20)
    refused(
        numeric("added_mass_flu", numbers(M)),
        parts=["'a' is not positive semi-definite", f"{4 - np.sqrt(20):g}"],
    )


def test_added_mass_with_the_sign_of_the_derivatives():
    refused(
        numeric("added_mass_frd", "-5.5 -12.7 -14.57 -.12 -.12 -.12"),
        parts=["smallest eigenvalue is -14.57", "M_A = -X_udot"],
    )


def test_singular_added_mass_is_allowed():
    read(numeric("added_mass_flu", "0 1 1 0 0 0"))


def test_damping_that_feeds_energy():
    refused(
        numeric("linear_damping_frd", "4 -6 5 1 1 1"),
        parts=["linear_damping of 'a' feeds energy", "-6"],
    )
    for quantity in ("quadratic_damping", "quadratic_damping_lumped"):
        refused(
            numeric(f"{quantity}_frd", "4 6 -5 1 1 1"),
            parts=[f"{quantity} of 'a' feeds energy", "[3,3] = -5"],
        )


# Names and numbers


def test_unknown_quantity():
    refused(
        numeric("aded_mass_frd", "1 1 1 1 1 1"),
        parts=["'a.aded_mass_frd'", "unknown quantity", "did you mean 'added_mass_frd'"],
    )


def test_quantity_without_frame():
    refused(
        numeric("added_mass", "1 1 1 1 1 1"),
        parts=["unknown quantity 'added_mass'", "did you mean 'added_mass_f"],
    )


def test_quantity_of_an_unknown_body():
    refused(
        numeric("added_mass_frd", "1 1 1 1 1 1", "hul"),
        parts=["'hul.added_mass_frd'", "does not exist", "['a']"],
    )


@pytest.mark.parametrize(
    ("quantity", "count", "allowed"),
    [
        ("added_mass_frd", 5, "6 or 21 or 36"),
        ("linear_damping_frd", 21, "6 or 36"),
        ("displaced_volume", 2, "allowed are 1"),
        ("wind", 6, "allowed are 4 or 7"),
        ("reference_speed", 1, "allowed are 2"),
        ("strips", 2, "allowed are 3"),
        ("strip_drag_frd", 3, "allowed are 2"),
    ],
)
def test_wrong_number_of_values(quantity, count, allowed):
    data = " ".join(["1"] * count)
    refused(numeric(quantity, data), parts=[f"'a.{quantity}' has {count} values", allowed])


def test_both_frames():
    refused(
        numeric("added_mass_frd", "1 1 1 1 1 1"),
        numeric("added_mass_flu", "1 1 1 1 1 1"),
        parts=["added_mass of 'a' is given in both frames"],
    )


def test_values_that_are_not_finite():
    spec = mujoco.MjSpec.from_string(one_body(numerics=numeric("added_mass_frd", "1 1 1 1 1 1")))
    spec.numerics[0].data = [1, 1, np.nan, 1, 1, 1]
    with pytest.raises(ModelError, match=r"'a.added_mass_frd' holds .*nan.*finite"):
        read_coefficients(spec)


# Buoyancy and restoring


@pytest.mark.parametrize("quantity", ["displaced_volume", "buoyancy", "submergence_height"])
@pytest.mark.parametrize("value", [0, -1])
def test_sizes_have_to_be_positive(quantity, value):
    refused(
        numeric(quantity, value),
        extra=CB,
        parts=[f"{quantity} of 'a' is {value}", "allowed is > 0"],
    )


def test_buoyancy_without_center_of_buoyancy():
    refused(
        numeric("displaced_volume", "0.01"),
        parts=["'a' has buoyancy but no site 'a.center_of_buoyancy'"],
    )


def test_center_of_buoyancy_in_another_body():
    refused(
        numeric("displaced_volume", "0.01"),
        world=f"<body name='b'><freejoint/><geom size='.1'/>{CB}</body>",
        parts=["site 'a.center_of_buoyancy' lies in the body 'b'", "allowed is 'a'"],
    )


@pytest.mark.parametrize("second", ["buoyancy", "restoring_frd"])
def test_one_source_of_buoyancy(second):
    value = "1 1 1 1 1 1" if second.startswith("restoring") else "1"
    refused(
        numeric("displaced_volume", "0.01"),
        numeric(second, value),
        extra=CB,
        parts=["'a' has displaced_volume and", "one of"],
    )


def test_buoyancy_and_its_center():
    body = read(numeric("buoyancy", "100"), extra=CB)
    assert body.buoyancy == 100
    np.testing.assert_array_equal(body.center_of_buoyancy, [0, 0, 0.01])


# Strips


@pytest.mark.parametrize("data", ["1 -1 1", "41 -1 1", "2.5 -1 1", "8 1 -1", "8 1 1"])
def test_wrong_strips(data):
    refused(numeric("strips", data), parts=["strips of 'a' is [", "from 2 to 40", "aft < fore"])


@pytest.mark.parametrize("area", ["1 1", "1 1 -1", "0 0 0"])
def test_wrong_strip_area(area):
    refused(
        numeric("strips", "3 -1 1"), numeric("strip_area", area), parts=["strip_area of 'a'", "3"]
    )


def test_negative_strip_drag():
    refused(
        numeric("strips", "3 -1 1"),
        numeric("strip_drag_frd", "1 -1"),
        parts=["strip_drag of 'a'", ">= 0"],
    )


@pytest.mark.parametrize("quantity", ["strip_drag_frd", "strip_area"])
def test_strip_data_without_strips(quantity):
    refused(numeric(quantity, "1 1"), parts=["no strips", "'a.strips'"])


def test_strips_are_scaled():
    body = read(
        numeric("strips", "4 -1 1"),
        numeric("strip_area", "1 2 2 1"),
        numeric("displaced_volume", "0.02"),
        extra=CB,
    )
    np.testing.assert_allclose(body.strips.x, [-0.75, -0.25, 0.25, 0.75])
    np.testing.assert_allclose(body.strips.weight, np.array([1, 2, 2, 1]) / 6)
    assert body.strips.radius == pytest.approx(np.sqrt(0.02 / 2 / np.pi))


# Wind and tanks


def test_negative_wind_area():
    refused(numeric("wind", "1 -1 1 1 1 1 1"), parts=["wind of 'a'", ">= 0"])


def test_tank_of_an_unknown_actuator():
    refused(
        numeric("tank.pump", "0 0 0 1025"), parts=["actuator 'pump'", "does not exist", "['t']"]
    )


@pytest.mark.parametrize("data", ["0 0 0", "0 0 0 0", "0 0 0 -1"])
def test_wrong_tank(data):
    refused(numeric("tank.t", data), parts=["'a.tank.t'", "4 numbers", "> 0"])


def test_tank_without_activation():
    import marine_mj

    with pytest.raises(ModelError, match=r"actuator 't' has no activation.*dyntype"):
        marine_mj.load_xml(one_body(numerics=numeric("tank.t", "0 0 0 1025")))
