"""`remosplat quality`: measures the error of a splat."""

import argparse
import dataclasses as dc
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.text import Text

from remosplat_drake.app.map_grade import GRADE_STYLES, grade_map
from remosplat_drake.app.map_knowledge import MapError
from remosplat_drake.base.atomic_file import check_writable
from remosplat_drake.base.progress import Progress
from remosplat_drake.base.resources import resolve
from remosplat_drake.base.table import Table
from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.readers.text_files import read_matrix
from remosplat_drake.commands.capture_admission import (
    add_inspection_arguments,
    admitted,
    after_alignment,
    check_inspection_arguments,
)
from remosplat_drake.commands.capture_flags import (
    add_capture_arguments,
    captured,
    check_capture_arguments,
)
from remosplat_drake.commands.flags import (
    check_finite,
    check_positive,
    check_seed,
)
from remosplat_drake.commands.json_output import add_json_argument, print_json
from remosplat_drake.commands.tables import open_console, print_table
from remosplat_drake.reconstruction.alignment.cameras_file import (
    undone_errors,
    with_cameras,
)
from remosplat_drake.reconstruction.report.assessment import assess
from remosplat_drake.reconstruction.report.quality_report import (
    QualityReport,
    page_path,
    pose_path,
    report_path,
)
from remosplat_drake.reconstruction.report.report_page import write_assessment
from remosplat_drake.reconstruction.workspace import Workspace
from remosplat_drake.scene.rmmi import read_scene
from remosplat_drake.splat.formats import read_splat

COMPARED = 8
"""Default of `--held-out`: every eighth view is compared with the splat."""

EXAMPLES = """
remosplat quality kitchen.ply my_capture
remosplat quality kitchen.ply my_capture --json
"""
"""Examples at the end of `--help`."""


def add_arguments(parser: argparse.ArgumentParser):
    """Declares the command's flags."""
    parser.add_argument("splat", metavar="SPLAT", help="a splat file")
    add_capture_arguments(parser)
    parser.add_argument(
        "--capture-pose",
        metavar="FILE",
        help=(
            "text file with a 4 x 4 matrix, the pose of the capture's world "
            "in the splat's frame (default: SPLAT.pose.txt beside the "
            "splat, which `reconstruct --floor` writes, or else the "
            "identity)"
        ),
    )
    parser.add_argument(
        "--truth", metavar="SCENE", help="the true geometry, an RMMI JSON file"
    )
    parser.add_argument(
        "--held-out",
        type=int,
        metavar="N",
        help=(
            "compare the splat with the image of every N-th view. Give the N "
            "of `reconstruct --held-out`, so that training has not used these "
            f"views (default: every {COMPARED}th view, whether training used "
            "it or not)"
        ),
    )
    parser.add_argument(
        "--focus",
        type=float,
        nargs=3,
        metavar=("X", "Y", "Z"),
        help="centre of the robot's workspace [m] (default: the middle of"
        " the captured points)",
    )
    parser.add_argument(
        "--reach",
        type=float,
        default=1.0,
        help="half of the workspace's edge length, around --focus [m] (1)",
    )
    parser.add_argument(
        "--method",
        default="unknown",
        help=("text for the report: a description of how the splat was made"),
    )
    parser.add_argument(
        "--points",
        type=int,
        default=5000,
        help="largest number of points at which distances are compared (5000)",
    )
    parser.add_argument(
        "--output",
        type=Path,
        metavar="DIR",
        help="folder of the report (default: the splat's)",
    )
    parser.add_argument("--seed", type=int, default=0)
    add_inspection_arguments(parser)
    add_json_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Measures the errors; writes and prints the report."""
    check_capture_arguments("quality", arguments)
    check_positive("quality", arguments, "held_out", "reach", "points")
    check_finite("quality", arguments, "focus")
    check_seed("quality", arguments)
    check_inspection_arguments(arguments)
    console = open_console(stderr=arguments.json)
    splat_path = resolve(arguments.splat)
    folder = arguments.output or splat_path.parent
    for path in (report_path(splat_path), page_path(splat_path)):
        check_writable(folder / path.name)
    splat = read_splat(splat_path)
    truth = read_scene(resolve(arguments.truth)) if arguments.truth else None
    workspace = None
    if arguments.focus is not None:
        workspace = Workspace.around(np.array(arguments.focus), arguments.reach)
    with Progress(console, "reading the capture") as progress:
        capture = captured(arguments, console, progress.report)
        progress.report("inspecting the capture")
        capture, warnings = admitted(capture, arguments, console)
        refined = with_cameras(capture, splat_path)
        if refined is not capture:
            undone = undone_errors(splat_path).sum(axis=0)
            warnings = after_alignment(warnings, refined, undone)
        capture = _placed(refined, arguments, splat_path)
        assessment = assess(
            splat,
            capture,
            range(0, len(capture), arguments.held_out or COMPARED),
            truth=truth,
            workspace=workspace,
            method=arguments.method,
            held_out=arguments.held_out is not None,
            count=arguments.points,
            seed=arguments.seed,
            warnings=warnings,
            progress=progress.report,
        )
    page = write_assessment(splat_path, assessment, folder)
    if arguments.json:
        print_json(
            {
                "grade": grade(assessment.report),
                **dc.asdict(assessment.report),
                "page": page,
            }
        )
        return 0
    print_report(console, assessment.report)
    console.print(f"pictures: {page}")
    return 0


def grade(report: QualityReport) -> str:
    """Returns the grade of a map, see `grade_map`."""
    warnings = tuple(report.warnings)
    return grade_map(MapError(report.remaining_error, warnings=warnings))


def _placed(
    capture: Capture, arguments: argparse.Namespace, splat: Path
) -> Capture:
    """Returns the capture, with refined camera poses, in the splat's frame."""
    path = pose_path(splat)
    if arguments.capture_pose is not None:
        path = resolve(arguments.capture_pose)
    elif not path.is_file():
        return capture
    return capture.expressed_in(read_matrix(path, (4, 4)))


def print_report(console: Console, report: QualityReport):
    """Prints the numbers of a report, and the grade of the splat."""
    rows = []
    for row in report.distances:
        values = (row.median, row.percentile_99, row.over, row.under)
        lengths = (f"{1e3 * value:.1f}" for value in values)
        rows.append((row.oracle, row.reference, str(row.count), *lengths))
    header = ("oracle", "against", "points", "median", "99 %", "over", "under")
    print_table(
        console, Table("distance errors [mm]", header, tuple(rows), texts=2)
    )
    images = report.images
    console.print(
        f"{images.views} views: PSNR {images.psnr:.1f} dB, SSIM "
        f"{images.ssim:.3f}, depth error {1e3 * images.depth_median:.1f} mm "
        f"(median), {1e3 * images.depth_percentile_99:.1f} mm (99 %)",
        soft_wrap=True,
    )
    verdict = grade(report)
    console.print(Text(verdict, GRADE_STYLES[verdict]), report.trust)
