"""Detects a robot whose two arms are mirror images of each other."""

import dataclasses as dc

import numpy as np

from remosplat_drake.robot.robot_model import RobotModel

_SAME = 1e-3
"""A joint axis is the mirror image of another axis if it is at most this far
from the mirrored axis [m], and if the cosine of the angle between the two
differs from 1 or -1 by at most this.
"""

_ACROSS = np.array([1.0, -1.0, 1.0])
"""The mirror plane is vertical, with a normal to the left."""


@dc.dataclass(frozen=True, eq=False)
class Mirror:
    """The mapping of a posture of n arm joints to its mirror image.

    Attributes:
        twin: For each joint, the index of its mirror image, shape (n,).
        sign: Factor on the position of the mirror image, 1 or -1, shape (n,).
    """

    twin: np.ndarray
    sign: np.ndarray

    def image(self, q_arm: np.ndarray) -> np.ndarray:
        """Mirrors a posture, shape (n,) [rad, m]."""
        return self.sign * q_arm[self.twin]

    def symmetric(self, q_arm: np.ndarray) -> np.ndarray:
        """Makes a posture symmetric: the second arm mirrors the first arm.

        Joints that carry both arms go to zero if they would turn the arms to
        one side.

        Args:
            q_arm: The posture, shape (n,) [rad, m].
        """
        first = np.arange(len(self.twin)) <= self.twin
        alone = (self.twin == np.arange(len(self.twin))) & (self.sign < 0)
        both = np.where(first, q_arm, self.image(q_arm))
        return np.where(alone, 0.0, both)


def find_mirror(robot: RobotModel) -> Mirror | None:
    """Finds the mirror symmetry of a robot's two arms; None if there is none.

    The arms are mirror images if, with all joints at zero, the mirror maps the
    axis of each joint of one arm to the axis of a joint of the other. The
    mirror is halfway between the first joints of the two arms.

    Args:
        robot: The robot.

    Returns:
        The mirror; None if there are not two arms, or if they are not mirror
        images.
    """
    bodies = robot.arrays.values.body_E
    chains = [_joints(robot, int(body)) for body in bodies]
    if len(chains) != 2 or len(chains[0]) != len(chains[1]):
        return None
    ends = [
        [i for i in chain if i not in other]
        for chain, other in (chains, chains[::-1])
    ]
    if not all(ends):
        return None
    state = robot.state(np.zeros(robot.n_q)).arrays
    axis, origin = state.a_W[robot.n_base :], state.o_W[robot.n_base :]
    turns = robot.arm_turns
    shoulders = origin[[end[0] for end in ends]]
    middle = np.array([0.0, shoulders[:, 1].mean(), 0.0])
    twin, sign = np.full(len(axis), -1), np.zeros(len(axis))
    for a, b in (*zip(*chains, strict=True), *zip(*chains[::-1], strict=True)):
        mirrored = _ACROSS * axis[a]
        way = middle + _ACROSS * (origin[a] - middle) - origin[b]
        along = float(axis[b] @ mirrored)
        off = np.linalg.norm(np.cross(way, axis[b])) if turns[a] else 0.0
        if (
            turns[a] != turns[b]
            or abs(along) < 1.0 - _SAME
            or off > _SAME
            or twin[b] not in (-1, a)
        ):
            return None
        # The mirror image of a turn to the left is a turn to the right.
        twin[b], sign[b] = a, np.sign(along) * (-1.0 if turns[a] else 1.0)
    return None if (twin < 0).any() else Mirror(twin, sign)


def _joints(robot: RobotModel, body: int) -> list[int]:
    """Returns the arm's joints that move a body, from the root outwards."""
    first = robot.n_q - len(robot.home)
    positions = robot.tree.position[robot.tree.chain(body)]
    return [int(i) - first for i in positions if i >= first]
