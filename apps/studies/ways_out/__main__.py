"""Do robots get out of starts that are too near, and does anything come nearer?

Each robot starts at random, up to 30 mm inside its distances to itself or to
the scene. Where it does not get out within 10 s, a search that knows nothing of
the controller says whether there is a way.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console

from apps.studies.command_line import study_main
from apps.studies.kept_trials import run_missing
from apps.studies.ways_out.report import summary, table
from apps.studies.ways_out.start import SCENARIOS, Start
from apps.studies.ways_out.trial import failed, restored, run_trial
from remosplat_drake.base.errors import FieldError, unknown_name
from remosplat_drake.benchmark.pool import Job


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the study's flags."""
    parser.add_argument(
        "--robots",
        nargs="+",
        default=list(SCENARIOS),
        metavar="NAME",
        help=f"which of {', '.join(SCENARIOS)} (all)",
    )
    parser.add_argument(
        "--count", type=int, default=1000, help="starts a robot (1000)"
    )
    parser.add_argument(
        "--first", type=int, default=0, help="seed of the first start (0)"
    )
    parser.add_argument(
        "--jobs", type=int, default=2, metavar="N", help="at a time (2)"
    )
    parser.add_argument(
        "--output",
        type=Path,
        default=Path("results/ways_out"),
        metavar="DIR",
        help="where results go; what is there is not done again",
    )


def run(arguments: argparse.Namespace) -> int:
    """Runs missing trials and prints what they show."""
    for name, least in (("count", 1), ("first", 0), ("jobs", 0)):
        if getattr(arguments, name) < least:
            raise FieldError(
                "ways_out", f"--{name}", f"must be at least {least}"
            )
    for name in arguments.robots:
        if name not in SCENARIOS:
            problem = unknown_name("robot", name, SCENARIOS)
            raise FieldError("ways_out", "--robots", problem)
    seeds = range(arguments.first, arguments.first + arguments.count)
    starts = [Start(name, seed) for seed in seeds for name in arguments.robots]
    results = run_missing(
        [Job(start, run_trial, failed) for start in starts],
        arguments.output / "starts.jsonl",
        restored,
        arguments.jobs,
        "starting",
    )
    console = Console()
    console.print(table(results))
    for line in summary(results):
        console.print(line, highlight=False, soft_wrap=True)
    return 0


def main(argv: Sequence[str] | None = None) -> int:
    """Runs the study from its command line and returns its exit code."""
    return study_main("ways_out", __doc__, add_arguments, run, argv)


if __name__ == "__main__":
    sys.exit(main())
