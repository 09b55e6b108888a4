"""Runs random operators, and evaluates their sessions with the truth."""

import argparse
import sys
from collections.abc import Sequence
from contextlib import closing

from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from apps.studies.command_line import add_output_flag, check_least, study_main
from apps.studies.operators import campaign
from apps.studies.operators.result import (
    OperatorResult,
    read_results,
    to_line,
)
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.teleop_session import check_mappable
from remosplat_drake.base.pool import Job, run_jobs
from remosplat_drake.benchmark.line_file import LineFile
from remosplat_drake.commands.flags import check_seed
from remosplat_drake.commands.number_flags import positive

RESULTS = "operators.jsonl"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the study's flags."""
    parser.add_argument(
        "--count", type=int, default=10, help="number of operators (10)"
    )
    parser.add_argument(
        "--seed", type=int, default=0, help="seed of the first operator (0)"
    )
    parser.add_argument(
        "--jobs",
        type=int,
        default=2,
        metavar="N",
        help="number of parallel operators; 0: one after the other, in this"
        " process (2)",
    )
    parser.add_argument(
        "--minutes",
        type=positive,
        default=5.0,
        metavar="MIN",
        help="simulated time of each operator (%(default)g)",
    )
    add_output_flag(
        parser,
        "operators",
        f"folder of {RESULTS} and the sessions; existing results are not"
        " computed again",
    )


def run(arguments: argparse.Namespace) -> int:
    """Runs missing operators; returns 1 if a forbidden touch occurred."""
    check_least("operators", arguments, count=1, jobs=0)
    check_seed("operators", arguments)
    for name in campaign.SCENARIOS:
        check_mappable(load_scenario(name))
    trials = campaign.make_trials(
        arguments.count, arguments.minutes, arguments.seed, arguments.output
    )
    path = arguments.output / RESULTS
    known = read_results(path)
    missing = [trial for trial in trials if trial.key not in known]
    running = run_jobs(
        (Job(t, campaign.run_operator, campaign.crashed) for t in missing),
        arguments.jobs,
    )
    progress = Progress(console=Console(stderr=True), transient=True)
    with LineFile(path) as file, closing(running), progress:
        task = progress.add_task("operating", total=len(missing))
        for result in running:
            file.append(to_line(result))
            known[result.key] = result
            progress.advance(task)
    results = [known[trial.key] for trial in trials]
    Console().print(table(results))
    return 1 if any(r.collisions or r.error for r in results) else 0


def table(results: list[OperatorResult]) -> Table:
    """Makes a table with one row per operator; distances are the smallest."""
    rows = Table("operator", title="Random operators, judged by the truth")
    for heading in (
        "path [m]",
        "maps",
        "frames",
        "changes",
        "stopped [s]",
        "to the mapped [mm]",
        "to the known [mm]",
        "collisions",
        "with unseen",
    ):
        rows.add_column(heading, justify="right")
    for result in results:
        if result.error:
            rows.add_row(result.key, f"failed: {result.error}")
            continue
        rows.add_row(
            result.key,
            f"{result.path_length:.1f}",
            f"{result.maps}",
            f"{result.frames}",
            f"{result.scene_changes}",
            f"{result.stopped:.0f}",
            f"{1e3 * result.mapped_clearance:.1f}",
            f"{1e3 * result.true_clearance:.1f}",
            f"{result.collisions}",
            f"{len(result.touches) - result.collisions}",
        )
    return rows


def main(argv: Sequence[str] | None = None) -> int:
    """Runs the study from its command line and returns its exit code."""
    return study_main("operators", __doc__, add_arguments, run, argv)


if __name__ == "__main__":
    sys.exit(main())
