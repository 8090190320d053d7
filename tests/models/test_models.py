"""Every model folder keeps the contract of docs/architecture.md."""

import re
from pathlib import Path

import mujoco
import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
MODELS = ROOT / "models"
NAMES = sorted(p.parent.name for p in MODELS.glob("*/*.xml") if p.parent.name == p.stem)
DOCKS = {"cradle", "cradle_suspended", "funnel", "pole"}
SUSPENDED = {"cradle_suspended"}
MATRIX = {6, 21, 36}
SIZES = {
    "added_mass_frd": MATRIX,
    "added_mass_flu": MATRIX,
    "linear_damping_frd": {6, 36},
    "linear_damping_flu": {6, 36},
    "quadratic_damping_frd": {6, 36},
    "quadratic_damping_flu": {6, 36},
    "viscous_damping_frd": (6, 36),
    "quadratic_damping_lumped_frd": {6, 36},
    "displaced_volume": {1},
    "buoyancy": {1},
    "submergence_height": {1},
    "strips": {3},
    "strip_drag_frd": {2},
    "restoring_frd": {6, 36},
    "equilibrium_height": {1},
    "hull_depth": {1},
    "wind": {7},
    "reference_speed": {2},
    "thrust_loss": {1},
}


def load(name: str) -> mujoco.MjSpec:
    """The model; the template with a name filled in."""
    if name == "_template":
        text = (MODELS / name / "VEHICLE.xml").read_text(encoding="utf-8")
        return mujoco.MjSpec.from_string(text.replace("VEHICLE", "example"))
    return mujoco.MjSpec.from_file(str(MODELS / name / f"{name}.xml"))


def numerics(name: str) -> dict[str, np.ndarray]:
    return {n.name: np.array(n.data) for n in load(name).numerics}


everything = pytest.mark.parametrize("name", [*NAMES, "_template"])
vehicles = pytest.mark.parametrize("name", [*(n for n in NAMES if n not in DOCKS), "_template"])


def test_the_folders_are_found():
    assert {"scout", "dus_v5750", "bluerov2"} | DOCKS <= set(NAMES)


@everything
def test_it_compiles_and_attaches(name):
    assert load(name).compile().nbody >= 2
    scene = mujoco.MjSpec()
    scene.attach(load(name), frame=scene.worldbody.add_frame(), prefix="one/")
    scene.attach(load(name), frame=scene.worldbody.add_frame(), prefix="two/")
    model = scene.compile()
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data)
    assert np.isfinite(data.qpos).all()


@everything
def test_it_has_a_readme_and_small_meshes(name):
    assert len((MODELS / name / "README.md").read_text(encoding="utf-8")) > 500
    for mesh in (MODELS / name / "assets").glob("*"):
        assert mesh.stat().st_size < 500_000, mesh.name
    if (MODELS / name / "assets").is_dir():
        assert (ROOT / "assets" / f"make_{name}.py").is_file()


@everything
def test_it_holds_a_vehicle_only(name):
    spec = load(name)
    root, *fixed = spec.worldbody.bodies
    # what a suspended dock leaves on its carrier
    assert not fixed if name not in SUSPENDED else all(not body.joints for body in fixed)
    joints = [j.type for j in root.joints]
    if name in SUSPENDED:
        assert joints == [mujoco.mjtJoint.mjJNT_SLIDE]
    else:
        assert joints == ([] if name in DOCKS else [mujoco.mjtJoint.mjJNT_FREE])
    assert not spec.worldbody.geoms and not spec.lights
    path = "VEHICLE.xml" if name == "_template" else f"{name}.xml"
    assert "<option" not in (MODELS / name / path).read_text(encoding="utf-8")


