"""Names and sizes of the ports of every station, simulated or real.

A controller is connected to a station by these names, so it works with both
kinds of stations. Ports with names that begin with `cheat.` contain ground
truth, which only a simulation has. Code that runs on the robot must not read
these ports.
"""

import dataclasses as dc

from remosplat_drake.robot.robot_description import Hand, RobotDescription

INPUT, OUTPUT = "input", "output"
"""Directions of a port."""

WRIST_CAMERA_RGB = "wrist_camera.rgb"
"""Name of the output with the wrist camera's colour image."""
WRIST_CAMERA_DEPTH = "wrist_camera.depth"
"""Name of the output with the wrist camera's depth image [m]."""
MOVERS = "movers"
"""Name of the output with the `Movers`, if a station receives movers."""
STATUS = "status"
"""Name of the output with the `StationStatus`."""
CHEAT = "cheat."
"""Prefix of the names of outputs with ground truth."""
CHEAT_QUERY_OBJECT = "cheat.query_object"
"""Name of the output with the scene graph's query object (ground truth)."""
CHEAT_CONTACT = "cheat.contact"
"""Name of the output with the contact results (ground truth)."""
CHEAT_OBJECTS = "cheat.objects"
"""Name of the output with the objects at their present poses (ground truth)."""

BASE_COMMAND = "base.velocity_commanded"
"""Name of the input with the base's commanded speeds [m/s, rad/s]."""
BASE_POSE = "base.pose_measured"
"""Name of the output with the base's pose x, y, yaw in W [m, m, rad]."""
BASE_VELOCITY = "base.velocity_measured"
"""Name of the output with the base's measured speeds [m/s, rad/s]."""


@dc.dataclass(frozen=True)
class Port:
    """A port of a station, the Drake diagram that represents the hardware.

    Attributes:
        name: Name of the port in the diagram.
        direction: `INPUT` or `OUTPUT`.
        size: Length of a vector-valued port; None for an abstract-valued one.
        content: Description of the port's values, with units.
    """

    name: str
    direction: str
    size: int | None
    content: str


def arm_command(description: RobotDescription) -> str:
    """Returns the name of the input for an arm's commanded joint rates."""
    return f"{description.arm.name}.velocity_commanded"


def arm_position(description: RobotDescription) -> str:
    """Returns the name of the output with an arm's joint positions."""
    return f"{description.arm.name}.position_measured"


def arm_velocity(description: RobotDescription) -> str:
    """Returns the name of the output with an arm's measured joint rates."""
    return f"{description.arm.name}.velocity_measured"


def hand_command(hand: Hand) -> str:
    """Returns the name of a hand's command input."""
    return f"{hand.name}.command"


def hand_state(hand: Hand) -> str:
    """Returns the name of a hand's state output."""
    return f"{hand.name}.state"


def station_ports(
    description: RobotDescription, wrist_camera: bool
) -> list[Port]:
    """Lists the ports that every station of a robot has.

    Args:
        description: Description of the robot. A robot without a mobile base has
            no `base` ports. Each gripper has its own `hand` ports.
        wrist_camera: Whether the station has a wrist camera.
    """
    n = len(description.arm.joints)
    ports = []
    if description.base:
        left = "left, " if description.n_base == 3 else ""
        speeds = f"forward, {left}yaw rate [m/s, rad/s]"
        ports += [
            Port(BASE_COMMAND, INPUT, description.n_base, speeds),
            Port(BASE_POSE, OUTPUT, 3, "x, y, yaw in W [m, m, rad]"),
            Port(BASE_VELOCITY, OUTPUT, description.n_base, speeds),
        ]
    ports += [
        Port(arm_command(description), INPUT, n, "joint rates [rad/s]"),
        Port(arm_position(description), OUTPUT, n, "joint positions [rad]"),
        Port(arm_velocity(description), OUTPUT, n, "joint rates [rad/s]"),
    ]
    for hand in description.effector_hands.values():
        state = "width, rate, force [m, m/s, N]"
        ports += [
            Port(hand_command(hand), INPUT, 2, "width, force [m, N]"),
            Port(hand_state(hand), OUTPUT, 3, state),
        ]
    if wrist_camera:
        ports += [
            Port(WRIST_CAMERA_RGB, OUTPUT, None, "ImageRgba8U"),
            Port(WRIST_CAMERA_DEPTH, OUTPUT, None, "ImageDepth32F [m]"),
        ]
    return [*ports, Port(STATUS, OUTPUT, None, "StationStatus")]
