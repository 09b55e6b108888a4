"""Two arms of which one is the other's mirror image."""

import dataclasses as dc

import numpy as np

from remosplat_drake.robot.robot_model import RobotModel

_SAME = 1e-3
"""How far axes of joints may be from mirrored ones [m], and how much their
directions may differ."""

_ACROSS = np.array([1.0, -1.0, 1.0])
"""The mirror is upright and faces left and right, as two arms do."""


@dc.dataclass(frozen=True, eq=False)
class Mirror:
    """The mirror image of each posture of n arm joints.

    Attributes:
        twin: The joint that each takes its position from, shape (n,).
        sign: Factor on that position, 1 or -1, shape (n,).
    """

    twin: np.ndarray
    sign: np.ndarray

    def image(self, q_arm: np.ndarray) -> np.ndarray:
        """Mirrors a posture, shape (n,) [rad, m]."""
        return self.sign * q_arm[self.twin]

    def symmetric(self, q_arm: np.ndarray) -> np.ndarray:
        """Makes a posture its own image: one arm does as the other one does.

        Joints that carry both arms go to zero if they would turn them to one
        side.

        Args:
            q_arm: The posture, shape (n,) [rad, m].
        """
        first = np.arange(len(self.twin)) <= self.twin
        alone = (self.twin == np.arange(len(self.twin))) & (self.sign < 0)
        both = np.where(first, q_arm, self.image(q_arm))
        return np.where(alone, 0.0, both)


def find_mirror(robot: RobotModel) -> Mirror | None:
    """Finds out whether a robot's two arms are mirror images.

    They are if the axis of each joint of one lies where the mirror has that of
    a joint of the other, all joints being at zero. The mirror stands between
    their first joints.

    Args:
        robot: The robot.

    Returns:
        The mirror; None if there is none, or not two arms.
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
        # The mirror image of a turn to the left is one to the right.
        twin[b], sign[b] = a, np.sign(along) * (-1.0 if turns[a] else 1.0)
    return None if (twin < 0).any() else Mirror(twin, sign)


def _joints(robot: RobotModel, body: int) -> list[int]:
    """The arm's joints that move a body, from the root on."""
    first = robot.n_q - len(robot.home)
    positions = robot.tree.position[robot.tree.chain(body)]
    return [int(i) - first for i in positions if i >= first]
