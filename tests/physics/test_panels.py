"""Hull panels: pressure of still water and waves on the wetted triangles of a hull mesh."""

import mujoco
import numpy as np
import pytest
import trimesh
from mujoco import batch

import marine_mj
from marine_mj.environment import Environment, WaveField, irregular_sea, regular_wave
from marine_mj.frames import quaternion_from_euler
from marine_mj.hydrodynamics import start_in_waves, write_environment
from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.coefficients import read_coefficients
from marine_mj.hydrodynamics.floating import (
    Pose,
    afloat,
    equilibrium,
    floating_restoring,
    righting_arms,
)
from marine_mj.hydrodynamics.native import records, table_of
from marine_mj.library import find_model
from marine_mj.validation import panels

RHO, G = 1025.0, 9.81
MASS, INERTIA = 2306.0, (1040.0, 5412.0, 5237.0)
SEA = Environment(waves=irregular_sea(1.1, 5.515, components=100, seed=1, spreading=10))
PANELS = {"hull": {"hydrostatics": "panels"}}


@pytest.fixture(scope="module")
def hull():
    """The USV's box."""
    return panels.box_hull()


def elements(model):
    """Parameters of the first body's elements, by kind."""
    table = table_of(model)
    record = records(table)[0]
    place, found = int(record[t_.B_ELEMENT_DATA]), {}
    for _ in range(int(record[t_.B_ELEMENTS])):
        found[table[place]] = table[place + t_.EL_DATA :]
        place += int(table[place + t_.EL_SIZE])
    return found


def node_counts(model):
    """Chebyshev nodes of the first body's panels; zeros: summed at every vertex."""
    return elements(model)[t_.PANELS][t_.P_COUNTS :][:3].astype(int).tolist()


# Rows of the validation that take less than a second


@pytest.mark.parametrize("case", [panels.shapes, panels.linear, panels.froude_krylov])
def test_closed_forms(case):
    # measured: GZ 7e-4 (sphere), lift 6e-14, G 7e-9 relative, Froude-Krylov 0.8 % at T 2 s
    missed = [f"{r.name}: {r.measured:g}" for r in case() if not r.ok]
    assert not missed


def test_energy_is_conserved():
    # measured 2e-7; the validation has 100 s at 2 ms: 9e-8
    assert panels.energy_drift("300 1300 3900 400 7300 2000", 10.0, 0.005) < 1e-5


@pytest.mark.parametrize(("H_s", "T_p"), [(0.65, 4.556), (1.1, 5.515), (2.5, 6.834)])
def test_expansion_is_the_direct_sum(hull, H_s, T_p):
    # measured 9e-5, 3e-5, 4e-4 of the largest force; the NumPy sum knows nothing of the kernel
    assert panels.expansion_error(hull, H_s, T_p, seeds=1, poses=4) < 0.005


@pytest.mark.parametrize("period", [2.6, 4.6])
def test_small_waves_move_the_usv_as_the_linear_model(period):
    # measured 0.5 % at 2.6 s, 0.04 % at 4.6 s
    np.testing.assert_allclose(panels.motion_ratio(period, 0.02), 1.0, atol=0.02)


# Pressure


@pytest.mark.parametrize(("H_s", "T_p"), [(0.8, 6.5), (0.05, 1.0)], ids=["nodes", "direct"])
@pytest.mark.parametrize("depth", [2.0, 12.0, np.inf])
def test_wrench_in_shallow_and_deep_water(hull, H_s, T_p, depth):
    """Wrench against pressure summed at every vertex, both by nodes and directly."""
    sea = irregular_sea(H_s, T_p, components=60, depth=depth, seed=3, spreading=8)
    model = panels.floating_body(hull, environment=Environment(waves=sea))
    assert (node_counts(model)[0] == 0) == (T_p < 3)
    pose = Pose(0.1, 0.2, -0.1)
    for time in (0.0, 7.7):
        ours = panels.wrench(model, pose, "waves", time) + panels.wrench(model, pose)
        exact = panels.direct_wrench(hull, pose, sea, time)
        # measured 2e-15 (direct) and 6e-5 (nodes, the shortest components at every vertex)
        share = 1e-12 if T_p < 3 else 2e-4
        np.testing.assert_allclose(ours, exact, atol=share * np.abs(exact).max())


