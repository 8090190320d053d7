"""A campaign's folder: lock, manifest and chunk files, each complete or not there at all."""

import contextlib
import datetime
import fcntl
import json
import os
import shutil
import socket
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
import xarray as xr

from marine_mj.analysis import SubsetState
from marine_mj.errors import AnalysisError, CampaignError

#: How long a look at the lock by `status` may keep a starting campaign waiting, s.
_LOCK_PATIENCE = 0.5


class CampaignFolder:
    """Files of one campaign.

    Attributes:
        path: the folder.
        runs: its folder of Parquet files, one per chunk.
        trajectories: its folder of NetCDF files, one per chunk.
        levels: its folder of states of searches for rare events, one per cell and repetition.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self.runs = self.path / "runs"
        self.trajectories = self.path / "trajectories"
        self.levels = self.path / "levels"
        self._parts = self.path / ".part"

    @property
    def exists(self) -> bool:
        """Whether a campaign was started here."""
        return (self.path / "manifest.json").is_file()

    def manifest(self) -> dict[str, Any]:
        """What the campaign was started with.

        Raises:
            CampaignError: there is no campaign in this folder, or its manifest is damaged.
        """
        file = self.path / "manifest.json"
        if not file.is_file():
            raise CampaignError(
                f"no campaign in {str(self.path)!r}: start it with `marine-mj campaign run FILE "
                f"--out {self.path}`, or give the --out it was started with"
            )
        try:
            found = json.loads(file.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise CampaignError(f"{str(file)!r} cannot be read: {error}") from None
        if found.get("format") != 1:
            raise CampaignError(
                f"{str(file)!r} has format {found.get('format')!r}; this version reads format 1"
            )
        return found

    def create(self) -> None:
        """Make the folder.

        Raises:
            CampaignError: it cannot be written.
        """
        with self._writing(self.path):
            for folder in (self.runs, self.trajectories, self._parts):
                folder.mkdir(parents=True, exist_ok=True)

    @contextlib.contextmanager
    def lock(self) -> Iterator[None]:
        """Hold the folder; the system lets go of it when the process ends, however it does.

        A lock file that a killed process left behind holds nothing and is taken over.

        Raises:
            CampaignError: another process holds it, or the file system knows no locks.
        """
        file = self.path / "lock"
        with self._writing(file):
            handle = os.open(file, os.O_RDWR | os.O_CREAT, 0o644)
        try:
            end = time.monotonic() + _LOCK_PATIENCE
            while not self._take(handle, fcntl.LOCK_EX):
                if time.monotonic() > end:
                    raise CampaignError(
                        f"campaign folder {str(self.path)!r} is in use by {self._holder()}: wait "
                        "for it, end it, or choose another --out"
                    )
                time.sleep(0.05)
            now = datetime.datetime.now().astimezone().isoformat(timespec="seconds")
            about = {"pid": os.getpid(), "host": socket.gethostname(), "since": now}
            with self._writing(file):
                os.ftruncate(handle, 0)
                os.pwrite(handle, json.dumps(about).encode(), 0)
            shutil.rmtree(self._parts, ignore_errors=True)
            self.create()
            yield
        finally:
            os.close(handle)

    def locked(self) -> str | None:
        """Who works in the folder at this moment; None if nobody does."""
        try:
            handle = os.open(self.path / "lock", os.O_RDONLY)
        except OSError:
            return None
        try:
            return None if self._take(handle, fcntl.LOCK_SH) else self._holder()
        finally:
            os.close(handle)

    def _take(self, handle: int, kind: int) -> bool:
        """Whether the lock could be had."""
        try:
            fcntl.flock(handle, kind | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        except OSError as error:
            raise CampaignError(
                f"the file system of {str(self.path)!r} has no locks ({error.strerror}), which "
                "keep two campaigns apart: choose an --out on another one"
            ) from None
        return True

    def _holder(self) -> str:
        """The process named in the lock file."""
        try:
            about = json.loads((self.path / "lock").read_text(encoding="utf-8"))
            return f"process {about['pid']} on {about['host']} since {about['since']}"
        except (OSError, ValueError, KeyError):
            return "another process"

    def write_json(self, name: str, value: dict[str, Any]) -> None:
        """Write a JSON file into the folder."""
        with self._atomic(self.path / name) as part:
            part.write_text(json.dumps(value, indent=2, allow_nan=False) + "\n", encoding="utf-8")

    def write_text(self, name: str, text: str) -> None:
        """Write a text file into the folder."""
        with self._atomic(self.path / name) as part:
            part.write_text(text, encoding="utf-8")

    def write_chunk(self, name: str, table: pa.Table, signals: xr.Dataset | None) -> None:
        """Write the files of a finished chunk; the Parquet file comes last and means finished.

        Raises:
            CampaignError: no space, or the folder cannot be written; finished chunks are intact.
        """
        if signals is not None:
            compressed = {
                str(k): {"zlib": True, "complevel": 1}
                for k, v in signals.data_vars.items()
                if v.dtype.kind == "f" and v.size
            }
            with self._atomic(self.trajectories / f"{name}.nc") as part:
                signals.to_netcdf(part, engine="h5netcdf", encoding=compressed)
        with self._atomic(self.runs / f"{name}.parquet") as part:
            pq.write_table(table, part, compression="zstd")

    def write_state(self, name: str, state: SubsetState) -> None:
        """Write the state of a search between two levels.

        Raises:
            CampaignError: no space, or the folder cannot be written; finished chunks are intact.
        """
        with self._writing(self.levels):
            self.levels.mkdir(exist_ok=True)
        with self._atomic(self.levels / f"{name}.npz") as part:
            state.save(part)

    def read_state(self, name: str) -> SubsetState | None:
        """State of a search; None where there is none, or a damaged file.

        The rows of its runs are all in the chunks, so that nothing is lost with the file.
        """
        with contextlib.suppress(OSError, AnalysisError):
            return SubsetState.load(self.levels / f"{name}.npz")
        return None

    def finished(self, name: str, runs: int) -> bool:
        """Whether a chunk's file is there with this number of runs.

        Raises:
            CampaignError: instead there is one of the same runs with other inputs.
        """
        file = self.runs / f"{name}.parquet"
        if file.is_file():
            with contextlib.suppress(OSError, pa.ArrowException):
                return pq.read_metadata(file).num_rows == runs
            return False
        for other in self.runs.glob(f"{name.rpartition('-')[0]}-*.parquet"):
            raise CampaignError(
                f"{str(other)!r} holds the same runs, computed with other inputs (wanted: "
                f"{file.name}): move it away to compute them anew, or choose a new --out"
            )
        return False

    def complete(self, first: int, end: int) -> bool:
        """Whether the files of all runs from `first` up to `end` are there and can be read."""
        rows = 0
        for file in self.chunk_files():
            if first <= first_run(file) < end:
                with contextlib.suppress(OSError, pa.ArrowException):
                    rows += pq.read_metadata(file).num_rows
        return rows == end - first

    def chunk_files(self) -> list[Path]:
        """Parquet files of all finished chunks, in the order of their runs."""
        return sorted(self.runs.glob("chunk-*.parquet"))

    def read(
        self, name: str, columns: list[str] | None = None, filters: list[Any] | None = None
    ) -> pa.Table:
        """Columns (default: all) of a finished chunk.

        Raises:
            CampaignError: its file is damaged.
        """
        file = self.runs / f"{name}.parquet"
        try:
            return pq.read_table(file, columns=columns, filters=filters)
        except (OSError, pa.ArrowException) as error:
            raise CampaignError(
                f"{str(file)!r} cannot be read (damaged?): {error}. `marine-mj campaign resume` "
                "computes it again"
            ) from None

    def remove_from(self, run: int) -> None:
        """Remove the chunks that start at this run or after it: the campaign stopped before."""
        for file in (*self.chunk_files(), *self.trajectories.glob("chunk-*.nc")):
            if first_run(file) >= run:
                file.unlink()

    @contextlib.contextmanager
    def _atomic(self, file: Path) -> Iterator[Path]:
        """A place to write to, which becomes the file when all of it is on the disk."""
        part = self._parts / file.name
        with self._writing(file):
            try:
                yield part
                _sync(part)
                os.replace(part, file)
                _sync(file.parent)
            finally:
                part.unlink(missing_ok=True)

    @contextlib.contextmanager
    def _writing(self, file: Path) -> Iterator[None]:
        """Turn what the system refuses into a clear error."""
        try:
            yield
        # h5py reports a full disk as RuntimeError when it finds it out on closing.
        except (OSError, RuntimeError) as error:
            raise CampaignError(
                f"cannot write {str(file)!r}: {error}. Finished chunks are intact; make room or "
                "set the permissions, then `marine-mj campaign resume`"
            ) from None


def chunk_name(first: int, digest: str) -> str:
    """Name of a chunk's files, without the ending: sorts by runs, names its inputs."""
    return f"chunk-{first:08d}-{digest[:16]}"


def first_run(file: Path) -> int:
    """Number of the first run in a chunk's file."""
    return int(file.name.split("-")[1])


def _sync(path: Path) -> None:
    """Wait until a file or folder is on the disk."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
