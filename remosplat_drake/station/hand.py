"""The gripper: its joints, its width, and how the width follows a command."""

import dataclasses as dc

from pydrake.multibody.plant import MultibodyPlant

from remosplat_drake.robot.robot_description import RobotDescription

SETTLING_TIME = 0.05
"""Time constant of the last millimetres before the commanded width [s]."""


@dc.dataclass(frozen=True, eq=False)
class HandGeometry:
    """A gripper whose width is the sum of its finger positions.

    Attributes:
        joints: Names of the finger joints; empty for a robot without hand.
        max_width: Largest opening [m].
        start_width: Opening at the start, as the description locks it [m].
    """

    joints: tuple[str, ...]
    max_width: float
    start_width: float


def hand_geometry(
    description: RobotDescription, plant: MultibodyPlant
) -> HandGeometry:
    """Reads the gripper off a plant that holds the robot."""
    names = tuple(description.hand.joints) if description.hand else ()
    upper = {
        name: float(plant.GetJointByName(name).position_upper_limits()[0])
        for name in names
    }
    start = [description.locked.get(name, upper[name]) for name in names]
    return HandGeometry(names, sum(upper.values()), sum(start))


def width_rate(
    width: float, target: float, hand: HandGeometry, speed: float
) -> float:
    """Rate of the gripper's width [m/s]: full speed, then a soft arrival.

    Args:
        width: Present width [m].
        target: Commanded width, held to what the gripper can reach [m].
        hand: The gripper.
        speed: Bound on the rate [m/s].
    """
    target = min(max(target, 0.0), hand.max_width)
    return min(max((target - width) / SETTLING_TIME, -speed), speed)
