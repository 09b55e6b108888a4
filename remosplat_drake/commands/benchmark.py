"""`remosplat benchmark`: compares controllers in many scenes."""

import argparse
import dataclasses as dc
import math
import os
import sys
from collections.abc import Callable
from pathlib import Path
from time import monotonic

from rich.console import Console

from remosplat_drake.app.compiling import compiling_shown
from remosplat_drake.base.atomic_file import check_writable, write_atomically
from remosplat_drake.base.progress import Progress
from remosplat_drake.benchmark.drawing import Drawing
from remosplat_drake.benchmark.methods import GROUPS, load_methods
from remosplat_drake.benchmark.overview import document, overview_table
from remosplat_drake.benchmark.report import report_tables, to_markdown
from remosplat_drake.benchmark.report_page import to_html
from remosplat_drake.benchmark.result import (
    CRASH,
    ERROR,
    TrialResult,
    read_results,
)
from remosplat_drake.benchmark.runner import (
    SplatMaking,
    compile_kernels,
    make_splats,
    missing_splats,
    run_trials,
)
from remosplat_drake.benchmark.splat_record import (
    SplatRecord,
    read_records,
    write_records,
)
from remosplat_drake.benchmark.splat_table import splat_table
from remosplat_drake.benchmark.suites import (
    METHODS,
    MOVING_METHODS,
    ROBOTS_METHOD,
    default_methods,
    interleave_families,
    load_cases,
    suite_robots,
)
from remosplat_drake.benchmark.summary import gather
from remosplat_drake.benchmark.trained_splats import stored_records
from remosplat_drake.benchmark.trial import Trial
from remosplat_drake.commands.benchmark_progress import BenchmarkProgress
from remosplat_drake.commands.json_output import add_json_argument, print_json
from remosplat_drake.commands.number_flags import at_least_one, positive
from remosplat_drake.commands.splat_making import (
    add_splat_arguments,
    splat_folders,
    splat_making,
)
from remosplat_drake.commands.tables import open_console, print_table

RESULTS, SPLATS = "trials.jsonl", "splats.jsonl"
REPORT, PAGE = "report.md", "report.html"
"""Names of the report's files in the output folder."""

CRASHED, UNUSABLE, UNFINISHED = 1, 2, 3
"""Exit codes. `CRASHED`: a trial crashed. `UNUSABLE`: a scene cannot be used.
`UNFINISHED`: some trials have not run yet."""

HEADING = "Benchmark"

