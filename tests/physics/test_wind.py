"""Wind forces on a vehicle."""

import mujoco
import numpy as np
import pytest
from conftest import model_error, numbers, one_body

import marine_mj
from marine_mj.environment import Environment, steady_wind
from marine_mj.hydrodynamics.wind import VESSEL_TYPES
from marine_mj.scenario import Scenario
from marine_mj.weather import environment_of

AREA_X, AREA_Y, LENGTH, HEIGHT = 2.0, 6.0, 5.0, 0.5
SIZE = [AREA_X, AREA_Y, LENGTH, HEIGHT]
AIR = 1.225
#: Courses (NED, towards which it blows) relative to a heading of 0: from all four quarters.
COURSES = np.radians([0.0, 30, 90, 150, 180, 210, 250, 330])


def wind_model(data, wind, extra="", text=""):
    """A body with the given wind numerics."""
    numerics = f'<numeric name="a.wind" data="{numbers(data)}"/>{extra}'
    if text:
        numerics += f'<text name="a.wind_type" data="{text}"/>'
    numerics += '<numeric name="a.equilibrium_height" data="0.2"/>'
    return marine_mj.load_xml(
        one_body(numerics=numerics, added_mass=np.zeros(6), pos="0 0 0.2"),
        Environment(wind=wind),
    )


def force_of(model, yaw=0.0, surge=0.0, sway=0.0):
    """Wind wrench (6), FRD, of the body at a NED heading and body velocity (FRD)."""
    data = mujoco.MjData(model)
    data.qpos[3:7] = np.cos(yaw / 2), 0, 0, -np.sin(yaw / 2)
    c, s = np.cos(yaw), np.sin(yaw)
    north, east = c * surge - s * sway, s * surge + c * sway
    data.qvel[:2] = north, -east
    mujoco.mj_forward(model, data)
    return marine_mj.wrenches(model, data)["a"]["wind"] * [1, -1, -1, 1, -1, -1]


def relative_wind(speed, course, yaw, surge, sway):
    """V_rw [m/s] and gamma_rw [rad] (Fossen 2021, sec. 10.1; Viknes study 3.52-3.53), NED."""
    u = surge - speed * np.cos(course - yaw)
    v = sway - speed * np.sin(course - yaw)
    return np.hypot(u, v), -np.arctan2(v, u)


def wrench_of(q, C_X, C_Y, C_N):
    """Wrench (6), FRD, of coefficients; Y and X act at the lateral centroid, above the origin."""
    X, Y, N = q * C_X * AREA_X, q * C_Y * AREA_Y, q * C_N * AREA_Y * LENGTH
    return np.array([X, Y, 0, HEIGHT * Y, -HEIGHT * X, N])


def profile(exponent, height=0.2 + HEIGHT):
    """Wind at the lateral centroid of the floating body over that at 10 m."""
    return (height / 10) ** exponent


@pytest.mark.parametrize("course", COURSES)
@pytest.mark.parametrize("exponent", [0.0, 0.12])
def test_constant_coefficients(course, exponent):
    """Fossen (2021), sec. 10.1, in the frame of the book (FRD, NED)."""
    c_x, c_y, c_n = 0.7, 0.9, 0.1
    model = wind_model(
        [*SIZE, c_x, c_y, c_n], steady_wind(12.0, -course, AIR, height_exponent=exponent)
    )
    motion = (0.4, 2.0, 0.5)
    V, gamma = relative_wind(12.0 * profile(exponent), course, *motion)
    C = -c_x * np.cos(gamma), c_y * np.sin(gamma), c_n * np.sin(2 * gamma)
    # measured 6e-14
    np.testing.assert_allclose(
        force_of(model, *motion), wrench_of(0.5 * AIR * V**2, *C), atol=1e-11
    )


