"""`remosplat detect`: detects movers with cameras and sends them to a robot."""

import argparse
import time
from pathlib import Path

from rich.console import Console

from remosplat_drake.app.scenario import Scenario, load_scenario
from remosplat_drake.app.stages.camera_detection import known_scene
from remosplat_drake.app.world import load_world
from remosplat_drake.base.errors import FieldError
from remosplat_drake.base.stop_signals import StopRequest, stop_signals
from remosplat_drake.commands.tables import open_console
from remosplat_drake.commands.wire import announce_wire
from remosplat_drake.detection.followed_map import FollowedMap
from remosplat_drake.detection.wire_detection import WireDetection
from remosplat_drake.hardware.hardware_config import REHEARSAL_URL

_REPORT = 10.0
"""Time between two printed progress lines [s]."""

EXAMPLES = """
remosplat detect PersonSeen
remosplat detect PersonSeen --lcm-url 'udpm://239.255.76.67:7667?ttl=1'
remosplat detect PersonSeen --session kitchen
"""
"""Examples at the end of `--help`."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's flags."""
    parser.add_argument(
        "scenario",
        nargs="?",
        help=(
            "NAME, FILE or FILE:NAME (see `remosplat scenarios`): scenario "
            "that contains `cameras`, a map, and the robot"
        ),
    )
    parser.add_argument(
        "--lcm-url",
        metavar="URL",
        help=(
            "LCM URL of the robot's drivers (default: the scenario's "
            f"hardware.lcm_url, whose default is {REHEARSAL_URL})"
        ),
    )
    parser.add_argument(
        "--camera-url",
        metavar="URL",
        help=(
            "LCM URL of the images (default: the scenario's "
            "hardware.camera_url)"
        ),
    )
    parser.add_argument(
        "--session",
        type=Path,
        metavar="DIR",
        help=(
            "session folder of a teleoperation; the command then uses the "
            "session's growing map, and objects in this map do not count as "
            "movers (default: the scenario's map)"
        ),
    )


def run(arguments: argparse.Namespace) -> int:
    """Detects movers, and sends them to the robot's controller until Ctrl-C."""
    scenario = load_scenario(arguments.scenario)
    console = open_console(stderr=True)
    detection = _open(arguments, scenario, console)
    with stop_signals() as request:
        names = ", ".join(camera.name for camera in scenario.cameras)
        console.print(f"listens to {names}; Ctrl-C ends")
        _watch(detection, console, request)
    return 0


def _open(
    arguments: argparse.Namespace, scenario: Scenario, console: Console
) -> WireDetection:
    """Loads the map, and joins the LCM networks of robot and cameras."""
    if not scenario.cameras:
        problem = "is empty; list the cameras that detect movers"
        raise FieldError(scenario.source, "cameras", problem)
    hardware = scenario.hardware
    if arguments.lcm_url:
        hardware.use_url(arguments.lcm_url)
    if arguments.camera_url:
        hardware.camera_url = arguments.camera_url
    world = load_world(scenario)
    known = known_scene(scenario, world)
    followed = None
    if arguments.session:
        followed = FollowedMap(arguments.session, known, scenario.detection)
    announce_wire(hardware.url, console)
    return WireDetection(
        scenario.cameras,
        world.robot,
        known,
        scenario.detection,
        hardware,
        followed,
    )


def _watch(
    detection: WireDetection, console: Console, request: StopRequest
) -> None:
    """Processes images; prints problems of cameras, and the progress."""
    missing: list[str] = []
    map_in_use = ""
    problems: dict[str, str] = {}
    latency: list[float] = []
    due = time.monotonic() + _REPORT
    while not request.made:
        if detection.step():
            latency.append(detection.latency)
        if detection.missing != missing and (missing := detection.missing):
            console.print(f"waits for {', '.join(missing)}")
        if detection.map_in_use != map_in_use and (
            map_in_use := detection.map_in_use
        ):
            console.print(f"uses {map_in_use}", highlight=False)
        for name, problem in detection.problems.items():
            if problem.split(" for ")[0] != problems.get(name, ""):
                problems[name] = problem.split(" for ")[0]
                console.print(f"{name}: {problem or 'usable images again'}")
        if time.monotonic() >= due:
            due += _REPORT
            _report(detection, latency, console)
            latency.clear()


def _report(
    detection: WireDetection, latency: list[float], console: Console
) -> None:
    if not latency:
        console.print("no usable image was received")
        return
    latency.sort()
    middle, late = (latency[int(s * (len(latency) - 1))] for s in (0.5, 0.99))
    moving = sum(track.is_trusted for track in detection.detection.tracks)
    console.print(
        f"{len(latency) / _REPORT:.0f} images per second, {moving} movers; "
        f"sent after {1e3 * middle:.0f} ms, 99 % within {1e3 * late:.0f} ms",
        highlight=False,
    )
