"""Runs many jobs in parallel on this machine: `run_jobs`.

Results are returned in the order in which they are ready. If a job fails, or if
its worker process dies, its result describes the failure.
"""

import dataclasses as dc
import logging
import multiprocessing
import os
import signal
import threading
import traceback
from collections import Counter, deque
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    Future,
    ProcessPoolExecutor,
    wait,
)
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing, contextmanager
from itertools import chain, islice
from multiprocessing.sharedctypes import Synchronized
from typing import Any, TypeVar

from remosplat_drake.base.child_process import one_thread_environment
from remosplat_drake.base.errors import RemoSplatError

T = TypeVar("T")
R = TypeVar("R")

DIED = "its process died"
"""Error text of a job whose worker process died."""

MAX_ATTEMPTS = 2
"""Number of attempts to run a job. If its worker dies at every attempt, the job
has failed."""

JOBS_A_WORKER = 100
"""Number of jobs after which new worker processes replace all workers.
Otherwise their memory would grow, since Drake never frees a diagram that
contains Python systems, nor the maps of these systems."""

VISIBLE_GPUS = "CUDA_VISIBLE_DEVICES"
"""Name of the environment variable that selects the GPUs of a process."""

Results = Generator[Any, None, None]
"""Type of a generator of jobs' results, in the order in which they are
ready."""


@dc.dataclass(frozen=True, eq=False)
class Job:
    """A function call that returns a result even if the function fails.

    Attributes:
        subject: Argument of the function. It should be small, since it is sent
            to a worker process.
        function: Function that is called; workers must be able to import it.
        failed: Function that makes a result from the subject and an error's
            text.
    """

    subject: Any
    function: Callable[[Any], Any]
    failed: Callable[[Any, str], Any]

    def run(self) -> Any:
        """Returns the function's result, or that of `failed` after an error."""
        try:
            return self.function(self.subject)
        except Exception:
            error = traceback.format_exc(limit=-3).strip()
            return self.failed(self.subject, error)

    def died(self) -> Any:
        """Returns the result for a job whose worker died at every attempt."""
        return self.failed(self.subject, DIED)


def run_jobs(
    jobs: Iterable[Job], workers: int, gpus: Sequence[str] = ()
) -> Results:
    """Runs jobs in worker processes; if a worker dies, only its job can fail.

    Args:
        jobs: Jobs to run. The iterator yields the next job when a worker is
            free.
        workers: Number of worker processes. 0 runs all jobs in this process, in
            order.
        gpus: Numbers of the GPUs that the workers share. Each worker uses one
            GPU.
    """
    if workers == 0:
        yield from (job.run() for job in jobs)
        return
    fresh, suspects, deaths = iter(jobs), deque[Job](), Counter[Job]()
    while True:
        if suspects:
            # After a worker has died, the jobs that were running are repeated
            # one by one, to find the job that causes the death.
            queue, count = _emptied(suspects), 1
        elif (job := next(fresh, None)) is not None:
            rest = islice(fresh, workers * JOBS_A_WORKER - 1)
            queue, count = chain([job], rest), workers
        else:
            return
        running: dict[Future, Job] = {}
        with _pool(count, gpus) as pool:
            try:
                yield from _drain(pool, queue, running, count, suspects)
            except BrokenProcessPool:
                for job in running.values():
                    deaths[job] += 1
                    if deaths[job] < MAX_ATTEMPTS:
                        suspects.append(job)
                    else:
                        yield job.died()


@dc.dataclass(frozen=True)
class _Failure:
    """The reason why a job has no result.

    Attributes:
        subject: Argument of the function.
        error: The error's text.
    """

    subject: Any
    error: str


def run_all(
    function: Callable[[T], R], subjects: Iterable[T], workers: int
) -> Generator[R, None, None]:
    """Calls a function with each of many arguments, until a call fails.

    Args:
        function: Function that is called; workers must be able to import it.
        subjects: The arguments, which should be small, since they are sent to
            worker processes. The iterator may be infinite.
        workers: Number of worker processes. 0 makes all calls in this process,
            in order.

    Yields:
        The results, in the order in which they are ready.

    Raises:
        RemoSplatError: A call fails.
    """
    jobs = (Job(subject, function, _Failure) for subject in subjects)
    with closing(run_jobs(jobs, workers)) as results:
        for result in results:
            if isinstance(result, _Failure):
                raise RemoSplatError(result.error.splitlines()[-1])
            yield result


def _emptied(jobs: deque[Job]) -> Iterator[Job]:
    while jobs:
        yield jobs.popleft()


def _drain(
    pool: ProcessPoolExecutor,
    queue: Iterator[Job],
    running: dict[Future, Job],
    workers: int,
    again: deque[Job],
) -> Results:
    """Submits jobs to free workers, and yields results until all are ready."""
    while True:
        while len(running) < workers and (job := next(queue, None)) is not None:
            try:
                running[pool.submit(job.run)] = job
            except BrokenProcessPool:
                again.append(job)
                raise
        if not running:
            return
        done, _ = wait(running, return_when=FIRST_COMPLETED)
        for future in done:
            result = future.result()
            del running[future]
            yield result


def gpu_for(worker: int, gpus: Sequence[str]) -> str:
    """Returns the number of the GPU that a worker uses."""
    return gpus[worker % len(gpus)]


@contextmanager
def _pool(workers: int, gpus: Sequence[str]) -> Iterator[ProcessPoolExecutor]:
    """Returns a pool of processes with one thread each, which ignore Ctrl-C."""
    spawn = multiprocessing.get_context("spawn")
    with one_thread_environment():
        pool = ProcessPoolExecutor(
            workers,
            mp_context=spawn,
            initializer=_start_worker,
            initargs=(spawn.Value("i", 0), tuple(gpus)),
        )
        try:
            yield pool
        except BaseException:
            for process in list((pool._processes or {}).values()):
                process.terminate()
            raise
        finally:
            pool.shutdown(cancel_futures=True)


def _start_worker(started: "Synchronized[int]", gpus: tuple[str, ...]):
    """Assigns a GPU to a worker, before any library initialises CUDA."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    logging.getLogger("drake").setLevel(logging.WARNING)
    with started.get_lock():
        worker = started.value
        started.value += 1
    if gpus:
        os.environ[VISIBLE_GPUS] = gpu_for(worker, gpus)


def _end_with_parent():
    """Ends this worker when its parent has ended, also if SIGKILL ended it."""
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)