@pytest.mark.parametrize("phase", [0.0, np.pi], ids=["crest", "trough"])
def test_pressure_is_zero_at_the_moved_surface(phase):
    """A small plate just under crest and trough feels its depth below them, none above."""
    plate = panels.hull_of(trimesh.creation.box((0.02, 0.02, 0.01)))
    wave = regular_wave(1.0, 5.0, phase=phase)
    model = panels.floating_body(plate, environment=Environment(waves=wave), timestep=1e-4)
    zeta = wave.elevation(0.0, 0.0, 0.0)
    for depth in (1e-3, 1e-4, 1e-6, -1e-6, -1e-3):
        pose = Pose(zeta - depth + 0.005)
        lift = (panels.wrench(model, pose) + panels.wrench(model, pose, "waves"))[2]
        if depth < 0:
            assert abs(lift) < 1e-12
        else:
            # less by the vertical acceleration, k a = 8 %; measured 8.1 %, and 4e-7 m of elevation
            # and pressure head by the expansion
            change = 1 - float(wave.wavenumber[0]) * zeta
            expected = RHO * G * 4e-4 * depth * change
            assert lift == pytest.approx(expected, rel=0.01, abs=RHO * G * 4e-4 * 2e-6)


def test_deep_body_feels_what_the_water_it_displaces_felt():
    """Far below the surface: buoyancy, and rho V times the water's acceleration."""
    ball = trimesh.creation.icosphere(3, 0.2)
    wave = regular_wave(0.6, 5.0, 0.5)
    model = panels.floating_body(
        panels.hull_of(ball), 10.0, environment=Environment(waves=wave), timestep=0.002
    )
    z, time = -4.0, 1.3
    force = panels.wrench(model, Pose(z), "waves", time)[:3]
    # Wheeler looks the pressure up below the moved surface
    zeta = wave.elevation(0, 0, time)
    expected = RHO * ball.volume * wave.acceleration(0, 0, z - zeta, time)
    # measured 0.34 % of the largest: the slope of the stretched depth, second order
    np.testing.assert_allclose(force, expected, atol=0.01 * np.abs(expected).max())
    lift = panels.wrench(model, Pose(z))[2]
    assert lift == pytest.approx(RHO * G * ball.volume, rel=1e-12)


def test_force_is_continuous_through_the_surface(hull):
    """No jump when vertices and panels get wet: steps of the lift shrink with those of the pose."""
    model = panels.floating_body(hull, environment=SEA)

    def largest_step(count):
        heights = np.linspace(-1.2, 0.6, count)
        lift = [panels.wrench(model, Pose(h, 0.1, 0.05), "waves", 3.0) for h in heights]
        return np.abs(np.diff(lift, axis=0)).max(axis=0)

    coarse, fine = largest_step(30), largest_step(120)
    # measured 0.244 to 0.253
    assert (fine < 0.35 * coarse).all()


# Hydrostatics


def test_equilibrium_is_one_of_the_kernel(hull):
    """Weight and water pressure cancel at the pose that the displaced volume gives."""
    center = (0.2, 0.05, 0.1)
    pose = equilibrium(hull, MASS, center, RHO)
    model = panels.floating_body(hull, MASS, center)
    lift = panels.wrench(model, pose)
    arm = pose.rotation @ np.array(center)
    weight = np.concatenate([[0, 0, -MASS * G], np.cross(arm, [0, 0, -MASS * G])])
    # measured 4e-8 N m, of 22,600 N
    np.testing.assert_allclose(lift + weight, 0.0, atol=1e-6)
    # port side and bow down
    assert pose.roll < 0 < pose.pitch


def test_righting_arms_of_solids():
    for _, solid, volume, expected, _ in panels.solids():
        arms = righting_arms(solid, volume, (0, 0, 0), panels.HEELS)
        # measured 7e-4 (sphere)
        np.testing.assert_allclose(arms, expected, rtol=0.005)


