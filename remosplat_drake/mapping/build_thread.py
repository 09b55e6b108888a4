"""`BuildThread`: builds maps in a thread while pictures are being taken."""

from collections.abc import Callable
from threading import Thread
from typing import Generic, TypeVar

from remosplat_drake.mapping.messages import Building
from remosplat_drake.reconstruction.pipeline import Report

Result = TypeVar("Result")


class BuildThread(Generic[Result]):
    """Runs one job at a time in a thread; its result is fetched later."""

    def __init__(self):
        """Starts without a job."""
        self._thread: Thread | None = None
        self._result: Result | Exception | None = None
        self._progress: Building | None = None
        self._is_dropped = False

    @property
    def is_busy(self) -> bool:
        """Whether the result of a started job has not been fetched yet."""
        return self._thread is not None

    def start(self, job: Callable[[Report], Result]) -> None:
        """Starts a job; the thread must not be busy.

        Args:
            job: A function; its argument is the callback for progress.
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

        Progress that the job reported last is discarded, so that `progress`
        returns nothing after the result.

        Returns:
            The result, or the exception of the job; None if the job still runs
            or was dropped, or if there is no job.
        """
        if self._thread is None or self._thread.is_alive():
            return None
        self._thread = self._progress = None
        return None if self._is_dropped else self._result

    def progress(self) -> Building | None:
        """Returns new progress of the job; None if there is none."""
        progress, self._progress = self._progress, None
        return None if self._is_dropped else progress

    def _report(self, stage: str, done: int, total: int) -> None:
        self._progress = Building(stage, done, total)
