"""Bars that show how far a benchmark is, and when it will be done."""

from types import TracebackType

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from remosplat_drake.benchmark.result import SUCCESS, TrialResult
from remosplat_drake.benchmark.splat_record import SplatRecord
from remosplat_drake.benchmark.trial_queue import TrialQueue


class BenchmarkProgress:
    """A bar of trials, and one of splats where some are to be made.

    Attributes:
        splats_left: Splats that are not made yet.
    """

    def __init__(self, console: Console):
        self._progress = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            TimeRemainingColumn(),
            console=console,
            transient=True,
        )
        self._splats = self._progress.add_task("splats", visible=False)
        self._trials = self._progress.add_task("running", total=None)
        self._succeeded = self._finished = 0
        self.splats_left = 0

    def __enter__(self) -> "BenchmarkProgress":
        self._progress.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ):
        self._progress.stop()

    def start(self, queue: TrialQueue) -> None:
        """Tells what is left to do."""
        self.splats_left = splats = queue.splats_left
        self._progress.update(self._splats, total=splats, visible=splats > 0)
        self._progress.update(self._trials, total=queue.trials_left)

    def show(self, result: TrialResult | SplatRecord) -> None:
        """Counts one result."""
        if isinstance(result, SplatRecord):
            self.splats_left -= 1
            self._progress.update(self._splats, advance=1)
            return
        self._finished += 1
        self._succeeded += result.outcome("text") == SUCCESS
        description = f"{self._succeeded}/{self._finished} reached"
        self._progress.update(self._trials, advance=1, description=description)
