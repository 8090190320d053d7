"""Wave databases as other programs write them: half circles, degrees, other water, other seas."""

import warnings

import mujoco
import numpy as np
import pytest
import xarray as xr
from conftest import model_error, one_body

import marine_mj
from marine_mj.environment import Environment, WaveField, regular_wave
from marine_mj.errors import MarineMjWarning, ModelError
from marine_mj.hydrodynamics import database_memory
from marine_mj.hydrodynamics.coefficients import BodyCoefficients
from marine_mj.hydrodynamics.drift import mean_drift
from marine_mj.hydrodynamics.netcdf import read_variables
from marine_mj.hydrodynamics.raos import (
    coarse_directions,
    database_path,
    heading_count,
    read_responses,
    responses,
)
from marine_mj.hydrodynamics.sea_check import missed_energy
from marine_mj.hydrodynamics.wave_file import WaveDatabase, facts, whole_circle
from marine_mj.scenario import Scenario
from marine_mj.scene import body_settings, build_scene

BOX = "dus_v5750_box.nc"
#: Signs under the mirror plane xz, written down apart from the package's.
XZ = {"surge": 1, "sway": -1, "heave": 1, "roll": -1, "pitch": 1, "yaw": -1}
YZ = {"surge": -1, "sway": 1, "heave": 1, "roll": 1, "pitch": -1, "yaw": -1}


def load(name=BOX) -> xr.Dataset:
    """A database of the package."""
    with xr.open_dataset(database_path(name), engine="h5netcdf") as file:
        return file.load()


def save(data, tmp_path) -> str:
    """A file of a changed database, a new one each time."""
    path = tmp_path / f"{len(list(tmp_path.iterdir()))}.nc"
    data.to_netcdf(path, engine="h5netcdf")
    return str(path)


def at(degrees, omega=3.0, **options) -> WaveField:
    """Waves of 1 m from these directions."""
    chi = np.radians(np.atleast_1d(np.asarray(degrees, dtype=float)))
    ones = np.ones(len(chi))
    return WaveField(omega * ones, omega**2 / 9.81 * ones, chi, ones, 0 * ones, **options)


def floating(path, environment=None, **settings):
    """A model of a body with that database."""
    numerics = (
        f'<text name="a.wave_database" data="{path}"/>'
        '<numeric name="a.restoring_frd" data="0 0 75414 10745 153703 0"/>'
    )
    xml = one_body(added_mass=np.ones(6), numerics=numerics, mass=2306, inertia="1040 5412 5237")
    return marine_mj.load_xml(xml, environment, {"a": settings})


# Directions


@pytest.mark.parametrize("response", ["force", "diffraction", "motion"])
def test_half_circle_is_mirrored_axis_by_axis(response):
    chi = np.array([20.0, 77.0, 163.0])
    here, there = (responses(BOX, response, at(sign * chi), 0.0) for sign in (1, -1))
    signs = np.array(list(XZ.values()))[:, None]
    scale = np.abs(here).max(axis=1, keepdims=True)
    assert (scale > 0).all()
    # measured 4e-15
    np.testing.assert_allclose(there / scale, signs * here / scale, atol=1e-12)


