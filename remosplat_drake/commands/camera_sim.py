"""`remosplat camera-sim`: simulates the real robot's cameras, on LCM."""

import argparse
import os
import time

from pydrake.lcm import DrakeLcm

from remosplat_drake.app.scenario import Scenario, load_scenario
from remosplat_drake.app.stages.movers import tracks_of
from remosplat_drake.app.world import World, load_world
from remosplat_drake.base.clock import wall_utime
from remosplat_drake.base.stop_signals import stop_signals
from remosplat_drake.camera.camera_sim import (
    CameraSim,
    HeardConfiguration,
)
from remosplat_drake.camera.wrist_camera_config import WristCameraConfig
from remosplat_drake.commands.number_flags import positive
from remosplat_drake.commands.tables import open_console
from remosplat_drake.commands.wire import (
    add_camera_wire_argument,
    add_wire_argument,
    open_camera_wire,
    open_wire,
)
from remosplat_drake.detection.simulated.wire_camera import WireCamera
from remosplat_drake.hardware.hardware_config import REHEARSAL_URL
from remosplat_drake.hardware.wire.inbox import Inbox

_YIELD = 10

_MOST_AHEAD = 50_000
"""The time stamp of an image is at most this long after its rendering begins
[us]. The limit is short, since the image shows the robot's position when
rendering begins."""

EXAMPLES = """
remosplat camera-sim StudioLive
remosplat camera-sim StudioLive --rate 2
remosplat camera-sim PersonSeen --camera left --rate 30
"""
"""Examples at the end of `--help`."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's flags."""
    parser.add_argument(
        "scenario",
        nargs="?",
        help=(
            "NAME, FILE or FILE:NAME (see `remosplat scenarios`): scenario "
            "with the camera and its surroundings"
        ),
    )
    add_wire_argument(parser, REHEARSAL_URL)
    add_camera_wire_argument(parser)
    parser.add_argument(
        "--camera",
        metavar="NAME",
        help="one of the scenario's `cameras` (default: the wrist camera)",
    )
    parser.add_argument(
        "--rate",
        type=positive,
        default=5.0,
        metavar="HZ",
        help="largest number of images per second (default: %(default)s)",
    )


def run(arguments: argparse.Namespace) -> int:
    """Waits for a status of every robot part; then sends images until Ctrl-C.

    Movers begin to move when the robot first moves.
    """
    scenario = load_scenario(arguments.scenario)
    if arguments.camera is not None:
        scenario.detection_camera(
            arguments.camera
        )  # Before the files are read.
    world = load_world(scenario, blank=True)
    heard = HeardConfiguration(world.robot.description)
    inbox = Inbox(open_wire(arguments.lcm_url), heard.channels)
    lcm, url = open_camera_wire(arguments)
    camera = _camera(arguments.camera, scenario, world, lcm)
    # A low priority, since rendering must not delay the programs that move the
    # robot.
    os.nice(_YIELD)
    with stop_signals() as request:
        open_console(stderr=True).print(f"the camera is on {url}; Ctrl-C ends")
        while not request.made:
            _listen(inbox, heard, 1.0 / arguments.rate)
            if heard.q is not None:
                ahead = camera.lead if isinstance(camera, WireCamera) else 0
                utime = wall_utime() + min(ahead, _MOST_AHEAD)
                camera.take(heard.q, utime, heard.time_at(utime))
    return 0


def _camera(
    name: str | None, scenario: Scenario, world: World, lcm: DrakeLcm
) -> CameraSim | WireCamera:
    """Returns the wrist camera, or the camera with the given name."""
    robot, truth, tracks = world.robot, world.truth, tracks_of(scenario)
    if name is None:
        wrist = scenario.camera or WristCameraConfig()
        return CameraSim(wrist, robot, truth, tracks, lcm)
    return WireCamera(
        scenario.detection_camera(name), robot, truth, tracks, lcm
    )


def _listen(inbox: Inbox, heard: HeardConfiguration, duration: float) -> None:
    """Receives the robot's statuses until the next image is due."""
    end = time.monotonic() + duration
    while time.monotonic() < end:
        for channel, data in inbox.fetch(timeout=0.005):
            heard.receive(channel, data)
