"""Are maps of carried cameras as right as they say, where nothing is a box?

Rooms of triangle meshes are captured by rays, along the path of a hand, with
the faults of real sensors and trackers. Their maps, made without the truth, are
judged by it, and so are the verdicts of their quality reports. Choose constants
on `--split develop`; report what `--split frozen` shows.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console

from apps.studies.command_line import study_main
from apps.studies.kept_trials import run_missing
from apps.studies.true_maps import report, rods
from apps.studies.true_maps.case import Case, draw_case
from apps.studies.true_maps.disturbance import NAMED
from apps.studies.true_maps.trial import failed, restored, run_trial
from remosplat_drake.base.errors import FieldError
from remosplat_drake.base.progress import Progress
from remosplat_drake.benchmark.pool import Job

SPLITS = {"develop": 100_000, "frozen": 500_000}
"""First seeds of scenes, paths and disturbances, by the name of the split."""

NAMED_SEEDS = (1, 3)
"""Seeds of the scenes of the named disturbances."""

NAMED_SPLIT = "named"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the study's flags."""
    parser.add_argument(
        "--split",
        choices=[NAMED_SPLIT, *SPLITS],
        default=NAMED_SPLIT,
        help="which cases: one fault at a time (named), those that constants"
        " are chosen on, or those that are reported",
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
        "--rods",
        action="store_true",
        help="measure how far thin rods are missed, in place of rooms",
    )
    parser.add_argument(
        "--output",
        type=Path,
        default=Path("results/true_maps"),
        metavar="DIR",
        help="where results go; what is there is not done again",
    )


def cases(split: str, first: int, count: int) -> list[Case]:
    """Returns cases of a split, in order.

    Args:
        split: Name of the split, or `named`.
        first: Number of the first case.
        count: How many; there are only so many named ones.
    """
    if split == NAMED_SPLIT:
        drawn = [Case(s, what) for s in NAMED_SEEDS for what in NAMED.values()]
        return drawn[first : first + count]
    start = SPLITS[split] + first
    return [draw_case(seed) for seed in range(start, start + count)]


def run(arguments: argparse.Namespace) -> int:
    """Runs missing trials and prints what they show."""
    for name, least in (("count", 1), ("first", 0), ("jobs", 0)):
        if getattr(arguments, name) < least:
            raise FieldError(
                "true_maps", f"--{name}", f"must be at least {least}"
            )
    console = Console()
    if arguments.rods:
        console.print(rods.table(_rods(arguments.first, arguments.count)))
        return 0
    wanted = cases(arguments.split, arguments.first, arguments.count)
    results = run_missing(
        [Job(case, run_trial, failed) for case in wanted],
        arguments.output / f"{arguments.split}.jsonl",
        restored,
        arguments.jobs,
    )
    console.print(report.table(results))
    for line in report.summary(results):
        console.print(line, highlight=False, soft_wrap=True)
    return 0


def _rods(first: int, count: int) -> list[rods.RodResult]:
    """Measures some of the setups with rods."""
    results: list[rods.RodResult] = []
    setups = rods.SETUPS[first : first + count]
    with Progress(Console(stderr=True), "mapping rods") as progress:
        for done, setup in enumerate(setups):
            progress.report("mapping rods", done, len(setups))
            results += rods.measure(setup)
    return results


def main(argv: Sequence[str] | None = None) -> int:
    """Runs the study from its command line and returns its exit code."""
    return study_main("true_maps", __doc__, add_arguments, run, argv)


if __name__ == "__main__":
    sys.exit(main())
