"""`remosplat driver-check`: checks a robot's drivers by the LCM protocol."""

import argparse
import contextlib
import time

from rich.console import Console

from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.scenario_robot import load_scenario_robot
from remosplat_drake.base.errors import FieldError
from remosplat_drake.base.stop_signals import stop_signals
from remosplat_drake.commands.doctor import show_finding
from remosplat_drake.commands.json_output import add_json_argument, print_json
from remosplat_drake.commands.number_flags import positive
from remosplat_drake.commands.tables import open_console
from remosplat_drake.hardware.conformance.checks import Seen, judge
from remosplat_drake.hardware.conformance.robot_record import (
    RobotRecord,
    gather,
)
from remosplat_drake.hardware.doctor.finding import FAILED, SKIPPED
from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.hardware.wire.multicast import MulticastListener, Packet
from remosplat_drake.robot.robot_model import RobotModel

_PERIOD = 0.001
_LOOK = 2.0
"""Time between two checks of all rules [s]."""

_LONGEST = 3600.0

STOP, RESTART = "stop", "restart"

EXAMPLES = """
remosplat driver-check my_arm.yaml
remosplat driver-check my_arm.yaml --skip restart --duration 60
"""
"""Examples at the end of `--help`."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's flags."""
    parser.add_argument(
        "scenario",
        help=(
            "NAME, FILE or FILE:NAME (see `remosplat scenarios`): scenario "
            "with the robot and its LCM URL"
        ),
    )
    parser.add_argument(
        "--lcm-url",
        metavar="URL",
        help="LCM URL of the robot (default: the scenario's hardware.lcm_url)",
    )
    parser.add_argument(
        "--duration",
        type=positive,
        default=300.0,
        metavar="S",
        help=(
            "longest time to listen; the check ends earlier if it has "
            "observed everything that the rules need (default: %(default)s)"
        ),
    )
    parser.add_argument(
        "--skip",
        action="append",
        default=[],
        choices=(STOP, RESTART),
        help=(
            "do not wait for a stop, or for the restart of a driver. A rule "
            "that could not be checked counts as violated, except the rule "
            "about restarts"
        ),
    )
    add_json_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Checks the drivers; returns 1 if a rule is violated or was not tested."""
    if arguments.duration > _LONGEST:
        problem = f"must be at most {_LONGEST:g}"
        raise FieldError("driver-check", "--duration", problem)
    console = open_console(stderr=arguments.json, soft_wrap=True)
    scenario = load_scenario(arguments.scenario)
    config = scenario.hardware
    if arguments.lcm_url:
        config.use_url(arguments.lcm_url)
    robot = load_scenario_robot(scenario)
    record = _listen(config, robot, arguments, console)
    findings = judge(record, config, robot.assumed_actuators)
    for finding in findings:
        show_finding(finding, console)
    slower = 1e3 * (config.arm_status_period - 1e-3)
    if slower > 1:
        console.print(
            f"at {config.arm_status_rate:g} Hz the controller detects an arm "
            f"that stops sending {slower:.0f} ms later than at 1 kHz, and the "
            "robot moves on for this time"
        )
    if arguments.json:
        print_json(findings)
    wrong = [
        finding
        for finding in findings
        if finding.result == FAILED
        or (finding.result == SKIPPED and finding.check != RESTART)
    ]
    return 1 if wrong else 0


def _listen(
    config: HardwareConfig,
    robot: RobotModel,
    arguments: argparse.Namespace,
    console: Console,
) -> RobotRecord:
    """Records messages until two seconds after all rules can be checked."""
    packets: list[Packet] = []
    seen, looked, told, complete = Seen(), 0, "", False
    listener = MulticastListener(config.url)
    console.print(
        f"listening on {config.url}; the check sends nothing. Meanwhile move "
        f"every axis (`remosplat identify {arguments.scenario} --fraction "
        "0.2`), press and release the stop of each part, and restart a "
        "driver; Ctrl-C ends"
    )
    start = time.monotonic()
    next_look = start + _LOOK
    with contextlib.closing(listener), stop_signals() as request:
        while True:
            time.sleep(_PERIOD)
            packets += listener.fetch()
            passed = time.monotonic() - start
            ends = passed >= arguments.duration or request.made
            if not ends and time.monotonic() < next_look:
                continue
            next_look = time.monotonic() + _LOOK
            seen.add(gather(packets[looked:], config, robot, _LOOK))
            looked = len(packets)
            still = seen.missing(
                STOP not in arguments.skip, RESTART not in arguments.skip
            )
            # A motion that was just detected continues for a while. The record
            # must contain all of it.
            if ends or (complete and not still):
                request.has_ended = True
                return gather(packets, config, robot, passed)
            complete = not still
            line = "; ".join(still)
            if still and line != told:
                told = line
                console.print(f"not observed yet: {line}", highlight=False)
