"""Every refusal of a model by the hydrodynamics, by the words of its message."""

import mujoco
import numpy as np
import pytest
from conftest import model_error, numeric, one_body, with_database

import marine_mj
from marine_mj.environment import Environment, WaveField
from marine_mj.errors import ModelError
from marine_mj.hydrodynamics import compile_spec, read_coefficients, write_environment
from marine_mj.hydrodynamics.stability import largest_timestep

pytestmark = pytest.mark.usefixtures("log_elsewhere")


def refused(xml, *parts, environment=None, settings=None):
    """Load the MJCF, expect a ModelError with all parts in its message."""
    with model_error(*parts):
        marine_mj.load_xml(xml, environment, settings)


# Options under which the hydrodynamics would be wrong

OPTIONS = {
    "pgs": ('solver="PGS"', ("PGS", "Newton")),
    "noslip": ('noslip_iterations="3"', ("noslip_iterations is 3", "allowed is 0", "impratio")),
    "density": ('density="1000"', ("density is 1000", "count the water twice")),
    "viscosity": ('viscosity="0.001"', ("viscosity 0.001", "count the water twice")),
}


@pytest.mark.parametrize("name", OPTIONS)
def test_options(name):
    option, parts = OPTIONS[name]
    refused(one_body(added_mass=np.ones(6), option=option), *parts)
    # a plain model may use all of them
    marine_mj.load_xml(one_body(option=option))


@pytest.mark.parametrize(
    ("flag", "parts"),
    [
        ('spring="disable" damper="disable"', ("spring and damper", "never calls")),
        ('sleep="enable"', ("sleep is enabled", "added mass")),
    ],
)
def test_flags(flag, parts):
    xml = one_body(added_mass=np.ones(6)).replace(
        "<custom>", f"<option><flag {flag}/></option><custom>"
    )
    refused(xml, *parts)


def test_one_of_spring_and_damper_may_be_disabled():
    for flag in ("spring", "damper"):
        xml = one_body(added_mass=np.ones(6), gravity=0).replace(
            "<custom>", f'<option><flag {flag}="disable"/></option><custom>'
        )
        model = marine_mj.load_xml(xml)
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        # 10 kg and 1 kg of added mass
        assert data.M[0] == pytest.approx(11.0)


def test_gravity_has_to_agree():
    refused(
        one_body(added_mass=np.ones(6), gravity=9.7),
        "gravity of the model is 9.7",
        "9.81 in the environment",
    )


def test_gravity_has_to_point_down():
    xml = one_body(added_mass=np.ones(6)).replace('gravity="0 0 -9.81"', 'gravity="1 0 -9.81"')
    refused(xml, "gravity of the model is [", "straight down")


# Time step


def damped(integrator, timestep, quadratic=False):
    """10 kg + 5 kg of added mass with a damping of 300 N s/m in surge at the reference speed."""
    kind, drag = ("quadratic", 75.0) if quadratic else ("linear", 300.0)
    return one_body(
        added_mass=[5, 5, 5, 1, 1, 1],
        numerics=numeric(f"{kind}_damping_flu", f"{drag} 1 1 1 1 1"),
        center="0 0 0",
        gravity=0,
        integrator=integrator,
        timestep=timestep,
    )


@pytest.mark.parametrize("quadratic", [False, True])
def test_timestep_above_the_bound(quadratic):
    # 2 M / D = 2 * 15 / 300; the quadratic slope is 2 * 75 * 2 m/s
    refused(
        damped("implicitfast", 0.11, quadratic),
        "timestep is 0.11 s",
        "at most 0.1 s",
        "damping or restoring of 'a'",
        "2 m/s",
    )
    marine_mj.load_xml(damped("implicitfast", 0.099, quadratic))
    refused(damped("RK4", 0.15, quadratic), "timestep is 0.15 s", "at most 0.139 s")
    marine_mj.load_xml(damped("RK4", 0.138, quadratic))


def test_timestep_above_the_bound_of_restoring():
    xml = one_body(
        added_mass=[5, 5, 5, 1, 1, 1],
        numerics=numeric("restoring_flu", "0 0 1500 1 1 0"),
        center="0 0 0",
        timestep=0.21,
    )
    refused(xml, "timestep is 0.21 s", "at most 0.2 s")


def speed_after(integrator, factor):
    """Speed after 400 steps from 1 m/s, at `factor` times the largest stable time step."""
    spec = mujoco.MjSpec.from_string(damped(integrator, 0.005))
    body = read_coefficients(spec)[0]
    model = compile_spec(spec)
    bound = largest_timestep(model, body, marine_mj.hydrodynamics.BodySettings())
    model.opt.timestep = factor * bound
    data = mujoco.MjData(model)
    data.qvel[0] = 1.0
    mujoco.mj_step(model, data, 400)
    return abs(data.qvel[0])


