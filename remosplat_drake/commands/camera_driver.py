"""`remosplat camera-driver`: sends the images of an Intel RealSense by LCM."""

import argparse
from functools import partial

from rich.console import Console

from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.base.stop_signals import StopRequest, stop_signals
from remosplat_drake.camera.camera_driver import CameraDriver
from remosplat_drake.camera.realsense import RealSenseCamera
from remosplat_drake.camera.wrist_camera_config import WristCameraConfig
from remosplat_drake.commands.flags import check_positive
from remosplat_drake.commands.tables import open_console
from remosplat_drake.commands.wire import (
    add_camera_wire_argument,
    add_wire_argument,
    open_camera_wire,
)
from remosplat_drake.hardware.wire.channels import WRIST_CAMERA

EXAMPLES = """
remosplat camera-driver kitchen.yaml
remosplat camera-driver kitchen.yaml --lcm-url 'udpm://239.255.76.67:7667?ttl=1'
"""
"""Examples at the end of `--help`."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's flags."""
    parser.add_argument(
        "scenario",
        nargs="?",
        help=(
            "NAME, FILE or FILE:NAME (see `remosplat scenarios`): scenario "
            "that defines the size and field of view of the sent images"
        ),
    )
    add_wire_argument(parser)
    add_camera_wire_argument(parser)
    parser.add_argument(
        "--camera",
        metavar="NAME",
        help="one of the scenario's `cameras` (default: the wrist camera)",
    )
    parser.add_argument(
        "--serial",
        metavar="NUMBER",
        help="serial number of the camera (default: the first camera found)",
    )
    for name, default, what in (
        ("width", 640, "width of its images [pixels]"),
        ("height", 480, "height of its images [pixels]"),
        ("fps", 15, "images per second"),
    ):
        parser.add_argument(
            f"--{name}",
            type=int,
            default=default,
            metavar="N",
            help=f"mode of the camera: {what} (default: %(default)s)",
        )


def run(arguments: argparse.Namespace) -> int:
    """Sends the camera's images until Ctrl-C."""
    check_positive("camera-driver", arguments, "width", "height", "fps")
    scenario = load_scenario(arguments.scenario)
    config, channel = scenario.camera or WristCameraConfig(), WRIST_CAMERA
    if arguments.camera is not None:
        camera = scenario.detection_camera(arguments.camera)
        config, channel = camera.lens, camera.channel_name
    lcm, url = open_camera_wire(arguments)
    open_camera = partial(
        RealSenseCamera,
        arguments.width,
        arguments.height,
        arguments.fps,
        arguments.serial,
    )
    driver = CameraDriver(lcm, config, open_camera, channel)
    console = open_console(stderr=True)
    console.print(f"the camera is on {url}; Ctrl-C ends")
    with stop_signals() as request:
        try:
            _drive(driver, console, request)
        finally:
            request.has_ended = True
            driver.close()
    return 0


def _drive(
    driver: CameraDriver, console: Console, request: StopRequest
) -> None:
    """Sends images, and prints when the camera stops and when it resumes."""
    problem, is_new = "", True
    while not request.made:
        driver.step()
        if is_new and driver.sent and driver.coverage < 1:
            is_new = False
            console.print(
                "the camera's field of view covers "
                f"{100 * driver.coverage:.0f} % of the image that the "
                "scenario's wrist_camera requires; reduce its fov_y_deg"
            )
        if driver.problem != problem:
            problem = driver.problem
            console.print(problem or "the camera is back")