@everything
def test_geoms_are_visual_or_collision_and_massless(name):
    model = load(name).compile()
    for i in range(model.ngeom):
        geom = model.geom(i)
        visual = geom.contype[0] == 0 and geom.conaffinity[0] == 0
        assert geom.group[0] == (2 if visual else 3), geom.name
        assert visual or geom.name, "collision geoms are reported by name"
        assert visual or geom.type[0] != mujoco.mjtGeom.mjGEOM_MESH
        if geom.name.startswith("forbidden_"):
            assert not visual
    assert {2, 3} <= set(model.geom_group)
    classes = set(re.findall(r'<default class="(?:\w+/)?(\w+)"', load(name).to_xml()))
    assert {"visual", "collision"} <= classes
    if name in DOCKS - SUSPENDED:
        assert model.body_mass.sum() == 0.0
    else:
        assert load(name).worldbody.bodies[0].explicitinertial


@vehicles
def test_numerics_are_legal(name):
    spec, values = load(name), numerics(name)
    table = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    for key, data in values.items():
        body, quantity, *actuator = key.split(".")
        assert not actuator or actuator[0] in {a.name for a in spec.actuators}
        assert spec.body(body) is not None
        assert quantity in SIZES or quantity == "strip_area", key
        assert re.search(rf"`{quantity.rsplit('_', 1)[0]}", table), quantity
        assert len(data) in SIZES.get(quantity, {len(data)}), key
        assert np.isfinite(data).all()
    floats = {"hull.displaced_volume", "hull.buoyancy", "hull.restoring_frd"} & set(values)
    assert len(floats) == 1
    assert (values["hull.added_mass_frd"] > 0).all()
    damping = [k for k in values if "damping" in k]
    assert damping and all((values[k] >= 0).all() for k in damping)
    assert ("hull.strips" in values) == ("hull.strip_drag_frd" in values)


@vehicles
def test_sites_actuators_and_cameras_have_their_names(name):
    spec, values = load(name), numerics(name)
    sites = {s.name for s in spec.sites}
    if "hull.restoring_frd" not in values:
        assert "hull.center_of_buoyancy" in sites
    thrusters = [a.name for a in spec.actuators]
    assert thrusters == [f"thruster_{i + 1}" for i in range(len(thrusters))]
    assert set(thrusters) <= sites
    model = spec.compile()
    assert model.actuator_ctrllimited.all()
    assert {"chase", "side"} <= {c.name for c in spec.cameras}


@vehicles
def test_a_submerged_vehicle_is_nearly_neutral_and_upright(name):
    values, model = numerics(name), load(name).compile()
    weight = 9.81 * model.body("hull").mass[0]
    if "hull.restoring_frd" in values:
        pytest.skip("floats on its restoring matrix")
    buoyancy = values.get("hull.buoyancy", 1025 * 9.81 * values.get("hull.displaced_volume", 0))
    assert 1.0 <= buoyancy[0] / weight < 1.02
    above = model.site("hull.center_of_buoyancy").pos - model.body("hull").ipos
    np.testing.assert_allclose(above[:2], 0.0)
    assert above[2] > 0


@vehicles
def test_files_of_texts_exist(name):
    texts = {t.name: t.data for t in load(name).texts}
    folders = (ROOT / "assets", ROOT / "models" / name / "assets")
    for file in texts.values():
        assert any((folder / file).is_file() for folder in folders), file
    assert ("hull.wave_database" in texts) == (name == "dus_v5750")


def thrust_matrix(name: str) -> tuple[np.ndarray, np.ndarray]:
    """Wrench about the origin (6, n) in body axes per newton, and limits (n, 2) in N."""
    model = load(name).compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    moment = np.zeros((model.nu, model.nv))
    mujoco.mju_sparse2dense(
        moment, data.actuator_moment, data.moment_rownnz, data.moment_rowadr, data.moment_colind
    )
    return moment[:, :6].T, model.actuator_ctrlrange


@pytest.mark.parametrize("name", ["scout", "bluerov2"])
def test_eight_thrusters_reach_all_six_directions(name):
    matrix, _ = thrust_matrix(name)
    assert matrix.shape == (6, 8)
    assert np.linalg.matrix_rank(matrix) == 6


