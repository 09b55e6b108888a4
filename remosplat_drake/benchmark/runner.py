"""Runs a benchmark: makes missing splats of scenes, then runs the trials.

The result of a trial depends only on the trial's description, and not on the
order of trials or on the number of parallel trials. When a trial ends, its
result is written to a file as one line. Trials with a result in the file do not
run again.
"""

import dataclasses as dc
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, suppress
from itertools import groupby, takewhile
from pathlib import Path

from remosplat_drake.base.pool import Job, run_jobs
from remosplat_drake.benchmark.line_file import LineFile
from remosplat_drake.benchmark.ray_cluster import on_ray
from remosplat_drake.benchmark.reaching_task import SURFEL, known_solids
from remosplat_drake.benchmark.result import (
    TrialResult,
    read_results,
    to_line,
)
from remosplat_drake.benchmark.splat_recipe import SplatRecipe
from remosplat_drake.benchmark.splat_record import SplatRecord
from remosplat_drake.benchmark.trained_splats import (
    SplatOrder,
    failed_record,
    make_splat,
)
from remosplat_drake.benchmark.trial import Trial, describe, run_trial
from remosplat_drake.capture.rendering.synthetic import (
    render_capture,
    survey_poses,
)
from remosplat_drake.reconstruction.surfels.surfels import surfels_from_capture

_WARM_UP = 2
"""Number of control ticks after which a method has called all of its
kernels."""


@dc.dataclass(frozen=True)
class SplatMaking:
    """Settings for making the missing splats of scenes.

    Attributes:
        recipe: Settings of the capture and the training.
        workers: Number of worker processes; 0 makes the splats in this process.
        gpus: GPUs that the workers share, as the driver names them.
    """

    recipe: SplatRecipe
    workers: int
    gpus: tuple[str, ...] = ()


def compile_kernels(trials: Sequence[Trial], renders: bool) -> None:
    """Compiles the kernels of trials, so that workers need not compile them.

    Errors are ignored here: they occur again in a worker, which records them.

    Args:
        trials: The trials. The first trial of each method runs for some ticks;
            those of custom controllers do not run.
        renders: Whether kernels for rendering are compiled, too.
    """
    firsts = {trial.method.name: trial for trial in reversed(trials)}
    for trial in firsts.values():
        method = trial.method
        if method.controller:
            continue
        limit = _WARM_UP * method.scenario.control_period
        scenario = dc.replace(method.scenario, time_limit=limit)
        brief = dc.replace(method, scenario=scenario)
        with suppress(Exception):
            run_trial(dc.replace(trial, method=brief))
    truth = known_solids(trials[0].case)
    if renders and truth is not None:
        with suppress(Exception):
            poses = survey_poses(truth, 2)
            surfels_from_capture(render_capture(truth, poses, 64, 48), 100)


def missing_splats(
    trials: Sequence[Trial], recipe: SplatRecipe
) -> list[SplatOrder]:
    """Returns orders for the splats that trials need and that are missing.

    There are no orders for scenes in which no method uses a splat, and for
    scenes with unknown solids.

    Args:
        trials: The trials, scene by scene.
        recipe: Settings of the splats.
    """
    return [
        SplatOrder(case, recipe)
        for case, of_scene in groupby(trials, key=lambda trial: trial.case)
        if any(trial.method.needs_splat for trial in of_scene)
        and known_solids(case) is not None
        and case.splat_key() == SURFEL
    ]


def make_splats(
    orders: Sequence[SplatOrder],
    making: SplatMaking,
    *,
    is_over: Callable[[], bool] = lambda: False,
    on_record: Callable[[SplatRecord], None] = lambda record: None,
    function: Callable[[SplatOrder], SplatRecord] = make_splat,
) -> list[SplatRecord]:
    """Makes splats, and stores them in the recipe's folder.

    Args:
        orders: Orders of the splats, one per scene.
        making: Recipe, workers and GPUs.
        is_over: Function that is called before each splat. When it returns
            True, no further splat is started.
        on_record: Function that is called with every new record.
        function: Function that makes a splat; workers must be able to import
            it.

    Returns:
        Records of all splats that were started, including failed splats.
    """
    jobs = (Job(order, function, failed_record) for order in orders)
    in_time = takewhile(lambda job: not is_over(), jobs)
    records = []
    with closing(run_jobs(in_time, making.workers, making.gpus)) as results:
        for record in results:
            records.append(record)
            on_record(record)
    return records


def run_trials(
    trials: Sequence[Trial],
    path: Path,
    jobs: int,
    *,
    gpus: Sequence[str] = (),
    ray_address: str | None = None,
    is_over: Callable[[], bool] = lambda: False,
    on_start: Callable[[int], None] = lambda missing: None,
    on_result: Callable[[TrialResult], None] = lambda result: None,
    function: Callable[[Trial], TrialResult] = run_trial,
) -> list[TrialResult]:
    """Runs the trials that have no result in a file, or that crashed.

    Args:
        trials: Trials to run, scene by scene.
        path: Path of the result file, which is created if it does not exist.
        jobs: Number of worker processes; 0 runs all trials in this process.
        gpus: GPUs that the workers share.
        ray_address: Address of a Ray cluster that runs the trials: "auto" is
            this machine's cluster, "local" a new cluster. None uses local
            processes.
        is_over: Function that is called before each scene. When it returns
            True, no further scene is started.
        on_start: Function that is called with the number of trials that will
            run.
        on_result: Function that is called with every new result.
        function: Function that runs a trial; workers must be able to import
            it.

    Returns:
        The stored and the new results of all trials, in the order of `trials`.
        Trials that were not started are omitted.

    Raises:
        FileError: The result file cannot be read or written.
        KeyboardInterrupt: Ctrl-C was pressed; every finished trial is in the
            file.
    """
    known = {
        result.key: result for result in read_results(path) if not result.error
    }
    keyed = [(trial.key(), trial) for trial in trials]
    missing = [trial for key, trial in keyed if key not in known]
    on_start(len(missing))

    def in_time() -> Iterator[Job]:
        for _, of_scene in groupby(missing, key=lambda trial: trial.case):
            if is_over():
                return
            yield from (Job(trial, function, describe) for trial in of_scene)

    running = (
        run_jobs(in_time(), jobs, gpus)
        if ray_address is None
        else on_ray(in_time(), ray_address)
    )
    with LineFile(path) as file, closing(running) as results:
        for result in results:
            file.append(to_line(result))
            known[result.key] = result
            on_result(result)
    return [known[key] for key, _ in keyed if key in known]
