"""Boundary elements on coarse panels: closed forms, identities, and the whole `hydro` command.

Fine panels and more bodies stand in `marine_mj.validation.geometry`.
"""

import json
import sys

import numpy as np
import pytest
import trimesh
import xarray as xr

from marine_mj import cli
from marine_mj.environment import group_speed, wavenumber
from marine_mj.errors import ModelError
from marine_mj.hydrodynamics import database_memory
from marine_mj.hydrodynamics.bem import database as database_module
from marine_mj.hydrodynamics.bem import figures
from marine_mj.hydrodynamics.bem.convergence import convergence
from marine_mj.hydrodynamics.bem.database import save_database
from marine_mj.hydrodynamics.bem.panels import Panels, lid, rectangle
from marine_mj.hydrodynamics.bem.rao import (
    drag_motion_raos,
    motion_raos,
    natural_frequency,
    natural_periods,
    rao,
    viscous_damping,
)
from marine_mj.hydrodynamics.bem.response import analyse
from marine_mj.hydrodynamics.bem.settings import Settings
from marine_mj.hydrodynamics.bem.solver import check_panels, floating_body, solve
from marine_mj.hydrodynamics.bem.study import read_hull
from marine_mj.hydrodynamics.estimates import ellipsoid_added_mass
from marine_mj.validation.geometry import (
    deep_added_mass,
    ellipsoid_panels,
    floating_hemisphere,
    haskind,
    prism_panels,
)
from marine_mj.validation.hemisphere import hemisphere

pytest.importorskip("capytaine")
RHO, G = 1025.0, 9.81


def test_deep_ellipsoid_is_lambs():
    ours = np.diag(deep_added_mass(ellipsoid_panels((1.0, 0.5, 0.25), 6)))
    exact = np.diag(ellipsoid_added_mass(1.0, 0.5, 0.25, RHO))
    np.testing.assert_allclose(ours, exact, rtol=0.05)  # 3.6 % with 288 panels, 1.0 with 1152


def test_deep_cube_turns_alike_about_all_axes():
    A = deep_added_mass(prism_panels((1, 1, 1), (4, 4, 4)))
    np.testing.assert_allclose(np.diag(A)[3:], A[3, 3], rtol=1e-9)
    np.testing.assert_allclose(np.diag(A)[:3], 5275, rtol=0.03)  # 5388: 384 panels
    assert np.abs(A - np.diag(np.diag(A))).max() < 1e-9 * A[0, 0]


def test_multipole_hemisphere_is_hulmes():
    """Heave values that Hulme (1982) prints, and the limits of long and short waves."""
    printed = {0.1: 0.8627, 0.2: 0.7938, 0.5: 0.5861, 1.0: 0.4284, 2.0: 0.3884, 5.0: 0.4471}
    for k, mu in printed.items():
        assert hemisphere(k).real == pytest.approx(mu, abs=6e-5)
    assert hemisphere(1e-4, surge=True).real == pytest.approx(0.5, abs=1e-3)


def test_floating_hemisphere_within_two_percent():
    waves = np.array([0.5, 1.0])
    solution = floating_hemisphere(9, waves)  # 324 panels
    unit = 2 / 3 * np.pi
    for dof in (0, 2):
        exact = np.array([hemisphere(k, surge=dof == 0) for k in waves])
        A = solution.added_mass[:, dof, dof] / unit
        B = solution.damping[:, dof, dof] / unit / solution.omega
        np.testing.assert_allclose(A, exact.real, rtol=0.02)  # 0.6 %
        np.testing.assert_allclose(B, exact.imag, rtol=0.03)  # 2.0 %


def test_excitation_is_haskinds():
    solution = floating_hemisphere(8, np.array([0.5, 1.5]), keep=True)
    direct, other = solution.froude_krylov + solution.diffraction, haskind(solution)
    for dof in (0, 1, 2):
        scale = np.abs(direct[..., dof]).max()
        assert np.abs(direct - other)[..., dof].max() < 0.02 * scale  # 0.23 %


