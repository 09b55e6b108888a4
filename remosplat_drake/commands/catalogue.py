"""The list of all commands, by group, for `remosplat --help`.

This module does not import the commands, so that help appears at once.
"""

from typing import NamedTuple


class Group(NamedTuple):
    """A group of commands that serve one purpose.

    Attributes:
        title: The purpose that the commands share.
        example: Example command line of one of the commands.
        commands: Purpose of each command, in one line, keyed by the command's
            name.
    """

    title: str
    example: str
    commands: dict[str, str]


GROUPS = (
    Group(
        "Drive",
        "remosplat run BookshelfReach",
        {
            "run": "drive the robot of a scenario to its targets",
            "teleop": "move the target by hand while the map grows",
            "replay": "play a recorded session again",
        },
    ),
    Group(
        "Look",
        "remosplat inspect TableReach --sphere panda_hand",
        {
            "scenarios": "list the shipped scenarios",
            "inspect": "show a sphere's depth views",
        },
    ),
    Group(
        "Maps",
        "remosplat reconstruct my_capture -o kitchen.ply",
        {
            "capture-info": "describe an RGB-D capture and check it",
            "reconstruct": "make a splat from an RGB-D capture",
            "quality": "measure the errors of a splat's distances",
            "convert": "convert a splat to another file format",
            "render-capture": "render RGB-D views of a scene, a model or a"
            " mesh",
        },
    ),
    Group(
        "The real robot",
        "remosplat doctor TableReach --skip all",
        {
            "doctor": "check robot, network and computer before a motion",
            "driver-check": "check a robot's drivers against the LCM protocol",
            "arm": "arm a real robot that waits for an operator",
            "identify": "measure how the axes of the real robot follow"
            " commands",
            "calibrate-hand-eye": "find the camera's pose on the robot",
            "panda-driver": "drive a Panda through panda-python",
            "arm-driver": "drive an arm by ROS 2, RTDE or a plug-in",
            "base-driver": "drive a mobile base by ROS 1, ROS 2 or a plug-in",
            "hand-driver": "drive a gripper by ROS 2 or a plug-in",
            "ros2-target": "send targets from ROS 2 to a teleoperation",
            "ros2-objects": "read a scenario's objects from MoveIt on ROS 2",
            "camera-driver": "send the images of a RealSense camera",
            "hardware-sim": "simulate the real robot and its drivers",
            "detect": ("detect movers by cameras, and send them to a robot"),
            "camera-sim": "simulate a camera of the real robot",
        },
    ),
    Group(
        "Measure",
        "remosplat benchmark --scenes 2 --output results/first",
        {
            "benchmark": "compare controllers in many scenes",
            "bench": "time distance queries and control ticks on this computer",
        },
    ),
    Group(
        "Your own robot",
        "remosplat import-robot my_arm.urdf",
        {
            "import-robot": "prepare a robot from its URDF or other files",
            "fit-spheres": "cover a robot's links with spheres",
            "fit-hulls": "cut a robot's meshes into convex collision shapes",
        },
    ),
)
"""The groups, in the order in which they are shown."""

COMMANDS = {
    name: summary
    for group in GROUPS
    for name, summary in group.commands.items()
}
"""Purpose of each command in one line, keyed by the command's name."""


def overview() -> str:
    """Returns the help text on all commands, in lines of at most 80 columns."""
    width = max(map(len, COMMANDS))
    parts = [
        "usage: remosplat COMMAND ...\n\n"
        "Reactive mobile manipulation on Gaussian splats.\n"
    ]
    for group in GROUPS:
        lines = [f"{group.title}, as in `{group.example}`:"]
        lines += [
            f"  {name:{width}}  {summary}"
            for name, summary in group.commands.items()
        ]
        parts.append("\n".join(lines) + "\n")
    parts.append(
        "`remosplat COMMAND --help` explains one command, with examples;\n"
        "`remosplat --version` is the version.\n"
    )
    return "\n".join(parts)