def blendermann(gamma, vessel_type, s_L):
    """C_X, C_Y, C_N of the Viknes study, eq. 6.34-6.38 with |gamma| in the last."""
    CDt, bow, stern, delta = VESSEL_TYPES[vessel_type]
    CDlAF = bow if abs(gamma) <= np.pi / 2 else stern
    CDl = CDlAF * AREA_X / AREA_Y
    den = 1 - 0.5 * delta * (1 - CDl / CDt) * np.sin(2 * gamma) ** 2
    C_Y = CDt * np.sin(gamma) / den
    C_N = (s_L / LENGTH - 0.18 * (abs(gamma) - np.pi / 2)) * C_Y
    return -CDlAF * np.cos(gamma) / den, C_Y, C_N


@pytest.mark.parametrize("course", COURSES)
@pytest.mark.parametrize("vessel_type", VESSEL_TYPES)
def test_blendermann_from_all_quarters(course, vessel_type):
    lever = '<numeric name="a.wind_lever" data="0.4"/>'
    model = wind_model(SIZE, steady_wind(9.0, -course, AIR), lever, vessel_type)
    motion = (-0.7, 1.0, -0.3)
    V, gamma = relative_wind(9.0 * profile(0.12), course, *motion)
    expected = wrench_of(0.5 * AIR * V**2, *blendermann(gamma, vessel_type, 0.4))
    np.testing.assert_allclose(force_of(model, *motion), expected, atol=1e-11)  # measured 5e-14


def viknes(lever):
    """The 8.3 m boat of the study in 1 m/s of wind from every full 30 degrees: (7, 6), FRD."""
    text = f'<numeric name="a.wind_lever" data="{lever}"/>'
    rows = []
    for gamma in np.radians(np.arange(0, 181, 30)):
        wind = steady_wind(1.0, gamma - np.pi, 1.224, height_exponent=0.0)  # from port
        model = wind_model([6.56, 15.93, 8.3, 1.0], wind, text, "offshore_supply_vessel")
        rows.append(force_of(model))
    return np.array(rows)


# (7, 4): X, Y, N with the lever 0.904 m, N with 0.03 m, as printed
TABLE = [
    [-2.21, 0, 0, 0],
    [-2.26, 5.19, 12.81, 8.27],
    [-1.31, 8.99, 15.15, 7.30],
    [0, 8.77, 7.93, 0.26],
    [1.85, 8.74, 1.06, -6.58],
    [3.20, 5.05, -3.33, -7.74],
    [3.21, 0, 0, 0],
]


def test_values_of_the_viknes_study():
    far, near = viknes(0.904), viknes(0.03)
    ours = np.column_stack([far[:, [0, 1, 5]], near[:, 5]])
    # printed to 0.01; measured 0.006
    np.testing.assert_allclose(ours, TABLE, atol=0.01)


def test_largest_moment_of_the_viknes_study():
    """409 N m at 48.5 deg in 5 m/s, 588.6 N m at 6.0 m/s."""
    text = '<numeric name="a.wind_lever" data="0.904"/>'
    angles = np.radians(np.arange(40.0, 60.0, 0.5))
    model = wind_model(
        [6.56, 15.93, 8.3, 1.0],
        steady_wind(5.0, np.pi, 1.224, height_exponent=0.0),
        text,
        "offshore_supply_vessel",
    )
    moments = [force_of(model, yaw=gamma)[5] for gamma in angles]
    i = int(np.argmax(np.abs(moments)))
    assert np.abs(moments[i]) == pytest.approx(409, rel=0.01)  # measured 408.9
    assert np.degrees(angles[i]) == pytest.approx(48.5, abs=0.5)
    assert 5.0 * np.sqrt(588.6 / abs(moments[i])) == pytest.approx(6.0, rel=0.01)


def test_starboard_mirrors_port():
    for text, data, extra in (
        ("cargo_vessel_loaded", SIZE, '<numeric name="a.wind_lever" data="-0.3"/>'),
        ("", SIZE, SYMMETRIC),
    ):
        model = wind_model(data, steady_wind(9.0, np.pi, AIR), extra, text)
        port, starboard = force_of(model, yaw=0.6), force_of(model, yaw=-0.6)
        mirror = [1, -1, 1, -1, 1, -1]
        np.testing.assert_allclose(starboard, port * mirror, atol=1e-12)  # measured 4e-15


