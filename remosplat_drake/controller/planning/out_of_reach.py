"""Targets that no configuration reaches, by the lengths of the arms alone."""

import numpy as np

from remosplat_drake.robot.kinematics import PRISMATIC
from remosplat_drake.robot.reach import shoulder
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.serial_chain import SerialChain
from remosplat_drake.signals.aim import Aim


def out_of_reach(robot: RobotModel, aim: Aim, q: np.ndarray) -> str:
    """Tells why an aim is out of reach; empty if that is not proved.

    No point of an arm is farther from its first joint than all its links are
    long together. A base drives on a plane, so that the height of that joint
    is known.

    Args:
        robot: The robot.
        aim: What the end effectors shall reach.
        q: Where the robot is, shape (n_q,) [rad, m].
    """
    first = robot.n_q - len(robot.home)
    for effector, target in aim.items:
        if not target.weights[3:].all():
            continue
        chain = robot.chains[effector]
        length = _length(robot, chain, first)
        away = target.X_WT[:3, 3] - shoulder(robot, q, effector)
        words = "from"
        if robot.n_base:
            away, words = away[2:], "above" if away[2] > 0.0 else "below"
        distance = float(np.linalg.norm(away))
        if distance > length:
            return (
                f"no configuration reaches it: it is {distance:.2f} m {words}"
                f" the arm's first joint, and the arm is {length:.2f} m long"
            )
    return ""


def _length(robot: RobotModel, chain: SerialChain, first: int) -> float:
    """Returns how long an arm is from its first joint on, laid out [m]."""
    joints = np.flatnonzero(chain.position >= first)
    length = np.linalg.norm(chain.X_MF[joints[1:], :3, 3], axis=1).sum()
    slides = chain.position[joints[chain.kind[joints] == PRISMATIC]]
    travel = np.maximum(abs(robot.position_lower), abs(robot.position_upper))
    length += travel[slides].sum()
    if len(joints):
        length += np.linalg.norm(chain.X_ME[:3, 3])
    return float(length)
