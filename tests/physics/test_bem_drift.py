"""Far-field mean drift from Capytaine against near-field closed forms and conservation laws."""

import numpy as np
import pytest
from scipy.special import jv, jvp, yv, yvp

from marine_mj.errors import ModelError
from marine_mj.hydrodynamics.bem.drift import mean_drift_force

cpt = pytest.importorskip("capytaine", reason="needs the extra `bem`")
xr = pytest.importorskip("xarray")

RHO, G = 1000.0, 9.81
THETA = 2 * np.pi * np.arange(720) / 720
DIRECTIONS = [0.0, 0.6]
cpt.set_logging("ERROR")


def solved(body, k, method="indirect"):
    """All results at the wave numbers k in deep water."""
    grid = xr.Dataset(
        coords={
            "wavenumber": np.asarray(k, dtype=float),
            "wave_direction": DIRECTIONS,
            "radiating_dof": list(body.dofs),
            "water_depth": [np.inf],
            "rho": [RHO],
            "g": [G],
        }
    )
    problems = cpt.io.xarray.problems_from_dataset(grid, body)
    return cpt.BEMSolver(method=method).solve_all(problems, progress_bar=False)


def motion(results, mass=None, damping=0.0, restoring=0.0):
    """RAO (omega, wave_direction, radiating_dof); zero, of a fixed body, without a mass."""
    omega = sorted({float(r.omega) for r in results})
    dofs = list(results[0].body.dofs)
    values = np.zeros((len(omega), len(DIRECTIONS), len(dofs)), dtype=complex)
    if mass is not None:
        data = cpt.assemble_dataset(results).squeeze(drop=True).sortby("wavenumber")
        order = {"radiating_dof": dofs, "influenced_dof": dofs}
        matrix = ("wavenumber", "influenced_dof", "radiating_dof")
        A = data["added_mass"].sel(order).transpose(*matrix).values
        B = data["radiation_damping"].sel(order).transpose(*matrix).values
        F = data["diffraction_force"] + data["Froude_Krylov_force"]
        F = F.sel(influenced_dof=dofs).transpose("wavenumber", "wave_direction", ...).values
        for i, w in enumerate(omega):
            Z = -(w**2) * (mass + A[i]) - 1j * w * (damping + B[i]) + restoring
            values[i] = np.linalg.solve(Z, F[i].T).T
    return xr.DataArray(
        values,
        dims=("omega", "wave_direction", "radiating_dof"),
        coords={"omega": omega, "wave_direction": DIRECTIONS, "radiating_dof": dofs},
    )


def with_translations(mesh, **options):
    """Body of a mesh in surge, sway and heave."""
    body = cpt.FloatingBody(mesh=mesh, **options)
    for dof in ("Surge", "Sway", "Heave"):
        body.add_translation_dof(name=dof)
    return body


@pytest.fixture(scope="module")
def hemisphere():
    """Results of a hemisphere of 1 m in surge, sway and heave at two wave numbers."""
    mesh = cpt.mesh_sphere(radius=1.0, resolution=(24, 32)).immersed_part()
    return solved(with_translations(mesh), [0.7, 1.4])


def pushed(k, R):
    """Mean force [N/m2] on a fixed, deep, vertical cylinder, by pressure (near field).

    The potential of MacCamy and Fuchs (1954) holds in deep water at every depth; the mean of
    1/2 rho g zeta^2 at the waterline and of Bernoulli's -1/2 rho |v|^2 below, integrated.
    """
    m = np.arange(-30, 31)
    H, slope = jv(m, k * R) + 1j * yv(m, k * R), jvp(m, k * R) + 1j * yvp(m, k * R)
    c = 1j**m * (jv(m, k * R) - jvp(m, k * R) / slope * H)
    E = np.exp(1j * np.outer(THETA, m))
    around, along = E @ c, E @ (1j * m * c) / R
    waterline = 0.25 * RHO * G * abs(around) ** 2
    below = 0.25 * RHO * G / k * (abs(along) ** 2 + k**2 * abs(around) ** 2) / (2 * k)
    return -((waterline - below) * np.cos(THETA)).mean() * 2 * np.pi * R


def test_fixed_cylinder():
    """Far field by panels against the near field in closed form; short waves 2/3 rho g R."""
    mesh = cpt.mesh_vertical_cylinder(length=6.0, radius=1.0, resolution=(4, 40, 28))
    mesh, k = mesh.immersed_part(), [1.0, 2.0]
    results = solved(with_translations(mesh, lid_mesh=mesh.generate_lid()), k)
    drift = mean_drift_force(results, motion(results)).values
    expected = np.array([pushed(number, 1.0) for number in k])
    beta = np.array(DIRECTIONS)
    along = np.stack([np.cos(beta), np.sin(beta), 0 * beta], axis=-1)
    # measured 1.8 % with 720 panels, 1.5 % with 1344
    assert abs(drift / expected[:, None, None] - along).max() < 0.025
    # measured 0.8 % below the asymptote
    assert pushed(20.0, 1.0) == pytest.approx(2 / 3 * RHO * G, rel=0.01)


#: Mass and hydrostatics of the hemisphere that floats at its equator.
MASS = 2 / 3 * np.pi * RHO * np.eye(3)
STIFFNESS = np.diag([0, 0, np.pi * RHO * G])


