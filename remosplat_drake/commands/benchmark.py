"""`remosplat benchmark`: the paper's comparison, and your own in it."""

import argparse
import os
from pathlib import Path

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from remosplat_drake import warm_up
from remosplat_drake.atomic_file import check_writable, write_atomically
from remosplat_drake.benchmark.methods import GROUPS, load_methods
from remosplat_drake.benchmark.report import report_tables, to_markdown
from remosplat_drake.benchmark.report_page import to_html
from remosplat_drake.benchmark.result import (
    CRASH,
    SUCCESS,
    TrialResult,
    read_results,
)
from remosplat_drake.benchmark.runner import run_trials
from remosplat_drake.benchmark.suites import load_cases
from remosplat_drake.benchmark.trial import Trial

RESULTS, REPORT, PAGE = "trials.jsonl", "report.md", "report.html"
"""What a benchmark leaves in its output folder."""

HEADING = "Benchmark"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command line."""
    parser.add_argument(
        "--scenes",
        type=_positive,
        default=20,
        metavar="N",
        help="how many of each family (default: 20)",
    )
    parser.add_argument(
        "--suite",
        default="generated",
        metavar="generated|published:DIR|scan:NAME",
        help="our own scenes (default), the published ones in DIR, or targets"
        " in scans: scan:demo, scan:FILE.yaml, scan:redkitchen:DATA",
    )
    parser.add_argument(
        "--methods",
        default="paper",
        metavar="A,B,...",
        help="names, FILE or FILE:NAME of benchmark/methods.yaml's kind, your"
        " own controller as MODULE:FUNCTION (see custom_controller.py), or"
        f" groups: {', '.join(GROUPS)} (default: paper)",
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
        help="values laid over every method, e.g. '{time_limit: 5}'",
    )
    parser.add_argument(
        "--splats",
        type=Path,
        action="append",
        default=[],
        metavar="DIR",
        help="where trained splats are, as SCENE.ply; otherwise surfels on"
        " the true geometry stand in",
    )
    parser.add_argument(
        "--trained-only",
        action="store_true",
        help="only scenes that have a trained splat",
    )
    parser.add_argument(
        "--output",
        type=Path,
        default=Path("results/benchmark"),
        metavar="DIR",
        help="what is there already is not run again"
        " (default: results/benchmark)",
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
        help="run on that Ray cluster instead (extra `cluster`); auto: the"
        " one of this machine",
    )


def _positive(text: str) -> int:
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError(f"{text} is not a number >= 1")
    return number


def run(arguments: argparse.Namespace) -> int:
    """Runs what is missing and prints the tables; 1 if a trial crashed."""
    console = Console(stderr=True)
    output: Path = arguments.output
    for name in (RESULTS, REPORT, PAGE):
        check_writable(output / name)
    methods = load_methods(
        arguments.methods.split(","),
        arguments.scenario_text,
        arguments.spheres,
    )
    with console.status("choosing scenes"):
        cases = load_cases(
            arguments.suite,
            arguments.scenes,
            tuple(arguments.splats),
            arguments.trained_only,
        )
    warm_up.announce(console)
    # Scene by scene: an interrupted run has compared all methods in some.
    trials = [Trial(method, case) for case in cases for method in methods]
    results = _run(trials, arguments, console)
    known = read_results(output / RESULTS)
    text = to_markdown(report_tables(known), HEADING)
    write_atomically(output / REPORT, text)
    write_atomically(output / PAGE, to_html(known, HEADING))
    print(text)
    console.print(f"wrote {RESULTS}, {REPORT} and {PAGE} to {output}")
    crashed = [r for r in results if r.outcome("text") == CRASH]
    for result in crashed:
        last = result.error.splitlines()[-1]
        console.print(
            f"[red]crashed:[/red] {result.method} in {result.scene}: {last}"
        )
    return 1 if crashed else 0


def _run(
    trials: list[Trial], arguments: argparse.Namespace, console: Console
) -> list[TrialResult]:
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    succeeded = finished = 0
    with Progress(*columns, console=console, transient=True) as progress:
        task = progress.add_task("running", total=None)

        def show(result: TrialResult):
            nonlocal succeeded, finished
            finished += 1
            succeeded += result.outcome("text") == SUCCESS
            description = f"{succeeded}/{finished} reached"
            progress.update(task, advance=1, description=description)

        def start(count: int):
            progress.update(task, total=count)

        return run_trials(
            trials,
            arguments.output / RESULTS,
            arguments.jobs,
            ray_address=arguments.ray,
            on_start=start,
            on_result=show,
        )
