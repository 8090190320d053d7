"""Handing work to a pool, through dead workers, down to the run that kills them."""

from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait

from marine_mj.campaign.pools import Pool
from marine_mj.campaign.worker import WORKER_DIED, Done, Work, do, failed
from marine_mj.errors import CampaignError


def dispatch(
    jobs: Iterator[tuple[int, Work]], pool: Pool, do: Callable[[Work], Done] = do
) -> Iterator[tuple[int, Done]]:
    """Results in the order in which they are ready, each with the name of its job.

    Twice as many jobs as there are workers are taken at a time, so that memory does not grow with
    their number. When a worker dies its jobs are given out again, `pool.retries` times, since the
    one to blame cannot be told from its neighbours; after that a job runs with nothing beside it,
    and when that kills workers too it is halved, until the culprit run is found. That one becomes
    a row with the error `WORKER_DIED`.

    Args:
        jobs: (name, work) pairs.
        pool: does the work.
        do: what is done, a function that can be pickled.

    Raises:
        CampaignError: the pool gave its work up.
        Exception: what `do` raises.
    """
    running: dict[Future, tuple[int, Work]] = {}
    again: deque[tuple[int, Work]] = deque()
    suspects: deque[tuple[int, Work]] = deque()
    deaths: dict[int, int] = {}
    while True:
        dead: list[tuple[int, Work]] = []
        while not suspects and not dead and len(running) < 2 * pool.slots:
            job = again.popleft() if again else next(jobs, None)
            if job is None:
                break
            try:
                running[pool.submit(do, job[1])] = job
            except pool.died:
                dead.append(job)
        if not running and not dead:
            if not suspects:
                return
            name, work = suspects.popleft()
            yield name, _alone(work, pool, do)
            continue
        done = wait(running, return_when=FIRST_COMPLETED).done if not dead else set()
        if dead or (pool.shared_fate and any(_died(future, pool) for future in done)):
            done = wait(running).done
        for future in sorted(done, key=lambda future: running[future][0]):
            job = running.pop(future)
            if _died(future, pool):
                dead.append(job)
            else:
                yield job[0], future.result()
        if dead:
            pool.restart()
        for job in sorted(dead, key=lambda job: job[0]):
            deaths[job[0]] = deaths.get(job[0], 0) + 1
            (suspects if deaths[job[0]] > pool.retries else again).append(job)


def _died(future: Future, pool: Pool) -> bool:
    """Whether the worker ended without an answer.

    Raises:
        CampaignError: the pool as a whole gave up, as Dask does when its scheduler is gone.
    """
    try:
        return isinstance(future.exception(), pool.died)
    except CancelledError:
        raise CampaignError(
            "the pool gave its work up: the cluster's scheduler is gone or cancelled it. Finished "
            "chunks are intact; when it is there again, `marine-mj campaign resume`"
        ) from None


def _alone(work: Work, pool: Pool, do: Callable[[Work], Done]) -> Done:
    """Results of work that has the pool for itself."""
    for _ in range(max(1, pool.retries)):
        try:
            future = pool.submit(do, work)
            wait([future])
            if not _died(future, pool):
                return future.result()
        except pool.died:
            pass
        pool.restart()
    if len(work.variations) == 1:
        return Done([failed(WORKER_DIED)])
    first, second = work.halves()
    return _alone(first, pool, do) + _alone(second, pool, do)