EXAMPLES = """
remosplat benchmark --scenes 20 --output results/first
remosplat benchmark --methods my_controller:make,sdf-hard --scenes 2
remosplat benchmark --suite robots --robot my_arm/my_arm.yaml
"""
"""Examples at the end of `--help`."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's flags."""
    parser.add_argument(
        "--scenes",
        type=at_least_one,
        default=20,
        metavar="N",
        help="number of scenes of each family (default: 20)",
    )
    parser.add_argument(
        "--suite",
        default="generated",
        metavar="generated|published:DIR|moving[:SUITE]|mbm:DIR|mbm-grasp:DIR"
        "|mbm-carry:DIR|scan:NAME|robots[:SCENE,...]",
        help=(
            "generated: generated scenes (default). published:DIR: the "
            "paper's scenes in DIR. moving: scenes with moving obstacles. "
            "mbm:DIR: MotionBenchMaker's problems in DIR without the object "
            "to grasp; mbm-grasp:DIR: with this object; mbm-carry:DIR: the "
            "robot also carries it back. scan: targets in scanned scenes, as "
            "scan:demo, scan:FILE.yaml or scan:redkitchen:DATA. robots: "
            "random targets for any robot, in the SCENEs clutter, trained, "
            "shelf, box, under_table (default: clutter,trained)"
        ),
    )
    parser.add_argument(
        "--robot",
        default="",
        metavar="NAME|FILE",
        help=(
            "robot that all methods drive (default: the robot of each method; "
            "in suite mbm: panda; in suite robots: all shipped robots). Suite "
            "robots accepts several robots, joined by commas. In suite mbm, a "
            "mobile robot starts at a displaced pose"
        ),
    )
    parser.add_argument(
        "--methods",
        metavar="A,B,...",
        help=(
            "methods to compare, joined by commas. Each is the name of a "
            "method; FILE or FILE:NAME of a file like benchmark/methods.yaml; "
            "your own controller as MODULE:FUNCTION (see "
            f"custom_controller.py); or a group: {', '.join(GROUPS)} "
            f"(default: {METHODS}; in suite moving: {MOVING_METHODS}; in "
            f"suite robots: {ROBOTS_METHOD})"
        ),
    )
    parser.add_argument(
        "--spheres",
        metavar="SET",
        help="sphere set of the robot: paper or covering (default)",
    )
    parser.add_argument(
        "--scenario-text",
        default="",
        metavar="YAML",
        help=(
            "YAML of settings that override those of every method, e.g. "
            "'{time_limit: 5}'"
        ),
    )
    parser.add_argument(
        "--output",
        type=Path,
        default=Path("results/benchmark"),
        metavar="DIR",
        help="folder of the results; trials with a result in it do not run "
        "again (default: results/benchmark)",
    )
    parser.add_argument(
        "--jobs",
        type=int,
        default=len(os.sched_getaffinity(0)),
        metavar="J",
        help="worker processes; 0: none (default: the number of cores)",
    )
    parser.add_argument(
        "--ray",
        metavar="ADDRESS",
        help=(
            "run the trials on the Ray cluster at this address (extra "
            "`cluster`); auto: the cluster of this machine"
        ),
    )
    parser.add_argument(
        "--stop-after",
        type=positive,
        default=math.inf,
        metavar="MINUTES",
        help=(
            "start no further trial after this time, and report the results "
            "so far; the same command, run again, runs the remaining trials"
        ),
    )
    add_splat_arguments(parser)
    add_json_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Runs the missing trials and prints the tables.

    Returns:
        0: all trials have run. 1: a trial crashed, or a splat could not be
        made. 2: a scene cannot be used; the trials in the other scenes have
        run. 3: `--stop-after` ended the run, and some trials have not run.
    """
    started = monotonic()
    console = open_console(stderr=True)
    output: Path = arguments.output
    for name in (RESULTS, SPLATS, REPORT, PAGE):
        check_writable(output / name)
    splats = splat_making(arguments)
    with Progress(console, "choosing scenes") as progress:
        trials = _trials(
            arguments,
            splat_folders(arguments, splats),
            lambda what, found, count: progress.report(
                f"drawing {what}", found, count
            ),
        )
    cases = list(dict.fromkeys(trial.case for trial in trials))
    if arguments.jobs > 1:
        with (
            Progress(console, "warming up") as progress,
            compiling_shown(progress, trials[0].method.scenario),
        ):
            compile_kernels(trials, splats is not None)
    seconds = 60 * arguments.stop_after
    outcome = _run(
        trials,
        arguments,
        splats,
        console,
        lambda: monotonic() - started > seconds,
    )
    if splats is not None:
        made = stored_records(cases, splats.recipe)
        write_records(output / SPLATS, [*made, *outcome.failed_splats])
    # A new result replaces an earlier result with another splat.
    results = [*read_results(output / RESULTS), *outcome.results]
    text = _report(results, output)
    if arguments.json:
        print_json({**document(results), "output": output})
    elif sys.stdout.isatty():
        for comparison in gather(results):
            print_table(open_console(), overview_table(comparison))
    else:
        print(text)
    console.print(f"wrote {RESULTS}, {REPORT} and {PAGE} to {output}")
    return _conclude(outcome, console)


def _trials(
    arguments: argparse.Namespace, folders: tuple[Path, ...], drawing: Drawing
) -> list[Trial]:
    """Returns all trials, ordered by scene.

    With this order, an interrupted run has the results of all methods in most
    scenes.
    """
    chosen = arguments.methods or default_methods(arguments.suite)
    names = chosen.split(",")
    trials: list[Trial] = []
    for robot in suite_robots(arguments.suite, arguments.robot):
        methods = load_methods(
            names, arguments.scenario_text, arguments.spheres, robot
        )
        cases = load_cases(
            arguments.suite,
            arguments.scenes,
            folders,
            arguments.trained_only,
            robot,
            arguments.jobs,
            drawing,
        )
        trials += [
            Trial(method, case)
            for case in interleave_families(cases)
            for method in methods
        ]
    return trials


@dc.dataclass(frozen=True)
class _Outcome:
    """The results of a run, and the trials that have not run."""

    results: list[TrialResult]
    failed_splats: list[SplatRecord]
    trials_left: int
    splats_left: int


def _run(
    trials: list[Trial],
    arguments: argparse.Namespace,
    splats: SplatMaking | None,
    console: Console,
    is_over: Callable[[], bool],
) -> _Outcome:
    orders, records = [], []
    progress = BenchmarkProgress(console)
    with progress, compiling_shown(progress, trials[0].method.scenario):
        if splats is not None:
            orders = missing_splats(trials, splats.recipe)
            progress.start_splats(len(orders))
            records = make_splats(
                orders, splats, is_over=is_over, on_record=progress.show_splat
            )
        results = run_trials(
            trials,
            arguments.output / RESULTS,
            arguments.jobs,
            gpus=splats.gpus if splats else (),
            ray_address=arguments.ray,
            is_over=is_over,
            on_start=progress.start_trials,
            on_result=progress.show_trial,
        )
    return _Outcome(
        results,
        [record for record in records if record.error],
        len(trials) - len(results),
        len(orders) - len(records),
    )


def _report(results: list[TrialResult], output: Path) -> str:
    """Writes the tables and plots, and returns the tables as Markdown."""
    made = splat_table(read_records(output / SPLATS))
    tables = [*report_tables(results), *filter(None, [made])]
    text = to_markdown(tables, HEADING)
    write_atomically(output / REPORT, text)
    write_atomically(output / PAGE, to_html(results, tables, HEADING))
    return text


def _conclude(outcome: _Outcome, console: Console) -> int:
    """Prints failures and the count of unrun trials; returns the exit code."""
    crashed = [r for r in outcome.results if r.outcome("text") == CRASH]
    broken = [
        *((f"{r.method} in {r.scene}", r.error) for r in crashed),
        *((f"splat of {r.scene}", r.error) for r in outcome.failed_splats),
    ]
    for what, error in broken:
        last = error.splitlines()[-1]
        console.print(f"[red]crashed:[/red] {what}: {last}")
    unusable = {
        r.problem: None for r in outcome.results if r.outcome("text") == ERROR
    }
    for problem in unusable:
        console.print(f"[red]error:[/red] {problem}", soft_wrap=True)
    if outcome.trials_left:
        console.print(
            f"--stop-after ended the run: {outcome.trials_left} trials and "
            f"{outcome.splats_left} splats remain; run the same command to "
            "continue"
        )
    if broken:
        return CRASHED
    if unusable:
        return UNUSABLE
    return UNFINISHED if outcome.trials_left else 0
