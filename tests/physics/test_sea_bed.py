"""Water of finite depth: motion at and below the bed, contact with it, starts in it."""

import mujoco
import numpy as np
import pytest
from conftest import one_body
from hypothesis import given, settings
from hypothesis import strategies as st

import marine_mj
from marine_mj import simulation
from marine_mj.environment import Current, Environment, WaveField, calm, irregular_sea
from marine_mj.errors import ScenarioError
from marine_mj.hydrodynamics.floating import Pose
from marine_mj.hydrodynamics.table import CONTACT_SENSOR, SEA_BED
from marine_mj.scenario import Scenario
from marine_mj.scene import compile_scene
from marine_mj.validation import panels
from marine_mj.water import SEABED, add_scenery

STRIPS = '<numeric name="a.strips" data="4 -1 1"/>'
DEMO = Scenario.load("docking_demo")


def felt(sea: Environment, position, pitch: float, time: float, strips: bool) -> np.ndarray:
    """Water velocity and material acceleration (2, 3), NWU, that a body feels (mean of strips)."""
    model = marine_mj.load_xml(
        one_body(
            numerics='<numeric name="a.linear_damping_flu" data="1 1 1 1 1 1"/>'
            f'<numeric name="a.displaced_volume" data="{1 / 1025!r}"/>{STRIPS if strips else ""}',
            extra='<site name="a.center_of_buoyancy"/>',
            gravity=0,
        ),
        sea,
        {"a": {"constant_buoyancy": True}},
    )
    data = mujoco.MjData(model)
    data.qpos[:3] = position
    data.qpos[3:7] = np.cos(pitch / 2), 0, np.sin(pitch / 2), 0
    data.time = time
    mujoco.mj_forward(model, data)
    R = data.body("a").xmat.reshape(3, 3)
    forces = marine_mj.wrenches(model, data)["a"]
    return np.stack([R @ forces["damping"][:3], R @ forces["waves"][:3]])


def expected(waves: WaveField, current: Current, points: np.ndarray, time: float) -> np.ndarray:
    """The same from the wave field and the current, mean over points (n, 3)."""
    x, y, z = points.T
    velocity = waves.velocity(x, y, z, time) + current.velocity_at(z, time)
    acceleration = waves.acceleration(x, y, z, time)
    acceleration += np.einsum("nij,nj->ni", waves.gradient(x, y, z, time), velocity)
    return np.stack([velocity.mean(axis=0), acceleration.mean(axis=0)])


@given(
    depth=st.floats(0.3, 60.0),
    height=st.floats(-4.0, 0.5),
    pitch=st.floats(-1.5, 1.5),
    strips=st.booleans(),
    stretching=st.sampled_from(["constant", "wheeler", "none"]),
    seed=st.integers(0, 5),
)
@settings(max_examples=80, deadline=None)
def test_kernel_and_wave_field_agree_at_any_height(depth, height, pitch, strips, stretching, seed):
    """From above the surface to three depths below the bed, with strips on both sides of it."""
    sea = irregular_sea(
        0.3 * min(depth, 4.0), 5.0, components=12, depth=depth, seed=seed, stretching=stretching
    )
    # no shear: the wave field's gradient has none
    current = Current(np.array([-depth]), np.array([[0.3, -0.2, 0.0]]))
    z, time = height * depth, 40.0
    if strips:  # near the surface they are wet in part
        z = min(z, -1.1 - sea.amplitude.sum())
    position = np.array([3.0, -2.0, z])
    axis = np.array([np.cos(pitch), 0.0, -np.sin(pitch)])
    reach = np.array([-0.75, -0.25, 0.25, 0.75]) if strips else np.zeros(1)
    points = position + reach[:, None] * axis
    if stretching == "wheeler":  # in the air the kernel holds the surface value
        sea_level = sea.elevation(points[:, 0], points[:, 1], time)
        points[:, 2] = np.minimum(points[:, 2], sea_level)
    ours = felt(Environment(waves=sea, current=current), position, pitch, time, strips)
    exact = expected(sea, current, points, time)
    # measured 2e-14; before, 1e8 m/s at four depths in 2 m of water
    np.testing.assert_allclose(ours, exact, atol=1e-11 * (1 + np.abs(exact).max()))


def test_below_the_bed_is_as_at_the_bed():
    """The case that exploded: 2 m of water, z = -8 m."""
    sea = Environment(waves=irregular_sea(0.5, 4.0, depth=2.0, seed=1))
    values = [felt(sea, [0, 0, z], 0.0, 5.0, False) for z in (-2.0, -8.0)]
    np.testing.assert_allclose(values[1], values[0], rtol=1e-12)
    assert 0.01 < np.linalg.norm(values[0][0]) < 1.0  # measured 0.12 m/s; before, 2.7e8 m/s