# rows gamma (deg), C_X, C_Y, C_N; roll coefficients beside
ROWS = [
    [0, -0.6, 0, 0],
    [40, -0.5, 0.5, 0.08],
    [90, 0.05, 0.9, 0.02],
    [150, 0.6, 0.4, -0.1],
    [180, 0.7, 0, 0],
]
ROLL = [0, 0.6, 1.1, 0.5, 0]
SYMMETRIC = (
    f'<numeric name="a.wind_table" data="{numbers(np.ravel(ROWS))}"/>'
    f'<numeric name="a.wind_roll" data="{numbers(ROLL)}"/>'
)


@pytest.mark.parametrize("course", np.append(COURSES, np.radians([40.0, 140.0, 1e-9])))
@pytest.mark.parametrize("roll", [True, False])
def test_user_table(course, roll):
    extra = SYMMETRIC if roll else SYMMETRIC.split("/>")[0] + "/>"
    model = wind_model(SIZE, steady_wind(11.0, -course, AIR), extra)
    motion = (0.3, 1.0, 0.2)
    V, gamma = relative_wind(11.0 * profile(0.12), course, *motion)
    rows, side = np.array(ROWS, dtype=float), np.sign(gamma)
    angle = np.degrees(abs(gamma))
    C = [np.interp(angle, rows[:, 0], rows[:, i]) for i in (1, 2, 3)]
    expected = wrench_of(0.5 * AIR * V**2, C[0], side * C[1], side * C[2])
    if roll:
        C_K = side * np.interp(angle, rows[:, 0], ROLL)
        expected[3] = 0.5 * AIR * V**2 * C_K * AREA_Y * HEIGHT
    np.testing.assert_allclose(force_of(model, *motion), expected, atol=1e-11)  # measured 4e-14


def test_table_over_the_whole_circle():
    """A deckhouse on one side: other coefficients from port than from starboard."""
    angles = np.arange(0, 361, 15)
    rows = np.column_stack([angles, np.cos(np.radians(angles)), 0.1 * angles % 36, 0.01 * angles])
    rows[-1, 1:] = rows[0, 1:]
    extra = f'<numeric name="a.wind_table" data="{numbers(rows)}"/>'
    model = wind_model(SIZE, steady_wind(8.0, np.pi, AIR, height_exponent=0.0), extra)
    for yaw in np.radians([-170.0, -100, -20, 5, 95, 179]):
        # the bow turned to starboard by `yaw` out of the wind: it comes from port
        gamma = relative_wind(8.0, np.pi, yaw, 0, 0)[1]
        C = [np.interp(np.degrees(gamma) % 360, angles, rows[:, i]) for i in (1, 2, 3)]
        expected = wrench_of(0.5 * AIR * 64, *C)
        np.testing.assert_allclose(force_of(model, yaw), expected, rtol=1e-9, atol=1e-9)


def test_height_profile_of_the_viknes_study():
    """v(1 m) / v(10 m) = 0.3981 with Hellman's exponent 0.4."""
    data = [2, 6, 5, 0.8, 0.7, 0.9, 0.1]  # centroid 1 m above the water
    high, low = (
        force_of(wind_model(data, steady_wind(10.0, 0.0, AIR, height_exponent=n)))
        for n in (0.0, 0.4)
    )
    assert np.sqrt(low[0] / high[0]) == pytest.approx(0.3981, abs=1e-4)


def test_profile_slows_the_wind_only():
    """The air that a body's own motion meets is the same at all heights."""
    data = [*SIZE, 0.7, 0.9, 0.1]
    forces = [
        force_of(wind_model(data, steady_wind(0.0, 0.0, AIR, height_exponent=n)), surge=10.0)
        for n in (0.0, 0.4)
    ]
    np.testing.assert_array_equal(*forces)
    assert forces[0][0] == pytest.approx(-0.5 * AIR * 0.7 * AREA_X * 100, rel=1e-12)