@pytest.mark.parametrize("depth", [np.inf, 1.8])
def test_damping_radiates_what_the_waves_carry_off(depth):
    """`B_jj = k / (8 pi rho g c_g) int |F_j|^2 d beta` (Newman 1977, sec. 6.18), axisymmetric."""
    hull = ellipsoid_panels((1.0, 1.0, 1.0), 8, floating=True)
    w = np.array([2.5])
    solution = solve(
        hull, lid(hull, 0.2), omega=w, directions=np.zeros(1), density=RHO, depth=depth
    )
    force = np.abs(solution.froude_krylov + solution.diffraction)[0, 0, 2]
    k, speed = wavenumber(w, depth)[0], group_speed(w, depth)[0]
    expected = k / (4 * RHO * G * speed) * force**2
    assert solution.damping[0, 2, 2] == pytest.approx(expected, rel=0.02)  # 0.1 and 0.8 %


def test_stiffness_is_capytaines(tmp_path):
    cpt = pytest.importorskip("capytaine")
    mesh = trimesh.creation.box(
        (4, 1.2, 1.0), trimesh.transformations.translation_matrix((0.3, 0, 0.1))
    )
    mesh.export(tmp_path / "box.stl")
    hull = read_hull(str(tmp_path / "box.stl"), Settings(center_of_mass=(0.3, 0.0, -0.1)))
    panels, _ = hull.panels(0.3)
    mesh = floating_body(panels, None, np.zeros(3)).mesh.merged()
    body = cpt.FloatingBody(mesh, cpt.rigid_body_dofs(), center_of_mass=(0.3, 0, -0.1))
    theirs = body.compute_hydrostatic_stiffness(rho=RHO, g=G).values
    # 0.3 %: Capytaine integrates y^2 and x^2 with one point for each panel.
    np.testing.assert_allclose(hull.stiffness, theirs, atol=5e-3 * theirs.max())


def test_near_surface_sphere_needs_no_lid_and_feels_waves(tmp_path):
    trimesh.creation.icosphere(2).export(tmp_path / "ball.stl")
    settings = Settings(
        waterline=1.5, submerged=False, omega=(1.0, 2.5), panel=0.5, directions=(0.0,)
    )
    data = analyse(read_hull(str(tmp_path / "ball.stl"), settings))
    assert "0 lid panels" in data.attrs["mesh"] and "waterplane_area" not in data
    # Havelock: a sphere goes round as the water does; heave and surge alike in long waves.
    force = np.hypot(*data.excitation_force.values[:, 0, 0, [0, 2]])
    assert force[0] == pytest.approx(force[1], rel=0.05)  # 2.8 %
    deep = analyse(read_hull(str(tmp_path / "ball.stl"), Settings(waterline=1.5, panel=0.5)))
    assert "RAO" not in deep and "added_mass" not in deep
    np.testing.assert_allclose(
        np.diag(deep.infinite_added_mass)[:3], 0.5 * RHO * 4 / 3 * np.pi, rtol=0.04
    )  # 2.3 % less: 162 corners on the sphere
    with pytest.raises(ModelError, match="has no RAO: it was made without waves"):
        figures.plot_raos(deep)
    with pytest.raises(ModelError, match="has no added_mass"):
        figures.plot_radiation(deep)


def test_too_few_and_too_many_panels():
    few = rectangle((0, 0, -1), (0, 1, 0), (1, 0, 0), 2, 2)
    with pytest.raises(ModelError, match=r"the hull has 4 panels .* allowed are 20 to 5000: set"):
        check_panels(few, np.zeros(0), G)
    many = rectangle((0, 0, -1), (0, 1, 0), (1, 0, 0), 80, 80)
    with pytest.raises(ModelError, match=r"6400 panels .*panel size to about 0.017 m"):
        check_panels(many, np.zeros(0), G)
    assert "resolve waves up to" in check_panels(Panels(many.corners[:100]), np.array([90.0]), G)[0]
    with pytest.raises(ModelError, match="method 'magic' does not exist"):
        solve(few, omega=np.zeros(0), directions=np.zeros(0), density=1.0, method="magic")


def test_missing_capytaine_is_named(monkeypatch, box_file):
    monkeypatch.setitem(sys.modules, "capytaine", None)
    hull = read_hull(box_file)  # hydrostatics work without it
    assert hull.still.volume > 0
    with pytest.raises(ModelError, match=r'pip install "marine-mj\[bem\]"'):
        analyse(hull)


@pytest.fixture(scope="module")
def box_file(tmp_path_factory):
    path = tmp_path_factory.mktemp("hull") / "box.stl"
    size, place = (5.0, 1.5, 1.3), trimesh.transformations.translation_matrix((0, 0, 0.35))
    trimesh.creation.box(size, place).export(path)
    return str(path)


