"""`remosplat reconstruct`: a splat from an RGB-D capture."""

import argparse
from pathlib import Path

import numpy as np
import yaml
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from remosplat_drake.atomic_file import check_writable, write_atomically
from remosplat_drake.capture.capture import Capture, check_reconstructible
from remosplat_drake.capture.formats import FORMATS, read_capture
from remosplat_drake.commands.quality import print_report
from remosplat_drake.errors import FieldError, RemoSplatError
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.reconstruction.assessment import Workspace, assess
from remosplat_drake.reconstruction.floor import find_floor
from remosplat_drake.reconstruction.measured_space import times_looked_through
from remosplat_drake.reconstruction.pipeline import (
    AUTO,
    DEVICES,
    Reconstruction,
    choose_device,
    reconstruct,
)
from remosplat_drake.reconstruction.point_cloud import InitialisationConfig
from remosplat_drake.reconstruction.quality_report import (
    page_path,
    report_path,
    write_report,
)
from remosplat_drake.reconstruction.report_page import to_html
from remosplat_drake.resources import resolve
from remosplat_drake.robot.robot_model import load_robot_model
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.scene.rmmi import read_rmmi
from remosplat_drake.splat.formats import write_splat
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.task.suggestion import suggest_task

_FREE_MARGIN = 0.05
"""Space is free if views saw at least so far beyond it [m]."""

TRUTH = "truth.json"
"""What a rendered capture says of its own geometry."""


def add_arguments(parser: argparse.ArgumentParser):
    """Declares the command's flags."""
    parser.add_argument(
        "capture", metavar="CAPTURE", help="a file or folder with RGB-D images"
    )
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        required=True,
        metavar="SPLAT.ply",
        help="the splat; its report and a scenario go beside it",
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
    _add_capture_arguments(parser)
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


def _add_capture_arguments(parser: argparse.ArgumentParser):
    parser.add_argument(
        "--format", choices=FORMATS, help="of the capture (default: found out)"
    )
    parser.add_argument(
        "--stride", type=int, default=1, help="use every so many frames (1)"
    )
    parser.add_argument(
        "--max-depth", type=float, help="depth beyond is unknown [m]"
    )
    parser.add_argument(
        "--max-size", type=int, help="shrink images to that width [pixels]"
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


def run(arguments: argparse.Namespace) -> int:
    """Writes the splat, its report and a scenario."""
    _check(arguments)
    device = choose_device(arguments.device)
    console = Console()
    with console.status("reading the capture"):
        capture = _read(arguments)
        check_reconstructible(capture)
        if arguments.floor:
            floor = find_floor(capture)
            capture = floor.aligned(capture)
    if arguments.floor:
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
    _report(result, capture, held_out, arguments, console)
    _suggest(result.splat, capture, arguments, console)
    return 0


def _check(arguments: argparse.Namespace):
    for name in ("count", "steps", "stride", "held_out"):
        if getattr(arguments, name) < 1:
            flag = "--" + name.replace("_", "-")
            raise FieldError("reconstruct", flag, "must be positive")
    if arguments.held_out == 1:
        raise FieldError("reconstruct", "--held-out", "leaves no view to use")
    if arguments.floor and arguments.truth:
        raise FieldError(
            "reconstruct",
            "--truth",
            "is in the capture's frame, which --floor changes; use one of them",
        )
    splat: Path = arguments.output
    for path in (splat, report_path(splat), page_path(splat), _scenario(splat)):
        check_writable(path)


def _read(arguments: argparse.Namespace) -> Capture:
    return read_capture(
        resolve(arguments.capture),
        arguments.format,
        stride=arguments.stride,
        max_depth=arguments.max_depth,
        max_size=arguments.max_size,
    )


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
    with Progress(*columns, console=console, transient=True) as progress:
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
        return read_rmmi(resolve(arguments.truth))
    path = resolve(arguments.capture) / TRUTH
    return None if arguments.floor or not path.is_file() else read_rmmi(path)


def _workspace(capture: Capture, arguments: argparse.Namespace) -> Workspace:
    if arguments.focus is None:
        return Workspace.of_capture(capture)
    return Workspace.around(np.array(arguments.focus))


def _report(
    result: Reconstruction,
    capture: Capture,
    held_out: np.ndarray,
    arguments: argparse.Namespace,
    console: Console,
):
    with console.status("measuring its quality") as status:
        assessment = assess(
            result.splat,
            capture,
            np.flatnonzero(held_out).tolist(),
            truth=_truth(arguments),
            workspace=_workspace(capture, arguments),
            method=result.method,
            seed=arguments.seed,
            progress=status.update,
        )
    splat: Path = arguments.output
    write_report(splat, assessment.report)
    write_atomically(page_path(splat), to_html(assessment, splat.name))
    print_report(console, assessment.report)
    console.print(f"pictures: {page_path(splat)}")


def _scenario(splat: Path) -> Path:
    return splat.with_suffix(".yaml")


def _suggest(
    splat_W: GaussianSplat,
    capture: Capture,
    arguments: argparse.Namespace,
    console: Console,
):
    """Writes a scenario that runs in the new scene, if there is room."""
    workspace = _workspace(capture, arguments)
    robot = load_robot_model("frankie", floor_height=0.03)
    try:
        task = suggest_task(
            robot,
            SphereToEllipsoidField(splat_W),
            workspace.lower,
            workspace.upper,
            lambda p_W: times_looked_through(capture, p_W, _FREE_MARGIN) > 1,
        )
    except RemoSplatError as error:
        console.print(f"no scenario: {error}")
        return
    splat: Path = arguments.output
    entry = {
        "scene": {"splat": splat.name},
        "robot": {"base_pose": task.base_pose.round(3).tolist()},
        "targets": [
            {
                "translation": task.X_WT.translation().round(3).tolist(),
                "rpy_deg": [180.0, 0.0, 0.0],
            }
        ],
    }
    name = "".join(word.capitalize() for word in splat.stem.split("_"))
    text = yaml.safe_dump(
        {name: entry}, sort_keys=False, default_flow_style=None
    )
    path = _scenario(splat)
    write_atomically(path, text)
    console.print(f"\n{text}\n  remosplat run {path}", highlight=False)
