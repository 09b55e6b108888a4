"""Tests that robots get out of starts with too small distances.

Each robot starts in a random posture that violates a stopping distance by up to
30 mm: between links, from the scene, from unseen space, from a mover at rest,
or from a joint limit. If it does not get out within 10 s, a search that is
independent of the controller checks whether a way out exists.
"""

import argparse
import sys
from collections.abc import Sequence

from rich.console import Console

from apps.studies.command_line import (
    add_trial_flags,
    check_least,
    study_main,
)
from apps.studies.kept_trials import run_missing
from apps.studies.ways_out import on_the_wire
from apps.studies.ways_out.report import summary, table, wire_table
from apps.studies.ways_out.start import (
    KINDS,
    SCENARIOS,
    UNSEEN,
    Start,
    has_unseen_space,
)
from apps.studies.ways_out.trial import failed, restored, run_trial
from remosplat_drake.base.errors import FieldError, unknown_name
from remosplat_drake.base.pool import Job


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the study's flags."""
    parser.add_argument(
        "--robots",
        nargs="+",
        default=list(SCENARIOS),
        metavar="NAME",
        help=f"some of {', '.join(SCENARIOS)} (all)",
    )
    parser.add_argument(
        "--kinds",
        nargs="+",
        default=list(KINDS),
        metavar="KIND",
        help=f"kinds of violated distances, some of {', '.join(KINDS)} (all)",
    )
    parser.add_argument(
        "--wire",
        action="store_true",
        help="drive a stand-in robot that starts too near to its surroundings",
    )
    add_trial_flags(parser, "ways_out", 1000, "starts of each robot and kind")


def run(arguments: argparse.Namespace) -> int:
    """Runs missing trials and prints the results."""
    check_least("ways_out", arguments, count=1, first=0, jobs=0)
    for what, valid in (("robot", SCENARIOS), ("kind", KINDS)):
        for name in getattr(arguments, f"{what}s"):
            if name not in valid:
                problem = unknown_name(what, name, valid)
                raise FieldError("ways_out", f"--{what}s", problem)
    if arguments.wire:
        return _run_on_the_wire(arguments)
    groups = [
        (robot, kind)
        for kind in arguments.kinds
        for robot in arguments.robots
        if kind != UNSEEN or has_unseen_space(robot)
    ]
    seeds = range(arguments.first, arguments.first + arguments.count)
    starts = [Start(robot, s, kind) for s in seeds for robot, kind in groups]
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


def _run_on_the_wire(arguments: argparse.Namespace) -> int:
    """Drives the stand-in out of starts, one after the other."""
    chosen = on_the_wire.starts(
        arguments.robots, arguments.first, arguments.count
    )
    results = run_missing(
        [Job(start, on_the_wire.drive, on_the_wire.failed) for start in chosen],
        arguments.output / "wire.jsonl",
        on_the_wire.restored,
        min(arguments.jobs, 1),
        "driving",
    )
    console = Console()
    console.print(wire_table(results))
    for r in results:
        if r.error or r.out_after is None:
            said = r.error.splitlines()[-1] if r.error else "not out"
            console.print(f"{r.key}: {said}", highlight=False, soft_wrap=True)
    return 0


def main(argv: Sequence[str] | None = None) -> int:
    """Runs the study from its command line and returns its exit code."""
    return study_main("ways_out", __doc__, add_arguments, run, argv)


if __name__ == "__main__":
    sys.exit(main())
