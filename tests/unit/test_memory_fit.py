"""Radiation memory: recovery of known models, and every refusal."""

import shutil
from pathlib import Path

import marine_mj.assets
import mujoco
import numpy as np
import pytest
import xarray as xr
from conftest import model_error, one_body

import marine_mj
from marine_mj.errors import ModelError
from marine_mj.hydrodynamics import Memory, database_memory, fit_memory, load
from marine_mj.hydrodynamics.fit_database import store_memory
from marine_mj.hydrodynamics.memory_pack import memory_element
from marine_mj.hydrodynamics.memory_store import memory_report, read_radiation
from marine_mj.hydrodynamics.table import LF_STATES

FILE = "dus_v5750_box.nc"
DATABASE = Path(marine_mj.assets.__file__).parent / FILE
OMEGA = np.linspace(0.2, 6.0, 40)
INFINITE = np.diag([100.0, 400, 5000, 360, 7600, 750]) + 20 * (np.eye(6, k=4) + np.eye(6, k=-4))


def known(s):
    """K(s) (n, 6, 6) = sum R s / (s^2 + 2 zeta w s + w^2), R >= 0: passive; and no yaw."""
    total = np.zeros((len(s), 6, 6), dtype=complex)
    terms = (  # frequency, damping ratio, (degrees of freedom, their drive)
        (2.0, 0.4, {0: 20.0, 4: 60.0}),
        (3.5, 0.3, {0: 30.0, 4: -40.0}),
        (2.8, 0.5, {1: 40.0, 3: -8.0}),
        (4.5, 0.35, {1: 50.0, 3: 6.0}),
        (2.2, 0.6, {2: 90.0}),
        (3.9, 0.4, {2: 50.0}),
    )
    for w, zeta, drive in terms:
        v = np.zeros(6)
        v[list(drive)] = list(drive.values())
        shape = 2 * zeta * w * s / (s**2 + 2 * zeta * w * s + w**2)
        total += shape[:, None, None] * np.outer(v, v)
    return total


def sampled(omega=OMEGA):
    """A and B (n, 6, 6) as a panel code would give them."""
    K = known(1j * omega)
    return INFINITE + K.imag / omega[:, None, None], K.real


@pytest.fixture(scope="module")
def recovered() -> Memory:
    """The fit of the known model."""
    return fit_memory(OMEGA, *sampled(), INFINITE, target=1e-4)


def test_known_model_is_recovered_far_beyond_the_data(recovered):
    omega = np.geomspace(0.01, 60.0, 200)
    K = known(1j * omega)
    error = np.abs(recovered.retardation(omega) - K).max() / np.abs(K).max()
    # measured 5e-16: the order is found, too
    assert error < 1e-6
    assert [len(poles) for _, poles in recovered.groups] == [2, 2, 2]
    assert recovered.states == 2 * (2 * 2 + 2 * 2 + 2)


def test_impulse_response_is_the_cosine_transform_of_the_damping(recovered):
    t = np.linspace(0.05, 8.0, 60)
    step = 4e-3
    omega = (np.arange(100_000) + 0.5) * step  # to 400 rad/s
    B = known(1j * omega)[:, [0, 0, 1, 2], [0, 4, 3, 2]].real
    expected = np.array([2 / np.pi * (B * np.cos(omega * x)[:, None]).sum(axis=0) for x in t])
    got = recovered.impulse_response(t)[:, [0, 0, 1, 2], [0, 4, 3, 2]]
    # measured 2.2e-4 of the largest: B ~ omega^-2 goes on beyond 400 rad/s
    assert np.abs(got - step * expected).max() < 5e-4 * np.abs(got).max()


def test_state_space_and_step_are_the_transfer_function(recovered):
    A, B, C = recovered.state_space()
    for w in (0.3, 2.0, 9.0):
        K = C @ np.linalg.solve(1j * w * np.eye(len(A)) - A, B)
        # measured 3e-12
        np.testing.assert_allclose(K, recovered.retardation([w])[0], atol=1e-8)
    assert (np.linalg.eigvals(A).real < 0).all()
    # zero-order hold against many small steps of Euler's midpoint rule
    step, nu = 0.05, np.arange(1.0, 7.0)
    x0 = np.linspace(-1, 1, len(A))
    Phi, Gamma = recovered.discrete(step)
    x, h = x0.copy(), step / 2000
    for _ in range(2000):
        x = x + h * (A @ (x + 0.5 * h * (A @ x + B @ nu)) + B @ nu)
    # measured 3e-10
    np.testing.assert_allclose(Phi @ x0 + Gamma @ nu, x, atol=1e-8)


def test_fit_is_symmetric_deterministic_and_zero_at_both_ends(recovered):
    again = fit_memory(OMEGA, *sampled(), INFINITE, target=1e-4)
    assert (again.poles == recovered.poles).all()
    assert (again.residues == recovered.residues).all()
    assert (again.residues == again.residues.transpose(0, 2, 1)).all()
    size = np.abs(recovered.retardation(OMEGA)).max()
    assert np.abs(recovered.retardation([0.0])).max() < 1e-9 * size  # measured 2e-16
    assert np.abs(recovered.retardation([1e5])).max() < 1e-3 * size  # measured 3e-5


