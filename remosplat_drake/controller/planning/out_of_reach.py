"""Detects targets that are out of reach, by the lengths of the arms."""

import numpy as np

from remosplat_drake.robot.reach import beyond_reach, end_effector_reach
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.aim import Aim


def out_of_reach(robot: RobotModel, aim: Aim, q: np.ndarray) -> str:
    """Returns why a target is out of reach; empty if all may be within reach.

    Args:
        robot: The robot.
        aim: The targets of the end effectors.
        q: Present configuration, shape (n_q,) [rad, m].
    """
    for effector, target in aim.items:
        if not target.constrains_full_position:
            continue
        lacking = beyond_reach(robot, q, target.X_WT[:3, 3], effector)
        if lacking > 0.0:
            length = end_effector_reach(robot, effector)
            return (
                f"the target is {lacking:.2f} m out of reach of the arm, which"
                f" is {length:.2f} m long; move the target"
            )
    return ""
