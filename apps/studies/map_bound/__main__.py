"""Does the bound on a map's error hold, where captures are not exact?

Scenes are rendered, their captures disturbed (poses, drift, scale, sensor),
reconstructed without the truth, and judged by it. The constants of
`reconstruction/uncertainty/bound.py` were chosen on the families and seeds of
`--split calibration`, and are reported on those of `--split evaluation`.
"""

import argparse
import dataclasses as dc
import json
import sys
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path

from rich.console import Console

from apps.studies.command_line import study_main
from apps.studies.kept_trials import run_missing
from apps.studies.map_bound import closed_loop
from apps.studies.map_bound.case import Case, draw_case
from apps.studies.map_bound.closed_loop import Aim
from apps.studies.map_bound.disturbance import NAMED
from apps.studies.map_bound.report import summary, table
from apps.studies.map_bound.trial import failed, restored, run_trial
from remosplat_drake.base.errors import FieldError
from remosplat_drake.benchmark.line_file import LineFile
from remosplat_drake.benchmark.pool import Job, run_jobs

SPLITS = {
    "calibration": (("table", "bookshelf2"), 1000),
    "evaluation": (("bookshelf", "table2", "posts"), 5000),
}
"""Families of scenes, and the first seed, by the name of the split."""

VIEWS = 40
"""Number of views of the named disturbances."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the study's flags."""
    parser.add_argument(
        "--split",
        choices=[*SPLITS, "named"],
        default="named",
        help="which cases: those that constants are chosen on, those that are"
        " reported, or the four of the table in docs/results/maps.md (named)",
    )
    parser.add_argument(
        "--count", type=int, default=8, help="how many cases (8)"
    )
    parser.add_argument(
        "--first", type=int, default=0, help="number of the first case (0)"
    )
    parser.add_argument(
        "--jobs", type=int, default=2, metavar="N", help="at a time (2)"
    )
    parser.add_argument(
        "--attacks",
        type=int,
        default=0,
        metavar="N",
        help="drive a robot to the N worst places of each map, in place of"
        " measuring its errors (0)",
    )
    parser.add_argument(
        "--output",
        type=Path,
        default=Path("results/map_bound"),
        metavar="DIR",
        help="where results go; what is there is not done again",
    )


def cases(split: str, first: int, count: int) -> list[Case]:
    """Returns cases of a split, in order.

    Args:
        split: Name of the split, or `named`.
        first: Number of the first case.
        count: How many.
    """
    if split == "named":
        drawn = [
            Case(family, 1, VIEWS, what)
            for what in NAMED.values()
            for family in ("table", "bookshelf")
        ]
        return drawn[first : first + count]
    families, start = SPLITS[split]
    numbers = range(first, first + count)
    return [draw_case(families[i % len(families)], start + i) for i in numbers]


def run(arguments: argparse.Namespace) -> int:
    """Runs missing trials and prints what they show."""
    for name, least in (
        ("count", 1),
        ("first", 0),
        ("jobs", 0),
        ("attacks", 0),
    ):
        if getattr(arguments, name) < least:
            raise FieldError(
                "map_bound", f"--{name}", f"must be at least {least}"
            )
    wanted = cases(arguments.split, arguments.first, arguments.count)
    if arguments.attacks:
        return _attack(wanted, arguments)
    results = run_missing(
        [Job(case, run_trial, failed) for case in wanted],
        arguments.output / f"{arguments.split}.jsonl",
        restored,
        arguments.jobs,
    )
    console = Console()
    console.print(table(results))
    for line in summary(results):
        console.print(line, highlight=False, soft_wrap=True)
    return 0


def _attack(wanted: list[Case], arguments: argparse.Namespace) -> int:
    """Drives a robot to the worst places of the cases' maps."""
    aims = [Aim(case, arguments.attacks) for case in wanted]
    running = run_jobs(
        (Job(aim, closed_loop.attack, closed_loop.failed) for aim in aims),
        arguments.jobs,
    )
    path = arguments.output / f"{arguments.split}-attacks.jsonl"
    console, attacks = Console(), []
    with LineFile(path) as file, closing(running):
        for results in running:
            for result in results:
                file.append(json.dumps(dc.asdict(result)))
                if result.error:
                    console.print(result.key, result.error.splitlines()[-1])
            attacks += results
    for line in closed_loop.summary(attacks):
        console.print(line, highlight=False, soft_wrap=True)
    return 0


def main(argv: Sequence[str] | None = None) -> int:
    """Runs the study from its command line and returns its exit code."""
    return study_main("map_bound", __doc__, add_arguments, run, argv)


if __name__ == "__main__":
    sys.exit(main())
