"""Compares link distances of imported robots' convex shapes with meshes.

    python -m apps.studies.true_shapes fetch=robots/fetch/fetch.urdf

Robots are placed at home, in the states that their files name, and at random.
FCL measures the distance of the meshes of two links. If it is less than 50 mm,
it is compared with the distance of their convex shapes. Links that intersect or
contain each other are left out.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from apps.studies.command_line import output_file, study_main
from apps.studies.true_shapes.errors import measure
from apps.studies.true_shapes.maker_meshes import MakerMeshes
from remosplat_drake.base.atomic_file import write_atomically
from remosplat_drake.base.errors import FieldError
from remosplat_drake.base.table import Table
from remosplat_drake.commands.tables import open_console, print_table
from remosplat_drake.robot.robot_model import load_robot

POSTURES = 300
"""Number of random postures."""

LEFT_OUT = {"fetch": ("bellows_link",)}
"""Links of makers' files that shipped robots lack."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the study's flags."""
    parser.add_argument(
        "robots",
        nargs="+",
        metavar="ROBOT=FILE",
        help="a shipped or imported robot, and its makers' file",
    )
    parser.add_argument(
        "--postures",
        type=int,
        default=POSTURES,
        help=f"number of random postures ({POSTURES})",
    )
    parser.add_argument(
        "--output", type=output_file, help="Markdown file for the table"
    )


def run(args: argparse.Namespace) -> int:
    """Measures all robots, and prints a table."""
    if not 0 <= args.postures <= 1_000_000:
        problem = f"expected 0 to 1000000, got {args.postures}"
        raise FieldError("true_shapes", "--postures", problem)
    rows = []
    for text in args.robots:
        name, equals, source = text.partition("=")
        if not (name and equals and source):
            raise FieldError("true_shapes", text, "expected ROBOT=FILE")
        robot = load_robot(name)
        meshes = MakerMeshes(
            Path(source).expanduser(),
            robot.tree.names,
            LEFT_OUT.get(name, ()),
        )
        rows.append(measure(robot, meshes, args.postures).row)
    table = Table(
        "",
        (
            "robot",
            "shapes",
            "named postures",
            "worst in these [mm]",
            "near pairs in all",
            "least [mm]",
            "99 % [mm]",
            "worst [mm]",
            "links of the worst pair",
        ),
        tuple(rows),
    )
    print_table(open_console(), table)
    if args.output:
        write_atomically(args.output, table.to_markdown())
    return 0


def main(argv: Sequence[str] | None = None) -> int:
    """Runs the study from its command line; returns the exit code."""
    return study_main("true_shapes", __doc__, add_arguments, run, argv)


if __name__ == "__main__":
    sys.exit(main())
