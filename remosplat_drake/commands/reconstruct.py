"""`remosplat reconstruct`: a splat from an RGB-D capture."""

import argparse
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from remosplat_drake.base.atomic_file import check_writable, write_atomically
from remosplat_drake.base.errors import FieldError, RemoSplatError
from remosplat_drake.base.resources import resolve
from remosplat_drake.capture.capture import Capture, check_reconstructible
from remosplat_drake.commands.alignment import (
    add_alignment_arguments,
    aligned,
    check_alignment,
)
from remosplat_drake.commands.flags import (
    TRUTH,
    add_capture_arguments,
    captured,
    check_finite,
    check_positive,
    check_seed,
)
from remosplat_drake.commands.quality import print_report
from remosplat_drake.commands.suggested_scenario import (
    scenario_path,
    write_scenario,
)
from remosplat_drake.reconstruction.alignment.cameras_file import (
    cameras_path,
    write_cameras,
)
from remosplat_drake.reconstruction.alignment.summary import AlignmentSummary
from remosplat_drake.reconstruction.devices import AUTO, DEVICES, choose_device
from remosplat_drake.reconstruction.floor import Floor, find_floor
from remosplat_drake.reconstruction.pipeline import Reconstruction, reconstruct
from remosplat_drake.reconstruction.report.assessment import assess
from remosplat_drake.reconstruction.report.quality_report import (
    QualityReport,
    page_path,
    pose_path,
    report_path,
)
from remosplat_drake.reconstruction.report.report_page import write_assessment
from remosplat_drake.reconstruction.seen_file import (
    seen_path,
    write_seen_space,
)
from remosplat_drake.reconstruction.seen_space import (
    find_seen_space,
    seen_box,
)
from remosplat_drake.reconstruction.surfels.point_cloud import (
    InitialisationConfig,
)
from remosplat_drake.reconstruction.workspace import Workspace
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.scene.rmmi import read_scene
from remosplat_drake.splat.formats import format_of_name, write_splat

_LEAST_COUNT = 100
"""Smallest number of splats that make a scene."""


def add_arguments(parser: argparse.ArgumentParser):
    """Declares the command's flags."""
    add_capture_arguments(parser)
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        required=True,
        metavar="SPLAT.ply",
        help="the splat; its report, seen space and a scenario go beside it",
    )
    parser.add_argument(
        "--device",
        choices=DEVICES,
        default=AUTO,
        help="cuda trains, cpu refines, none lays discs and stops (auto)",
    )
    parser.add_argument(
        "--floor",
        action="store_true",
        help="find the floor and put it at z = 0, z up",
    )
    parser.add_argument(
        "--held-out",
        type=int,
        default=8,
        metavar="N",
        help="every N-th view only judges (8)",
    )
    parser.add_argument(
        "--truth",
        metavar="SCENE",
        help="the true geometry, an RMMI JSON file (default: the capture's"
        f" {TRUTH}, if it has one)",
    )
    parser.add_argument(
        "--count", type=int, default=60_000, help="splats at most (60000)"
    )
    parser.add_argument(
        "--focus",
        type=float,
        nargs=3,
        metavar=("X", "Y", "Z"),
        help="where the splats are finest and the robot works, in the splat's"
        " frame (default: everywhere alike)",
    )
    parser.add_argument(
        "--initialisation",
        choices=("surfels", "voxels"),
        default="surfels",
        help="from depth images (surfels) or from a point cloud (voxels)",
    )
    parser.add_argument(
        "--random-points", type=int, default=0, help="floaters to add (0)"
    )
    parser.add_argument(
        "--steps", type=int, default=500, help="of training, at most (500)"
    )
    parser.add_argument("--seed", type=int, default=0)
    add_alignment_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    """Writes the splat, its report and a scenario of it."""
    _check(arguments)
    device = choose_device(arguments.device)
    console = Console()
    with console.status("reading the capture"):
        capture = captured(arguments)
        check_reconstructible(capture)
    alignment, summary = aligned(capture, arguments, console)
    capture = capture if alignment is None else alignment.capture
    with console.status("looking for the floor"):
        floor = find_floor(capture) if arguments.floor else None
        if floor is not None:
            capture = floor.aligned(capture)
    workspace = _workspace(capture, arguments)
    if floor is not None:
        console.print(
            f"floor: {floor.area:.1f} m², flat to {1e3 * floor.rms:.1f} mm,"
            f" cameras {floor.camera_height:.2f} m above"
        )
    held_out = np.arange(len(capture)) % arguments.held_out == 0
    result = _reconstruct(capture, device, held_out, arguments, console)
    write_splat(arguments.output, result.splat)
    console.print(
        f"{len(result.splat)} splats in {result.seconds:.0f} s:"
        f" {arguments.output}"
    )
    _write_pose(floor, arguments.output)
    write_cameras(arguments.output, alignment)
    with console.status("finding what was seen"):
        box = seen_box(capture, workspace)
        coverage = find_seen_space(capture, result.splat, *box)
        write_seen_space(arguments.output, coverage)
    report = _report(
        result, capture, held_out, workspace, summary, arguments, console
    )
    try:
        text = write_scenario(
            arguments.output,
            result.splat,
            capture,
            workspace,
            report.map_error,
        )
    except RemoSplatError as error:
        console.print(f"no scenario: {error}")
        return 0
    path = scenario_path(arguments.output)
    console.print(f"\n{text}\n  remosplat run {path}", highlight=False)
    return 0


