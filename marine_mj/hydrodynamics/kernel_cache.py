"""The kernels come from the disk cache, always: a process of their own compiles them first.

In a process that has just compiled them, calls between kernels go to other copies of the same code
than in a process that loads them, copies that were optimised apart: results differ in the last
bit. So no process that simulates ever compiles.
"""

import contextlib
import hashlib
import os
import subprocess
import sys
from pathlib import Path

import llvmlite
import llvmlite.binding as llvm
import numba
from numba.core.caching import FunctionCache

from marine_mj.hydrodynamics import table

#: Set in the process that compiles.
VARIABLE = "MARINE_MJ_COMPILES_KERNELS"


def _stamp() -> Path:
    """File that says that these kernels are in the cache, in a folder of that cache."""
    folder = Path(__file__).parent
    sources = [*sorted((folder / "kernels").glob("*.py")), folder / "layout.py"]
    digest = hashlib.sha256(
        f"{numba.__version__} {llvmlite.__version__} {llvm.get_host_cpu_name()} "
        f"{llvm.get_host_cpu_features().flatten()} {sys.version}".encode()
    )
    for path in [*sources, Path(table.__file__)]:
        digest.update(path.read_bytes())
        digest.update(repr(path.stat().st_mtime).encode())  # numba looks at it, too
    return Path(FunctionCache(_stamp).cache_path) / f"kernels-{digest.hexdigest()[:24]}.stamp"


def compile_kernels() -> None:
    """Fill the cache in another process, unless it is filled; once per installation and change.

    Where no other process can be started or nothing can be cached, this process compiles.
    """
    if os.environ.get(VARIABLE):
        return
    with contextlib.suppress(OSError, RuntimeError, subprocess.SubprocessError):
        stamp = _stamp()
        if stamp.exists():
            return
        command = [sys.executable, "-c", "import marine_mj.hydrodynamics.native"]
        subprocess.run(
            command, env={**os.environ, VARIABLE: "1"}, check=True, stdout=subprocess.DEVNULL
        )
        stamp.parent.mkdir(parents=True, exist_ok=True)
        for old in stamp.parent.glob("kernels-*.stamp"):
            old.unlink(missing_ok=True)
        stamp.touch()