def test_hydro_command(box_file, tmp_path, capsys):
    """The USV's box from a coarsely remeshed STL beside the database that fine panels made."""
    target = tmp_path / "out" / "usv.nc"
    with pytest.raises(SystemExit) as stop:
        options = {
            "-o": str(target),
            "--panel": "0.45",
            "--mass": "2306",
            "--center-of-gravity": "0 0 0",
            "--inertia": "1040 5412 5237",
            "--periods": "2 2.4 3 8 20",
            "--directions": "0 45 90 180",
            "--roll-damping": "0.07",
        }
        listed = [part for pair in options.items() for part in pair]
        cli.main(["hydro", box_file, "--convergence", "--no-memory", *listed])
    out = capsys.readouterr()
    assert stop.value.code == 0, out.err
    for part in ("displaced volume", "2.25", "GM_T", "natural period", "convergence", "wrote"):
        assert part in out.out
    names = sorted(p.name for p in target.parent.iterdir())
    pictures = ["convergence", "forces", "radiation", "raos"]
    assert names == sorted(["usv.nc", *(f"usv_{p}.png" for p in pictures)])
    w = 2 * np.pi / np.array([2.4, 3.0, 8.0, 20.0])
    for dof, beta, worst in (("Heave", 0.0, 0.02), ("Pitch", 0.0, 0.02), ("Roll", np.pi / 2, 0.08)):
        ours, fine = (rao(str(f), w, beta, dof) for f in (target, "dus_v5750_box.nc"))
        assert (
            np.abs(ours - fine).max() < worst * np.abs(fine).max()
        )  # 1.4, 1.7 and 5.7 %: resonance
    with xr.open_dataset(target, engine="h5netcdf") as data:
        assert len(data.attrs["mesh_sha256"]) == 64
        assert json.loads(data.attrs["settings"])["roll_damping"] == 0.07
        assert "capytaine 3" in data.attrs["software"]
        assert json.loads(data.attrs["natural_periods"])["Roll"] == pytest.approx(2.3, rel=0.05)
        assert data.transversal_metacentric_height == pytest.approx(0.625 - 0.15, rel=1e-3)
        np.testing.assert_allclose(data.viscous_damping[3, 3], data.viscous_roll_damping)


def test_hydro_command_stores_memory_and_drift(tmp_path, capsys):
    """What a dynamic vehicle in waves reads of a database, all from one command: a hemisphere."""
    file, target = tmp_path / "ball.stl", tmp_path / "ball.nc"
    trimesh.creation.icosphere(2, 1.0).export(file)
    omega = " ".join(f"{w:.3f}" for w in np.linspace(0.8, 6.0, 18))
    options = ["--omega", omega, "--directions", "0 180", "--panel", "0.3", "--drift"]
    with pytest.raises(SystemExit) as stop:
        cli.main(["hydro", str(file), "-o", str(target), *options])
    out = capsys.readouterr()
    assert stop.value.code == 0, out.err
    assert "radiation memory" in out.out and "indirect method" in out.out
    memory = database_memory(str(target))
    assert memory.states > 10
    with xr.open_dataset(target, engine="h5netcdf") as data:
        drift = data["mean_drift_force"].sel(drift_dof="Surge", omega=6.0).values
        np.testing.assert_allclose(memory.infinite_added_mass, data.infinite_added_mass, rtol=1e-9)
    # short waves: 2/3 of 1/2 rho g a^2 per metre of diameter are thrown back by a round wall
    assert drift[0] == pytest.approx(2 / 3 * 0.5 * 1025 * 9.81 * 2.0, rel=0.25)
    assert drift[1] == pytest.approx(-drift[0], rel=0.02)


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (["--omega", "1 2", "--periods", "3 4"], 1, "both --omega and --periods"),
        (["--periods", "0 4"], 1, "frequencies above 0"),
        (["--waterline", "-5"], 1, "lies above the water"),
        (["--inertia", "a b c"], 2, "not a list of numbers"),
        (["--hydrostatics"], 0, ""),
    ],
)
def test_hydro_exit_codes(box_file, capsys, arguments, code, message):
    with pytest.raises(SystemExit) as stop:
        cli.main(["hydro", box_file, *arguments])
    out = capsys.readouterr()
    assert stop.value.code == code
    assert message in out.err and "Traceback" not in out.err


