"""Shows the progress of kernel compilation, which delays a first start."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from time import monotonic

from remosplat_drake.app.scenario import Scenario
from remosplat_drake.base.kernels import compilation, files
from remosplat_drake.base.kernels.listing import read_list
from remosplat_drake.base.progress import Progress, Stage
from remosplat_drake.oracle.oracle_config import SphereToEllipsoid

RUN_KERNELS = Path(__file__).with_name("run_kernels.json")
"""File that lists the kernels of runs whose map consists of ellipsoids."""

_SURE = 5.0
"""The remaining time of compilation is estimated from the expected and the
measured speed. After this time [s], both speeds have equal weight."""


@contextmanager
def compiling_shown(
    progress: Progress,
    scenario: Scenario | None = None,
    tell: Callable[[str], None] = lambda text: None,
) -> Iterator[None]:
    """Shows the progress of compilation while the `with` block waits for it.

    Args:
        progress: Display of the run's progress. During compilation, it shows
            the number of compiled kernels in place of the present stage.
        scenario: The scenario that the block runs, or None. As soon as one
            kernel is missing, all kernels of the scenario are compiled, on all
            cores.
        tell: Function that is called with the displayed text after each kernel.
    """
    if scenario is not None and isinstance(scenario.oracle, SphereToEllipsoid):
        compilation.expect(lambda: read_list(RUN_KERNELS))
    compilation.show(_Shown(progress, tell))
    try:
        yield
    finally:
        compilation.show(None)


class _Shown:
    """Shows the compilation as a stage while the process waits for kernels."""

    def __init__(self, progress: Progress, tell: Callable[[str], None]):
        self._progress, self._tell = progress, tell
        self._stage = Stage("compiling kernels", estimate=self._estimate)
        self._before: Stage | None = None
        self._is_shown = False
        self._start: float | None = None

    def __call__(self, waits: bool) -> None:
        if waits and not self._is_shown:
            self._before = self._progress.stage
            self._progress.show(self._stage)
            if self._start is None:
                self._start = monotonic()
                _print_reason()
                self._progress.print_line()
        if waits:
            self._tell(f"{self._stage.what}: {self._stage.state()[1]}")
        elif self._is_shown and self._before is not None:
            self._progress.show(self._before)
        self._is_shown = waits

    def _estimate(self) -> tuple[float, float]:
        """Returns the finished fraction, and the remaining time [s]."""
        count = compilation.count()
        self._stage.done, self._stage.total = count.done, count.total
        spent = monotonic() - (self._start or monotonic())
        pace = (spent + _SURE) / (count.work_done + _SURE)
        left = (count.work - count.work_done) * pace
        return min(count.work_done / max(count.work, 1e-9), 0.99), left


def _print_reason() -> None:
    """Prints a line if a wheel's kernels do not fit this computer."""
    made = files.unfit()
    if made:
        with suppress(OSError):  # stderr is closed.
            print(
                "kernels must be compiled, since the package's kernels are "
                f"for {made}, but this computer has {files.made_for()}",
                file=sys.stderr,
            )
