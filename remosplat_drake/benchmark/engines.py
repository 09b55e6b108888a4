"""How trials are run: here, or in many processes of this machine.

An engine is a generator of results, in whatever order they come.
"""

import multiprocessing
import os
import signal
import traceback
from collections import deque
from collections.abc import Callable, Generator, Iterator
from concurrent.futures import (
    FIRST_COMPLETED,
    Future,
    ProcessPoolExecutor,
    wait,
)
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager

from remosplat_drake.benchmark.result import TrialResult
from remosplat_drake.benchmark.trial import Trial, describe

MAX_ATTEMPTS = 2
"""A trial whose worker dies so often is recorded as crashed."""

ONE_THREAD = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "NUMBA_NUM_THREADS": "1",
}
"""Environment of a worker."""

DIED = "its process died"
"""What a result says whose worker was lost."""

RunTrial = Callable[[Trial], TrialResult]
Results = Generator[TrialResult, None, None]


def guarded(function: RunTrial, trial: Trial) -> TrialResult:
    """The trial's result; an error in it becomes a result, too."""
    try:
        return function(trial)
    except Exception:
        return describe(trial, error=traceback.format_exc(limit=-3).strip())


def in_this_process(trials: list[Trial], function: RunTrial) -> Results:
    """One after the other, in order."""
    for trial in trials:
        yield guarded(function, trial)


def in_workers(trials: list[Trial], jobs: int, function: RunTrial) -> Results:
    """Results as they come; a worker that dies costs at most its trial."""
    waiting = deque((trial, 1) for trial in trials)
    suspects: deque[tuple[Trial, int]] = deque()
    while waiting or suspects:
        # After a death, those that were running then go one by one: only
        # so is it clear whose worker dies.
        queue, workers = (suspects, 1) if suspects else (waiting, jobs)
        running: dict[Future, tuple[Trial, int]] = {}
        with _pool(min(workers, len(queue))) as pool:
            try:
                yield from _drain(pool, queue, running, workers, function)
            except BrokenProcessPool:
                for trial, attempt in running.values():
                    if attempt < MAX_ATTEMPTS:
                        suspects.append((trial, attempt + 1))
                    else:
                        yield describe(trial, error=DIED)


def _drain(
    pool: ProcessPoolExecutor,
    queue: deque[tuple[Trial, int]],
    running: dict[Future, tuple[Trial, int]],
    workers: int,
    function: RunTrial,
) -> Results:
    """Keeps the workers busy; `running` tells who is at work."""
    while queue or running:
        while queue and len(running) < workers:
            # A dead pool takes nothing: then the trial stays in the queue.
            future = pool.submit(guarded, function, queue[0][0])
            running[future] = queue.popleft()
        done, _ = wait(running, return_when=FIRST_COMPLETED)
        for future in done:
            result = future.result()
            del running[future]
            yield result


@contextmanager
def _pool(workers: int) -> Iterator[ProcessPoolExecutor]:
    """Spawned workers of one thread each; Ctrl-C is the parent's to handle."""
    with _one_thread():
        pool = ProcessPoolExecutor(
            workers,
            mp_context=multiprocessing.get_context("spawn"),
            initializer=_ignore_interrupts,
        )
        try:
            yield pool
        except BaseException:
            for process in list((pool._processes or {}).values()):
                process.terminate()
            raise
        finally:
            pool.shutdown(cancel_futures=True)


def _ignore_interrupts():
    signal.signal(signal.SIGINT, signal.SIG_IGN)


@contextmanager
def _one_thread() -> Iterator[None]:
    """Children inherit these; they are read when the libraries load."""
    before = {name: os.environ.get(name) for name in ONE_THREAD}
    os.environ.update(ONE_THREAD)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