def _check(arguments: argparse.Namespace):
    numbers = ("count", "steps", "stride", "held_out", "max_depth", "max_size")
    check_positive("reconstruct", arguments, *numbers)
    check_finite("reconstruct", arguments, "focus")
    check_seed("reconstruct", arguments)
    check_alignment(arguments)
    if arguments.count < _LEAST_COUNT:
        problem = f"must be at least {_LEAST_COUNT}"
        raise FieldError("reconstruct", "--count", problem)
    if arguments.held_out == 1:
        raise FieldError("reconstruct", "--held-out", "leaves no view to use")
    if arguments.floor and arguments.truth:
        raise FieldError(
            "reconstruct",
            "--truth",
            "is in the capture's frame, which --floor changes; use one of them",
        )
    splat: Path = arguments.output
    format_of_name(splat)
    for path in (
        splat,
        report_path(splat),
        page_path(splat),
        pose_path(splat),
        cameras_path(splat),
        seen_path(splat),
        scenario_path(splat),
    ):
        check_writable(path)


def _reconstruct(
    capture: Capture,
    device: str,
    held_out: np.ndarray,
    arguments: argparse.Namespace,
    console: Console,
) -> Reconstruction:
    """Runs the pipeline under a progress bar; Ctrl-C keeps the training."""
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.percentage:3.0f} %"),
        TimeElapsedColumn(),
    )
    focus = arguments.focus
    with Progress(
        *columns,
        console=console,
        transient=True,
        disable=not console.is_terminal,
    ) as progress:
        task = progress.add_task("starting")

        def show(stage: str, done: int, total: int):
            progress.update(
                task, description=stage, completed=done, total=total
            )

        return reconstruct(
            capture,
            device,
            initialisation=InitialisationConfig(
                method=arguments.initialisation,
                count=arguments.count,
                focus=None if focus is None else np.array(focus),
                random_points=arguments.random_points,
                seed=arguments.seed,
            ),
            steps=arguments.steps,
            seed=arguments.seed,
            held_out=held_out,
            checkpoint=arguments.output.with_suffix(".training.pt"),
            report=show,
        )


def _truth(arguments: argparse.Namespace) -> PrimitiveScene | None:
    if arguments.truth:
        return read_scene(resolve(arguments.truth))
    path = resolve(arguments.capture) / TRUTH
    return None if arguments.floor or not path.is_file() else read_scene(path)


def _workspace(capture: Capture, arguments: argparse.Namespace) -> Workspace:
    if arguments.focus is None:
        return Workspace.of_capture(capture)
    workspace = Workspace.around(np.array(arguments.focus))
    if not workspace.is_seen(capture):
        raise FieldError(
            "reconstruct", "--focus", "is far from all that was captured"
        )
    return workspace


def _write_pose(floor: Floor | None, splat: Path):
    """Keeps the pose of the capture's world where `quality` looks for it."""
    if floor is None:
        pose_path(splat).unlink(missing_ok=True)
        return
    rows = floor.X_FW.GetAsMatrix4().tolist()
    text = "\n".join(
        " ".join(f"{round(x, 12):.12g}" for x in row) for row in rows
    )
    write_atomically(pose_path(splat), text + "\n")


def _report(
    result: Reconstruction,
    capture: Capture,
    held_out: np.ndarray,
    workspace: Workspace,
    alignment: AlignmentSummary | None,
    arguments: argparse.Namespace,
    console: Console,
) -> QualityReport:
    with console.status("measuring its quality") as status:
        assessment = assess(
            result.splat,
            capture,
            np.flatnonzero(held_out).tolist(),
            truth=_truth(arguments),
            workspace=workspace,
            method=result.method,
            seed=arguments.seed,
            progress=status.update,
        )
    assessment.report.alignment = alignment
    page = write_assessment(arguments.output, assessment)
    print_report(console, assessment.report)
    console.print(f"pictures: {page}")
    return assessment.report