def test_restoring_of_the_mesh_is_the_slope_at_the_equilibrium(hull):
    center = np.array([0.1, 0.03, 0.05])
    pose = equilibrium(hull, MASS, center, RHO)
    matrix = afloat(hull, pose).stiffness(RHO, G, MASS, pose.place(center), pose.origin)
    np.testing.assert_allclose(matrix, floating_restoring(hull, MASS, center, RHO, G), rtol=1e-9)
    model = panels.floating_body(hull, MASS, tuple(center))
    step = 1e-5
    for axis, name in ((2, "height"), (3, "roll")):
        ends = []
        for sign in (1, -1):
            moved = Pose(**{**vars(pose), name: getattr(pose, name) + sign * step})
            arm = moved.rotation @ center
            weight = np.cross(arm, [0, 0, -MASS * G])
            force = panels.wrench(model, moved)
            ends.append([force[2] - MASS * G, *(force[3:5] + weight[:2])])
        slope = -(np.array(ends[0]) - ends[1]) / (2 * step)
        # measured 9e-12 (heave) and 1.1e-4 (roll: it turns about the trimmed axis)
        np.testing.assert_allclose(slope, matrix[2:5, axis], atol=1e-3 * matrix[axis, axis])


def test_pushed_under_it_comes_back(hull):
    damping = '<numeric name="a.linear_damping_flu" data="500 1500 6000 3000 9000 1500"/>'
    model = panels.floating_body(
        hull, MASS, (0, 0, 0), INERTIA, timestep=0.01, coefficients=damping
    )
    data = mujoco.MjData(model)
    data.qpos[2] = -2.5  # 1.5 m of water above the deck
    data.qpos[3:7] = quaternion_from_euler([0.4, 0.3, 0.0])
    mujoco.mj_step(model, data, 6000)
    # measured 1e-15 m and 5e-18 rad
    assert data.qpos[2] == pytest.approx(equilibrium(hull, MASS, (0, 0, 0)).height, abs=1e-4)
    assert np.abs(2 * data.qpos[4:6]).max() < 1e-4


# In the simulation


def test_a_moved_and_turned_world_changes_nothing(hull):
    sea, turn, shift = SEA.waves, 0.7, np.array([30.0, -12.0])
    c, s = np.cos(turn), np.sin(turn)
    along = np.cos(sea.direction + turn) * shift[0] + np.sin(sea.direction + turn) * shift[1]
    moved = WaveField(
        sea.omega,
        sea.wavenumber,
        sea.direction + turn,
        sea.amplitude,
        sea.phase - sea.wavenumber * along,
    )
    forces = []
    for field, place, yaw in ((sea, np.zeros(2), 0.2), (moved, shift, 0.2 + turn)):
        model = panels.floating_body(hull, environment=Environment(waves=field))
        data = mujoco.MjData(model)
        data.time = 4.0
        start = np.array([2.0, 1.0])
        if yaw != 0.2:
            start = np.array([[c, -s], [s, c]]) @ start
        data.qpos[:3] = *(start + place), 0.1
        data.qpos[3:7] = quaternion_from_euler([0.15, -0.1, yaw])
        mujoco.mj_forward(model, data)
        forces.append(marine_mj.wrenches(model, data)["a"]["waves"])
    # measured 1e-15 of the largest
    np.testing.assert_allclose(forces[0], forces[1], atol=1e-10 * np.abs(forces[0]).max())


def test_one_and_two_threads_agree_bit_for_bit():
    model = marine_mj.load("dus_v5750", SEA, PANELS)
    ends = []
    for threads in (1, 2):
        pool = batch.Batch(model, 4, nthread=threads)
        pool.bind("qpos")[:, 2] = np.linspace(-0.2, 0.2, 4)
        pool.step(nstep=200)
        ends.append(np.array(pool.bind("qpos")))
    assert np.array_equal(*ends)
    data = mujoco.MjData(model)
    data.qpos[2] = -0.2
    mujoco.mj_step(model, data, 200)
    assert np.array_equal(data.qpos, ends[0][0])


