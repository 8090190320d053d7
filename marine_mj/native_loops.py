"""Native loops over leading dimensions, compiled once and by one process at a time."""

import contextlib
import fcntl
import hashlib
import os
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from numba import guvectorize


def native_loop(signature: str, layout: str) -> Callable[[Callable], Any]:
    """Decorator: numba's `guvectorize` of one signature, from the disk cache where it has it.

    numba caches a loop and the kernel inside it in two files. Two processes that compile the same
    loop for the first time can leave files that do not belong together, and the next process to
    load them crashes. So only one process at a time compiles or loads.

    Args:
        signature: types, e.g. `"void(f8[:], f8[:])"`.
        layout: dimensions, e.g. `"(n)->(n)"`.
    """

    def decorate(function: Callable) -> Any:
        with _alone():
            # The numpy ufunc itself: numba's wrapper costs as much as a small call.
            return guvectorize([signature], layout, cache=True)(function).ufunc

    return decorate


@contextlib.contextmanager
def _alone() -> Iterator[None]:
    """Hold the lock of this installation and user; none where the file system has no locks."""
    place = hashlib.sha256(str(Path(__file__).parent).encode()).hexdigest()[:16]
    path = Path(tempfile.gettempdir()) / f"marine_mj-{os.getuid()}-{place}.lock"
    with contextlib.ExitStack() as stack:
        with contextlib.suppress(OSError):
            file = stack.enter_context(open(path, "a"))
            fcntl.flock(file, fcntl.LOCK_EX)
        yield