def test_symmetry_changes_nothing_but_speed(box_file):
    hull = read_hull(box_file, Settings(center_of_mass=(0, 0, 0)))
    panels, cover = hull.panels(0.5)
    assert panels.mirrors == (1, 0)
    omega, directions = np.array([2.5]), np.array([0.7])
    wanted = {"omega": omega, "directions": directions, "density": RHO}
    quarter = solve(panels, cover, **wanted)
    whole = solve(Panels(panels.whole()), Panels(cover.whole()), **wanted)
    for name in ("added_mass", "damping", "infinite", "zero", "diffraction", "froude_krylov"):
        a, b = getattr(quarter, name), getattr(whole, name)
        np.testing.assert_allclose(a, b, atol=1e-4 * np.abs(b).max(), err_msg=name)


def test_lid_removes_the_irregular_frequency(box_file):
    """First irregular frequency of the box: sqrt(g k coth(k T)), k = pi sqrt(1/L^2 + 1/B^2)."""
    hull = read_hull(box_file, Settings(center_of_mass=(0, 0, 0)))
    panels, cover = hull.panels(0.3)
    k = np.pi * np.hypot(1 / 5.0, 1 / 1.5)
    around = np.sqrt(G * k / np.tanh(k * 0.3)) * np.linspace(0.94, 1.06, 7)
    wanted = {"omega": around, "directions": np.zeros(0), "density": RHO}
    rough, smooth = (solve(panels, c, **wanted).added_mass[:, 2, 2] for c in (None, cover))
    bend = [np.abs(np.diff(a, 2)).max() / abs(a.mean()) for a in (rough, smooth)]
    assert bend[1] < 0.005 < 0.5 < bend[0]  # 0.0005 and 0.96


def test_convergence_of_a_deep_ball(tmp_path):
    trimesh.creation.icosphere(4).export(tmp_path / "ball.stl")
    rows = convergence(
        read_hull(str(tmp_path / "ball.stl"), Settings(submerged=True)), np.array([0.6, 0.45, 0.3])
    )
    assert len(rows) == 6
    heave = rows[2]
    exact = 2 / 3 * np.pi * RHO
    errors = np.abs(heave.values / exact - 1)
    assert errors[0] > errors[1] > errors[2] and errors[2] < 0.03  # 3.2, 3.0, 1.9 %


def test_motion_of_one_degree_of_freedom():
    """Closed form of a damped oscillator, its resonance and its quadratic damping."""
    omega = np.linspace(0.5, 4.0, 400)
    M, B, C = np.tile(np.eye(6), (400, 1, 1)), np.tile(0.1 * np.eye(6), (400, 1, 1)), 4 * np.eye(6)
    F = np.ones((400, 1, 6)) * (1 + 0.5j)
    X = motion_raos(omega, M, B, C, F)
    exact = (1 + 0.5j) / (4 - omega**2 - 0.1j * omega)
    np.testing.assert_allclose(X[:, 0, 2], exact, rtol=1e-12)
    assert natural_frequency(omega, 0 * omega, 1.0, 4.0) == pytest.approx(2.0)
    assert np.isnan(natural_frequency(omega, 0 * omega, 1.0, -4.0))
    drag = np.array([0, 0, 0.8, 0, 0, 0.0])
    Y = drag_motion_raos(omega, M, B, C, F, drag, 0.7)[:, 0, 2]
    equivalent = 0.1 + 8 / (3 * np.pi) * omega * np.abs(Y) * 0.7 * 0.8
    np.testing.assert_allclose(Y, F[0, 0, 0] / (4 - omega**2 - 1j * omega * equivalent), rtol=1e-4)
    assert np.abs(Y).max() < 0.5 * np.abs(X[:, 0, 2]).max()
    with pytest.raises(ModelError, match="allowed are 6 values >= 0 and an amplitude above 0"):
        drag_motion_raos(omega, M, B, C, F, -drag, 0.7)


def test_drag_linearisation_against_the_time_domain():
    """Amplitude of `x'' + d |x'| x' + c x = f cos(w t)` near resonance."""
    from scipy.integrate import solve_ivp

    w, c, d, f = 1.95, 4.0, 0.8, 1.0
    X = drag_motion_raos(
        np.array([w]), np.eye(6)[None], np.zeros((1, 6, 6)), c * np.eye(6),
        np.full((1, 1, 6), f, dtype=complex), np.array([0, 0, d, 0, 0, 0.0]), 1.0,
    )  # fmt: skip
    run = solve_ivp(
        lambda t, y: [y[1], f * np.cos(w * t) - d * abs(y[1]) * y[1] - c * y[0]],
        (0, 60), [0.0, 0.0], rtol=1e-8, atol=1e-10, dense_output=True,
    )  # fmt: skip
    late = np.abs(run.sol(np.linspace(50, 60, 2000))[0]).max()
    assert abs(X[0, 0, 2]) == pytest.approx(late, rel=0.02)  # 0.5 %


