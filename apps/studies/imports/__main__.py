"""Imports vendors' robots, each by one command, and checks the results.

Thirty robots are imported as their users would, each by one command in a
process of its own: URDF, xacro, SDFormat and MJCF of arms, grippers, mobile
bases and upper bodies. `--sources` is a folder in which each of the wheels
`example-robot-data`, `rtb-data`, `pybullet` and `robosuite` is unpacked in a
folder of its name (with underscores), beside a folder `fetch` of a Fetch.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console

from apps.studies.command_line import add_output_flag, study_main
from apps.studies.imports.case import (
    Case,
    Robot,
    check_sources,
    known_robots,
)
from apps.studies.imports.trial import Result, failed, restored, run_trial
from apps.studies.kept_trials import run_missing
from remosplat_drake.base.errors import FieldError, unknown_name
from remosplat_drake.base.pool import Job
from remosplat_drake.base.table import Table
from remosplat_drake.commands.tables import print_table

LONGEST = 60.0
"""Processor time that an import may take [s]."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the study's flags."""
    parser.add_argument(
        "--sources",
        type=Path,
        required=True,
        metavar="DIR",
        help="folder with the unpacked wheels",
    )
    parser.add_argument(
        "--robot",
        action="append",
        default=[],
        metavar="NAME",
        help="import only this robot; may be given several times",
    )
    parser.add_argument(
        "--jobs",
        type=int,
        default=2,
        metavar="N",
        help="number of parallel imports (2)",
    )
    add_output_flag(
        parser,
        "imports",
        "folder of the robots and results; existing results are not computed"
        " again",
    )


def run(arguments: argparse.Namespace) -> int:
    """Imports the robots that are missing, and prints a table of all."""
    names = [robot.name for robot in known_robots()]
    for name in arguments.robot:
        if name not in names:
            problem = unknown_name("robot", name, names)
            raise FieldError("imports", "--robot", problem)
    if arguments.jobs < 0:
        raise FieldError("imports", "--jobs", "must be at least 0")
    cases = [
        Case(name, arguments.sources.absolute(), arguments.output.absolute())
        for name in arguments.robot or names
    ]
    check_sources(cases)
    results = run_missing(
        [Job(case, run_trial, failed) for case in cases],
        arguments.output / "imports.jsonl",
        restored,
        arguments.jobs,
        "importing",
    )
    robots = [case.robot for case in cases]
    print_table(Console(), table(robots, results))
    return 0


def is_right(robot: Robot, result: Result) -> bool:
    """Returns whether the result of an import is correct.

    Args:
        robot: The robot, with the correct result.
        result: The result of the import.
    """
    return all(judged(robot, result))


def judged(robot: Robot, result: Result) -> tuple[bool, bool, bool]:
    """Returns whether tools, joints and base of an import are correct, each.

    Args:
        robot: The robot, with the correct result.
        result: The result of the import.
    """
    return (
        sorted(result.tools) == sorted(robot.tools),
        sorted(result.joints) == sorted(robot.joints),
        result.base == robot.base,
    )


def table(robots: Sequence[Robot], results: Sequence[Result]) -> Table:
    """Makes a table of imports and the correct results.

    Args:
        robots: The robots.
        results: Result of each robot.
    """
    rows = []
    for robot, result in zip(robots, results, strict=True):
        suffix = Path(robot.file).suffix.removeprefix(".")
        said = result.problem or result.error.partition("\n")[0]
        if said:
            cells = ("", "", "", "", said)
        else:
            right = ("yes" if ok else "NO" for ok in judged(robot, result))
            cells = (*right, str(result.tried), result.home)
        time = f"{result.seconds:.0f}"
        rows.append(
            (robot.name, robot.source, suffix, *cells[:3], time, *cells[3:])
        )
    pairs = list(zip(robots, results, strict=True))
    good = sum(is_right(*pair) for pair in pairs)
    tried = sum(result.tried > 0 for result in results)
    slow = [result.key for result in results if result.seconds > LONGEST]
    notes = (
        f"{good} of {len(rows)} are right, {tried} reach targets;"
        f" {len(slow)} take more than {LONGEST:g} s of a core"
    )
    header = ("robot", "from", "format", "tool", "joints", "base")
    header += ("time [s]", "targets", "home, or why not")
    return Table("Imports", header, tuple(rows), notes, texts=6)


def main(argv: Sequence[str] | None = None) -> int:
    """Runs the study from its command line and returns its exit code."""
    return study_main("imports", __doc__, add_arguments, run, argv)


if __name__ == "__main__":
    sys.exit(main())
