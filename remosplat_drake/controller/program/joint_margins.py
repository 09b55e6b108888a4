"""Computes influence and stopping distances of joints from their limits."""

import numpy as np

from remosplat_drake.robot.robot_model import RobotModel

INFLUENCE_SHARE = 1 / 3
"""An influence distance is at most this fraction of a joint's range."""

STOP_SHARE = 1 / 10
"""A stopping distance is at most this fraction of a joint's range."""


def joint_margins(
    robot: RobotModel, hinge: float, slide: float, share: float
) -> np.ndarray:
    """Computes the arm's influence or stopping distances, shape (n_arm,).

    Args:
        robot: The robot, for the kinds and ranges of its joints.
        hinge: Distance of a revolute joint from its limits [rad].
        slide: Distance of a prismatic joint from its limits [m].
        share: The distance is at most this fraction of a joint's range.

    Returns:
        The distance of each joint, which is the same at both of its limits
        [rad, m].
    """
    arm = slice(robot.n_q - (robot.n_u - robot.n_base), robot.n_q)
    extent = robot.position_upper[arm] - robot.position_lower[arm]
    return np.minimum(np.where(robot.arm_turns, hinge, slide), share * extent)
