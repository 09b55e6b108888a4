"""`hand_links`: finds the links of a hand from the links' names."""

from remosplat_drake.robot import kinematics as kin
from remosplat_drake.robot.robot_model import RobotModel


def hand_links(robot: RobotModel, effector: int = 0) -> frozenset[str]:
    """Returns the names of the links of a hand: its fingers and its palm.

    Fingers are the bodies at joints that no command moves, beyond the last
    joint of the arm. If there are no fingers, the hand is the link of the end
    effector.

    Args:
        robot: The robot.
        effector: Index of the end effector.
    """
    tree = robot.tree
    end = int(robot.arrays.values.body_E[effector])
    moved = [b for b in tree.chain(end) if tree.position[b] >= 0]
    fingers = [
        body
        for body in range(len(tree.names))
        if tree.kind[body] != kin.FIXED
        and tree.position[body] < 0
        and moved[-1] in tree.chain(body)
    ]
    links = {*fingers, *(int(tree.parent[body]) for body in fingers)} or {end}
    return frozenset(tree.names[body] for body in links)
