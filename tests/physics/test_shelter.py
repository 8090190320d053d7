"""The water motion near a floating hull: kernel, limits, refusals, the field itself."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest
import trimesh
import xarray as xr
from scipy.interpolate import RegularGridInterpolator

from marine_mj import cli
from marine_mj.environment import Environment, WaveField, calm
from marine_mj.errors import ModelError, ScenarioError
from marine_mj.frames import rotation_from_quaternion
from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.bem.rao import motion_raos
from marine_mj.hydrodynamics.bem.response import respond, shelter_of
from marine_mj.hydrodynamics.bem.settings import Settings
from marine_mj.hydrodynamics.bem.shelter import disturbance, shelter_database, shelter_grid
from marine_mj.hydrodynamics.bem.solver import solve_bodies
from marine_mj.hydrodynamics.bem.study import read_hull
from marine_mj.hydrodynamics.native import table_of
from marine_mj.hydrodynamics.raos import database_path
from marine_mj.hydrodynamics.shelter import read_field
from marine_mj.scenario import Scenario
from marine_mj.scene import compile_scene
from marine_mj.validation.multibody import SCENE, usv_part, water_acceleration

DATABASE = "dus_v5750_shelter.nc"
BARE = SCENE.with_values({"vehicles.auv.sheltered_by": None})


def sea(periods, directions, amplitudes, phases):
    """Deep-water waves."""
    omega = 2 * np.pi / np.asarray(periods)
    return WaveField(
        omega=omega,
        wavenumber=omega**2 / 9.81,
        direction=np.asarray(directions, dtype=float),
        amplitude=np.asarray(amplitudes, dtype=float),
        phase=np.asarray(phases, dtype=float),
    )


def scenes(waves):
    """The Scout as one point, with and without shelter."""
    point = {"vehicles.auv.strips": False}
    return [
        compile_scene(scenario.with_values(point), Environment(waves=waves), visual=False)
        for scenario in (SCENE, BARE)
    ]


def added(pair, vehicle, hull, time):
    """Acceleration (3) that the hull adds at the vehicle's origin, as the kernel gives it."""
    on, off = (water_acceleration(scene, vehicle, hull, time) for scene in pair)
    return on - off


@pytest.mark.parametrize("yaw", [0.0, np.pi / 4])
def test_kernel_is_the_database(yaw):
    """Trilinear field times the strengths at the hull, summed by NumPy straight from the file."""
    with xr.open_dataset(database_path(DATABASE), engine="h5netcdf") as data:
        data = data.load()
    number = [20, 30, 8, 25]
    angle = [4, 0, 20, 12]  # multiples of 45 degrees: headings of the table
    omega = data["omega"].values[number].astype(float)
    # on the database's directions, as seen from the hull
    directions = data["wave_direction"].values[angle] + yaw
    waves = sea(2 * np.pi / omega, directions, [0.3, 0.2, 0.5, 0.1], [0.3, 1.0, -2.0, 4.0])
    pair = scenes(waves)
    origin, time = np.array([12.0, -1.0, 0.2]), 7.3
    for pitch, roll in ((0.0, 0.0), (0.1, -0.07)):
        quaternion = np.array([1.0, 0, 0, 0])
        for axis, by in ((2, yaw), (1, pitch), (0, roll)):  # yaw, then pitch, then roll
            turn, both = np.zeros(4), np.zeros(4)
            turn[0], turn[1 + axis] = np.cos(0.5 * by), np.sin(0.5 * by)
            mujoco.mju_mulQuat(both, quaternion, turn)
            quaternion = both
        R = rotation_from_quaternion(quaternion)
        for local in ([0.3, 0.2, -0.9], [-2.1, -0.7, -0.45], [1.7, 0.9, -2.6], [0.0, 0.0, -0.2]):
            point = origin + R @ local
            got = added(pair, point, (origin, quaternion), time)
            axes = [data[name].values for name in "xyz"]
            inside = np.minimum(local, [9, 9, axes[2][-1]])
            field = RegularGridInterpolator(axes, data["field"].values.astype(float))(inside)[0]
            strength = data["shelter_strength"].values.astype(float)
            S = (strength[0] + 1j * strength[1])[number, angle]
            theta = waves.wavenumber * (
                origin[0] * np.cos(directions) + origin[1] * np.sin(directions)
            )
            phasor = waves.amplitude * np.exp(1j * (theta - omega * time + waves.phase))
            expected = R @ (field @ ((-1j * omega * phasor) @ S).real)
            np.testing.assert_allclose(got, expected, atol=1e-12)  # measured 1e-15