def test_fit_of_the_box_is_good_and_passive():
    report = memory_report(FILE)
    names = {pair.name: pair for pair in report}
    assert set(names) >= {"heave", "surge-pitch", "sway-roll", "yaw"} and len(names) == 8
    for pair in report:  # measured: worst error 0.0099 (roll), R2 0.9994 (A of roll)
        assert pair.error < 0.011 and min(pair.r2_damping, pair.r2_added_mass) > 0.999
    memory = database_memory(FILE)
    memory.check()
    K = memory.retardation(np.geomspace(0.01, 1000, 3000)).real
    lowest = np.linalg.eigvalsh(K)
    # measured 1.7e-7 of the largest
    assert (lowest[:, 0] >= 0).all()


def test_memory_never_gives_net_energy():
    """Cumulative work of mu on any motion, exact integration between the samples."""
    memory = database_memory(FILE)
    Phi, Gamma = memory.discrete(0.01)
    C = memory.state_space()[2]
    scale = np.sqrt(np.abs(memory.retardation(OMEGA)).max(axis=0).diagonal())
    lowest, spent = 0.0, []
    for seed in range(6):
        rng = np.random.default_rng(seed)
        noise = rng.normal(size=(4000, 6)) / scale
        smooth = np.exp(-0.01 * rng.uniform(0.3, 30.0))  # correlation times from 0.03 to 3 s
        x, nu, work = np.zeros(memory.states), np.zeros(6), 0.0
        for kick in noise:
            nu = smooth * nu + kick
            following = Phi @ x + Gamma @ nu
            work += 0.01 * nu @ C @ (0.5 * (x + following))
            lowest = min(lowest, work)
            x = following
        spent.append(work)
    # measured: never below 0, at the end 15 to 300 J
    assert lowest >= 0 and min(spent) > 1


# Refusals


def refused(*words, omega=OMEGA, added=None, damping=None, infinite=INFINITE, **options):
    """fit_memory raises a ModelError with these words."""
    A, B = sampled() if len(omega) == 40 else (np.zeros((len(omega), 6, 6)),) * 2
    with model_error(*words):
        added = A if added is None else added
        fit_memory(omega, added, B if damping is None else damping, infinite, **options)


def test_damping_that_feeds_energy_is_refused():
    B = sampled()[1]
    B[20, 2, 2] *= -0.5
    refused("damping at 3.174 rad/s", "eigenvalue -0.", "allowed is >= -0.02", "lid", damping=B)


def test_wrong_infinite_added_mass_is_refused_by_the_name_of_the_pair():
    wrong = INFINITE.copy()
    wrong[2, 2] *= 1.5
    refused("memory in heave has the error", "allowed is 0.05", "more frequencies", infinite=wrong)


def test_poles_far_above_the_data_are_refused():
    wrong = INFINITE.copy()
    wrong[2, 2] += 1e5
    refused("no passive radiation memory", "in heave", "check infinite_added_mass", infinite=wrong)


def test_negative_infinite_added_mass_is_refused():
    wrong = INFINITE.copy()
    wrong[2, 2] = -300.0
    refused("A(inf) of the radiation data has the eigenvalue -300", ">= 0", infinite=wrong)


def test_too_low_an_order_is_refused():
    with xr.open_dataset(DATABASE, engine="h5netcdf") as data:
        A, B = data["added_mass"].values, data["radiation_damping"].values
        omega, infinite = data["omega"].values, data["infinite_added_mass"].values
    with pytest.raises(ModelError, match=r"memory in \w+(-\w+)? has the error 0\.\d+ at order 4"):
        fit_memory(omega, A, B, infinite, most_poles=2)


def test_shapes_frequencies_and_symmetry():
    A = sampled()[0]
    refused("shapes omega (5,)", "n >= 8", omega=OMEGA[:5])
    refused("finite, positive, rising", omega=OMEGA[::-1])
    A[3, 0, 4] += 400
    refused("added mass (surge, pitch) and its mirror differ by", "allowed is 0.05", added=A)


def test_unstable_and_active_models_are_refused():
    memory = database_memory(FILE)
    poles = memory.poles.copy()
    poles[0] = 0.1 + 2j
    with pytest.raises(ModelError, match=r"pole of the radiation memory is 0\.1\+2j rad/s"):
        Memory(memory.infinite_added_mass, poles, memory.residues).check()
    with pytest.raises(ModelError, match=r"not passive: the smallest eigenvalue .* at .* rad/s"):
        Memory(memory.infinite_added_mass, memory.poles, -memory.residues).check()


def edited(tmp_path, change, memory=False):
    """A copy of the database with a change, without its stored fit unless asked for."""
    with xr.open_dataset(DATABASE, engine="h5netcdf") as file:
        data = file.load()
    if not memory:
        data = data.drop_vars(["memory_poles", "memory_residues"])
    path = tmp_path / "edited.nc"
    change(data).to_netcdf(path, engine="h5netcdf")
    return path


