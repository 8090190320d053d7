"""Wave drift: coefficients of a database or a file, choices, refusals, bits."""

from pathlib import Path

import marine_mj.assets
import mujoco
import numpy as np
import pytest
import xarray as xr
from conftest import model_error, numbers, one_body
from drift_cases import FILE, RHO, ROWS, G, boat, expected_drift, force, waves_of
from mujoco import batch

import marine_mj
from marine_mj.environment import Environment, irregular_sea, regular_wave
from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.coefficients import BodyCoefficients
from marine_mj.hydrodynamics.drift import drift_of, mean_drift
from marine_mj.hydrodynamics.native import records, table_of
from marine_mj.scenario import Scenario
from marine_mj.scene import body_settings, build_scene


@pytest.fixture(scope="module")
def database():
    """omega (n,), direction (m,), mean drift (n, m, 3), 0 to 180 deg as the file has it."""
    path = Path(marine_mj.assets.__file__).parent / FILE
    with xr.open_dataset(path, engine="h5netcdf") as data:
        drift = data["mean_drift_force"].sel(drift_dof=["Surge", "Sway", "Yaw"])
        drift = drift.transpose("omega", "wave_direction", "drift_dof").values.astype(float)
        return data["omega"].values, data["wave_direction"].values, drift


def usv(waves, numerics="", **settings):
    """The USV's box as body `a` with its database."""
    xml = one_body(
        numerics=f'<text name="a.wave_database" data="{FILE}"/>'
        '<numeric name="a.restoring_frd" data="0 0 75414 10745 153703 0"/>' + numerics,
        added_mass=[300, 800, 8000, 400, 9500, 1500],
        mass=2306.0,
        center="0 0 0",
        inertia="1040 5412 5237",
        pos="0 0 0",
    )
    return marine_mj.load_xml(xml, Environment(waves=waves), {"a": settings})


def kinds(model):
    """Kinds of the elements of the first body."""
    table = table_of(model)
    record = records(table)[0]
    place, found = int(record[t_.B_ELEMENT_DATA]), []
    for _ in range(int(record[t_.B_ELEMENTS])):
        found.append(table[place + t_.EL_KIND])
        place += int(table[place + t_.EL_SIZE])
    return found


@pytest.mark.parametrize("yaw_steps", [0, 7, 18])
@pytest.mark.parametrize("column", [0, 3, 9])
def test_drift_of_a_database(database, yaw_steps, column):
    """At its own frequencies and directions, on top of the first-order force."""
    omega, direction, drift = database
    index, yaw = 27, np.radians(15 * yaw_steps)
    sea = regular_wave(0.4, 2 * np.pi / omega[index], direction[column] + yaw, phase=0.3)
    wrench = {
        name: force(usv(sea, drift=name), 7.7, 4.0, -9.0, yaw) for name in ("none", "mean", "slow")
    }
    expected = 0.04 * drift[index, column]
    for name in ("mean", "slow"):
        got = (wrench[name] - wrench["none"])[[0, 1, 5]]
        # measured 7e-14 N
        np.testing.assert_allclose(got, expected, atol=1e-10 * abs(drift[index]).max())


def test_database_of_a_symmetric_box(database):
    """No sway in head seas, no surge in beam seas, bow as stern, waves push along."""
    omega, direction, drift = database
    np.testing.assert_allclose(np.degrees(direction), np.arange(0, 181, 11.25), atol=1e-9)
    scale = abs(drift).max(axis=(0, 1))
    astern = drift[:, ::-1] * [-1, 1, -1]
    # measured 5e-12 of the largest
    np.testing.assert_allclose(astern, drift, atol=1e-6 * scale.max())
    assert abs(drift[:, [0, -1]][..., 1:]).max() < 1e-6 * scale.max()
    assert abs(drift[:, 8, 0]).max() < 1e-6 * scale.max()
    # shortest waves: the asymptote 1/2 rho g B and 1/2 rho g L of a wall; measured 0.94 and 0.87
    ends, sides = drift[-1, 0, 0] / (0.5 * RHO * G * 1.5), drift[-1, 8, 1] / (0.5 * RHO * G * 5.0)
    assert ends == pytest.approx(1, abs=0.15)
    assert sides == pytest.approx(1, abs=0.15)
    assert omega[-1] ** 2 / G * 0.3 > 1  # draft beyond the waves' depth


SEA = irregular_sea(0.8, 4.0, components=20, seed=1)


def test_default_is_slow_with_coefficients():
    assert t_.DRIFT in kinds(boat(SEA))
    assert t_.DRIFT in kinds(usv(SEA))
    slow = usv(SEA, drift="slow")
    assert (table_of(usv(SEA)) == table_of(slow)).all()


def test_file_comes_before_the_database():
    rows = f'<numeric name="a.drift" data="{numbers(ROWS)}"/>'
    sea = waves_of([1.3], 0.5, np.pi / 2)
    own, none = (force(usv(sea, rows, drift=d)) for d in ("mean", "none"))
    expected = 0.25 * expected_drift(1.3, np.pi / 2)[1]
    assert (own - none)[1] == pytest.approx(expected, rel=1e-9)  # measured 2e-16


def test_none_costs_nothing():
    """No element, and the bits of a body that has no coefficients at all."""
    xml = one_body(added_mass=np.ones(6), pos="0 0 0", gravity=0)
    bare = marine_mj.load_xml(xml, Environment(waves=SEA))
    off = boat(SEA, "none", added_mass=np.ones(6))
    assert (table_of(off) == table_of(bare)).all()
    assert t_.DRIFT not in kinds(usv(SEA, drift="none"))
    assert t_.DRIFT not in kinds(usv(SEA, motion="rao"))
    assert t_.DRIFT not in kinds(usv(Environment().waves))  # calm