def test_nothing_in_long_waves_and_far_below():
    level = np.array([10.0, 0, 0]), np.array([1.0, 0, 0, 0])
    for period, depth, limit in ((20.0, 1.0, 0.003), (3.0, 3.0, 0.04), (3.0, 4.6, 0.0)):
        waves = sea([period], [0.0], [0.1], [0.0])
        own = waves.omega[0] ** 2 * 0.1 * np.exp(-waves.wavenumber[0] * depth)
        pair = scenes(waves)
        change = [added(pair, np.array([10.0, 0, -depth]), level, t) for t in (0, period / 4)]
        # measured 0.0013 in 20 s waves at 1 m; 0.019 at 3 m; 0 below the grid
        assert np.abs(change).max() <= limit * own


def test_far_away_and_in_calm_water_the_bits_are_those_without():
    far = {"vehicles.auv.position_ned": [30.0, 0.0, 2.0]}
    waves = sea([3.0, 5.0], [0.2, 0.0], [0.2, 0.3], [0.0, 1.0])
    for environment in (Environment(waves=waves), Environment(waves=calm())):
        ends = []
        for scenario in (SCENE, BARE):
            scene = compile_scene(scenario.with_values(far), environment, visual=False)
            data = mujoco.MjData(scene.model)
            mujoco.mj_step(scene.model, data, 50)
            ends.append(np.concatenate([data.qpos, data.qvel]))
        np.testing.assert_array_equal(*ends)


def test_fades_out_and_knows_no_nan():
    """Zero on the outer nodes, so nothing jumps at the border; a lost vehicle harms nobody."""
    x, _, z, field = read_field(database_path(DATABASE))
    for side in (field[0], field[-1], field[:, 0], field[:, -1], field[:, :, 0]):
        assert not side.any()
    assert np.abs(field[1:-1, 1:-1, 1:]).max() > 0.01
    level = np.array([10.0, 0, 0]), np.array([1.0, 0, 0, 0])
    waves = sea([3.0], [0.0], [0.1], [0.0])
    near = added(scenes(waves), np.array([10.0 + x[-1] - 1e-9, 0, -1.0]), level, 0.4)
    assert np.abs(near).max() < 1e-9  # measured 1e-11
    scene = compile_scene(SCENE, Environment(waves=waves), visual=False)
    data = mujoco.MjData(scene.model)
    data.qpos[:] = np.nan
    mujoco.mj_forward(scene.model, data)  # does not crash
    assert z[-1] < -0.3


def test_off_costs_no_table():
    waves = Environment(waves=sea([3.0], [0.0], [0.1], [0.0]))
    on, off = (compile_scene(s, waves, visual=False).model for s in (SCENE, BARE))
    records = int(table_of(off)[t_.H_FIRST_BODY])
    assert table_of(off)[records + t_.B_SHELTER] == 0
    assert len(table_of(on)) > len(table_of(off))


