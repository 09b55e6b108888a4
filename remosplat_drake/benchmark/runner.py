"""Runs many trials at once, keeps every result, and can be interrupted.

Each trial is a pure function of its description, so results do not depend on
how many run at once or in which order. A result is one line, written in one
piece as soon as it is there; what is in the file already is not run again.
"""

import multiprocessing
import os
import signal
import traceback
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    Future,
    ProcessPoolExecutor,
    wait,
)
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing, contextmanager
from pathlib import Path

from remosplat_drake.benchmark.result import (
    TrialResult,
    read_results,
    to_line,
)
from remosplat_drake.benchmark.trial import Trial, describe, run_trial
from remosplat_drake.errors import FileError

MAX_ATTEMPTS = 2
"""A trial whose worker dies so often is recorded as crashed."""

RunTrial = Callable[[Trial], TrialResult]


def run_trials(
    trials: Sequence[Trial],
    path: Path,
    jobs: int,
    *,
    on_start: Callable[[int], None] | None = None,
    on_result: Callable[[TrialResult], None] | None = None,
    function: RunTrial = run_trial,
) -> list[TrialResult]:
    """Runs what a result file does not hold yet, and what crashed.

    Args:
        trials: What to run.
        path: The result file; made if it is not there.
        jobs: Worker processes; 0 runs everything in this one.
        on_start: Called with the number of trials that are left to run.
        on_result: Called with every new result.
        function: What runs a trial; must be importable by workers.

    Returns:
        The results of all trials, old and new, in the order of `trials`.

    Raises:
        FileError: The result file cannot be read or written.
        KeyboardInterrupt: Ctrl-C; every finished trial is in the file.
    """
    known = {
        result.key: result for result in read_results(path) if not result.error
    }
    keys = [trial.key() for trial in trials]
    todo = {
        key: trial
        for key, trial in zip(keys, trials, strict=True)
        if key not in known
    }
    if on_start is not None:
        on_start(len(todo))
    run = _in_this_process if jobs == 0 else _in_workers
    with (
        _ResultFile(path) as file,
        closing(run(list(todo.values()), jobs, function)) as results,
    ):
        for result in results:
            file.append(result)
            known[result.key] = result
            if on_result is not None:
                on_result(result)
    return [known[key] for key in keys]


def guarded(function: RunTrial, trial: Trial) -> TrialResult:
    """The trial's result; an error in it becomes a result, too."""
    try:
        return function(trial)
    except Exception:
        return describe(trial, error=traceback.format_exc(limit=-3).strip())


class _ResultFile:
    """Appends whole lines that are on disk when `append` returns."""

    def __init__(self, path: Path):
        self._path = path

    def __enter__(self) -> "_ResultFile":
        flags = os.O_RDWR | os.O_CREAT | os.O_APPEND
        try:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            self._handle = os.open(self._path, flags, 0o666)
            self._cut_torn_line()
        except OSError as error:
            raise FileError(self._path, error.strerror or str(error)) from error
        return self

    def __exit__(self, *exception):
        os.close(self._handle)

    def append(self, result: TrialResult):
        line = (to_line(result) + "\n").encode()
        try:
            written = os.write(self._handle, line)
            os.fsync(self._handle)
        except OSError as error:
            raise FileError(self._path, error.strerror or str(error)) from error
        if written < len(line):
            raise FileError(self._path, "the disk is full")

    def _cut_torn_line(self):
        """Removes what a kill in the middle of writing has left."""
        data = self._path.read_bytes()
        os.ftruncate(self._handle, data.rfind(b"\n") + 1)


def _in_this_process(
    trials: list[Trial], jobs: int, function: RunTrial
) -> Generator[TrialResult, None, None]:
    for trial in trials:
        yield guarded(function, trial)


def _in_workers(
    trials: list[Trial], jobs: int, function: RunTrial
) -> Generator[TrialResult, None, None]:
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
                        yield describe(trial, error="its process died")


def _drain(
    pool: ProcessPoolExecutor,
    queue: deque[tuple[Trial, int]],
    running: dict[Future, tuple[Trial, int]],
    workers: int,
    function: RunTrial,
) -> Generator[TrialResult, None, None]:
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
    names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS")
    before = {name: os.environ.get(name) for name in names}
    os.environ.update(dict.fromkeys(names, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