def test_stored_fit_is_the_fit_of_the_data(tmp_path):
    path = tmp_path / "copy.nc"
    shutil.copy(DATABASE, path)
    fresh = store_memory(path)
    with (
        xr.open_dataset(path, engine="h5netcdf") as new,
        xr.open_dataset(DATABASE, engine="h5netcdf") as old,
    ):
        fit = ["memory_poles", "memory_residues"]
        assert new.drop_vars(fit).identical(old.drop_vars(fit))
        for name, values in zip(fit, (fresh.poles, fresh.residues), strict=True):
            assert (new[name].values == [values.real, values.imag]).all()
    shipped = database_memory(FILE)
    omega = np.geomspace(0.05, 50, 100)
    K = shipped.retardation(omega)
    # another machine may round otherwise; measured here 0
    assert np.abs(fresh.retardation(omega) - K).max() < 1e-6 * np.abs(K).max()


def test_added_mass_at_infinite_frequency_stands_for_the_variable(tmp_path):
    def change(data):
        radiation = data[["added_mass", "radiation_damping"]]
        last = radiation.isel(omega=-1).assign_coords(omega=np.inf) * 0
        last["added_mass"] = data["infinite_added_mass"]
        drop = ["infinite_added_mass"]
        kept = data.drop_vars([*drop, "period", "wavenumber"])
        return kept.drop_dims("omega").merge(
            xr.concat([radiation.drop_vars(["period", "wavenumber"]), last], dim="omega")
        )

    data, stored = read_radiation(edited(tmp_path, change))
    expected, _ = read_radiation(DATABASE)
    assert not stored
    for name, values in expected.items():
        np.testing.assert_array_equal(data[name], values)


def test_stored_fit_of_other_data_is_refused(tmp_path):
    def change(data):
        data["radiation_damping"] = data["radiation_damping"] * 1.3
        return data

    with pytest.raises(ModelError, match=r"edited\.nc does not belong to its data: .*fit_database"):
        database_memory(str(edited(tmp_path, change, memory=True)))


def floating(path, **settings):
    """A model of a body with that database."""
    numerics = (
        f'<text name="a.wave_database" data="{path}"/>'
        '<numeric name="a.restoring_frd" data="0 0 75414 10745 153703 0"/>'
    )
    xml = one_body(added_mass=np.ones(6), numerics=numerics, mass=2306, inertia="1040 5412 5237")
    return marine_mj.load_xml(xml, settings={"a": settings})


def test_database_without_infinite_frequency(tmp_path):
    path = edited(tmp_path, lambda data: data.drop_vars("infinite_added_mass"))
    assert floating(path).na == LF_STATES  # constants, as nothing else was asked for
    with pytest.raises(ModelError, match=r"edited\.nc has no radiation memory .*'constant'"):
        floating(path, radiation="memory")


def test_settings_that_do_not_go_together():
    with pytest.raises(ModelError, match="radiation is 'exact', allowed are memory, constant"):
        floating(FILE, radiation="exact")
    with pytest.raises(ModelError, match="radiation 'memory' of 'a' needs the motion 'dynamic'"):
        floating(FILE, radiation="memory", motion="rao")


def test_body_without_a_joint_of_its_own_is_refused():
    xml = (
        "<mujoco><custom>"
        f'<text name="b.wave_database" data="{FILE}"/>'
        '<numeric name="b.added_mass_flu" data="1 1 1 1 1 1"/></custom><worldbody>'
        '<body name="a"><freejoint/><geom size="1" mass="2306"/>'
        '<body name="b"><geom size="1" mass="1"/></body></body></worldbody></mujoco>'
    )
    with pytest.raises(ModelError, match="'b' has radiation memory but no joint of its own"):
        marine_mj.load_xml(xml)


def test_more_poles_than_the_kernel_has_room_for():
    many = Memory(np.eye(6), np.full(49, -1 + 1j), np.zeros((49, 6, 6), dtype=complex))
    with pytest.raises(ModelError, match="memory of 'a' has 49 poles, allowed are 48"):
        memory_element(mujoco.MjModel.from_xml_string("<mujoco/>"), "a", many)


def test_disabled_actuation_is_refused():
    xml = one_body(
        added_mass=np.ones(6),
        numerics=f'<text name="a.wave_database" data="{FILE}"/>',
        mass=2306,
        tail='<option><flag actuation="disable"/></option>',
    )
    with pytest.raises(ModelError, match="radiation memory of 'a' would stand still"):
        marine_mj.load_xml(xml)


def test_actuators_keep_their_places_and_the_memory_has_no_force():
    model = floating(FILE)
    assert model.actuator(0).name == "t" and model.actuator(1).name == "marine_mj/memory/a"
    assert model.na - LF_STATES == database_memory(FILE).states == 54
    data = mujoco.MjData(model)
    data.act[:] = 1.0
    data.ctrl[1] = 5.0
    mujoco.mj_forward(model, data)
    assert (data.qfrc_actuator == 0).all()
    assert load("dus_v5750", settings={"hull": {"radiation": "constant"}}).na == LF_STATES
