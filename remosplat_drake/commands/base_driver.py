"""`remosplat base-driver`: between the station's wire and a base on ROS."""

import argparse
import os
import time

from rich.console import Console

from remosplat_drake.base.clock import Pacer, wall_utime
from remosplat_drake.base.errors import FieldError
from remosplat_drake.base.stop_signals import stop_signals
from remosplat_drake.commands.wire import (
    add_wire_argument,
    leased_inbox,
    open_wire,
)
from remosplat_drake.hardware.drivers.ros1_link import Ros1Link
from remosplat_drake.hardware.drivers.ros2_link import Ros2Link
from remosplat_drake.hardware.drivers.ros_base import PERIOD, RosBase, RosLink
from remosplat_drake.hardware.wire.channels import BASE_COMMAND

ROS1, ROS2 = "ros1", "ros2"

_LAST_ZEROS = 10


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's flags."""
    parser.add_argument(
        "ros",
        choices=(ROS1, ROS2),
        help="what the base speaks: ROS 1 (rospy) or ROS 2 (CycloneDDS)",
    )
    add_wire_argument(parser)
    parser.add_argument(
        "--command-topic",
        default="/frankie/cmd_vel",
        metavar="TOPIC",
        help="Twist to the base (default: %(default)s)",
    )
    parser.add_argument(
        "--odometry-topic",
        default="/frankie/odom",
        metavar="TOPIC",
        help="Odometry from the base (default: %(default)s)",
    )
    parser.add_argument(
        "--domain",
        type=int,
        metavar="N",
        help="ROS 2 only: domain (default: ROS_DOMAIN_ID, or 0)",
    )


def run(arguments: argparse.Namespace) -> int:
    """Bridges wire and ROS until Ctrl-C, and then tells the base to stop."""
    lcm = open_wire(arguments.lcm_url)
    link = _link(arguments)
    console = Console(stderr=True)
    inbox = leased_inbox(lcm, [BASE_COMMAND], "base-driver", console)
    bridge = RosBase(lcm, link, inbox=inbox)
    pacer = Pacer(PERIOD)
    with stop_signals() as request:
        console.print(
            f"{arguments.lcm_url} <-> {arguments.command_topic},"
            f" {arguments.odometry_topic}; Ctrl-C ends"
        )
        try:
            while not request.made:
                pacer.wait()
                bridge.step(wall_utime(), time.monotonic())
        finally:
            request.is_heeded = True
            _leave(bridge, link, pacer)
    return 0


def _leave(bridge: RosBase, link: RosLink, pacer: Pacer) -> None:
    """Stops the base, several times: one message may be lost on the way."""
    try:
        for _ in range(_LAST_ZEROS):
            bridge.stop()
            pacer.wait()
    finally:
        link.close()


def _link(arguments: argparse.Namespace) -> RosLink:
    topics = (arguments.command_topic, arguments.odometry_topic)
    if arguments.ros == ROS1:
        return Ros1Link(*topics)
    return Ros2Link(*topics, domain=_domain(arguments.domain))


def _domain(given: int | None) -> int:
    if given is not None:
        return given
    text = os.environ.get("ROS_DOMAIN_ID", "0")
    if not text.isdecimal():
        raise FieldError("environment", "ROS_DOMAIN_ID", f"{text!r}: no number")
    return int(text)