def test_centroid_in_the_water_counts_as_a_rectangle():
    model = wind_model([2, 6, 5, -0.3, 0.7, 0.9, 0.1], steady_wind(10.0, 0.0, AIR))
    speed = 10.0 * profile(0.12, 0.5 * 6 / 5)
    assert force_of(model)[0] == pytest.approx(0.5 * AIR * 0.7 * 2 * speed**2, rel=1e-12)


def test_scenarios_set_the_profile():
    base = Scenario.load("docking_demo").with_values({"wind.speed": 8.0})
    assert environment_of(base).wind.height_exponent == 0.12
    other = base.with_values({"wind.height_exponent": 0.0})
    assert environment_of(other).wind.height_exponent == 0.0
    # the wind itself is the same realisation
    winds = [environment_of(s).wind.velocity for s in (base, other)]
    np.testing.assert_array_equal(*winds)


def test_still_air_brakes():
    model = marine_mj.load_xml(
        one_body(numerics='<numeric name="a.wind" data="2 6 5 .5 .7 .9 .1"/>', pos="0 0 0.2"),
        Environment(wind=steady_wind(1e-9, 0.0)),
    )
    data = mujoco.MjData(model)
    data.qvel[0] = 10.0
    mujoco.mj_forward(model, data)
    force = marine_mj.wrenches(model, data)["a"]["wind"]
    assert force[0] == pytest.approx(-0.5 * 1.225 * 0.7 * 2.0 * 100, rel=1e-6)


def test_still_air_brakes_without_any_wind():
    """`no_wind` promises that a moving vehicle still has air drag."""
    model = marine_mj.load_xml(
        one_body(numerics='<numeric name="a.wind" data="2 6 5 .5 .7 .9 .1"/>', pos="0 0 0.2")
    )
    data = mujoco.MjData(model)
    data.qvel[0] = 10.0
    mujoco.mj_forward(model, data)
    force = marine_mj.wrenches(model, data)["a"]["wind"]
    assert force[0] == pytest.approx(-0.5 * 1.225 * 0.7 * 2.0 * 100, rel=1e-12)


def table_of(rows):
    """Numeric `wind_table` of rows."""
    return f'<numeric name="a.wind_table" data="{numbers(rows)}"/>'


@pytest.mark.parametrize(
    ("data", "extra", "text", "parts"),
    [
        ([2, 6, 5, 0.5], "", "", ["'a' has 0 laws", "a.wind_table", "a.wind_type"]),
        ([2, 6, 5, 0.5, 0.7, 0.9, 0.1], SYMMETRIC, "", ["'a' has 2 laws", "allowed is one"]),
        (SIZE, "", "tug", ["wind_type of 'a' is 'tug'", "cargo_vessel_loaded"]),
        ([0, 6, 5, 0.5], "", "cargo_vessel_loaded", ["0.0, 6.0, 5.0", "must be > 0"]),
        (SIZE, table_of([[0, 1, 0, 0], [90, 1, 0, 0]]), "", ["angles", "to 180", "to 360"]),
        (SIZE, table_of([[0, 1, 0.1, 0], [180, 1, 0, 0]]), "", ["not 0 at 0 or 180 deg"]),
        (SIZE, table_of([[0, 1, 0, 0], [360, 2, 0, 0]]), "", ["other coefficients at 360 deg"]),
        (
            SIZE,
            table_of(ROWS) + '<numeric name="a.wind_roll" data="0 0"/>',
            "",
            ["wind_roll of 'a' has 2 values, allowed are 5"],
        ),
        (
            [*SIZE, 0.7, 0.9, 0.1],
            '<numeric name="a.wind_lever" data="1"/>',
            "",
            ["wind_lever of 'a' belongs to wind_type"],
        ),
        ([-1, 6, 5, 0.5, 0.7, 0.9, 0.1], "", "", ["areas and length must be >= 0"]),
    ],
)
def test_refusals(data, extra, text, parts):
    with model_error(*parts):
        wind_model(data, steady_wind(1.0, 0.0), extra, text)


def test_coefficients_without_areas_are_refused():
    with model_error("'a' has wind_table but no numeric 'a.wind'"):
        marine_mj.load_xml(one_body(numerics=SYMMETRIC.split("/>")[0] + "/>"))
