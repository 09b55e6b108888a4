"""`remosplat calibrate-hand-eye`: finds the camera's pose on the robot."""

import argparse
import math
from pathlib import Path

import numpy as np
from rich.console import Console

from remosplat_drake.app.mount_file import mount_fields, write_mount
from remosplat_drake.app.scenario import Scenario, load_scenario, split_spec
from remosplat_drake.app.scenario_robot import load_scenario_robot
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.base.resources import resolve
from remosplat_drake.base.stop_signals import stop_signals
from remosplat_drake.camera.board_calibration import (
    CharucoBoard,
    find_board,
    fit_board,
)
from remosplat_drake.camera.calibration_frames import (
    APART,
    collect_still_frames,
)
from remosplat_drake.camera.hand_eye_calibration import refine_hand_eye
from remosplat_drake.camera.lcm_camera import LcmCamera
from remosplat_drake.camera.wrist_camera_config import WristCameraConfig
from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.checks.overlap import measure_overlap
from remosplat_drake.capture.formats import read_capture
from remosplat_drake.commands.tables import open_console
from remosplat_drake.hardware.hardware_config import check_lcm_url

EXAMPLES = """
remosplat calibrate-hand-eye kitchen.yaml --board 7x5:0.04:0.03
remosplat calibrate-hand-eye kitchen.yaml --board 7x5:0.04:0.03 --write
"""
"""Examples at the end of `--help`."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's flags."""
    parser.add_argument(
        "scenario",
        help=(
            "scenario, as NAME, FILE or FILE:NAME, that contains the robot, "
            "its camera, and the camera's assumed pose on the robot (mount)"
        ),
    )
    parser.add_argument(
        "--board",
        metavar="CxR:SQUARE:MARKER",
        help=(
            "a ChArUco board: numbers of squares along its sides, side length "
            "of squares and of markers [m], and optionally :DICTIONARY of "
            "OpenCV, e.g. 7x5:0.04:0.03. Without a board, the command uses "
            "overlapping depth images of the scene; the assumed mount must "
            "then be correct to a few degrees"
        ),
    )
    parser.add_argument(
        "--capture",
        type=Path,
        metavar="FOLDER",
        help=(
            "recorded images, with camera poses that were computed from the "
            "assumed mount (default: images received over LCM)"
        ),
    )
    parser.add_argument(
        "--lcm-url",
        metavar="URL",
        help="LCM URL of the robot (default: the scenario's hardware.lcm_url)",
    )
    parser.add_argument(
        "--frames",
        type=int,
        default=15,
        metavar="N",
        help="number of images to receive over LCM (default: %(default)s)",
    )
    parser.add_argument(
        "--write",
        action="store_true",
        help="write the mount to the scenario's file",
    )


def run(arguments: argparse.Namespace) -> int:
    """Finds the mount, prints it, and writes it if requested."""
    console = open_console(soft_wrap=True)
    if arguments.write and split_spec(arguments.scenario) is None:
        raise RemoSplatError(
            "--write: shipped scenarios cannot be changed; give a scenario file"
        )
    board = arguments.board and CharucoBoard.parse(arguments.board)
    scenario = load_scenario(arguments.scenario)
    config = scenario.camera or WristCameraConfig()
    believed = config.hand_eye().GetAsMatrix4()
    capture = _capture(arguments, scenario, config, console)
    if board:
        X_FC = _from_board(board, capture, believed, console)
    else:
        X_FC = _from_scene(capture, believed, console)
    change = np.linalg.solve(believed, X_FC)
    turn = math.acos(np.clip((np.trace(change[:3, :3]) - 1) / 2, -1, 1))
    console.print(
        f"the assumed mount was wrong by {math.degrees(turn):.2f} deg and "
        f"{1e3 * np.linalg.norm(change[:3, 3]):.1f} mm"
    )
    fields = ", ".join(f"{k}: {v}" for k, v in mount_fields(X_FC).items())
    console.print(f"wrist_camera: {{{fields}}}", highlight=False)
    if arguments.write:
        write_mount(arguments.scenario, X_FC)
        console.print(f"written to {arguments.scenario}")
    return 0


def _from_board(
    board: CharucoBoard, capture: Capture, X_FC: np.ndarray, console: Console
) -> np.ndarray:
    fit = fit_board(find_board(board, capture, X_FC))
    console.print(
        f"residual: {fit.residual:.2f} pixels (RMS) over {fit.images} images;"
        f" standard deviation {1e3 * fit.deviation:.2f} mm,"
        f" {math.degrees(fit.turn_deviation):.3f} deg"
    )
    return fit.X_FC


def _from_scene(
    capture: Capture, X_FC: np.ndarray, console: Console
) -> np.ndarray:
    fit = refine_hand_eye(capture, X_FC)
    before, after = (
        1e3 * float(np.median(measure_overlap(images).differences))
        for images in (capture, fit.capture)
    )
    console.print(
        f"residual: overlapping images differ by {after:.2f} mm (median),"
        f" {before:.2f} mm before, over {len(capture)} images"
    )
    return fit.X_FC


def _capture(
    arguments: argparse.Namespace,
    scenario: Scenario,
    config: WristCameraConfig,
    console: Console,
) -> Capture:
    """Reads the images from files, or receives them over LCM."""
    if arguments.capture is not None:
        return read_capture(resolve(arguments.capture))
    hardware = scenario.hardware
    if arguments.lcm_url:
        check_lcm_url(arguments.lcm_url)
        hardware.lcm_url, hardware.lcm = arguments.lcm_url, None
    robot = load_scenario_robot(scenario)
    camera = LcmCamera(config, robot, hardware)
    console.print(
        f"move the camera to {arguments.frames} places that show the same "
        f"scene; between two places, turn it by {math.degrees(APART):.0f} deg "
        "or more, about different axes; an image is taken whenever the robot "
        "stands still; Ctrl-C ends"
    )
    told = -1
    with stop_signals() as request:

        def tell(count: int) -> bool:
            nonlocal told
            if count != told:
                told = count
                console.print(f"{count} of {arguments.frames}")
            return not request.made

        capture = collect_still_frames(camera, arguments.frames, tell)
        request.has_ended = True
    return capture
