"""`BuildThread`: makes one map at a time, beside the taking of pictures."""

from collections.abc import Callable
from threading import Thread
from typing import Generic, TypeVar

from remosplat_drake.mapping.messages import Building
from remosplat_drake.reconstruction.pipeline import Report

Result = TypeVar("Result")


class BuildThread(Generic[Result]):
    """Runs one job at a time; its result is fetched when there is one."""

    def __init__(self):
        """Has nothing to do."""
        self._thread: Thread | None = None
        self._result: Result | Exception | None = None
        self._progress: Building | None = None
        self._is_dropped = False

    @property
    def is_busy(self) -> bool:
        """Whether a job was started whose result has not been fetched."""
        return self._thread is not None

    def start(self, job: Callable[[Report], Result]) -> None:
        """Starts a job while there is none."""
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
        """Forgets the job; nothing else can start before it has ended."""
        self._is_dropped = True

    def fetch(self) -> Result | Exception | None:
        """The result of a job that has ended since, or why there is none."""
        if self._thread is None or self._thread.is_alive():
            return None
        self._thread = None
        return None if self._is_dropped else self._result

    def progress(self) -> Building | None:
        """How far the job has come, if that is new."""
        progress, self._progress = self._progress, None
        return None if self._is_dropped else progress

    def _report(self, stage: str, done: int, total: int) -> None:
        self._progress = Building(stage, done, total)
