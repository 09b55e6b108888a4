"""Draws pictures of the benchmark's scenes."""

import argparse
import sys
from collections.abc import Sequence
from itertools import groupby

from rich.console import Console
from rich.progress import Progress

from apps.studies.command_line import check_least, output_file, study_main
from apps.studies.scenes.contact_sheet import Section, contact_sheet
from apps.studies.scenes.picture import SceneView, robot_solids
from remosplat_drake.base.atomic_file import atomic_write
from remosplat_drake.base.errors import FieldError
from remosplat_drake.benchmark.scene_case import SceneCase
from remosplat_drake.benchmark.suites import load_suite
from remosplat_drake.robot.robot_model import load_robot


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the study's flags."""
    parser.add_argument(
        "--suite",
        default="generated",
        metavar="generated[:FAMILY,...]|published:DIR",
        help="our own scenes (default), or the published ones in DIR",
    )
    parser.add_argument(
        "--scenes",
        type=int,
        default=8,
        metavar="N",
        help="number of scenes of each family (8)",
    )
    parser.add_argument(
        "--columns", type=int, default=4, help="number of pictures in a row (4)"
    )
    parser.add_argument(
        "--width",
        type=int,
        default=400,
        help="width of a picture [pixels] (400)",
    )
    parser.add_argument(
        "--output",
        type=output_file,
        default="scenes.png",
        metavar="FILE.png",
        help="file of the contact sheet (scenes.png)",
    )


def run(arguments: argparse.Namespace) -> int:
    """Draws the contact sheet and writes it."""
    _check(arguments)
    console = Console(stderr=True)
    with console.status("choosing scenes"):
        cases = load_suite(arguments.suite, arguments.scenes)
    robot = robot_solids(load_robot("frankie"))
    view = SceneView(robot, arguments.width, arguments.width * 3 // 4)
    with Progress(console=console, transient=True) as progress:
        task = progress.add_task("drawing", total=len(cases))
        sections = []
        for family, members in groupby(cases, lambda case: case.family):
            members = list(members)
            pictures = []
            for case in members:
                pictures.append(view.draw(case.truth()))
                progress.advance(task)
            sections.append(_section(family, members, pictures))
    sheet = contact_sheet(sections, arguments.columns)
    with atomic_write(arguments.output, "wb") as file:
        sheet.save(file, "PNG")
    console.print(f"{len(cases)} scenes in {arguments.output}")
    return 0


def _section(family: str, cases: list[SceneCase], pictures: list) -> Section:
    names = [case.name for case in cases]
    return Section(family, cases[0].suite, names, pictures)


def _check(arguments: argparse.Namespace) -> None:
    check_least("scenes", arguments, scenes=1, columns=1, width=80)
    if arguments.output.suffix.lower() != ".png":
        raise FieldError("scenes", "--output", "must end in .png")


def main(argv: Sequence[str] | None = None) -> int:
    """Runs the study from its command line and returns its exit code."""
    return study_main("scenes", __doc__, add_arguments, run, argv)


if __name__ == "__main__":
    sys.exit(main())
