"""`remosplat reconstruct`: makes a splat from an RGB-D capture."""

import argparse
import dataclasses as dc
from pathlib import Path

import numpy as np
from rich.console import Console

from remosplat_drake.base.atomic_file import check_writable
from remosplat_drake.base.errors import FieldError, RemoSplatError
from remosplat_drake.base.kept_stages import KeptStages
from remosplat_drake.base.progress import Progress
from remosplat_drake.commands.alignment import (
    add_alignment_arguments,
    check_alignment,
)
from remosplat_drake.commands.capture_admission import (
    add_inspection_arguments,
    check_inspection_arguments,
)
from remosplat_drake.commands.capture_flags import (
    TRUTH,
    add_capture_arguments,
    check_capture_arguments,
)
from remosplat_drake.commands.flags import (
    check_finite,
    check_positive,
    check_seed,
)
from remosplat_drake.commands.map_placement import (
    add_placement_arguments,
    true_scene,
    write_pose,
)
from remosplat_drake.commands.prepared_capture import (
    PreparedCapture,
    prepare_capture,
)
from remosplat_drake.commands.quality import print_report
from remosplat_drake.commands.suggested_entry import FRANKIE, scenario_path
from remosplat_drake.commands.suggested_scenario import write_scenario
from remosplat_drake.commands.tables import open_console
from remosplat_drake.reconstruction.alignment.cameras_file import (
    cameras_path,
    write_cameras,
)
from remosplat_drake.reconstruction.devices import AUTO, DEVICES, choose_device
from remosplat_drake.reconstruction.pipeline import (
    Reconstruction,
    check_refinable,
    reconstruct,
)
from remosplat_drake.reconstruction.placement import FLOOR
from remosplat_drake.reconstruction.report.assessment import assess
from remosplat_drake.reconstruction.report.quality_report import (
    QualityReport,
    page_path,
    pose_path,
    report_path,
)
from remosplat_drake.reconstruction.report.report_page import write_assessment
from remosplat_drake.reconstruction.report.validation import (
    Validations,
    cross_validate,
)
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
from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.signals.coverage import Coverage
from remosplat_drake.splat.formats import format_of_name, write_splat

_LEAST_COUNT = 100
"""Smallest number of splats that `--count` accepts."""

EXAMPLES = """
remosplat reconstruct my_capture -o kitchen.ply
"""
"""Examples at the end of `--help`."""


def add_arguments(parser: argparse.ArgumentParser):
    """Declares the command's flags."""
    add_capture_arguments(parser)
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        required=True,
        metavar="SPLAT.ply",
        help=(
            "file of the splat; the command writes a report, the seen space "
            "and a scenario beside it"
        ),
    )
    parser.add_argument(
        "--device",
        choices=DEVICES,
        default=AUTO,
        help=(
            "cuda: train the splats on a GPU; cpu: refine them on the CPU; "
            "none: only place discs on the measured surfaces; auto: cuda if "
            "available, else cpu (auto)"
        ),
    )
    add_placement_arguments(parser)
    parser.add_argument(
        "--robot",
        default=FRANKIE,
        metavar="MODEL",
        help=f"name or file of the robot of the generated scenario ({FRANKIE})",
    )
    parser.add_argument(
        "--held-out",
        type=int,
        default=8,
        metavar="N",
        help="use every N-th view only for evaluation, not for training (8)",
    )
    parser.add_argument(
        "--truth",
        metavar="SCENE",
        help="the true geometry, an RMMI JSON file (default: the capture's"
        f" {TRUTH}, if it has one)",
    )
    parser.add_argument(
        "--count",
        type=int,
        default=60_000,
        help="largest number of initial splats (60000)",
    )
    parser.add_argument(
        "--focus",
        type=float,
        nargs=3,
        metavar=("X", "Y", "Z"),
        help="centre of the robot's workspace, around which splats are finest,"
        " in the splat's frame (default: equally fine everywhere)",
    )
    parser.add_argument(
        "--initialisation",
        choices=("surfels", "voxels"),
        default="surfels",
        help="source of the initial splats: depth images (surfels) or a point"
        " cloud (voxels)",
    )
    parser.add_argument(
        "--random-points",
        type=int,
        default=0,
        help="number of floaters (isolated false splats) to add, for tests (0)",
    )
    parser.add_argument(
        "--steps",
        type=int,
        default=500,
        help="largest number of training steps (500)",
    )
    parser.add_argument(
        "--refine-cameras",
        action="store_true",
        help="also train the cameras' poses, focal lengths, principal point"
        " and depth curve; needs a CUDA device",
    )
    parser.add_argument("--seed", type=int, default=0)
    add_alignment_arguments(parser)
    add_inspection_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    """Makes the splat; writes it with its report and a scenario."""
    _check(arguments)
    device = choose_device(arguments.device)
    check_refinable(device, arguments.refine_cameras)
    console = open_console()
    with KeptStages(stages_path(arguments.output), console.print) as stages:
        _run(arguments, device, console, stages)
    return 0


def stages_path(splat: Path) -> Path:
    """Returns the folder with the finished stages of an interrupted job."""
    return splat.with_suffix(".unfinished")


