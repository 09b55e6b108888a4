"""Which trial or splat comes next, so that a partial run is worth most.

Scenes come in turn from every family. As soon as a scene has its splat, the
trials of all methods in it follow: whenever a run stops, it has compared
all methods in balanced scenes.
"""

import dataclasses as dc
from collections import deque
from collections.abc import Callable, Container, Sequence
from itertools import chain, groupby, zip_longest

from remosplat_drake.benchmark.jobs import Job
from remosplat_drake.benchmark.reaching_task import SURFEL, BenchmarkCase
from remosplat_drake.benchmark.result import TrialResult
from remosplat_drake.benchmark.splat_recipe import SplatRecipe
from remosplat_drake.benchmark.splat_record import SplatRecord
from remosplat_drake.benchmark.trained_splats import (
    SplatOrder,
    failed_record,
    make_splat,
)
from remosplat_drake.benchmark.trial import Trial, describe, run_trial

RunTrial = Callable[[Trial], TrialResult]


@dc.dataclass(frozen=True)
class SplatMaking:
    """How scenes get the splats they lack.

    Attributes:
        recipe: How a splat is made.
        at_once: How many are made at the same time, at most.
        gpus: GPUs that the workers share, as the driver names them.
        function: What makes one; must be importable by workers.
    """

    recipe: SplatRecipe
    at_once: int
    gpus: tuple[str, ...] = ()
    function: Callable[[SplatOrder], SplatRecord] = make_splat


def interleave_families(
    cases: Sequence[BenchmarkCase],
) -> list[BenchmarkCase]:
    """The first of each family, then the second of each, and so on."""
    by_family = [
        list(group) for _, group in groupby(cases, key=lambda c: c.family)
    ]
    turns = chain.from_iterable(zip_longest(*by_family))
    return [case for case in turns if case is not None]


class TrialQueue:
    """A `JobSource` of trials, and of the splats that they wait for."""

    def __init__(
        self,
        trials: Sequence[Trial],
        known: Container[str],
        workers: int,
        *,
        function: RunTrial = run_trial,
        splats: SplatMaking | None = None,
        is_over: Callable[[], bool] = lambda: False,
    ):
        """Sorts trials into those that can run and those that wait.

        Args:
            trials: What to run, scene by scene.
            known: Keys of trials that need not be run again.
            workers: How many jobs run at the same time.
            function: What runs a trial.
            splats: How scenes get the splats they lack; None leaves them
                without.
            is_over: Once it says so, no other scene is begun.
        """
        self._known, self._workers = known, workers
        self._function, self._splats = function, splats
        self._is_over = is_over
        self._ready: deque[Trial] = deque()
        self._waiting: deque[tuple[SplatOrder, list[Trial]]] = deque()
        self._making: dict[Job, list[Trial]] = {}
        self._begun: BenchmarkCase | None = None
        self.keys: list[str] = []
        for case, group in groupby(trials, key=lambda trial: trial.case):
            of_scene = list(group)
            order = self._order(case, of_scene)
            if order is None:
                self._release(of_scene)
            else:
                self._waiting.append((order, of_scene))

    @property
    def splats_left(self) -> int:
        """Splats that are not made yet."""
        return len(self._waiting)

    @property
    def trials_left(self) -> int:
        """Trials that are not handed out yet."""
        waiting = chain((w for _, w in self._waiting), self._making.values())
        return len(self._ready) + sum(len(trials) for trials in waiting)

    def take(self) -> Job | None:
        """The next splat or trial.

        One worker is left for trials as long as there are any. When it is
        over, the methods in the scene that has begun still follow.
        """
        is_over = self._is_over()
        if not is_over and self._may_make_splat():
            assert self._splats is not None
            order, trials = self._waiting.popleft()
            job = Job(order, self._splats.function, failed_record)
            self._making[job] = trials
            return job
        if not self._ready or (is_over and self._ready[0].case != self._begun):
            return None
        trial = self._ready.popleft()
        self._begun = trial.case
        return Job(trial, self._function, describe)

    def done(self, job: Job, result: object) -> None:
        """A scene whose splat has failed goes on without."""
        if job in self._making:
            self._release(self._making.pop(job))

    def _may_make_splat(self) -> bool:
        if self._splats is None or not self._waiting:
            return False
        free_for_trials = self._workers - len(self._making) - 1
        return len(self._making) < self._splats.at_once and (
            free_for_trials > 0 or not self._ready
        )

    def _order(
        self, case: BenchmarkCase, trials: list[Trial]
    ) -> SplatOrder | None:
        """The order of the splat that the trials of a scene must wait for."""
        if self._splats is None:
            return None
        if not any(trial.method.needs_splat for trial in trials):
            return None
        if case.splat_key() != SURFEL or case.task().solids is None:
            return None
        return SplatOrder(case, self._splats.recipe)

    def _release(self, trials: list[Trial]) -> None:
        """Their keys are only known now: they name the splat's content."""
        for trial in trials:
            key = trial.key()
            self.keys.append(key)
            if key not in self._known:
                self._ready.append(trial)
