"""`BuildThread`: builds maps in a thread while pictures are being taken."""

from collections.abc import Callable
from threading import Thread
from typing import Generic, TypeVar

from remosplat_drake.mapping.messages import Building
from remosplat_drake.reconstruction.pipeline import Report

Result = TypeVar("Result")


class BuildThread(Generic[Result]):
    """Runs one job at a time in a thread, whose result `fetch` returns."""

    def __init__(self):
        """Starts without a job."""
        self._thread: Thread | None = None
        self._result: Result | Exception | None = None
        self._progress: Building | None = None
        self._is_dropped = False

    @property
    def is_busy(self) -> bool:
        """Whether there is a job whose result has not been fetched yet."""
        return self._thread is not None

    def start(self, job: Callable[[Report], Result]) -> None:
        """Starts a job. The thread must not be busy.

        Args:
            job: A function, which receives the callback for progress.
        """
        assert self._thread is None

        def work() -> None:
            try:
                self._result = job(self._report)
            except Exception as error:
                self._result = error

        self._result, self._is_dropped = None, False
        self._thread = Thread(target=work, name="build", daemon=True)
        self._thread.start()

    def drop(self) -> None:
        """Discards the result of the current job, which runs to its end."""
        self._is_dropped = True

    def fetch(self) -> Result | Exception | None:
        """Fetches the result of a job that has ended.

        Progress that was not read is discarded, so that `progress` returns None
        after the result was fetched.

        Returns:
            The result, or the exception of the job; None if the job still runs
            or was dropped, or if there is no job.
        """
        if self._thread is None or self._thread.is_alive():
            return None
        self._thread = self._progress = None
        return None if self._is_dropped else self._result

    def progress(self) -> Building | None:
        """Returns the job's latest progress; None if there is no new one."""
        progress, self._progress = self._progress, None
        return None if self._is_dropped else progress

    def _report(self, stage: str, done: int, total: int) -> None:
        self._progress = Building(stage, done, total)
