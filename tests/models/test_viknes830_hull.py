"""Hull mesh and wave database of the 8.3 m USV against its study's main dimensions."""

import hashlib
import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from marine_mj.hydrodynamics.bem.settings import Settings
from marine_mj.hydrodynamics.bem.study import read_hull

ASSETS = Path(__file__).parents[2] / "assets"
#: Metacentric height above the keel minus the draught, and the radii of gyration of the study.
STUDY = Settings(mass=5002.6, center_of_mass=(0, 0, 0.252), gyration=(0.89, 1.96, 1.96))


@pytest.fixture(scope="module")
def hull():
    return read_hull("viknes830_hull.stl", STUDY)


@pytest.fixture(scope="module")
def data():
    with xr.open_dataset(ASSETS / "viknes830.nc", engine="h5netcdf") as file:
        return file.load()


def test_main_dimensions(hull):
    still = hull.still
    assert np.ptp(hull.mesh.vertices[:, 0]) == pytest.approx(8.3, abs=1e-3)
    assert (still.length, still.breadth) == pytest.approx((7.2, 2.573), abs=1e-4)
    assert still.draught == pytest.approx(0.76, abs=1e-4)
    assert still.volume == pytest.approx(4.8806, rel=1e-3)  # 4.8806
    assert still.waterplane_area == pytest.approx(14.543, rel=5e-3)  # 14.567
    # LCB 2.840 m before the aft perpendicular against 2.837, KB 0.562 m
    np.testing.assert_allclose(still.center_of_buoyancy, [0, 0, 0.562 - 0.76], atol=5e-3)
    heights = still.metacentric_heights(hull.body.center_of_mass)
    np.testing.assert_allclose(heights, [0.971, 8.623], rtol=5e-3)  # 0.973, 8.637
    # Study: 146229 N/m, 47652 and 423178 N m
    np.testing.assert_allclose(np.diag(hull.stiffness)[2:5], [146229, 47652, 423178], rtol=5e-3)


def test_inertia_is_the_studys(hull):
    expected = [5002.6, 5002.6, 5002.6, 4280.2, 19535.6, 19217.9]
    np.testing.assert_allclose(np.diag(hull.rigid), expected, rtol=1e-4)
    assert hull.rigid[0, 4] == pytest.approx(1260.7, abs=0.1)  # FLU: + m z_G


def test_database_is_of_this_mesh(hull, data):
    file = ASSETS / "viknes830_hull.stl"
    assert data.attrs["mesh_sha256"] == hashlib.sha256(file.read_bytes()).hexdigest()
    np.testing.assert_allclose(data.hydrostatic_stiffness, hull.stiffness, rtol=1e-9, atol=1e-6)
    assert (ASSETS / "viknes830.nc").stat().st_size < 400_000


def test_long_waves_carry_the_hull_along(data):
    """Head seas, longest waves: heave follows the surface, surge leads, pitch is the slope."""
    rao = data.RAO.values[0, 0] + 1j * data.RAO.values[1, 0]
    head = rao[np.argmin(np.abs(data.wave_direction.values - np.pi))]
    assert head[2] == pytest.approx(1.0, abs=0.01)
    assert head[0] == pytest.approx(-1j, abs=0.02)
    assert head[4] / data.wavenumber.values[0] == pytest.approx(1j, abs=0.03)


def test_natural_periods(data):
    """Study: 2.25, 2.30, 2.30 s with A(inf) by strips; 2.08 and 2.45 s coupled."""
    periods = json.loads(data.attrs["natural_periods"])
    assert periods["Heave"] == pytest.approx(2.08, rel=0.05)  # 1.99
    assert periods["Roll"] == pytest.approx(2.30, rel=0.05)  # 2.23
    assert periods["Pitch"] == pytest.approx(2.08, rel=0.05)  # 2.07


def test_added_mass_beside_the_studys_strips(data):
    """Three-dimensional flow takes a quarter off heave: docs/hydrodynamics.md says why."""
    A = data.infinite_added_mass.values
    assert np.linalg.eigvalsh(A)[0] > 0
    np.testing.assert_allclose(A[2, 2] / 13722.8, 0.79, atol=0.03)  # 0.789
    np.testing.assert_allclose(A[3, 3] / 2131.0, 0.91, atol=0.05)  # 0.910