def _run(
    arguments: argparse.Namespace,
    device: str,
    console: Console,
    stages: KeptStages,
):
    prepared = prepare_capture(arguments, console, stages)
    held_out = np.arange(len(prepared.capture)) % arguments.held_out == 0
    result = _reconstruct(
        prepared, device, held_out, arguments, console, stages
    )
    capture = result.capture
    prepared = dc.replace(prepared, capture=capture)
    write_splat(arguments.output, result.splat)
    console.print(
        f"{len(result.splat)} splats in {result.seconds:.0f} s:"
        f" {arguments.output}"
    )
    write_pose(prepared.placement, arguments.output)
    _write_cameras(result, prepared, arguments)
    with Progress(console, "finding what was seen"):
        box = seen_box(capture, prepared.workspace)
        coverage = stages.kept(
            "seen space",
            Coverage,
            [capture, result.splat, box],
            lambda: find_seen_space(capture, result.splat, *box),
        )
        write_seen_space(arguments.output, coverage)
    report = _report(result, prepared, held_out, arguments, console, stages)
    _suggest(result, prepared, report, arguments, console)


def _write_cameras(
    result: Reconstruction,
    prepared: PreparedCapture,
    arguments: argparse.Namespace,
):
    """Writes the refined camera poses, in the frame of the capture's files."""
    undone = []
    if prepared.alignment is not None and prepared.alignment.accepted:
        undone.append(prepared.alignment.undone)
    if arguments.refine_cameras:
        undone.append(result.undone)
    if not undone:
        write_cameras(arguments.output, None)
        return
    X_WF = prepared.placement.X_FW.inverse().GetAsMatrix4()
    refined_W = result.capture.expressed_in(X_WF)
    write_cameras(arguments.output, refined_W, undone)


def _suggest(
    result: Reconstruction,
    prepared: PreparedCapture,
    report: QualityReport,
    arguments: argparse.Namespace,
    console: Console,
):
    """Writes a scenario for the splat, or prints why there is none."""
    path = scenario_path(arguments.output)
    if not prepared.placement.has_floor:
        path.unlink(missing_ok=True)
        console.print(
            f"no scenario: {prepared.placement.words} (if z is up and z = 0 "
            "is the floor, add --up capture)",
            soft_wrap=True,
        )
        return
    try:
        text = write_scenario(
            arguments.output,
            result.splat,
            prepared.capture,
            prepared.workspace,
            report.remaining_error,
            report.warnings,
            arguments.robot,
        )
    except RemoSplatError as error:
        console.print(f"no scenario: {error}")
        return
    console.print(f"\n{text}\n  remosplat run {path}", highlight=False)


def _check(arguments: argparse.Namespace):
    check_capture_arguments("reconstruct", arguments)
    check_positive("reconstruct", arguments, "count", "steps", "held_out")
    check_finite("reconstruct", arguments, "focus")
    check_seed("reconstruct", arguments)
    check_alignment(arguments)
    check_inspection_arguments(arguments)
    if arguments.count < _LEAST_COUNT:
        problem = f"must be at least {_LEAST_COUNT}"
        raise FieldError("reconstruct", "--count", problem)
    if arguments.held_out == 1:
        raise FieldError(
            "reconstruct",
            "--held-out",
            "leaves no view to train with; use a larger number",
        )
    if arguments.up == FLOOR and arguments.truth:
        raise FieldError(
            "reconstruct",
            "--truth",
            "is in the capture's frame, but --floor changes the frame; leave "
            "one of the two flags out",
        )
    load_robot(arguments.robot)
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
        stages_path(splat) / "any",
    ):
        check_writable(path)


def _initialisation(arguments: argparse.Namespace) -> InitialisationConfig:
    focus = arguments.focus
    return InitialisationConfig(
        method=arguments.initialisation,
        count=arguments.count,
        focus=None if focus is None else np.array(focus),
        random_points=arguments.random_points,
        seed=arguments.seed,
    )


def _reconstruct(
    prepared: PreparedCapture,
    device: str,
    held_out: np.ndarray,
    arguments: argparse.Namespace,
    console: Console,
    stages: KeptStages,
) -> Reconstruction:
    """Runs the pipeline with a progress bar; Ctrl-C saves the training."""
    initialisation = _initialisation(arguments)
    steps, seed = arguments.steps, arguments.seed
    with Progress(console, "starting") as progress:
        return stages.kept(
            "splat",
            Reconstruction,
            [
                *(prepared.capture, prepared.errors, held_out),
                *(device, initialisation, steps, seed),
                arguments.refine_cameras,
            ],
            lambda: reconstruct(
                prepared.capture,
                device,
                initialisation=initialisation,
                steps=steps,
                seed=seed,
                refine_cameras=arguments.refine_cameras,
                held_out=held_out,
                bounded=True,
                errors=prepared.errors,
                checkpoint=arguments.output.with_suffix(".training.pt"),
                report=progress.report,
            ),
        )


def _report(
    result: Reconstruction,
    prepared: PreparedCapture,
    held_out: np.ndarray,
    arguments: argparse.Namespace,
    console: Console,
    stages: KeptStages,
) -> QualityReport:
    moved = prepared.placement.moves
    with Progress(console, "cross-validating") as progress:
        validations = stages.kept(
            "cross-validation",
            Validations,
            [prepared.capture, prepared.errors, _initialisation(arguments)],
            lambda: cross_validate(
                prepared.capture,
                prepared.workspace,
                prepared.errors,
                _initialisation(arguments),
                progress.report,
            ),
        )
    with Progress(console, "measuring its quality") as progress:
        assessment = assess(
            result.splat,
            prepared.capture,
            np.flatnonzero(held_out).tolist(),
            truth=None if moved else true_scene(arguments),
            workspace=prepared.workspace,
            method=result.method,
            seed=arguments.seed,
            warnings=prepared.warnings,
            validations=validations.of_oracles,
            progress=progress.report,
        )
    assessment.report.alignment = prepared.summary
    page = write_assessment(arguments.output, assessment)
    print_report(console, assessment.report)
    console.print(f"pictures: {page}")
    return assessment.report