@pytest.mark.parametrize("integrator", ["Euler", "implicit", "implicitfast", "RK4"])
def test_the_bound_is_the_true_one(integrator):
    assert speed_after(integrator, 0.98) < 1e-3  # measured 8e-8 (semi-implicit), 1e-16 (RK4)
    assert speed_after(integrator, 1.2) > 1e6


# Bodies and settings


def test_body_that_cannot_move():
    xml = one_body(added_mass=np.ones(6)).replace('<freejoint name="a"/>', "")
    refused(xml, "hydrodynamic body 'a' cannot move", "joint")


def test_too_many_degrees_of_freedom():
    inside = ""
    for number in range(49):
        name = "a" if number == 0 else f"b{number}"
        inside = (
            f'<body name="{name}"><joint axis="0 1 0"/><inertial pos="0 0 0" mass="1" '
            f'diaginertia="1 1 1"/>{inside}</body>'
        )
    xml = (
        f"<mujoco><custom>{numeric('added_mass_flu', '1 1 1 1 1 1')}</custom>"
        f"<worldbody>{inside}</worldbody></mujoco>"
    )
    refused(xml, "49 degrees of freedom move the body 'a'", "allowed are 48")


def test_settings_of_an_unknown_body():
    refused(
        one_body(added_mass=np.ones(6)),
        "settings name the body 'hull'",
        "['a']",
        settings={"hull": {"strips": False}},
    )


def test_unknown_setting():
    refused(
        one_body(added_mass=np.ones(6)),
        "setting 'stripes' of 'a'",
        "did you mean 'strips'",
        settings={"a": {"stripes": False}},
    )


def test_unknown_motion():
    refused(
        one_body(added_mass=np.ones(6)),
        "motion is 'held'",
        "free, dynamic, rao, fixed",
        settings={"a": {"motion": "held"}},
    )


@pytest.mark.parametrize("motion", ["rao", "dynamic"])
def test_motion_without_wave_database(motion):
    refused(
        one_body(added_mass=np.ones(6)),
        f"motion '{motion}' of 'a' needs RAOs",
        "a.wave_database",
        settings={"a": {"motion": motion}},
    )


SEA = WaveField(np.ones(1), np.full(1, 1 / 9.81), np.zeros(1), np.ones(1), np.zeros(1))


def test_missing_wave_database():
    refused(
        with_database("no_such.nc"),
        "wave database 'no_such.nc' does not exist",
        "dus_v5750_box.nc",
        environment=Environment(waves=SEA),
    )


def test_damaged_wave_database(tmp_path):
    path = tmp_path / "damaged.nc"
    path.write_bytes(b"not a NetCDF file")
    refused(
        with_database(path),
        "damaged.nc is not a wave database",
        "excitation_force",
        environment=Environment(waves=SEA),
    )


def test_wave_database_of_an_unknown_body():
    refused(with_database("dus_v5750_box.nc", "hull"), "'hull.wave_database'", "['a']")


def test_prescribed_motion_of_a_body_without_free_joint():
    xml = with_database("dus_v5750_box.nc").replace(
        '<freejoint name="a"/>', '<joint type="slide" axis="0 0 1"/>'
    )
    refused(xml, "motion 'rao' of 'a'", "free joint", settings={"a": {"motion": "rao"}})


def test_too_many_wave_components():
    n = 501
    sea = WaveField(
        np.linspace(0.5, 3, n),
        np.linspace(0.5, 3, n) ** 2 / 9.81,
        np.zeros(n),
        np.full(n, 1e-3),
        np.zeros(n),
    )
    refused(
        one_body(added_mass=np.ones(6)),
        "501 components",
        "allowed are 500",
        environment=Environment(waves=sea),
    )


def test_environment_of_another_size():
    spec = mujoco.MjSpec.from_string(one_body(added_mass=np.ones(6)))
    bodies = read_coefficients(spec)
    model = compile_spec(spec)
    with pytest.raises(ModelError, match=r"needs a table of \d+ numbers, the model has \d+"):
        write_environment(model, bodies, Environment(waves=SEA))


# Files and names


def test_unknown_vehicle():
    with pytest.raises(ModelError, match="unknown vehicle 'no_such_thing'; there are"):
        marine_mj.load("no_such_thing")


def test_similar_vehicle(tmp_path, monkeypatch):
    folder = tmp_path / "models" / "gannet"
    folder.mkdir(parents=True)
    (folder / "gannet.xml").write_text(one_body(added_mass=np.ones(6)))
    monkeypatch.chdir(tmp_path)
    assert marine_mj.load("gannet").nv == 6
    with pytest.raises(ModelError, match="unknown vehicle 'ganet'; did you mean 'gannet'"):
        marine_mj.load("ganet")


def test_file_that_does_not_exist():
    refused("no/such/file.xml", "cannot read the MJCF 'no/such/file.xml'")


def test_broken_mjcf():
    refused("<mujoco><worldbody>", "cannot read the MJCF")
    refused(one_body(added_mass=np.ones(6), mass=-1), "cannot ", "MJCF", "mass")
