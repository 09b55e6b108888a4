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


class BenchmarkProgress:
    """A bar of trials, and one of splats where some are to be made."""

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

    def start_splats(self, count: int) -> None:
        """Tells how many splats are to be made."""
        self._progress.update(self._splats, total=count, visible=count > 0)

    def show_splat(self, record: SplatRecord) -> None:
        """Counts one splat."""
        self._progress.update(self._splats, advance=1)

    def start_trials(self, count: int) -> None:
        """Tells how many trials are to be run."""
        self._progress.update(self._trials, total=count)

    def show_trial(self, result: TrialResult) -> None:
        """Counts one trial."""
        self._finished += 1
        self._succeeded += result.outcome("text") == SUCCESS
        description = f"{self._succeeded}/{self._finished} reached"
        self._progress.update(self._trials, advance=1, description=description)