def test_refusals():
    with pytest.raises(ModelError, match=r"bodies is empty; allowed are one or more"):
        solve_bodies([], omega=np.ones(1), directions=np.zeros(1), density=1025.0)
    with pytest.raises(ScenarioError, match=r"auv\.sheltered_by is 'ship'; allowed .* usv"):
        SCENE.with_values({"vehicles.auv.sheltered_by": "ship"})
    with pytest.raises(ScenarioError, match=r"sheltered_by is 'auv'; allowed is another"):
        SCENE.with_values({"vehicles.auv.sheltered_by": "auv"})
    with pytest.raises(
        ModelError, match=r"sheltered_by of 'usv/hull' is 'auv/hull'.*there is none"
    ):
        compile_scene(BARE.with_values({"vehicles.usv.sheltered_by": "auv"}))
    two = Scenario.load("docking_demo").model_dump()
    two["vehicles"]["other"] = dict(two["vehicles"]["usv"], dock=None, sheltered_by="usv")
    with pytest.raises(ModelError, match=r"has motion 'dynamic' and sheltered_by.*allowed is"):
        compile_scene(Scenario.parse(two, "two"))
    with pytest.raises(ModelError, match=r"dus_v5750_box\.nc is not a shelter database"):
        read_field(database_path("dus_v5750_box.nc"))


def test_no_water_flows_through_the_moving_bottom():
    """Just below the box its motion, the waves and the disturbance give the same velocity."""
    pytest.importorskip("capytaine")
    omega = 2 * np.pi / np.array([4.6, 2.0])
    part, rigid, C = usv_part(0.15)
    direction = np.array([0.25 * np.pi])
    solution = solve_bodies(
        [part], omega=omega, directions=direction, density=1025.0, method="indirect", keep=True
    )
    force = solution.froude_krylov + solution.diffraction
    X = motion_raos(omega, rigid + solution.added_mass, solution.damping, C, force)
    n_x, n_y = 34, 5  # panels of the bottom: points below their centres
    x = -2.5 + 5 / n_x * (np.array([5, 16, 28]) + 0.5)
    y = 0.75 / n_y * (np.array([0, 2]) + 0.5)
    points = np.array([[a, b, -0.3 - 1e-4] for a in x for b in y])
    velocity = disturbance(solution, X, points)[:, 0, :, 2]
    k = omega[:, None] ** 2 / 9.81
    along = points[:, :2] @ np.sqrt([0.5, 0.5])
    water = -1j * omega[:, None] * np.exp(k * (points[:, 2] + 1j * along))
    Z, roll, pitch = (X[:, 0, i, None] for i in (2, 3, 4))
    hull = -1j * omega[:, None] * (Z + roll * points[:, 1] - pitch * points[:, 0])
    wrong = np.abs(velocity + water - hull).max(axis=1) / np.abs(hull).max(axis=1)
    assert wrong.max() < 1e-3, wrong  # measured 3e-5 at 4.6 s, 1.4e-4 at 2 s
    with pytest.raises(ModelError, match=r"has no sources: solve with method='indirect' and"):
        disturbance(replace(solution, details={}), X, points)


def velocity_in(path, omega, direction, points):
    """Velocity (p, 3) [m/s per m] that a shelter database holds, at a frequency of its own."""
    with xr.open_dataset(path, engine="h5netcdf") as data:
        axes = [data[name].values for name in "xyz"]
        field = RegularGridInterpolator(axes, data["field"].values.astype(float))(points)
        near = data["shelter_strength"].sel(omega=omega, method="nearest")
        assert float(near["omega"]) == pytest.approx(omega, rel=1e-6)
        strength = near.sel(wave_direction=direction, method="nearest").values.astype(float)
    return field @ (strength[0] + 1j * strength[1])


