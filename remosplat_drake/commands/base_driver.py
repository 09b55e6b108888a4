"""`remosplat base-driver`: between the station's wire and a base on ROS."""

import argparse
import contextlib
import math
import os
import time
from collections.abc import Iterator
from pathlib import Path

from rich.console import Console

from remosplat_drake.base.clock import Pacer, wall_utime
from remosplat_drake.base.errors import FieldError, FileError
from remosplat_drake.base.stop_signals import stop_signals
from remosplat_drake.commands.tables import open_console
from remosplat_drake.commands.wire import (
    add_wire_argument,
    leased_inbox,
    open_wire,
)
from remosplat_drake.hardware.drivers.arcl_monitor import (
    ArclMonitor,
    split_address,
)
from remosplat_drake.hardware.drivers.ros1_link import Ros1Link
from remosplat_drake.hardware.drivers.ros2_link import Ros2Link
from remosplat_drake.hardware.drivers.ros_base import (
    PERIOD,
    RosBase,
    RosLink,
    RosTopics,
)
from remosplat_drake.hardware.wire.channels import BASE_COMMAND, COMMAND_RAMP

ROS1, ROS2 = "ros1", "ros2"

_LAST_ZEROS = 10

EXAMPLES = """
remosplat base-driver ros2 --localization-topic /amcl_pose
remosplat base-driver ros1 --localization-tf map odom --tf-deviation 0.03 1
"""
"""What `--help` ends with."""


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
    _add_localization(parser)
    _add_stops(parser)
    parser.add_argument(
        "--domain",
        type=int,
        metavar="N",
        help="ROS 2 only: domain (default: ROS_DOMAIN_ID, or 0)",
    )


def _add_localization(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("where the base is in the map")
    group.add_argument(
        "--localization-topic",
        default="",
        metavar="TOPIC",
        help="PoseWithCovarianceStamped of the base in the map, such as"
        " /amcl_pose",
    )
    group.add_argument(
        "--base-frame",
        default=RosTopics.base_frame,
        metavar="FRAME",
        help="the frame whose pose that is (default: %(default)s)",
    )
    group.add_argument(
        "--localization-tf",
        nargs=2,
        metavar=("MAP", "FRAME"),
        help="take from /tf where FRAME, the odometry's or the base's, is in"
        " MAP",
    )
    group.add_argument(
        "--tf-deviation",
        nargs=2,
        type=float,
        default=(0.05, 2.0),
        metavar=("M", "DEG"),
        help="standard deviations of what /tf tells: position and heading"
        " (default: 0.05 m, 2 deg)",
    )


def _add_stops(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("whether the base may move")
    for flag, meaning in (
        ("emergency-stop", "true while an emergency stop is latched"),
        ("protective-stop", "true while the scanner holds the base"),
        ("motors", "true while the motors are on"),
    ):
        group.add_argument(
            f"--{flag}-topic",
            default="",
            metavar="TOPIC",
            help=f"Bool: {meaning}",
        )
    group.add_argument(
        "--stop-expiry",
        type=float,
        default=RosTopics.stop_expiry,
        metavar="S",
        help="silence after which such a topic counts as a stop (default:"
        " %(default)s; inf for topics that tell changes only)",
    )
    group.add_argument(
        "--arcl",
        metavar="HOST[:PORT]",
        help="ask an Omron base over ARCL, besides",
    )
    group.add_argument(
        "--arcl-password-file",
        type=Path,
        metavar="FILE",
        help="file with the password of ARCL",
    )


def run(arguments: argparse.Namespace) -> int:
    """Bridges wire and ROS until Ctrl-C, and then tells the base to stop."""
    lcm = open_wire(arguments.lcm_url)
    link = _link(arguments)
    console = open_console(stderr=True)
    inbox = leased_inbox(
        lcm, [COMMAND_RAMP, BASE_COMMAND], "base-driver", console
    )
    pacer = Pacer(PERIOD)
    with stop_signals() as request, _arcl(arguments, console) as sources:
        bridge = RosBase(lcm, link, sources=sources, inbox=inbox)
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


@contextlib.contextmanager
def _arcl(
    arguments: argparse.Namespace, console: Console
) -> Iterator[list[ArclMonitor]]:
    """Asks over ARCL while the context lasts, if somebody wants it."""
    if arguments.arcl is None:
        yield []
        return
    host, port = split_address(arguments.arcl)
    monitor = ArclMonitor(host, port, _password(arguments), console.print)
    try:
        yield [monitor]
    finally:
        monitor.close()


def _password(arguments: argparse.Namespace) -> str:
    """Reads the password of ARCL; in a command line all could read it."""
    path = arguments.arcl_password_file
    if path is None:
        raise FieldError("--arcl", arguments.arcl, "needs --arcl-password-file")
    try:
        return path.read_text().strip()
    except (OSError, UnicodeDecodeError) as error:
        raise FileError(path, f"cannot be read: {error}") from error


def _link(arguments: argparse.Namespace) -> RosLink:
    topics = _topics(arguments)
    if arguments.ros == ROS1:
        return Ros1Link(topics)
    return Ros2Link(topics, ros_domain(arguments.domain))


def _topics(arguments: argparse.Namespace) -> RosTopics:
    meters, degrees = arguments.tf_deviation
    for flag, value in (
        ("--tf-deviation", min(meters, degrees)),
        ("--stop-expiry", arguments.stop_expiry),
    ):
        if not value > 0:
            raise FieldError("command line", flag, f"{value} is not positive")
    frames = arguments.localization_tf
    return RosTopics(
        arguments.command_topic,
        arguments.odometry_topic,
        arguments.localization_topic,
        arguments.base_frame,
        tuple(frames) if frames else None,
        (meters, meters, math.radians(degrees)),
        arguments.emergency_stop_topic,
        arguments.protective_stop_topic,
        arguments.motors_topic,
        arguments.stop_expiry,
    )


def ros_domain(given: int | None) -> int:
    """Returns the ROS 2 domain that a flag or the environment names."""
    if given is not None:
        return given
    text = os.environ.get("ROS_DOMAIN_ID", "0")
    if not text.isdecimal():
        raise FieldError("environment", "ROS_DOMAIN_ID", f"{text!r}: no number")
    return int(text)
