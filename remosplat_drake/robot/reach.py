"""Computes the reach of a robot's arm from its shoulder."""

from functools import lru_cache

import numpy as np

from remosplat_drake.robot.kinematics import PRISMATIC, KinematicTree
from remosplat_drake.robot.robot_model import RobotModel


def shoulder(robot: RobotModel, q: np.ndarray, effector: int = 0) -> np.ndarray:
    """Returns the position p_W of an arm's first joint, shape (3,) [m].

    Args:
        robot: The robot.
        q: Configuration, shape (n_q,).
        effector: Index of the end effector that the arm carries.
    """
    parent, X_PF = _mount(robot, effector)
    return (robot.body_poses(q)[parent] @ X_PF)[:3, 3]


@lru_cache(maxsize=16)
def _mount(robot: RobotModel, effector: int) -> tuple[int, np.ndarray]:
    """Returns the body to which an arm is mounted, and the pose X_PF there."""
    tree, chain = robot.tree, robot.chains[effector]
    joint = chain.position[chain.position >= robot.n_q - len(robot.home)][0]
    first = _body_moved_by(robot, joint)
    return int(tree.parent[first]), tree.X_PF[first]


def arm_reach(robot: RobotModel) -> float:
    """Returns an upper bound on the arm's reach from its shoulder [m].

    It is the length of the straight arm, regardless of joint limits, up to the
    surface of its farthest sphere.
    """
    tree, first = robot.tree, _body_moved_by(robot, robot.n_q - len(robot.home))
    travel = np.maximum(abs(robot.position_lower), abs(robot.position_upper))
    model, reach = robot.spheres, 0.0
    for link, p_LS, radius in zip(
        model.links, model.p_LS, model.radius, strict=True
    ):
        chain = tree.chain(tree.index(link))
        if first not in chain:
            continue
        chain = chain[chain.index(first) :]
        length = sum(_length(tree, body, travel) for body in chain)
        length -= np.linalg.norm(tree.X_PF[first, :3, 3])
        reach = max(reach, length + np.linalg.norm(p_LS) + radius)
    return float(reach)


@lru_cache(maxsize=16)
def end_effector_reach(robot: RobotModel, effector: int = 0) -> float:
    """Returns the largest distance of an end effector from its shoulder [m].

    It is the sum of all links' lengths, regardless of joint limits.

    Args:
        robot: The robot.
        effector: Index of the end effector.
    """
    chain, first = robot.chains[effector], robot.n_q - len(robot.home)
    joints = np.flatnonzero(chain.position >= first)
    length = np.linalg.norm(chain.X_MF[joints[1:], :3, 3], axis=1).sum()
    slides = chain.position[joints[chain.kind[joints] == PRISMATIC]]
    travel = np.maximum(abs(robot.position_lower), abs(robot.position_upper))
    length += travel[slides].sum()
    if len(joints):
        length += np.linalg.norm(chain.X_ME[:3, 3])
    return float(length)


def beyond_reach(
    robot: RobotModel,
    q: np.ndarray,
    p_WT: np.ndarray,
    effector: int = 0,
    *,
    parked: bool = False,
) -> float:
    """Returns a lower bound on a point's distance beyond the reach [m].

    If the robot has a base that drives, only the height of the arm's first
    joint matters, since the base can drive to any x and y. A result of zero
    does not prove that the point is within reach.

    Args:
        robot: The robot.
        q: Configuration, shape (n_q,).
        p_WT: The point in W, shape (3,) [m].
        effector: Index of the end effector.
        parked: Whether all speeds of the base are limited to zero.
    """
    way = p_WT - shoulder(robot, q, effector)
    drives = robot.n_base and not parked
    distance = abs(way[2]) if drives else np.linalg.norm(way)
    return max(0.0, float(distance) - end_effector_reach(robot, effector))


def _body_moved_by(robot: RobotModel, joint: int) -> int:
    """Returns the body that the joint with an entry of q moves."""
    return int(np.flatnonzero(robot.tree.position == joint)[0])


def _length(tree: KinematicTree, body: int, travel: np.ndarray) -> float:
    """Largest distance between the origins of a body and its parent [m]."""
    length = np.linalg.norm(tree.X_PF[body, :3, 3])
    length += np.linalg.norm(tree.X_MB[body, :3, 3])
    if tree.kind[body] == PRISMATIC:
        joint = tree.position[body]
        length += abs(tree.offset[body]) if joint < 0 else travel[joint]
    return float(length)
