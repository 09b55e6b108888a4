"""`remosplat ros2-objects`: reads a scenario's objects from MoveIt."""

import argparse
from pathlib import Path

import yaml

from remosplat_drake.base.atomic_file import check_writable, write_atomically
from remosplat_drake.base.clock import Pacer
from remosplat_drake.base.stop_signals import stop_signals
from remosplat_drake.commands.number_flags import positive
from remosplat_drake.commands.tables import open_console
from remosplat_drake.hardware.drivers.collision_objects import CollisionObjects
from remosplat_drake.hardware.drivers.ros2_node import Ros2Node, taken

_PERIOD = 0.02

EXAMPLES = """
remosplat ros2-objects --out objects.yaml
remosplat ros2-objects --scene-topic /monitored_planning_scene
"""
"""Examples at the end of `--help`."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's flags."""
    parser.add_argument(
        "--scene-topic",
        default="/planning_scene",
        metavar="TOPIC",
        help=(
            "topic of moveit_msgs/PlanningScene, such as "
            "/monitored_planning_scene of move_group (default: %(default)s)"
        ),
    )
    parser.add_argument(
        "--object-topic",
        default="/collision_object",
        metavar="TOPIC",
        help="topic of moveit_msgs/CollisionObject (default: %(default)s)",
    )
    parser.add_argument(
        "--frame",
        default="world",
        metavar="FRAME",
        help=(
            "name of the ROS frame that is the scenario's world W (default: "
            "%(default)s)"
        ),
    )
    parser.add_argument(
        "--duration",
        type=positive,
        default=10.0,
        metavar="S",
        help="time to listen in seconds; Ctrl-C ends it earlier (default: "
        "%(default)s)",
    )
    parser.add_argument(
        "--out",
        type=Path,
        metavar="FILE",
        help="YAML file to write (default: print to the terminal)",
    )


def run(arguments: argparse.Namespace) -> int:
    """Listens and writes the objects; returns 1 if an object was left out."""
    if arguments.out:
        check_writable(arguments.out)
    console = open_console(stderr=True, soft_wrap=True)
    node = Ros2Node(None, "objects from ROS 2")
    from remosplat_drake.hardware.drivers import moveit_messages as moveit

    scenes = node.reader(arguments.scene_topic, moveit.PlanningScene)
    single = node.reader(arguments.object_topic, moveit.CollisionObject)
    objects = CollisionObjects(arguments.frame)
    problems: dict[str, None] = {}
    topics = f"{arguments.scene_topic}, {arguments.object_topic}"
    console.print(f"listening to {topics}; Ctrl-C ends", highlight=False)
    pacer = Pacer(_PERIOD)
    with stop_signals() as request:
        while not request.made and pacer.ticks * _PERIOD < arguments.duration:
            pacer.wait()
            found = [x for s in taken(scenes) for x in objects.put_scene(s)]
            found += [objects.put(sample) for sample in taken(single)]
            for problem in filter(None, found):
                if problem not in problems:
                    console.print(problem, highlight=False, markup=False)
                problems[problem] = None
    request.has_ended = True
    entries = objects.entries()
    text = yaml.safe_dump({"objects": entries}, sort_keys=False)
    if arguments.out:
        write_atomically(arguments.out, text)
    else:
        print(text, end="")
    console.print(f"{len(entries)} objects", highlight=False)
    return 1 if problems else 0
