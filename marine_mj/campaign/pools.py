"""Where the work is done: processes of this machine, or a Dask cluster."""

import contextlib
import logging
import multiprocessing
import os
import signal
import threading
import weakref
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from typing import Any, Protocol

from marine_mj.errors import CampaignError

#: One worker is one thread: its libraries must not start more. Dask's workers report no trifles.
_WORKER_ENVIRONMENT = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "NUMEXPR_NUM_THREADS": "1",
    "VECLIB_MAXIMUM_THREADS": "1",
    "NUMBA_NUM_THREADS": "1",
    "DASK_LOGGING__DISTRIBUTED": "critical",
}
#: How long `--cluster tcp://...` waits for the scheduler, s.
_CONNECT = 15.0


class Pool(Protocol):
    """An executor that survives its workers.

    Attributes:
        slots: pieces of work that can be done at the same time.
        died: exceptions that mean a worker ended without an answer.
        shared_fate: whether one dead worker takes the work of all others with it.
        retries: how often work whose worker died is worth trying again.
    """

    slots: int
    died: tuple[type[BaseException], ...]
    shared_fate: bool
    retries: int

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Future:
        """Future of a call in a worker."""
        ...

    def restart(self) -> None:
        """Make the pool usable again after a worker died."""
        ...


def cores() -> int:
    """Processors that this process may use."""
    return len(os.sched_getaffinity(0))


@contextlib.contextmanager
def open_pool(
    workers: int | None = None, cluster: str | None = None, executor: Executor | None = None
) -> Iterator[Pool]:
    """A pool of workers of one thread each, closed at the end; work still running is given up.

    Args:
        workers: processes on this machine; default: one per processor. Not with an address.
        cluster: None for plain processes, "local" for a Dask cluster on this machine, or the
            address of a Dask scheduler, such as `tcp://10.0.0.1:8786`.
        executor: any other executor, instead; `workers` says how many calls it does at a time. It
            stays open, and what it does not survive ends the campaign.

    Raises:
        CampaignError: bad number of workers, Dask is missing, or there is no scheduler there.
    """
    if workers is not None and workers < 1:
        raise CampaignError(f"workers = {workers} is not allowed: 1 or more")
    if executor is not None:
        with contextlib.closing(GivenPool(executor, workers or 1)) as given:
            yield given
        return
    if cluster is None:
        with _limited(), contextlib.closing(LocalPool(workers or cores())) as pool:
            yield pool
        return
    if cluster != "local" and "://" not in cluster:
        raise CampaignError(
            f"cluster = {cluster!r} is not allowed: 'local', or the address of a Dask scheduler "
            "such as tcp://10.0.0.1:8786"
        )
    if cluster != "local" and workers is not None:
        raise CampaignError(
            f"workers = {workers} does not go with cluster = {cluster!r}: the cluster has its own"
        )
    with _limited(), contextlib.closing(DaskPool(cluster, workers or cores())) as dask_pool:
        yield dask_pool


class Here(Executor):
    """Calls are done at once by the caller: a worker that runs whole campaigns needs no others."""

    def submit(self, function: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future:
        """Future that is done."""
        future: Future = Future()
        try:
            future.set_result(function(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future


class GivenPool:
    """An executor of the caller, who also closes it."""

    died: tuple[type[BaseException], ...] = ()
    shared_fate = False
    retries = 0

    def __init__(self, executor: Executor, slots: int) -> None:
        self.slots, self._executor = slots, executor
        self._futures: weakref.WeakSet[Future] = weakref.WeakSet()

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Future:
        """Future of a call."""
        future = self._executor.submit(function, *arguments)
        self._futures.add(future)
        return future

    def restart(self) -> None:
        """Never called: no exception means a dead worker."""

    def close(self) -> None:
        """Give up what has not begun."""
        for future in list(self._futures):
            future.cancel()


class LocalPool:
    """Processes of this machine, started afresh (spawn), so that they inherit no locks."""

    died: tuple[type[BaseException], ...] = (BrokenProcessPool,)
    shared_fate = True
    retries = 2

    def __init__(self, workers: int) -> None:
        self.slots = workers
        self._executor: ProcessPoolExecutor | None = None

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Future:
        """Future of a call in a worker."""
        if self._executor is None:
            context = multiprocessing.get_context("spawn")
            self._executor = ProcessPoolExecutor(self.slots, context, initializer=_start_worker)
        return self._executor.submit(function, *arguments)

    def restart(self) -> None:
        """Give up all workers; the next call starts new ones."""
        self.close()

    def close(self) -> None:
        """End all workers at once."""
        executor, self._executor = self._executor, None
        if executor is None:
            return
        processes = list((executor._processes or {}).values())
        executor.shutdown(wait=False, cancel_futures=True)
        for process in processes:
            process.kill()
        executor.shutdown(wait=True)


class DaskPool:
    """Workers of a Dask cluster; its scheduler replaces those that die and tries again itself."""

    shared_fate = False
    retries = 0

    def __init__(self, cluster: str, workers: int) -> None:
        """Start a cluster on this machine, or connect to one.

        Raises:
            CampaignError: Dask is missing, or there is no scheduler at the address.
        """
        try:
            from distributed import Client, KilledWorker, LocalCluster
        except ImportError as error:
            raise CampaignError(
                f"a Dask cluster needs dask.distributed ({error}): pip install 'marine-mj[cluster]'"
            ) from None
        # Its notes about workers that come and go would drown the progress.
        logging.getLogger("distributed").setLevel(logging.CRITICAL)
        self.died: tuple[type[BaseException], ...] = (KilledWorker,)
        self._cluster: Any = None
        if cluster == "local":
            self._cluster = LocalCluster(
                n_workers=workers,
                threads_per_worker=1,
                processes=True,
                silence_logs=logging.CRITICAL,
                scheduler_kwargs={"dashboard": False, "allowed_failures": 1},
                dashboard_address="127.0.0.1:0",
            )
            self.slots = workers
        try:
            self._client = Client(self._cluster or cluster, timeout=_CONNECT)
        except (OSError, ValueError) as error:
            raise CampaignError(
                f"no Dask scheduler answers at {cluster!r} within {_CONNECT:g} s ({error}): start "
                "one with `dask scheduler` and give the address that it prints"
            ) from None
        if cluster != "local":
            threads = self._client.nthreads()
            if not threads:
                self._client.close()
                raise CampaignError(
                    f"the scheduler at {cluster!r} has no workers: start some with `dask worker "
                    f"{cluster} --nthreads 1`"
                )
            self.slots = sum(threads.values())
        self._executor: Executor = self._client.get_executor(pure=False)

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Future:
        """Future of a call in a worker."""
        return self._executor.submit(function, *arguments)

    def restart(self) -> None:
        """Nothing to do: the scheduler goes on with the workers that it has."""

    def close(self) -> None:
        """Give up what runs and disconnect."""
        self._executor.shutdown(wait=False)
        self._client.close()
        if self._cluster is not None:
            self._cluster.close()


@contextlib.contextmanager
def _limited() -> Iterator[None]:
    """Processes started inside inherit the settings; this process has its libraries loaded."""
    before = {name: os.environ.get(name) for name in _WORKER_ENVIRONMENT}
    os.environ.update(_WORKER_ENVIRONMENT)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def _start_worker() -> None:
    """Leave Ctrl+C to the parent, and do not outlive it when it is killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()

    def watch() -> None:
        if parent is not None:
            parent.join()
            os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
