"""Wave loads between the directions of a database, against the boundary element method."""

import numpy as np
import pytest
from conftest import model_error

from marine_mj.hydrodynamics import fit_memory
from marine_mj.hydrodynamics.bem.settings import Settings
from marine_mj.hydrodynamics.bem.study import read_hull
from marine_mj.hydrodynamics.fit_database import store_memory
from marine_mj.hydrodynamics.harmonics import harmonics, orders, unresolved
from marine_mj.hydrodynamics.memory_fit import irregular_frequencies
from marine_mj.hydrodynamics.memory_store import memory_report
from marine_mj.hydrodynamics.wave_file import whole_circle
from marine_mj.library import assets_folder
from marine_mj.validation import databases as cases

pytest.importorskip("capytaine")


def test_usv_box_at_its_highest_frequency():
    # measured 0.099 % of the axis's largest force (50 % with straight lines over 22.5 deg)
    assert cases.usv_box_between([40]) < 0.3


def test_viknes_near_its_highest_frequency():
    # measured 0.005 % (41 % with straight lines over 15 deg)
    assert cases.viknes_between([38, 39], (3.75, 86.25, 131.25)) < 0.02


@pytest.mark.parametrize(("ratio", "lines"), [(0.58, 2.75), (0.4, 5.13)])
def test_ship_hull_in_five_degree_steps(ratio, lines):
    """200 m box hull; straight lines between the 5 deg steps lose several per cent."""
    ours, straight = cases.ship_between(ratio)
    assert ours < 1e-6  # measured 3e-13 %
    assert straight == pytest.approx(lines, rel=0.02)


def test_estimated_error_is_that_of_the_directions_between():
    """Even (trigonometric) and uneven (spline) lists, fine and coarse, at lambda/L 0.4."""
    directions, force = cases.ship_loads(0.4)
    scale = np.abs(force).max(axis=(0, 1))
    shifted = np.arange(0, 144, 4) + np.tile([0, 1, -1, 0], 9)
    shifted[0] = 0
    # measured: (error, estimate) = 0.01 and 0.036, 1.33 and 0.48, 0.0035 and 0.0033, 0.043, 0.047
    lists = (np.arange(0, 144, 6), np.arange(0, 144, 12), np.sort(shifted))
    for chosen in lists:
        circle = whole_circle(directions[chosen], "none")
        found = harmonics(circle, force[:, chosen])
        wave = np.exp(1j * np.outer(directions, orders(found)))
        got = np.einsum("dm,nmj->ndj", wave, found)
        error = float((np.abs(got - force) / scale).max())
        estimate = float(unresolved(circle, force[:, chosen])[0])
        assert 0.3 * error < estimate < 5 * error or (error > 0.1 < estimate), (error, estimate)


def test_a_study_says_what_its_directions_lack():
    hull = str(assets_folder() / "viknes830_hull.stl")

    def notes(*degrees, **options):
        settings = Settings(directions=tuple(np.radians(degrees).tolist()), **options)
        found = read_hull(hull, settings)
        return " ".join(n for n in found.notes if "direction" in n), found

    text, found = notes(0, 90, 180)
    assert "circle open from 0 to 90 deg (with the hull symmetry 'xz')" in text
    assert found.mirror_planes == "xz" and found.radius == pytest.approx(4.363, abs=1e-3)
    text, _ = notes(*range(0, 181, 15))
    assert "up to 15 deg apart" in text and "every 7.5 deg" in text
    assert notes(*np.arange(0, 181, 7.5))[0] == ""
    assert notes(*range(0, 181, 15), omega=(0.5, 2.0))[0] == ""
    # the default needs no note and is fine enough for its default frequencies
    default = read_hull(hull)
    assert np.degrees(np.diff(default.directions())).max() == pytest.approx(7.5)


# Radiation memory of a barge without a lid


def test_irregular_frequencies_are_named():
    omega, A, B, infinite = cases.barge()
    found = irregular_frequencies(omega, A, B)
    # closed form 3.317 rad/s, steps of 0.1
    assert abs(found[0] - cases.first_irregular()) < 0.1
    with model_error("jump at 3.3, 3.4", "lid in the waterplane", "band=(0.3, 3.1)", "--band"):
        fit_memory(omega, A, B, infinite)


@pytest.mark.parametrize("until", [2.5, 3.0])
@pytest.mark.parametrize("noise", [0.0, 0.005])
def test_fits_are_passive_far_beyond_the_band(until, noise):
    """3.0 rad/s: the fit once failed its own check at 3.4 rad/s, with an eigenvalue of -0.009."""
    omega, A, B, infinite = cases.barge()
    rng = np.random.default_rng(0)
    A, B = (x + noise * x.std(axis=0) * rng.normal(size=x.shape) for x in (A, B))
    memory = fit_memory(omega, A, B, infinite, band=(0.0, until), allowed=0.1)
    memory.check()
    # at 40,000 frequencies of our own; measured 0
    assert cases.lowest_damping(memory) > -1e-9


def test_asymmetric_data_are_fitted_when_asked_for():
    omega, A, B, infinite = cases.barge()
    skew = A.copy()
    skew[:, 0, 4] *= 1.3
    with model_error("(surge, pitch) and its mirror differ", "symmetrise=True"):
        fit_memory(omega, skew, B, infinite, band=(0.0, 3.0))
    memory = fit_memory(omega, skew, B, infinite, band=(0.0, 3.0), symmetrise=True)
    A_mean = 0.5 * (skew + np.swapaxes(skew, 1, 2))
    inside = omega <= 3.0
    w = omega[inside][:, None, None]
    wanted = B[inside] + 1j * w * (A_mean[inside] - infinite)
    got = memory.retardation(omega[inside])
    error = np.linalg.norm(got - wanted, axis=0) / np.linalg.norm(wanted, axis=0).max()
    assert error.max() < 0.02  # measured 0.008


def test_band_is_stored_and_kept_to(tmp_path):
    """A database with irregular frequencies works after `store_memory` with a band."""
    import xarray as xr

    omega, A, B, infinite = cases.barge()
    pair = ("radiating_dof", "influenced_dof")
    dofs = ["Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw"]
    data = xr.Dataset(
        {
            "added_mass": (("omega", *pair), A),
            "radiation_damping": (("omega", *pair), B),
            "infinite_added_mass": (pair, infinite),
        },
        coords={"omega": omega, "radiating_dof": dofs, "influenced_dof": dofs},
    )
    path = tmp_path / "barge.nc"
    data.to_netcdf(path, engine="h5netcdf")
    with model_error("jump at 3.3, 3.4"):
        store_memory(path)
    store_memory(path, band=(0.3, 3.0))
    assert max(pair.error for pair in memory_report(str(path))) < 0.05
