"""`remosplat ros2-target`: target poses from ROS 2 to a teleoperation."""

import argparse

from remosplat_drake.base.clock import Pacer
from remosplat_drake.base.stop_signals import stop_signals
from remosplat_drake.commands.tables import open_console
from remosplat_drake.commands.wire import add_wire_argument, open_wire
from remosplat_drake.hardware.drivers.ros2_target import Ros2Target
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
        help="URL at which the teleoperation listens (default: %(default)s)",
    )
    parser.add_argument(
        "--topic",
        default="/target_pose",
        metavar="TOPIC",
        help="PoseStamped of the end effector (default: %(default)s)",
    )
    parser.add_argument(
        "--frame",
        default="world",
        metavar="FRAME",
        help="name of the ROS frame that is the scenario's world W (default:"
        " %(default)s)",
    )


def run(arguments: argparse.Namespace) -> int:
    """Forwards poses until Ctrl-C."""
    lcm = open_wire(arguments.lcm_url)
    console = open_console(stderr=True)
    target = Ros2Target(
        lcm,
        arguments.channel,
        arguments.topic,
        arguments.frame,
        tell=lambda news: console.print(
            f"ros2-target: {news}", highlight=False
        ),
    )
    console.print(f"{arguments.topic} -> {arguments.lcm_url}; Ctrl-C ends")
    pacer = Pacer(_PERIOD)
    with stop_signals() as request:
        while not request.made:
            pacer.wait()
            target.step()
    request.is_heeded = True
    return 0
