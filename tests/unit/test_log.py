"""Log files: round trip, attributes, and what is refused."""

import json

import numpy as np
import pytest
import xarray as xr

from marine_mj.errors import LogError
from marine_mj.simulation import Log

SCENARIO = """
name = "test"
seed = 7
[vehicles.auv]
model = "scout"
[task]
domain = "docking"
name = "dock"
"""


@pytest.fixture
def log():
    time = np.linspace(0, 1, 11)
    data = xr.Dataset(
        {
            "qpos": (("time", "q"), np.arange(77.0).reshape(11, 7), {"units": "m"}),
            "qvel": (("time", "v"), np.zeros((11, 6))),
            "act": (("time", "a"), np.zeros((11, 0))),
        },
        {"time": time, "vehicle": ["auv"]},
        {
            "scenario": SCENARIO,
            "seed": 7,
            "versions": "{}",
            "summary": json.dumps({"docked": True, "capture": None}),
        },
    )
    return Log(data)


def test_round_trip(log, tmp_path):
    path = log.save(tmp_path / "new" / "log.nc")
    loaded = Log.load(path)
    xr.testing.assert_identical(loaded.data, log.data)
    assert loaded.scenario.name == "test" and loaded.seed == 7
    assert loaded.summary == {"docked": True, "capture": None}
    assert [p.name for p in path.parent.iterdir()] == ["log.nc"]


def test_missing_file(tmp_path):
    with pytest.raises(LogError, match=r"none\.nc' does not exist"):
        Log.load(tmp_path / "none.nc")


@pytest.mark.parametrize("keep", [0, 100, 0.5, 0.98])
def test_truncated_file(log, tmp_path, keep):
    path = log.save(tmp_path / "log.nc")
    content = path.read_bytes()
    path.write_bytes(content[: keep if isinstance(keep, int) else int(keep * len(content))])
    with pytest.raises(LogError, match=r"cannot be read .*corrupt, truncated or not NetCDF"):
        Log.load(path)


def test_corrupt_file(tmp_path):
    path = tmp_path / "log.nc"
    path.write_bytes(b"\x89HDF\r\n\x1a\n" + b"nonsense" * 500)
    with pytest.raises(LogError, match="cannot be read"):
        Log.load(path)


def test_other_netcdf_file(tmp_path):
    path = tmp_path / "other.nc"
    xr.Dataset({"a": ("x", [1.0])}).to_netcdf(path, engine="h5netcdf")
    with pytest.raises(LogError, match="not a log of marine_mj: time, qpos, qvel, attribute scen"):
        Log.load(path)


def test_scenario_of_another_version(log):
    log.data.attrs["scenario"] = SCENARIO + "\n[sea]\nnew_key = 1"
    with pytest.raises(LogError, match=r"unknown key 'new_key'.*log written with versions"):
        _ = log.scenario


def test_unwritable_folder(log, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(LogError, match="cannot write log"):
        log.save(tmp_path / "file" / "log.nc")
