"""`Progress`: shows the progress of a long job, in a terminal or a log."""

import dataclasses as dc
import math
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from threading import Event, Thread
from time import monotonic
from types import TracebackType
from typing import Self, TypeVar

from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

T = TypeVar("T")

BEGUN = 1.0
"""If the output is not a terminal, the first line about a stage is printed when
the stage has lasted this long [s]. Shorter stages print no line."""

PERIOD = 30.0
"""Time between two lines about a stage, if the output is not a terminal [s]."""

_STEP, _LEAST_PERIOD = 0.1, 5.0
"""If the output is not a terminal, another line is printed after this fraction
of the work has been done, but not before this time [s] has passed since the
last line."""

_BAR = 30
"""Width of the progress bar [columns]."""


@dc.dataclass(eq=False)
class Stage:
    """A part of a job with its own progress display.

    Attributes:
        what: Name of the stage's work.
        done: Number of finished steps.
        total: Number of all steps; None if it is unknown. For fewer than two
            steps, only the elapsed time is shown.
        estimate: Function that returns the finished fraction of the work and
            the remaining time [s]. If it is None, both are computed for steps
            of equal duration.
        start: Time at which the stage began, on the monotonic clock [s].
    """

    what: str
    done: int = 0
    total: int | None = None
    estimate: Callable[[], tuple[float, float]] | None = None
    start: float = dc.field(default_factory=monotonic)
    _shown: float = dc.field(default=0.0, init=False)
    _told: tuple[float, float] | None = dc.field(default=None, init=False)

    def __post_init__(self):
        self._first = self.done

    def state(self) -> tuple[float | None, str]:
        """Returns the finished fraction (None if unknown) and a description.

        The fraction never decreases.
        """
        elapsed = monotonic() - self.start
        if self.estimate is not None:
            fraction, left = self.estimate()
        elif self.total is not None and self.total > 1:
            fraction, steps = self.done / self.total, self.done - self._first
            left = math.inf
            if steps > 0:
                left = elapsed * (self.total - self.done) / steps
        else:
            return None, _duration(elapsed)
        self._shown = max(self._shown, min(fraction, 1.0))
        said = f"{self.done} of {self.total}"
        if math.isfinite(left):
            said += f", about {_duration(left)} left"
        return self._shown, said

    def line(self) -> str:
        """Returns a line about the stage, and records the time of this line."""
        fraction, said = self.state()
        self._told = monotonic(), fraction or 0.0
        return f"{self.what}: {said}"

    def is_line_due(self) -> bool:
        """Whether another line about the stage is due."""
        if self._told is None:
            return monotonic() - self.start >= BEGUN
        time, fraction = self._told
        since, more = monotonic() - time, (self.state()[0] or 0.0) - fraction
        return since >= PERIOD or (since >= _LEAST_PERIOD and more >= _STEP)


class Progress:
    """Shows the stage of a job, with a bar, the steps, and the remaining time.

    In a terminal, the stage is shown in one line, which vanishes at the end. If
    the output is not a terminal, lines are printed to stderr: one for each
    stage that is not short, and further lines for long stages. Nothing is shown
    before the first report.

    Example:
        >>> from rich.console import Console
        >>> from remosplat_drake.base.progress import Progress
        >>> with Progress(Console(), "beginning") as progress:
        ...     for i in range(3):
        ...         progress.report("counting", i, 3)

    Attributes:
        stage: The displayed stage; None before the first report.
    """

    def __init__(self, console: Console, what: str = ""):
        """Prepares the display; the context manager shows it.

        Args:
            console: Console on which progress is shown.
            what: Name of the first stage. If it is empty, nothing is shown
                until the first report.
        """
        self.stage: Stage | None = None
        self._first = what
        self._live = None
        if console.is_interactive and console.file.isatty():
            self._live = Live(
                console=console,
                get_renderable=self._row,
                refresh_per_second=10,
                transient=True,
            )
        self._lines = Thread(target=self._print_lines, daemon=True)
        self._ended = Event()

    def __enter__(self) -> Self:
        if self._first:
            self.report(self._first)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._ended.set()
        if self._live is not None:
            self._live.stop()
        elif self._lines.is_alive():
            self._lines.join()

    def report(
        self, what: str, done: int = 0, total: int | None = None
    ) -> None:
        """Shows the progress of a stage; a new name begins a new stage.

        Args:
            what: Name of the stage's work.
            done: Number of finished steps.
            total: Number of all steps; None if unknown.
        """
        stage = self.stage
        if stage is None or stage.what != what:
            stage = Stage(what, done)
        stage.done, stage.total = done, total
        self.show(stage)

    def over(self, items: Sequence[T], what: str) -> Iterator[T]:
        """Yields items, and shows the number of items that have been processed.

        Args:
            items: The items.
            what: Name of the work that processes them.
        """
        for done, item in enumerate(items):
            self.report(what, done, len(items))
            yield item

    def show(self, stage: Stage) -> None:
        """Replaces the displayed stage by another one."""
        is_first, self.stage = self.stage is None, stage
        if not is_first:
            return
        if self._live is not None:
            self._live.start()
        else:
            self._lines.start()

    def print_line(self) -> None:
        """Prints a line about the stage, if the output is not a terminal."""
        stage = self.stage
        if self._live is None and stage is not None:
            with suppress(OSError):  # The reader has closed the pipe.
                print(stage.line(), file=sys.stderr, flush=True)

    def _print_lines(self) -> None:
        while not self._ended.wait(min(BEGUN, PERIOD) / 2):
            if self.stage is not None and self.stage.is_line_due():
                self.print_line()

    def _row(self) -> RenderableType:
        if self.stage is None:
            return Group()
        fraction, said = self.stage.state()
        bar = ProgressBar(1.0, fraction or 0.0, _BAR, pulse=fraction is None)
        row = Table.grid(padding=(0, 1))
        row.add_row(Text(self.stage.what), bar, Text(said))
        return row


def _duration(time: float) -> str:
    return f"{time:.0f} s" if time < 100.0 else f"{time / 60.0:.0f} min"