@pytest.mark.parametrize("T_p", [6.5, 1.0], ids=["nodes", "direct"])
@pytest.mark.parametrize("height", [-1.5, -2.6, -9.0])
def test_hull_panels_reach_below_the_bed(height, T_p):
    """Pressure on a hull that stands in the bed, 2 m deep, or lies below it."""
    sea = irregular_sea(0.4 if T_p > 3 else 0.05, T_p, components=60, depth=2.0, seed=3)
    hull, pose = panels.box_hull(), Pose(height, 0.2, -0.1)
    model = panels.floating_body(hull, environment=Environment(waves=sea))
    for time in (0.0, 7.7):
        ours = panels.wrench(model, pose, "waves", time)
        still = panels.direct_wrench(hull, pose, calm(2.0), time)
        exact = panels.direct_wrench(hull, pose, sea, time) - still
        # measured 3e-15 of the still water's force (direct), 4e-4 of the waves' (nodes)
        tolerance = 1e-12 * np.abs(still).max() if T_p < 3 else 2e-3 * np.abs(exact).max()
        np.testing.assert_allclose(ours, exact, atol=tolerance)


def test_current_is_held_beyond_its_levels():
    current = Current(np.array([-2.0, 0.0]), np.array([[0.1, 0.0, 0.0], [0.5, 0.2, 0.0]]))
    for z in (-9.0, -2.0, -0.7, 0.0, 3.0):
        ours = felt(Environment(current=current), [0, 0, z], 0.0, 0.0, False)[0]
        np.testing.assert_allclose(ours, current.velocity_at(z, 0.0), atol=1e-14)


def shallow(depth: float, **changes) -> Scenario:
    """The demo's vehicles in calm water of that depth, the AUV on its ideal wrench."""
    sea = {"spectrum": "none", "depth": depth}
    return DEMO.with_values({"sea": sea, "vehicles.auv.actuation": "wrench", **changes})


def test_a_vehicle_pushed_down_rests_on_the_bed():
    scene = compile_scene(shallow(5.0), visual=False)
    model, data = scene.model, mujoco.MjData(scene.model)
    push = 40.0
    data.ctrl[model.actuator("auv/heave").id] = -push
    mujoco.mj_step(model, data, 4000)
    bed = model.geom(SEA_BED).id
    touching = [c for c in data.contact if bed in c.geom]
    assert touching and min(c.dist for c in touching) > -0.01  # measured -0.7 mm
    auv = model.body("auv/hull").id
    assert np.abs(data.qvel[model.joint("auv/free").dofadr[0] :][:6]).max() < 1e-3
    wrenches = marine_mj.wrenches(model, data)["auv/hull"]
    weight = model.body_subtreemass[auv] * 9.81
    # the bed carries the push and what the water does not carry of the weight
    buoyancy = data.xmat[auv].reshape(3, 3)[2] @ wrenches["restoring"][:3]
    normal = sum(_normal(model, data, i) for i, c in enumerate(data.contact) if bed in c.geom)
    assert normal == pytest.approx(push + weight - buoyancy, rel=1e-6)  # measured 1e-13
    # it is no dock: the scene's contact sensor leaves it out
    assert not data.sensor(CONTACT_SENSOR).data.any()


def _normal(model, data, contact: int) -> float:
    """Normal force of a contact, N."""
    wrench = np.zeros(6)
    mujoco.mj_contactForce(model, data, contact, wrench)
    return wrench[0]


def test_only_scenes_of_finite_depth_have_a_bed():
    deep = compile_scene(DEMO, visual=False).model
    assert mujoco.mj_name2id(deep, mujoco.mjtObj.mjOBJ_GEOM, SEA_BED) == -1
    assert compile_scene(shallow(5.0), visual=False).model.ngeom == deep.ngeom + 1
    assert marine_mj.load("scout", Environment(waves=irregular_sea(0.3, 4, depth=5.0))).nbody == 2


def test_starts_in_the_bed_are_refused_by_name():
    with pytest.raises(
        ScenarioError, match=r"docking_demo.*vehicles\.auv\.position_ned starts 4 m"
    ):
        DEMO.with_values({"sea.depth": 3.0})
    # the origin is above the bed, the hull (radius 0.1 m) and its fins are not
    with pytest.raises(ScenarioError, match=r"'docking_demo': 'auv/.* m below the sea bed"):
        compile_scene(shallow(4.05), visual=False)
    compile_scene(shallow(4.3), visual=False)


def test_demo_docks_in_shallow_water():
    log = simulation.run(DEMO.with_values({"sea.depth": 5.0}))
    assert log.summary["docked"] and log.summary["contact_success"]


def test_pictures_show_the_bed_where_it_is():
    model = compile_scene(shallow(7.5), scenery=add_scenery).model
    assert model.geom_pos[model.geom(SEABED).id, 2] == -7.5
    model = compile_scene(DEMO, scenery=add_scenery).model
    assert model.geom_pos[model.geom(SEABED).id, 2] == -10.0