def test_natural_periods_take_the_coupling_in():
    """Roll about a centre of gravity above the origin: the coupled mode turns about that point."""
    omega = np.array([0.5, 5.0])
    m, height, inertia, c = 1000.0, 0.5, 400.0, 5000.0
    rigid = np.diag([m, m, m, inertia + m * height**2, 2000, 2000.0])
    rigid[1, 3] = rigid[3, 1] = -m * height
    C = np.diag([0, 0, 4000.0, c, 9000, 0])
    periods = natural_periods(omega, np.zeros((2, 6, 6)), rigid, C)
    assert periods["Roll"] == pytest.approx(2 * np.pi * np.sqrt(inertia / c), rel=1e-9)
    assert periods["Heave"] == pytest.approx(2 * np.pi * np.sqrt(m / 4000), rel=1e-9)
    assert set(
        natural_periods(omega, np.zeros((2, 6, 6)), rigid, np.diag([0, 0, 1.0, -1, 1, 0]))
    ) == {
        "Heave",
        "Pitch",
    }


def test_viscous_damping_refusals():
    args = np.array([1.0, 2.0]), np.zeros((2, 6, 6)), np.eye(6), np.diag([0, 0, 1.0, 1, 1, 0])
    assert viscous_damping(*args, {"Roll": 0.1})[3, 3] == pytest.approx(0.2)
    with pytest.raises(
        ModelError, match=r"damping ratio 0.1 of 'Yaw'; allowed is >= 0 for a degree"
    ):
        viscous_damping(*args, {"Yaw": 0.1})
    with pytest.raises(ModelError, match=r"damping ratio -0.1 of 'Roll'"):
        viscous_damping(*args, {"Roll": -0.1})
    with pytest.raises(ModelError, match="feeds energy: smallest eigenvalue -1"):
        viscous_damping(*args, {}, -np.eye(6))


def test_rao_lookup():
    w = np.array([[0.3], [0.6]])
    values = rao("dus_v5750_box.nc", w, np.array([0.0, np.pi / 2]), "Heave")
    assert values.shape == (2, 2) and abs(values[0, 0]) == pytest.approx(1.0, abs=0.01)
    assert abs(rao("dus_v5750_box.nc", 0.3, 0.0, "Heave", "force")) > 1e4
    with pytest.raises(ModelError, match="degree of freedom 'Jump' does not exist"):
        rao("dus_v5750_box.nc", 1.0, 0.0, "Jump")


def test_database_is_written_whole_or_not_at_all(tmp_path, monkeypatch):
    data = xr.Dataset({"a": ("x", np.arange(3.0))})
    path = save_database(data, tmp_path / "new" / "a.nc")
    assert [p.name for p in path.parent.iterdir()] == ["a.nc"]
    with pytest.raises(ModelError, match=r"cannot be written .*choose another place"):
        save_database(data, path / "below.nc")

    def full(*_, **__):
        raise OSError("disk full")

    before = path.read_bytes()
    monkeypatch.setattr(xr.Dataset, "to_netcdf", full)
    with pytest.raises(ModelError, match="disk full"):
        save_database(data, path)
    assert path.read_bytes() == before and len(list(path.parent.iterdir())) == 1


def test_steps_after_the_solution_may_add_to_the_database(monkeypatch, tmp_path):
    trimesh.creation.icosphere(2).export(tmp_path / "ball.stl")
    step = lambda data: data.assign(extra=1.0)  # noqa: E731
    monkeypatch.setattr(database_module, "POST_PROCESSING", [step])
    hull = read_hull(str(tmp_path / "ball.stl"), Settings(submerged=True, panel=0.6))
    assert analyse(hull).extra == 1.0


def test_lid_of_a_quarter_is_a_quarter():
    hull = ellipsoid_panels((1.0, 1.0, 1.0), 6, floating=True)
    cover = lid(hull, 0.25)
    assert cover.mirrors == (1, 0)
    points, faces = cover.triangles()
    area = trimesh.Trimesh(points, faces, process=False).area
    polygon = 24 / 2 * np.sin(2 * np.pi / 24)
    assert area == pytest.approx(polygon, rel=0.05)  # 3.9 %: sagging columns