def test_full_half_and_quarter_circle_give_the_same(tmp_path):
    """The file over the whole circle, written out by hand, against its half and its quarter."""
    half = load()
    other = half.isel(wave_direction=slice(-2, 0, -1))
    other = other.assign_coords(wave_direction=2 * np.pi - other.wave_direction)
    signs = xr.DataArray(list(XZ.values()), dims="influenced_dof")
    for name in ("excitation_force", "diffraction_force", "Froude_Krylov_force"):
        other[name] = other[name] * signs
    other["RAO"] = other["RAO"] * signs.rename(influenced_dof="radiating_dof")
    other["mean_drift_force"] = other["mean_drift_force"] * xr.DataArray(
        [1, -1, -1], dims="drift_dof"
    )
    full = xr.concat([half, other], dim="wave_direction", data_vars="minimal")
    full.attrs["hull_symmetry"] = "none"
    quarter = half.isel(wave_direction=slice(0, 9))
    files = [save(data, tmp_path) for data in (full, half, quarter)]
    sea = at([3.0, 100.0, 181.0, 275.0, 359.0])
    whole, *rest = (responses(f, "force", sea, 0.3) for f in files)
    drifts = [
        mean_drift(BodyCoefficients("a", np.zeros((6, 6)), wave_database=f), Environment(sea), 0.3)
        for f in files
    ]
    scale = np.abs(whole).max()
    for got, drift in zip(rest, drifts[1:], strict=True):
        # measured 1e-11 (single precision of what the solver leaves of a zero), drift 2e-6
        np.testing.assert_allclose(got, whole, atol=1e-9 * scale)
        np.testing.assert_allclose(drift, drifts[0], atol=1e-5 * np.abs(drifts[0]).max())
    assert np.abs(whole[1]).max() > 0.1 * scale


def test_beam_seas_of_half_a_circle_without_symmetry_are_refused_until_it_is_stated(tmp_path):
    data = load()
    del data.attrs["hull_symmetry"]
    file = save(data, tmp_path)
    sea = Environment(waves=regular_wave(0.2, 2.5, -np.pi / 2))
    with model_error("circle open from 180 to 360 deg", 'hull_symmetry = "xz"', "vehicles.NAME"):
        floating(file, sea)
    told = floating(file, sea, hull_symmetry="xz")
    stated = floating(BOX, sea)
    np.testing.assert_array_equal(told.numeric_data, stated.numeric_data)
    with model_error("hull_symmetry is 'yz', allowed are none, xz, xz yz"):
        floating(file, sea, hull_symmetry="yz")
    data.attrs["hull_symmetry"] = "both"
    with model_error("attribute hull_symmetry = 'both'", "'xz yz'"):
        floating(save(data, tmp_path), sea)


def test_scenario_passes_the_symmetry_on():
    scenario = Scenario.load("docking_demo").with_values({"vehicles.usv.hull_symmetry": "xz"})
    settings = body_settings(scenario, build_scene(scenario))
    assert [s["hull_symmetry"] for s in settings.values()].count("xz") == 1


def test_a_sector_without_directions_is_refused(tmp_path):
    data = load().isel(wave_direction=[0, 1, 2, 3, 4, 5, 14, 15, 16])
    with model_error("circle open from 56.25 to 157.5 deg", "hull symmetry 'xz'", "up to 60 deg"):
        read_responses(database_path(save(data, tmp_path)), "force", "xz")
    with model_error("circle open from 56.25 to 123.7"):  # the other plane does not help
        read_responses(database_path(save(data, tmp_path)), "force", "xz yz")
    assert len(read_responses(database_path(BOX), "force")[1]) == 32


def test_degrees_are_converted_or_refused(tmp_path):
    data = load()
    degrees = data.assign_coords(wave_direction=np.degrees(data.wave_direction.values))
    file = save(degrees, tmp_path)
    with model_error("wave_direction of", "reaches 180", "look like degrees", 'units = "degrees"'):
        responses(file, "force", at(30.0), 0.0)
    with model_error("look like degrees"):
        body = BodyCoefficients("a", np.zeros((6, 6)), wave_database=file)
        mean_drift(body, Environment(at(30.0)), 0.0)
    degrees.wave_direction.attrs["units"] = "degrees"
    got = responses(save(degrees, tmp_path), "force", at(30.0), 0.0)
    np.testing.assert_allclose(got, responses(BOX, "force", at(30.0), 0.0), rtol=1e-9, atol=1e-6)