def test_scenario_chooses_the_drift():
    for chosen in (None, "none", "mean"):
        values = {"vehicles.usv.drift": chosen}
        scenario = Scenario.load("docking_demo").with_values(values)
        assert body_settings(scenario, build_scene(scenario))["usv/hull"]["drift"] == chosen


@pytest.mark.parametrize("drift", ["mean", "slow"])
def test_batch_with_one_and_two_threads(drift):
    model = usv(SEA, drift=drift)
    record = mujoco.mjtState.mjSTATE_FULLPHYSICS
    control = np.zeros((4, 100, model.nu))
    control[:, :, 0] = np.arange(4)[:, None] * 50.0
    got = [
        batch.Batch(model, 4, nthread=threads).rollout(
            100, control, int(mujoco.mjtState.mjSTATE_CTRL), record=[record]
        )[record]
        for threads in (1, 2)
    ]
    assert (got[0] == got[1]).all()
    data = mujoco.MjData(model)
    data.ctrl[0] = 50.0
    mujoco.mj_step(model, data, 100)
    state = np.zeros(mujoco.mj_stateSize(model, record))
    mujoco.mj_getState(model, data, state, record)
    assert (got[0][1, -1] == state).all()


@pytest.mark.parametrize("drift", ["mean", "slow"])
def test_state_that_is_not_a_number(drift):
    """The kernel reads no table at a heading that is none: NaN, and no crash."""
    model = usv(SEA, drift=drift)
    data = mujoco.MjData(model)
    data.qpos[:] = np.nan
    mujoco.mj_forward(model, data)
    assert np.isnan(data.qacc).any()


def test_calm_water_needs_no_database():
    text = '<text name="a.wave_database" data="no_such.nc"/>'
    xml = one_body(numerics=text, added_mass=np.ones(6), pos="0 0 0")
    assert kinds(marine_mj.load_xml(xml, settings={"a": {"radiation": "constant"}})) == []


@pytest.mark.parametrize(
    "rows", [[[0.0, 1, 1, 0]], [[1.0, -1, 1, 0]], [[1.0, 1, 1, 0], [1.0, 1, 1, 0]]]
)
def test_wrong_rows(rows):
    with model_error("drift of 'a'", "rising", "D_n"):
        boat(SEA, rows=np.array(rows))


def test_wrong_number_of_values():
    with model_error("numeric 'a.drift' has 5 values", "4 or 8"):
        boat(SEA, rows=np.ones(5))


def test_unknown_drift():
    with model_error("drift is 'fast'", "none, mean, slow"):
        boat(SEA, "fast")


def test_drift_without_coefficients():
    xml = one_body(added_mass=np.ones(6))
    load = marine_mj.load_xml
    with model_error("drift 'slow' of 'a'", "a.drift"):
        load(xml, None, {"a": {"drift": "slow"}})


def test_drift_of_prescribed_motion():
    with model_error("drift 'mean' of 'a'", "prescribed"):
        usv(SEA, motion="rao", drift="mean")


def body_with(tmp_path, values, name="mean_drift_force", symmetry="xz"):
    """Coefficients of a body whose database holds one variable."""
    path = tmp_path / f"{len(list(tmp_path.iterdir()))}.nc"
    data = values.to_dataset(name=name).assign_attrs(hull_symmetry=symmetry)
    data.to_netcdf(path, engine="h5netcdf")
    return BodyCoefficients("a", np.zeros((6, 6)), wave_database=str(path))


def test_databases_that_lack_drift(tmp_path):
    """Without the variable: none by default, refused when asked for; damaged ones are refused."""
    path = Path(marine_mj.assets.__file__).parent / FILE
    with xr.open_dataset(path, engine="h5netcdf") as data:
        drift = data["mean_drift_force"].drop_vars(["period", "wavenumber"]).load()
    plain = body_with(tmp_path, drift, "other")
    assert drift_of(plain, None, "dynamic") == "none"
    with model_error("needs coefficients", "mean_drift_force"):
        drift_of(plain, "slow", "dynamic")
    with model_error("has no mean_drift_force"):
        mean_drift(plain, Environment(waves=SEA), 0.0)
    whole = body_with(tmp_path, drift[::-1])
    assert drift_of(whole, None, "dynamic") == "slow"
    assert drift_of(whole, None, "free") == "none"
    assert drift_of(whole, "mean", "free") == "mean"
    ours, turned = (
        mean_drift(BodyCoefficients("a", np.zeros((6, 6)), wave_database=f), env, 0.3)
        for f in (FILE, whole.wave_database)
        for env in (Environment(waves=SEA),)
    )
    np.testing.assert_array_equal(ours, turned)  # the order of the frequencies does not matter
    half = body_with(tmp_path, drift, symmetry="none")
    with model_error("circle open from 180 to 360 deg", "gaps up to 60", 'hull_symmetry = "xz"'):
        drift_of(half, None, "dynamic")
    part = body_with(tmp_path, drift[:, :13])
    with model_error("circle open from 135 to 225 deg", "compute the directions that are missing"):
        drift_of(part, None, "dynamic")
    nan = body_with(tmp_path, drift * np.nan)
    with model_error("holds NaN"):
        drift_of(nan, None, "dynamic")
    lost = body_with(tmp_path, drift[:, :, :2])
    with model_error("(omega, wave_direction, drift_dof)", "Yaw"):
        drift_of(lost, None, "dynamic")