def test_scout_has_the_published_thrust_and_buoyancy():
    matrix, limits = thrust_matrix("scout")
    forward = matrix[:, :4].sum(axis=1)
    np.testing.assert_allclose(forward, [4, 0, 0, 0, 0, 0], atol=1e-12)
    np.testing.assert_allclose(limits[:4].sum(axis=0), [-152, 192])
    heave = np.abs(matrix[:, 4:6]) @ limits[4:6, 1]
    assert heave[2] == pytest.approx(68)
    assert heave[4] == pytest.approx(20, rel=1e-3)
    sway = np.abs(matrix[:, 6:8]) @ limits[6:8, 1]
    assert sway[1] == pytest.approx(68)
    assert sway[5] == pytest.approx(20, rel=1e-3)
    # No moment that was not asked for: pitch and heave are free of roll, sway too.
    np.testing.assert_allclose(matrix[[3, 5], 4:6], 0, atol=1e-12)
    np.testing.assert_allclose(matrix[3, 6:8].sum(), 0, atol=1e-12)
    assert np.abs(matrix[3, 6:8]) @ limits[6:8, 1] == pytest.approx(3.4)
    assert 1025 * 9.81 * numerics("scout")["hull.displaced_volume"][0] == pytest.approx(
        613.37, abs=0.02
    )


def test_scout_strips_add_up_to_the_published_drag():
    values = numerics("scout")
    count, aft, fore = values["hull.strips"]
    width = (fore - aft) / count
    x = aft + width * (np.arange(count) + 0.5)
    drag = values["hull.strip_drag_frd"][0] * width
    rest = values["hull.quadratic_damping_frd"]
    lumped = values["hull.quadratic_damping_lumped_frd"]
    assert drag * count == pytest.approx(502.4, abs=1e-3)
    assert rest[4] + np.sum(drag * np.abs(x) ** 3) == pytest.approx(109.5, abs=1e-3)
    np.testing.assert_allclose(lumped, [42.1, 502.4, 502.4, 1.0, 109.5, 109.5])


def test_seat_and_aperture_of_the_cradle_on_the_usv():
    usv, cradle = load("dus_v5750"), load("cradle")
    alone = usv.compile()
    usv = load("dus_v5750")
    usv.attach(cradle, site="dock_mount", prefix="dock/")
    model = usv.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(data.site("dock/aperture").xpos, [0, 0, -1])
    np.testing.assert_allclose(data.site("dock/seat").xpos, [0, 0, -0.5])
    assert model.body_subtreemass[1] == alone.body_subtreemass[1] == 2306
    assert data.ncon == 0, "the cradle does not touch its carrier"


def test_the_suspended_cradle_has_the_guides_of_the_cradle():
    """The same geoms, seat on seat and aperture on aperture, with the same contact."""
    fixed, hung = load("cradle").compile(), load("cradle_suspended").compile()
    places = []
    for model, prefix in ((fixed, ""), (hung, "guides/")):
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        names = [model.geom(i).name for i in range(model.ngeom) if model.geom_contype[i]]
        assert names and all(name.startswith(prefix) for name in names)
        seat = data.site("seat").xpos
        np.testing.assert_allclose(data.site(f"{prefix}seat").xpos, seat)
        np.testing.assert_allclose(data.site(f"{prefix}aperture").xpos, data.site("aperture").xpos)
        geoms = {name.removeprefix(prefix): model.geom(name) for name in names}
        places.append(
            {
                name: (data.geom_xpos[g.id] - seat, data.geom_xmat[g.id], g.size, g.solref)
                for name, g in geoms.items()
            }
        )
    assert places[0].keys() == places[1].keys()
    for name, values in places[0].items():
        for ours, theirs in zip(values, places[1][name], strict=True):
            np.testing.assert_allclose(ours, theirs, atol=1e-12, err_msg=name)
