"""How jobs are run: here, or in many processes of this machine.

An engine is a generator of results, in whatever order they come.
"""

import logging
import multiprocessing
import os
import signal
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    Future,
    ProcessPoolExecutor,
    wait,
)
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing.sharedctypes import Synchronized

from remosplat_drake.base.child_process import one_thread_environment
from remosplat_drake.benchmark.jobs import Job, JobList, JobSource, Results

MAX_ATTEMPTS = 2
"""A job whose worker dies so often is given up."""

VISIBLE_GPUS = "CUDA_VISIBLE_DEVICES"
"""The variable that names the GPUs a process sees."""


def in_this_process(source: JobSource) -> Results:
    """One after the other, in order."""
    while (job := source.take()) is not None:
        result = job.run()
        source.done(job, result)
        yield result


def in_workers(
    source: JobSource, workers: int, gpus: Sequence[str] = ()
) -> Results:
    """Results as they come; a worker that dies costs at most its job.

    Args:
        source: What to run.
        workers: How many processes.
        gpus: GPUs that workers share, as `VISIBLE_GPUS` names them; each
            worker sees one.
    """
    again, deaths = JobList(), Counter[Job]()
    finished = False
    while not finished or again:
        # After a death, those that were running then go one by one: only
        # so is it clear whose worker dies.
        queue, count = (again, 1) if again else (source, workers)
        running: dict[Future, Job] = {}
        with _pool(count, gpus) as pool:
            try:
                for job, result in _drain(pool, queue, running, count, again):
                    source.done(job, result)
                    yield result
                finished = queue is source
            except BrokenProcessPool:
                for job in running.values():
                    deaths[job] += 1
                    if deaths[job] < MAX_ATTEMPTS:
                        again.add(job)
                    else:
                        result = job.died()
                        source.done(job, result)
                        yield result


def _drain(
    pool: ProcessPoolExecutor,
    queue: JobSource,
    running: dict[Future, Job],
    workers: int,
    again: JobList,
) -> Iterator[tuple[Job, object]]:
    """Keeps the workers busy; `running` tells who is at work."""
    while True:
        while len(running) < workers and (job := queue.take()) is not None:
            try:
                running[pool.submit(job.run)] = job
            except BrokenProcessPool:
                again.add(job)
                raise
        if not running:
            return
        done, _ = wait(running, return_when=FIRST_COMPLETED)
        for future in done:
            result = future.result()
            yield running.pop(future), result


def gpu_for(worker: int, gpus: Sequence[str]) -> str:
    """The GPU of a worker: they take turns."""
    return gpus[worker % len(gpus)]


@contextmanager
def _pool(workers: int, gpus: Sequence[str]) -> Iterator[ProcessPoolExecutor]:
    """Spawned workers of one thread each; Ctrl-C is the parent's to handle."""
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
    """Gives a worker its GPU, before anything has looked for one."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    logging.getLogger("drake").setLevel(logging.WARNING)
    with started.get_lock():
        worker = started.value
        started.value += 1
    if gpus:
        os.environ[VISIBLE_GPUS] = gpu_for(worker, gpus)