def test_command_makes_the_database_of_the_box(tmp_path, capsys):
    """From a mesh by one command, coarse panels, beside the file of the package."""
    pytest.importorskip("capytaine")
    file, target = tmp_path / "box.stl", tmp_path / "box.nc"
    place = trimesh.transformations.translation_matrix((0, 0, 0.35))
    trimesh.creation.box((5.0, 1.5, 1.3), place).export(file)
    options = {
        "-o": str(target),
        "--panel": "0.4",
        "--mass": "2306",
        "--center-of-gravity": "0 0 0",
        "--inertia": "1040 5412 5237",
        "--periods": "2 3.2",
        "--directions": "0 90",
        "--roll-damping": "0.07",
    }
    listed = [part for pair in options.items() for part in pair]
    with pytest.raises(SystemExit) as stop:
        cli.main(["hydro", str(file), "--shelter", "--no-memory", *listed])
    out = capsys.readouterr()
    assert stop.value.code == 0, out.err
    made = tmp_path / "box_shelter.nc"
    assert "modes, left out" in out.out and "box_shelter.nc" in out.out
    read_field.cache_clear()
    for ours, theirs in zip(
        read_field(made)[:2], read_field(database_path(DATABASE)), strict=False
    ):
        np.testing.assert_allclose(ours, theirs, atol=1e-9)
    x, y, z = np.meshgrid([-2.0, 0.0, 1.5], [0.0, 0.4], [-1.0, -2.0], indexing="ij")
    points = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    # Of the orbital speed at the surface: measured 0.017 and 0.0057, the field itself is up to
    # 0.35 and 0.056; 0.006 and 0.005 (at 3 s) on panels of 0.25 m.
    for period, within in ((2.0, 0.02), (3.2, 0.008)):
        for direction in (0.0, 0.5 * np.pi):
            omega = 2 * np.pi / period
            ours, theirs = (
                velocity_in(path, omega, direction, points)
                for path in (made, database_path(DATABASE))
            )
            assert np.abs(ours - theirs).max() < within * omega


def test_shelter_of_a_hull_whose_origin_is_not_in_the_water_surface(tmp_path):
    """A vehicle's axes: the same water motion, its grid counted from the body origin."""
    pytest.importorskip("capytaine")
    file = tmp_path / "box.stl"
    trimesh.creation.box((2.0, 0.8, 0.8)).export(file)
    settings = Settings(panel=0.3, omega=(2.0, 3.0), directions=(0.0, 1.0), shelter=True)
    hull = read_hull(str(file), settings)
    raised = replace(hull, origin=np.array([0.0, 0.0, 0.35]))
    plain, other = (shelter_of(h, respond(h)) for h in (hull, raised))
    np.testing.assert_allclose(other["z"], plain["z"] - 0.35)
    water = [
        np.einsum("xyzam,cwdm->cwdxyza", d["field"], d["shelter_strength"]) for d in (plain, other)
    ]
    np.testing.assert_allclose(*water, atol=1e-5 * np.abs(water[0]).max())
    with pytest.raises(ModelError, match=r"shelter of box\.stl, .* allowed is a hull in waves"):
        read_hull(str(file), Settings(submerged=True, shelter=True))


def test_grid_of_a_hull_lies_below_it_and_above_the_bottom():
    low, high = np.array([-6.0, -1.0, -0.8]), np.array([5.0, 1.0, 0.0])
    x, y, z = shelter_grid(low, high, 0.3, 4.0)
    for axis in (x, y, z):
        assert (np.diff(axis) > 0).all()
    assert x[0] < -6.0 and x[-1] > 5.0 and y[0] < -1.0 and y[-1] > 1.0
    assert {-6.0, 5.0} <= set(x) and {-1.0, 0.0, 1.0} <= set(y)  # its ends and sides are nodes
    assert z[-1] == pytest.approx(-0.8 - 0.3) and z[0] > -4.0  # not nearer than a panel


def test_modes_limit_and_grid_are_checked(monkeypatch):
    monkeypatch.setattr(t_, "MAX_SHELTER_MODES", 2)
    read_field.cache_clear()  # a refusal is not cached
    with pytest.raises(ModelError, match=r"modes, allowed are 2: make it with a larger residue"):
        read_field(database_path(DATABASE))
    falling = [np.array([0.0, 1, 2]), np.array([2.0, 1, 0]), np.array([-2.0, -1, 0])]
    with pytest.raises(ModelError, match=r"y of the grid is \[2\. 1\. 0\.\]; allowed are 3 or"):
        shelter_database(None, None, falling, {})
