"""Reading NetCDF variables against xarray."""

import h5netcdf
import numpy as np
import pytest
import xarray as xr

from marine_mj.hydrodynamics.netcdf import read_variables
from marine_mj.library import assets_folder

DATABASES = sorted(assets_folder().glob("*.nc"))


@pytest.mark.parametrize("path", DATABASES, ids=lambda path: path.stem)
def test_packaged_databases_are_read_as_by_xarray(path):
    """Every variable of numbers, with its axes turned round and two labels swapped."""
    with xr.open_dataset(path, engine="h5netcdf") as data:
        numbers = [name for name in data.variables if data[name].dtype.kind == "f"]
        wanted = {name: data[name].dims[::-1] for name in numbers}
        labels = {n: data[n].values[::-1].tolist() for n in data.dims if n.endswith("_dof")}
        found = read_variables(path, wanted, labels)
        assert list(found) == numbers
        for name, axes in wanted.items():
            chosen = {axis: labels[axis] for axis in axes if axis in labels}
            expected = data[name].sel(chosen).transpose(*axes).values.astype(float)
            np.testing.assert_array_equal(found[name], expected)
            assert found[name].dtype == np.float64


@pytest.fixture
def small(tmp_path):
    """A file with labels as arrays of characters, and a packed variable."""
    path = tmp_path / "small.nc"
    with h5netcdf.File(path, "w") as file:
        file.dimensions = {"row": 2, "dof": 3, "width": 5}
        names = np.array([list("surge"), list("sway\0"), list("yaw\0\0")], dtype="S1")
        file.create_variable("dof", ("dof", "width"), data=names)
        file.create_variable("force", ("row", "dof"), data=np.arange(6).reshape(2, 3))
        file.create_variable("packed", ("row",), data=np.arange(2)).attrs["scale_factor"] = 0.1
    return path


def test_labels_of_characters_and_optional_variables(small):
    wanted = {"force": ("dof", "row"), "moment": ("row",)}
    found = read_variables(small, wanted, {"dof": ["yaw", "surge"]}, optional=("moment",))
    assert list(found) == ["force"]
    np.testing.assert_array_equal(found["force"], [[2, 5], [0, 3]])


@pytest.mark.parametrize(
    ("wanted", "labels", "error", "message"),
    [
        ({"moment": ("row",)}, {}, KeyError, "moment"),
        ({"force": ("row", "dof")}, {"dof": ["heave"]}, KeyError, "heave"),
        ({"force": ("row", "mode")}, {}, ValueError, "force has the axes row, dof"),
        ({"packed": ("row",)}, {}, ValueError, "packed with scale_factor"),
    ],
)
def test_what_is_missing_is_named(small, wanted, labels, error, message):
    with pytest.raises(error, match=message):
        read_variables(small, wanted, labels)


def test_a_file_that_is_none(tmp_path):
    path = tmp_path / "text.nc"
    path.write_text("no data")
    with pytest.raises(OSError):
        read_variables(path, {"omega": ("omega",)}, {})
