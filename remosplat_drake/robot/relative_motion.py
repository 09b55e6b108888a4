"""Bounds the motion of one link of the robot relative to another link."""

import numpy as np

from remosplat_drake.robot.motion_bounds import travel
from remosplat_drake.robot.robot_model import RobotModel


def levers(robot: RobotModel, link_A: str, link_B: str) -> np.ndarray:
    """Bounds the distances of B's origin from the joints between A and B.

    Relative to A, a revolute joint between the two carries B around its axis.
    The largest lever is the length of the links between the axis and B, if they
    are stretched out. Joints that move both links together do not count.

    Args:
        robot: The robot.
        link_A: Name of the reference link.
        link_B: Name of the link whose motion is bounded.

    Returns:
        One length for each command, shape (n_u,) [m]: the bound for revolute
        joints, 1 for prismatic joints, and -1 for joints that are not between A
        and B.
    """
    tree = robot.tree
    outward_A = tree.chain(tree.index(link_A))
    outward_B = tree.chain(tree.index(link_B))
    found = np.full(robot.n_u, -1.0)
    length = 0.0

    def note(body: int) -> None:
        moved = robot.screw_body == body
        found[moved] = np.where(robot.screw_turns[moved], length, 1.0)

    for body in reversed([x for x in outward_B if x not in outward_A]):
        length += float(np.linalg.norm(tree.X_MB[body, :3, 3]))
        note(body)
        length += travel(tree, robot.joint_reach, body)
        length += float(np.linalg.norm(tree.X_PF[body, :3, 3]))
    for body in [x for x in outward_A if x not in outward_B]:
        length += float(np.linalg.norm(tree.X_PF[body, :3, 3]))
        note(body)
        length += travel(tree, robot.joint_reach, body)
        length += float(np.linalg.norm(tree.X_MB[body, :3, 3]))
    return found
