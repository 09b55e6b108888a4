"""Runs many trials at once, keeps every result, and can be interrupted.

Each trial is a pure function of its description, so results do not depend on
how many run at once or in which order. A result is one line, written in one
piece as soon as it is there; what is in the file already is not run again.
"""

from collections.abc import Callable, Sequence
from contextlib import closing
from pathlib import Path

from remosplat_drake.benchmark.engines import in_this_process, in_workers
from remosplat_drake.benchmark.jobs import JobSource, Results
from remosplat_drake.benchmark.line_file import LineFile
from remosplat_drake.benchmark.ray_engine import on_ray
from remosplat_drake.benchmark.result import TrialResult, read_results, to_line
from remosplat_drake.benchmark.splat_record import SplatRecord
from remosplat_drake.benchmark.trial import Trial, run_trial
from remosplat_drake.benchmark.trial_queue import (
    RunTrial,
    SplatMaking,
    TrialQueue,
)


def run_trials(
    trials: Sequence[Trial],
    path: Path,
    jobs: int,
    *,
    ray_address: str | None = None,
    splats: SplatMaking | None = None,
    is_over: Callable[[], bool] = lambda: False,
    on_start: Callable[[TrialQueue], None] | None = None,
    on_result: Callable[[TrialResult | SplatRecord], None] | None = None,
    function: RunTrial = run_trial,
) -> list[TrialResult]:
    """Runs what a result file does not hold yet, and what crashed.

    Args:
        trials: What to run, scene by scene.
        path: The result file; made if it is not there.
        jobs: Worker processes; 0 runs everything in this one.
        ray_address: Run on that Ray cluster instead ("auto": the one of this
            machine, "local": a new one).
        splats: How scenes get the splats they lack; None leaves them without.
        is_over: Once it says so, no other scene is begun.
        on_start: Called with what is left to run.
        on_result: Called with every new result, and every new splat's record.
        function: What runs a trial; must be importable by workers.

    Returns:
        The results of all trials, old and new, in the order in which their
        scenes were ready; without those that were not started in time.

    Raises:
        FileError: The result file cannot be read or written.
        KeyboardInterrupt: Ctrl-C; every finished trial is in the file.
    """
    known = {
        result.key: result for result in read_results(path) if not result.error
    }
    queue = TrialQueue(
        trials,
        known.copy(),
        jobs,
        function=function,
        splats=splats,
        is_over=is_over,
    )
    if on_start is not None:
        on_start(queue)
    running = _run(queue, jobs, ray_address, splats.gpus if splats else ())
    with (
        LineFile(path) as file,
        closing(running) as results,
    ):
        for result in results:
            if isinstance(result, TrialResult):
                file.append(to_line(result))
                known[result.key] = result
            if on_result is not None:
                on_result(result)
    return [known[key] for key in queue.keys if key in known]


def _run(
    source: JobSource,
    jobs: int,
    ray_address: str | None,
    gpus: Sequence[str],
) -> Results:
    if ray_address is not None:
        return on_ray(source, ray_address)
    if jobs == 0:
        return in_this_process(source)
    return in_workers(source, jobs, gpus)
