"""Simulates grippers: their joints, and their motion to a commanded width."""

import dataclasses as dc
from collections.abc import Sequence

from pydrake.multibody.plant import MultibodyPlant

from remosplat_drake.robot.model_file import add_robot_model
from remosplat_drake.robot.robot_description import Hand, RobotDescription
from remosplat_drake.robot.robot_model import RobotModel

SETTLING_TIME = 0.05
"""Time constant with which the width approaches the commanded width [s]."""


@dc.dataclass(frozen=True, eq=False)
class HandGeometry:
    """A gripper whose opening width is the sum of its finger positions.

    Attributes:
        hand: The gripper's description, which names its ports.
        joints: Names of the finger joints.
        max_width: Greatest opening [m].
        start_width: Opening at the start [m], from the robot's description.
    """

    hand: Hand
    joints: tuple[str, ...]
    max_width: float
    start_width: float


def hand_geometries(
    description: RobotDescription, plant: MultibodyPlant
) -> tuple[HandGeometry, ...]:
    """Reads the geometry of a robot's grippers from a plant with the robot.

    Args:
        description: Description of the robot.
        plant: A plant with the robot's joints.

    Returns:
        The grippers, in the order of `effector_hands`.
    """
    hands = description.effector_hands.values()
    return tuple(_geometry(hand, description.locked, plant) for hand in hands)


def robot_hands(robot: RobotModel) -> dict[int, HandGeometry]:
    """Returns the geometry of each end effector's gripper.

    Args:
        robot: The robot, with or without grippers.
    """
    plant = MultibodyPlant(0.0)
    add_robot_model(robot.description, plant)
    plant.Finalize()
    hands = hand_geometries(robot.description, plant)
    effectors = map(robot.effectors.index, robot.description.effector_hands)
    return dict(zip(effectors, hands, strict=True))


def finger_slices(
    hands: Sequence[HandGeometry], first: int
) -> tuple[slice, ...]:
    """Returns the indices of each gripper's fingers in a list of all joints.

    Args:
        hands: The grippers.
        first: Index of the first finger.
    """
    slices = []
    for hand in hands:
        slices.append(slice(first, first + len(hand.joints)))
        first += len(hand.joints)
    return tuple(slices)


def finger_joints(hands: Sequence[HandGeometry]) -> tuple[str, ...]:
    """Returns the names of the joints of all fingers.

    Args:
        hands: The grippers.
    """
    return tuple(name for hand in hands for name in hand.joints)


def _geometry(
    hand: Hand, locked: dict[str, float], plant: MultibodyPlant
) -> HandGeometry:
    names = tuple(hand.joints)
    upper = {
        name: float(plant.GetJointByName(name).position_upper_limits()[0])
        for name in names
    }
    start = [locked.get(name, upper[name]) for name in names]
    return HandGeometry(hand, names, sum(upper.values()), sum(start))


def width_rate(
    width: float, target: float, hand: HandGeometry, speed: float
) -> float:
    """Returns the rate of a gripper's width [m/s].

    The rate is proportional to the error of the width, and limited to `speed`.

    Args:
        width: Present width [m].
        target: Commanded width [m], which is clamped to the gripper's range.
        hand: Geometry of the gripper.
        speed: Greatest rate of the width [m/s].
    """
    target = min(max(target, 0.0), hand.max_width)
    return min(max((target - width) / SETTLING_TIME, -speed), speed)
