"""The log of a run: an xarray Dataset with units, frames, scenario, seed and versions."""

import json
import os
import tempfile
from functools import cached_property
from pathlib import Path
from typing import Any

import xarray as xr

from marine_mj.errors import LogError, ScenarioError
from marine_mj.scenario import Scenario

#: Variables that a replay needs.
_REQUIRED = ("time", "qpos", "qvel")


class Log:
    """One recorded run.

    Attributes:
        data: dataset with `time` and the variables of docs/architecture.md, section Log.
    """

    def __init__(self, data: xr.Dataset) -> None:
        """Wrap a dataset.

        Raises:
            LogError: it lacks what every log has.
        """
        missing = [name for name in _REQUIRED if name not in data.variables]
        if missing or "scenario" not in data.attrs:
            missing += [] if "scenario" in data.attrs else ["attribute scenario"]
            raise LogError(f"not a log of marine_mj: {', '.join(missing)} missing")
        self.data = data

    @cached_property
    def scenario(self) -> Scenario:
        """The scenario that was run.

        Raises:
            LogError: the recorded scenario is not valid in this version.
        """
        try:
            return Scenario.from_toml(self.data.attrs["scenario"], "scenario of the log")
        except ScenarioError as error:
            versions = self.data.attrs.get("versions", "{}")
            raise LogError(f"{error} (log written with versions {versions})") from None

    @property
    def summary(self) -> dict[str, Any]:
        """Results of the run."""
        return json.loads(self.data.attrs.get("summary", "{}"))

    @property
    def seed(self) -> int:
        """Seed of all random numbers of the run."""
        return int(self.data.attrs["seed"])

    def save(self, path: str | Path) -> Path:
        """Write a NetCDF file: complete or not at all.

        Raises:
            LogError: the folder cannot be written.
        """
        path = Path(path)
        temporary: str | None = None
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            handle, temporary = tempfile.mkstemp(suffix=".nc.part", dir=path.parent)
            os.close(handle)
            self.data.to_netcdf(Path(temporary), engine="h5netcdf", encoding=self._encoding())
            Path(temporary).chmod(0o644)
            os.replace(temporary, path)
        except OSError as error:
            raise LogError(f"cannot write log {str(path)!r}: {error}") from None
        finally:
            if temporary is not None:
                Path(temporary).unlink(missing_ok=True)
        return path

    def _encoding(self) -> dict[str, dict[str, Any]]:
        """Light compression of everything that has a length."""
        return {
            str(name): {"zlib": True, "complevel": 1}
            for name, variable in self.data.data_vars.items()
            if variable.size > 0 and variable.ndim > 0 and variable.dtype.kind == "f"
        }

    @classmethod
    def load(cls, path: str | Path) -> "Log":
        """Log from a NetCDF file.

        Raises:
            LogError: there is no such file, it is corrupt or truncated, or not a log.
        """
        path = Path(path)
        if not path.is_file():
            raise LogError(f"log {str(path)!r} does not exist: write one with marine-mj run")
        try:
            with xr.open_dataset(path, engine="h5netcdf") as dataset:
                data = dataset.load()
        # h5py reports damage with many kinds of exception.
        except Exception as error:
            raise LogError(
                f"log {str(path)!r} cannot be read ({path.stat().st_size} bytes; corrupt, "
                f"truncated or not NetCDF): {type(error).__name__}: {error}"
            ) from None
        try:
            return cls(data)
        except LogError as error:
            raise LogError(f"log {str(path)!r}: {error}") from None