def test_uneven_and_doubled_directions():
    circle = whole_circle(np.radians([0.0, 10, 35, 90, 180, 360]), "xz yz")
    degrees = np.degrees(circle.angle)
    assert (np.diff(degrees) > 0).all() and not circle.even
    np.testing.assert_allclose(degrees[:6], [0, 10, 35, 90, 145, 170])
    np.testing.assert_allclose(np.degrees(circle.gap), 55)


# Water


def test_forces_radiation_and_drift_go_with_the_density():
    """A body in fresh water: linear potential flow is proportional to rho."""
    ratio = 999.0 / 1025.0
    name, sea = WaveDatabase(BOX, water_density=999.0), at([10.0, 200.0])
    for response, factor in (("force", ratio), ("diffraction", ratio), ("motion", 1.0)):
        got, plain = (responses(n, response, sea, 0.0) for n in (name, BOX))
        np.testing.assert_allclose(got, factor * plain, rtol=1e-12)
    fresh, salt = database_memory(name), database_memory(BOX)
    omega = np.array([0.5, 3.0, 20.0])
    np.testing.assert_allclose(
        fresh.retardation(omega), ratio * salt.retardation(omega), rtol=1e-12
    )
    np.testing.assert_allclose(fresh.infinite_added_mass, ratio * salt.infinite_added_mass)


def test_packed_model_in_fresh_water():
    """First-order force, drift, A(inf) and memory of the model; not the vehicle's own numbers."""
    waves = regular_wave(0.4, 3.0, 0.6)
    found: dict[tuple[float, str], dict] = {}
    for density in (1025.0, 999.0):
        for drift in ("none", "mean"):
            model = floating(BOX, Environment(waves=waves, water_density=density), drift=drift)
            data = mujoco.MjData(model)
            data.qpos[2], data.act[:] = 0.01, 1.0
            mujoco.mj_forward(model, data)
            found[density, drift] = marine_mj.wrenches(model, data)["a"]
    salt, fresh = (found[density, "none"] for density in (1025.0, 999.0))
    assert set(salt) >= {"waves", "radiation", "restoring"}
    for part in ("waves", "radiation"):
        assert np.abs(salt[part]).max() > 0
        np.testing.assert_allclose(fresh[part], 999 / 1025 * salt[part], rtol=1e-9, atol=1e-9)
    np.testing.assert_array_equal(fresh["restoring"], salt["restoring"])
    second = [found[d, "mean"]["waves"] - found[d, "none"]["waves"] for d in (1025.0, 999.0)]
    np.testing.assert_allclose(second[1], 999 / 1025 * second[0], rtol=1e-9, atol=1e-9)


def test_facts_of_files_old_and_new(tmp_path):
    about = facts(database_path(BOX))
    assert (about.density, about.gravity, about.depth) == (1025.0, 9.81, np.inf)
    assert about.symmetry == "xz yz" and about.radius == pytest.approx(np.hypot(2.5, 0.75))
    data = load()
    for name in ("water_density", "gravity", "water_depth", "hull_symmetry", "hull_radius"):
        del data.attrs[name]
    old = facts(database_path(save(data, tmp_path)))  # from the text of the attribute "water"
    assert (old.density, old.gravity, old.depth, old.symmetry) == (1025.0, 9.81, np.inf, None)
    assert old.radius == pytest.approx(2.6, rel=0.1)  # from the stiffness; measured 2.71
    data.attrs["water"] = ""
    data = data.assign_coords(rho=1000.0, g=9.8, water_depth=12.0)  # as Capytaine writes
    found = facts(database_path(save(data, tmp_path)))
    assert (found.density, found.gravity, found.depth) == (1000.0, 9.8, 12.0)