def test_causes_sum_to_the_motion(hull):
    model = panels.floating_body(hull, MASS, (0, 0, 0), INERTIA, SEA)
    data = mujoco.MjData(model)
    data.time = 5.0
    mujoco.mj_forward(model, data)
    causes = marine_mj.wrenches(model, data)["a"]
    total = sum(causes.values())
    expected = np.array([MASS] * 3 + list(INERTIA)) * data.qacc
    # measured 2e-12 N
    np.testing.assert_allclose(total, expected, atol=1e-9 * np.abs(causes["restoring"]).max())
    # in still water there is no wave part
    still = panels.floating_body(hull, MASS, (0, 0, 0), INERTIA)
    assert not panels.wrench(still, Pose(0.1, 0.2), "waves").any()


def test_dynamic_motion_takes_the_diffraction_force(hull):
    """At rest in a small wave the causes are those of the linear model, and no lifted weight."""
    height, period = 2e-3, 3.5
    sea = Environment(waves=regular_wave(height, period, 0.6))
    forces = {}
    for kind in ("panels", "linear"):
        model = marine_mj.load("dus_v5750", sea, {"hull": {"hydrostatics": kind}})
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        forces[kind] = marine_mj.wrenches(model, data)["hull"]
    waves = forces["panels"]["waves"], forces["linear"]["waves"]
    scale = np.abs(waves[1]).max()
    # measured 0.43 %, mesh and 24 headings
    np.testing.assert_allclose(*waves, atol=0.01 * scale)
    lift = forces["panels"]["restoring"][2]
    assert lift == pytest.approx(RHO * G * 2.25, rel=1e-9)


def test_restoring_is_the_same_in_level_axes(hull):
    """The seakeeping frame of dynamic motion only turns the wrench and back."""
    data_of = {}
    for motion in ("dynamic", "free"):
        model = marine_mj.load("dus_v5750", SEA, {"hull": PANELS["hull"] | {"motion": motion}})
        data = mujoco.MjData(model)
        data.qpos[2:7] = 0.1, *quaternion_from_euler([0.3, -0.2, 1.1])
        mujoco.mj_forward(model, data)
        data_of[motion] = marine_mj.wrenches(model, data)["hull"]["restoring"]
    # measured 4e-12 N of 2e4 N
    np.testing.assert_allclose(data_of["dynamic"], data_of["free"], atol=1e-8)


def test_without_froude_krylov_only_still_water_presses(hull):
    settings = {"hull": PANELS["hull"] | {"motion": "free", "froude_krylov": False}}
    model = marine_mj.load("dus_v5750", SEA, settings)
    data = mujoco.MjData(model)
    data.time = 3.0
    mujoco.mj_forward(model, data)
    assert not marine_mj.wrenches(model, data)["hull"]["waves"].any()


def test_restoring_matrix_stays_the_default():
    """A body with both keeps its matrix; one with a mesh only floats on it."""
    model = marine_mj.load("dus_v5750")
    assert set(elements(model)) == {t_.RESTORING, t_.WIND, t_.MEMORY}


def test_another_sea_fits_in_the_same_model():
    """The table's length does not depend on how many nodes a sea needs."""
    spec = mujoco.MjSpec.from_file(str(find_model("dus_v5750")))
    bodies = read_coefficients(spec)
    model = marine_mj.load("dus_v5750", SEA, PANELS)
    other = Environment(waves=irregular_sea(4.0, 9.0, components=100, seed=9))
    before = node_counts(model)
    write_environment(model, bodies, other, PANELS)
    assert node_counts(model) != before
    data = mujoco.MjData(model)
    start_in_waves(model, data)
    mujoco.mj_step(model, data, 1000)
    assert np.isfinite(data.qpos).all()
    assert abs(data.qpos[2]) < 5


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e12])
def test_nonsense_in_the_state_harms_nothing(hull, value):
    """The kernel returns; what it read outside its own arrays would show in the next state."""
    model = panels.floating_body(hull, MASS, (0, 0, 0), INERTIA, SEA)
    data = mujoco.MjData(model)
    fresh = mujoco.MjData(model)
    mujoco.mj_forward(model, fresh)
    before = model.numeric_data.copy()
    data.qpos[2] = value
    mujoco.mj_forward(model, data)
    assert np.array_equal(model.numeric_data, before)
    data.qpos[2] = 0.0
    mujoco.mj_forward(model, data)
    assert np.array_equal(data.qacc, fresh.qacc)
