"""Shows the progress of a benchmark and its remaining time."""

from remosplat_drake.base.progress import Progress, Stage
from remosplat_drake.benchmark.result import SUCCESS, TrialResult
from remosplat_drake.benchmark.splat_record import SplatRecord


class BenchmarkProgress(Progress):
    """Displays the progress of making splats, and then that of the trials."""

    _splats: Stage
    _trials: Stage
    _succeeded = 0

    def start_splats(self, count: int) -> None:
        """Sets the number of splats to make."""
        self._splats = Stage("splats", total=count)
        if count:
            self.show(self._splats)

    def show_splat(self, record: SplatRecord) -> None:
        """Increments the number of finished splats."""
        self._splats.done += 1

    def start_trials(self, count: int) -> None:
        """Sets the number of trials to run."""
        self._trials = Stage("running", total=count)
        self.show(self._trials)

    def show_trial(self, result: TrialResult) -> None:
        """Increments the number of finished trials."""
        self._succeeded += result.outcome("text") == SUCCESS
        self._trials.done += 1
        finished = f"{self._succeeded}/{self._trials.done}"
        self._trials.what = f"{finished} reached"