def told(file, environment, **settings) -> list[str]:
    """What loading a model warns of."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", MarineMjWarning)
        floating(file, environment, **settings)
    return [str(w.message) for w in caught if issubclass(w.category, MarineMjWarning)]


def test_another_depth_warns_where_the_bottom_is_felt():
    def sea(depth):
        return Environment(waves=regular_wave(0.2, 5.0, 0.6, depth=depth))

    assert told(BOX, sea(np.inf)) == [] and told(BOX, sea(60.0)) == []
    (message,) = told(BOX, sea(4.0))
    assert "is for a depth of inf m, the sea is 4 m deep" in message and "--depth" in message


def test_an_unstated_density_warns_in_other_water(tmp_path):
    data = load()
    del data.attrs["water_density"]
    data.attrs["water"] = ""
    file, waves = save(data, tmp_path), regular_wave(0.2, 3.0, 0.6)
    assert told(file, Environment(waves=waves)) == []
    (message,) = told(file, Environment(waves=waves, water_density=999.0))
    assert "does not state its density, taken is 1025 kg/m3" in message


# Seas outside the file


def two(share, omega) -> Environment:
    """A sea with this share of its energy at a frequency, the rest at 2 rad/s."""
    w = np.array([2.0, omega])
    amplitude = 0.1 * np.sqrt([1 - share, share])
    return Environment(waves=WaveField(w, w**2 / 9.81, 0 * w, amplitude, 0 * w))


def test_missed_energy_warns_and_is_refused():
    assert told(BOX, two(0.009, 7.0)) == []
    (message,) = told(BOX, two(0.02, 7.0))
    assert "from 0.209 to 6.28 rad/s, the sea from 2 to 7: 2 % of the sea's energy" in message
    with model_error("11 % of the sea's energy lies outside", "allowed are 10 %", "--omega"):
        floating(BOX, two(0.11, 7.0))


def test_long_waves_below_the_file_need_no_table(tmp_path):
    """A file that starts at 0.52 rad/s (k R = 0.07) against the whole one, at 0.31 rad/s."""
    assert missed_energy(BOX, "force", two(0.5, 0.1).waves)[0] == 0.0
    short = load().isel(omega=slice(3, None))
    file = save(short, tmp_path)
    assert missed_energy(file, "force", two(0.5, 0.3).waves)[0] == 0.0
    sea = at([0.0, 40.0, 90.0], omega=np.pi / 10)
    # surge, sway, heave, roll, pitch; measured 0.006, 0.001, 0.027, 0.010, 0.016 of the force and
    # 0.004, 0.004, 0.001, 0.016, 0.001 of the motion; held at its lowest value the file would give
    # 2.7 times the surge force
    for response, allowed in (("force", 0.04), ("motion", 0.025)):
        got, exact = (responses(f, response, sea, 0.0) for f in (file, BOX))
        error = np.abs(got - exact)[:5].max(axis=1) / np.abs(exact)[:5].max(axis=1)
        assert (error < allowed).all(), error
    later = load().isel(omega=slice(20, None))  # from 2.3 rad/s: k R = 1.4, no long waves
    with model_error("from 2.33 to 6.28 rad/s, the sea from 1 to 2: 100 % of the sea's energy"):
        floating(save(later, tmp_path), two(0.5, 1.0))


# Between the directions


def test_coarse_directions_are_told_with_the_step_they_need(tmp_path):
    assert coarse_directions(BOX, "force") == ""
    data = load().isel(wave_direction=slice(0, None, 2))  # 22.5 deg, as it once was
    text = coarse_directions(save(data, tmp_path), "force")
    # k R = 10.5: harmonics up to 15.7, 180 deg / 15.7 = 11.5 deg
    assert "up to 22.5 deg apart, enough up to" in text and text.endswith("every 11.25 deg")
    del data.attrs["hull_radius"]
    bare = data.drop_vars("hydrostatic_stiffness")
    assert "compute it every" in coarse_directions(save(bare, tmp_path), "force")
    (message,) = told(save(data, tmp_path), Environment(waves=regular_wave(0.2, 3.0, 0.6)))
    assert "wave database of 'a': excitation_force" in message


def test_heading_count_keeps_what_it_promises():
    """Cubic Lagrange interpolation between the headings, done here, against the response itself."""
    count = heading_count(BOX, "force")
    assert count == 96
    omega, _, table = read_responses(database_path(BOX), "force")
    scale = np.abs(table).max(axis=(0, 1))
    waves = WaveField(omega, omega**2 / 9.81, 0 * omega + 0.123, 1 + 0 * omega, 0 * omega)
    step, worst = 2 * np.pi / count, {}
    for nodes in (count, count // 2):
        step = 2 * np.pi / nodes
        places = np.arange(nodes) * step
        exact = responses(BOX, "force", waves, places + 0.5 * step)
        at_nodes = responses(BOX, "force", waves, places)
        weights = np.array([-1, 9, 9, -1]) / 16
        got = sum(
            w * np.roll(at_nodes, -s, axis=0) for w, s in zip(weights, (-1, 0, 1, 2), strict=True)
        )
        worst[nodes] = (np.abs(got - exact) / scale[:, None]).max()
    # measured 0.0019 with 96 headings, 0.026 with 48
    assert worst[count] < 0.003 < worst[count // 2]


def test_many_headings_have_the_bits_of_one():
    waves = at(np.linspace(0, 300, 7))
    many = responses(BOX, "force", waves, np.array([0.1, 2.0]))
    for yaw, got in zip((0.1, 2.0), many, strict=True):
        assert (got == responses(BOX, "force", waves, yaw)).all()


def test_damaged_values_are_refused(tmp_path):
    data = load()
    data["excitation_force"][0, 3, 2, 1] = np.nan
    with pytest.raises(ModelError, match=r"excitation_force in .* holds NaN or infinity"):
        responses(save(data, tmp_path), "force", at(30.0), 0.0)


def test_omega_zero_and_infinity_have_no_waves(tmp_path):
    """Capytaine writes NaN loads there."""
    data = load()
    ends = data.isel(omega=[0, -1]).assign_coords(omega=[0.0, np.inf])
    ends["excitation_force"] = ends["excitation_force"] * np.nan
    file = save(xr.concat([data, ends], dim="omega", data_vars="minimal"), tmp_path)
    got = responses(file, "force", at(30.0), 0.0)
    assert (got == responses(BOX, "force", at(30.0), 0.0)).all()
    raw = read_variables(database_path(file), {"omega": ("omega",)}, {})["omega"]
    assert len(raw) == len(data.omega) + 2


@pytest.mark.parametrize(
    ("change", "parts"),
    [
        ({"omega": (3, np.nan)}, ("omega[3] is nan", ">= 0 rad/s")),
        ({"omega": (3, -1.0)}, ("omega[3] is -1", ">= 0 rad/s")),
        ({"omega": (3, None)}, ("omega has", "twice")),
    ],
)
def test_frequencies_that_are_none_are_refused(change, parts, tmp_path):
    data = load()
    place, value = change["omega"]
    omega = data["omega"].values.copy()
    omega[place] = omega[place + 1] if value is None else value
    path = save(data.assign_coords(omega=omega), tmp_path)
    for radiation in ("memory", "constant"):
        with model_error(*parts):
            floating(path, Environment(waves=regular_wave(0.1, 3.0)), radiation=radiation)


@pytest.mark.parametrize("value", [np.nan, -1025.0, 1.025, 1e9])
def test_density_of_the_file_is_checked(value, tmp_path):
    data = load()
    data.attrs["water_density"] = value
    with model_error("water_density of", f"{value:g} kg/m3", "100 to 20000"):
        floating(save(data, tmp_path), Environment(waves=regular_wave(0.1, 3.0)))


def test_unknown_unit_of_direction(tmp_path):
    data = load()
    data["wave_direction"].attrs["units"] = "gon"
    with model_error("wave_direction", "'gon'", "'rad' and 'degrees'"):
        floating(save(data, tmp_path), Environment(waves=regular_wave(0.1, 3.0)))
