"""`remosplat ros2-target`: sends targets from ROS 2 to a teleoperation."""

import argparse

from remosplat_drake.base.clock import Pacer
from remosplat_drake.base.stop_signals import stop_signals
from remosplat_drake.commands.tables import open_console
from remosplat_drake.commands.wire import add_wire_argument, open_wire
from remosplat_drake.hardware.drivers.ros2_target import (
    POSES,
    VELOCITIES,
    Ros2Target,
)
from remosplat_drake.teleop.teleop_config import PoseStreamConfig

_PERIOD = 0.01

EXAMPLES = """
remosplat ros2-target
remosplat ros2-target --topic /goal_pose --frame map
"""
"""Examples at the end of `--help`."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's flags."""
    add_wire_argument(parser, PoseStreamConfig.lcm_url)
    parser.add_argument(
        "--channel",
        default=PoseStreamConfig.channel,
        metavar="NAME",
        help=(
            "LCM channel of the poses for the teleoperation (default: "
            "%(default)s)"
        ),
    )
    parser.add_argument(
        "--velocity-channel",
        default=PoseStreamConfig.velocity_channel,
        metavar="NAME",
        help=(
            "LCM channel of the velocities for the teleoperation (default: "
            "%(default)s)"
        ),
    )
    parser.add_argument(
        "--topic",
        default="/target_pose",
        metavar="TOPIC",
        help=(
            "topic of PoseStamped, the end effector's target pose (default: "
            "%(default)s)"
        ),
    )
    parser.add_argument(
        "--twist-topic",
        default="/target_twist",
        metavar="TOPIC",
        help=(
            "topic of TwistStamped, the target's velocity (default: "
            "%(default)s)"
        ),
    )
    parser.add_argument(
        "--frame",
        default="world",
        metavar="FRAME",
        help="name of the ROS frame that is the scenario's world W (default:"
        " %(default)s)",
    )


def run(arguments: argparse.Namespace) -> int:
    """Forwards poses and velocities until Ctrl-C."""
    lcm = open_wire(arguments.lcm_url)
    console = open_console(stderr=True)
    targets = [
        Ros2Target(
            lcm,
            channel,
            topic,
            arguments.frame,
            kind=kind,
            tell=lambda news: console.print(
                f"ros2-target: {news}", highlight=False
            ),
        )
        for kind, channel, topic in (
            (POSES, arguments.channel, arguments.topic),
            (VELOCITIES, arguments.velocity_channel, arguments.twist_topic),
        )
    ]
    topics = f"{arguments.topic}, {arguments.twist_topic}"
    console.print(f"{topics} -> {arguments.lcm_url}; Ctrl-C ends")
    pacer = Pacer(_PERIOD)
    with stop_signals() as request:
        while not request.made:
            pacer.wait()
            for target in targets:
                target.step()
    request.has_ended = True
    return 0
