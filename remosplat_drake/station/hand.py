"""The simulated gripper: its joints, and how its width follows a command."""

import dataclasses as dc

from pydrake.multibody.plant import MultibodyPlant

from remosplat_drake.robot.robot_description import RobotDescription

SETTLING_TIME = 0.05
"""Time constant of the last millimetres before the commanded width [s]."""


@dc.dataclass(frozen=True, eq=False)
class HandGeometry:
    """A gripper whose opening width is the sum of its finger positions.

    Attributes:
        joints: Names of the finger joints; empty for a robot without hand.
        max_width: Greatest opening [m].
        start_width: Opening at the start [m], as the robot's description
            has it.
    """

    joints: tuple[str, ...]
    max_width: float
    start_width: float


def hand_geometry(
    description: RobotDescription, plant: MultibodyPlant
) -> HandGeometry:
    """Reads the gripper's geometry off a plant that holds the robot.

    Args:
        description: Description of the robot.
        plant: A plant with the robot's joints.
    """
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
    """Returns the rate of the gripper's width: full speed, soft arrival [m/s].

    Args:
        width: Present width [m].
        target: Commanded width [m]; it is clamped to the gripper's range.
        hand: Geometry of the gripper.
        speed: Greatest rate [m/s].
    """
    target = min(max(target, 0.0), hand.max_width)
    return min(max((target - width) / SETTLING_TIME, -speed), speed)
