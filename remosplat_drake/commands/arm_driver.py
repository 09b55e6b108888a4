"""`remosplat arm-driver`: between the station's wire and any other arm."""

import argparse
import re
import time
from collections.abc import Iterator

from rich.console import Console

from remosplat_drake.base.clock import Pacer, wall_utime
from remosplat_drake.base.errors import FieldError, RemoSplatError
from remosplat_drake.base.stop_signals import stop_signals
from remosplat_drake.commands.base_driver import ros_domain
from remosplat_drake.commands.flags import flag_name
from remosplat_drake.commands.number_flags import number
from remosplat_drake.commands.tables import open_console
from remosplat_drake.commands.wire import (
    add_wire_argument,
    leased_inbox,
    open_wire,
)
from remosplat_drake.hardware.drivers.arm_driver import ArmDriver, ArmLink
from remosplat_drake.hardware.drivers.arm_stops import (
    BOOL,
    INT32,
    MODE_TYPES,
    ArmTopics,
)
from remosplat_drake.hardware.drivers.ros2_arm import Ros2Arm
from remosplat_drake.hardware.drivers.ur_arm import UrArm
from remosplat_drake.hardware.wire.channels import COMMAND_RAMP, PANDA_COMMAND
from remosplat_drake.robot.robot_description import (
    RobotDescription,
    load_robot_description,
)

ROS2, UR = "ros2", "ur"

_PERIOD = 0.008
"""Period of the driver's loop [s]: a command to a Universal Robots controller
is a dialogue of some milliseconds."""

_UR_JOINTS = 6

_PATIENCE = 3.0
"""How long the arm is given to come to rest at the end [s]."""

_AFTERWARDS = 0.2
"""How long a stopped arm's mode is told before the driver ends [s]."""

EXAMPLES = """
remosplat arm-driver ur 192.168.56.101 --robot ur5e
remosplat arm-driver ros2 --robot arm.yaml --emergency-stop-topic /e_stop
"""
"""What `--help` ends with."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's flags."""
    parser.add_argument(
        "kind",
        choices=(ROS2, UR),
        help="what the arm speaks: ros2_control's velocity controller, or"
        " Universal Robots' RTDE (extra `ur`)",
    )
    parser.add_argument(
        "host",
        nargs="?",
        help="name or address of a Universal Robots controller",
    )
    parser.add_argument(
        "--robot",
        required=True,
        metavar="NAME|FILE",
        help="the robot whose arm it is: it says the joints and how fast they"
        " follow",
    )
    add_wire_argument(parser)
    parser.add_argument(
        "--command-topic",
        default=ArmTopics.command,
        metavar="TOPIC",
        help="Float64MultiArray of joint rates to a"
        " JointGroupVelocityController (default: %(default)s)",
    )
    parser.add_argument(
        "--states-topic",
        default=ArmTopics.states,
        metavar="TOPIC",
        help="JointState from the arm (default: %(default)s)",
    )
    _add_stops(parser)
    parser.add_argument(
        "--domain",
        type=int,
        metavar="N",
        help="ROS 2 only: domain (default: ROS_DOMAIN_ID, or 0)",
    )