def scattered(results, rao):
    """Kochin function (omega, direction, theta) of everything but the incident wave."""
    waves = np.zeros((*rao.shape[:2], len(THETA)), dtype=complex)
    omega, dofs = list(rao["omega"].values), list(rao["radiating_dof"].values)
    for r in results:
        i = omega.index(float(r.omega))
        H = cpt.post_pro.compute_kochin(r, THETA)
        if hasattr(r, "radiating_dof"):
            waves[i] += rao.values[i, :, dofs.index(r.radiating_dof), None] * H
        else:
            waves[i, DIRECTIONS.index(r.wave_direction)] += H
    return waves


def surplus(results):
    """Damping by pressure over that by the energy of the radiated waves, minus 1.

    B = 4 pi rho k / omega int |H|^2 d theta.
    """
    found = []
    for r in results:
        if hasattr(r, "radiating_dof"):
            H = cpt.post_pro.compute_kochin(r, THETA)
            flux = 8 * np.pi**2 * RHO * r.wavenumber / r.omega * (abs(H) ** 2).mean()
            found.append(r.radiation_damping[r.radiating_dof] / flux - 1)
    return np.array(found)


def test_radiated_energy_is_the_damping(hemisphere):
    """Normalisation of the Kochin functions. Flat panels: the error is of first order in size."""
    coarse = cpt.mesh_sphere(radius=1.0, resolution=(16, 24)).immersed_part()
    errors = surplus(solved(with_translations(coarse), [0.7, 1.4])), surplus(hemisphere)
    # measured -3.4 % at most of 384 panels, -1.7 % of 1536 panels
    assert abs(errors[1]).max() < 0.04
    # extrapolated to no size: measured -0.7 %
    assert abs((24 * errors[1] - 16 * errors[0]) / 8).max() < 0.02


@pytest.mark.parametrize("viscous", [0.0, 0.3])
def test_floating_hemisphere(hemisphere, viscous):
    """Maruo (1960): without losses F = 2 pi rho k^2 int |H|^2 (cos b - cos theta) d theta.

    What viscous damping takes from the waves (power P) adds its momentum P k / omega along them.
    """
    D = viscous * RHO * np.sqrt(G) * np.eye(3)
    rao = motion(hemisphere, MASS, D, STIFFNESS)
    drift = mean_drift_force(hemisphere, rao)
    H = abs(scattered(hemisphere, rao)) ** 2
    omega = rao["omega"].values
    k = omega**2 / G
    power = 0.5 * omega[:, None] ** 2 * np.einsum("wbi,ij,wbj->wb", rao.conj(), D, rao).real
    for component, dof in ((np.cos, "Surge"), (np.sin, "Sway")):
        wave = component(np.array(DIRECTIONS))
        lever = wave[:, None] - component(THETA)
        expected = 4 * np.pi**2 * RHO * k[:, None] ** 2 * (H * lever).mean(axis=-1)
        expected = expected + power * (k / omega)[:, None] * wave
        got = drift.sel(drift_dof=dof).values
        # measured 5e-6 without losses; with them 2.4 %, 0.5 % (the damping of the panels, above)
        np.testing.assert_allclose(got, expected, rtol=0.03 if viscous else 1e-4, atol=1e-9)
    # measured 3e-7: a round body is not turned
    assert abs(drift.sel(drift_dof="Yaw")).max() < 1e-5 * abs(drift).max()


def test_yaw_moment_of_a_body_beside_the_origin(hemisphere):
    """Moved by (x, y) the moment about the origin is x F_y - y F_x, the force the same."""
    x, y = 1.3, -0.7
    mesh = cpt.mesh_sphere(radius=1.0, resolution=(24, 32)).immersed_part()
    moved = solved(with_translations(mesh.translated([x, y, 0.0])), [0.7, 1.4])
    here = mean_drift_force(hemisphere, motion(hemisphere, MASS, 0.0, STIFFNESS)).values
    there = mean_drift_force(moved, motion(moved, MASS, 0.0, STIFFNESS)).values
    moment = x * here[..., 1] - y * here[..., 0]
    scale = abs(here).max()
    # measured 2.3e-5 and 3.7e-5 of the largest force
    np.testing.assert_allclose(there[..., :2], here[..., :2], atol=1e-4 * scale)
    np.testing.assert_allclose(there[..., 2], here[..., 2] + moment, atol=2e-4 * scale)


def test_missing_results(hemisphere):
    rao = motion(hemisphere)
    with pytest.raises(ModelError, match="5 radiation and 4 diffraction results: needed"):
        mean_drift_force([r for r in hemisphere if r is not hemisphere[-1]], rao)


def test_other_frequencies(hemisphere):
    rao = motion(hemisphere).assign_coords(omega=[1.0, 2.0])
    with pytest.raises(ModelError, match="the RAO has the frequencies"):
        mean_drift_force(hemisphere, rao)


def test_results_without_sources(hemisphere):
    body = hemisphere[0].body
    results = solved(body, [0.7], "direct")
    with pytest.raises(ModelError, match="method='indirect' and keep_details=True"):
        mean_drift_force(results, motion(results))