def _add_stops(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("whether an arm on ROS 2 may move")
    group.add_argument(
        "--emergency-stop-topic",
        default=ArmTopics.emergency_stop,
        metavar="TOPIC",
        help="Bool: true while an emergency stop is latched",
    )
    group.add_argument(
        "--mode-topic",
        default=ArmTopics.mode,
        metavar="TOPIC",
        help="String, Int32 or Bool: the arm's mode",
    )
    group.add_argument(
        "--mode-type",
        choices=MODE_TYPES,
        default=ArmTopics.mode_type,
        help="type of the mode's messages, in std_msgs (default: %(default)s)",
    )
    group.add_argument(
        "--running-mode",
        action="append",
        default=[],
        metavar="MODE",
        help="what the mode is while the arm obeys: a text, a number, true or"
        " false; may be given repeatedly",
    )
    group.add_argument(
        "--stop-expiry",
        type=number,
        default=ArmTopics.stop_expiry,
        metavar="S",
        help="silence after which such a topic counts as a stop (default:"
        " %(default)s; inf for topics that tell changes only)",
    )


def run(arguments: argparse.Namespace) -> int:
    """Drives the arm until Ctrl-C, or until it is stopped by itself."""
    description = load_robot_description(arguments.robot)
    lcm = open_wire(arguments.lcm_url)
    console = open_console(stderr=True)
    link = _link(arguments, description, console)
    inbox = leased_inbox(
        lcm, [COMMAND_RAMP, PANDA_COMMAND], "arm-driver", console
    )
    driver = ArmDriver(lcm, link, len(description.arm.joints), inbox)
    pacer, problem = Pacer(_PERIOD), ""
    with stop_signals() as request:
        console.print(f"{arguments.lcm_url} <-> {arguments.kind}; Ctrl-C ends")
        try:
            while not request.made and not problem:
                pacer.wait()
                report = driver.step(wall_utime())
                problem = report.problem if report else ""
        finally:
            request.is_heeded = True
            _leave(driver, link, pacer, bool(problem))
    if problem:
        raise RemoSplatError(f"the arm has stopped: {problem}")
    return 0


def _leave(
    driver: ArmDriver, link: ArmLink, pacer: Pacer, has_stopped: bool
) -> None:
    """Brings the arm to rest, or tells for a moment why it rests."""
    try:
        end = time.monotonic() + (_AFTERWARDS if has_stopped else _PATIENCE)
        while time.monotonic() < end:
            if driver.brake(wall_utime()) and not has_stopped:
                break
            pacer.wait()
    finally:
        link.close()


def _link(
    arguments: argparse.Namespace,
    description: RobotDescription,
    console: Console,
) -> ArmLink:
    joints = description.arm.joints
    if arguments.kind == ROS2:
        if arguments.host:
            raise FieldError("arm-driver", "host", "ros2 has topics, no host")
        topics = _topics(arguments)

        def tell(news: str) -> None:
            console.print(f"arm-driver: {news}", highlight=False)

        link = Ros2Arm(topics, joints, ros_domain(arguments.domain), tell)
        for news in _untold(topics):
            tell(news)
        return link
    for name in ("emergency_stop_topic", "mode_topic"):
        if getattr(arguments, name):
            problem = "only with ros2; a UR tells its stops itself"
            raise FieldError("arm-driver", flag_name(name), problem)
    if not arguments.host:
        raise FieldError("arm-driver", "host", "ur wants the controller's")
    if len(joints) != _UR_JOINTS:
        problem = f"{description.name} has {len(joints)} joints, a UR has 6"
        raise FieldError("arm-driver", "--robot", problem)
    return UrArm(arguments.host, max(description.acceleration_limits))


def _topics(arguments: argparse.Namespace) -> ArmTopics:
    """Returns the topics that the flags name.

    Raises:
        FieldError: A flag contradicts another, or is out of its range.
    """
    if not arguments.stop_expiry > 0:
        raise FieldError("arm-driver", "--stop-expiry", "must be positive")
    modes, kind = arguments.running_mode, arguments.mode_type
    if bool(modes) != bool(arguments.mode_topic):
        problem = "belongs with --mode-topic: give both, or neither"
        raise FieldError("arm-driver", "--running-mode", problem)
    for mode in modes:
        if kind == BOOL and mode not in ("true", "false"):
            problem = f"{mode!r}: a {BOOL} is true or false"
            raise FieldError("arm-driver", "--running-mode", problem)
        if kind == INT32 and not re.fullmatch(r"0|-?[1-9]\d*", mode):
            problem = f"{mode!r}: an {INT32} is a whole number"
            raise FieldError("arm-driver", "--running-mode", problem)
    return ArmTopics(
        arguments.command_topic,
        arguments.states_topic,
        arguments.emergency_stop_topic,
        arguments.mode_topic,
        kind,
        tuple(modes),
        arguments.stop_expiry,
    )


def _untold(topics: ArmTopics) -> Iterator[str]:
    """Yields what nothing tells of the arm."""
    if not topics.emergency_stop:
        yield (
            "no --emergency-stop-topic: nothing tells of the arm's emergency"
            " stop"
        )
    if not topics.mode:
        yield (
            "no --mode-topic: nothing tells whether the arm obeys; its mode is"
            " taken to be `move`"
        )
