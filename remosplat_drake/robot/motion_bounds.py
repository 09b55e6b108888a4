"""Bounds the first and second derivatives of points of the robot.

The bounds hold for all configurations within the joint limits. Verification
relies on them between the configurations that it checks.
"""

import numpy as np

from remosplat_drake.robot import kinematics as kin


def jacobian_bound(
    tree: kin.KinematicTree,
    reach: np.ndarray,
    screws: tuple[np.ndarray, np.ndarray],
    body: np.ndarray,
    p_LP: np.ndarray,
) -> np.ndarray:
    """Bounds |dp_WP/du_j| of points P that are fixed to bodies L.

    Per radian, a revolute joint moves a point by at most the length of the
    links between joint and point. A prismatic joint moves a point by the length
    of its own motion.

    Args:
        tree: The robot's tree.
        reach: Largest absolute position of each joint, shape (n_q,) [m, rad].
        screws: For each command, the body of the tree that its joint moves, and
            whether the joint is revolute, shape (n_u,) each.
        body: The body of each of the n points, shape (n,).
        p_LP: The points in their bodies, shape (n, 3) [m].

    Returns:
        The bounds, shape (n, n_u) [m/rad or 1].
    """
    screw_body, screw_turns = screws
    bound = np.zeros((len(body), len(screw_body)))
    for i, length in enumerate(np.linalg.norm(p_LP, axis=1)):
        for link in reversed(tree.chain(body[i])):
            length += np.linalg.norm(tree.X_MB[link, :3, 3])
            columns = np.flatnonzero(screw_body == link)
            turning = screw_turns[columns]
            bound[i, columns] = np.where(turning, length, 1.0)
            length += travel(tree, reach, link)
            length += np.linalg.norm(tree.X_PF[link, :3, 3])
    return bound


def hessian_bound(
    bound: np.ndarray, turning: np.ndarray, moves: np.ndarray
) -> np.ndarray:
    """Bounds |d2p_WP / dq_j dq_k| of points P.

    For two revolute joints, the inner one rotates the axis of the outer one and
    the lever from it to the point, so the outer joint's Jacobian bound applies.
    A revolute joint rotates the unit vector of an outer prismatic joint. A
    prismatic joint rotates nothing.

    Args:
        bound: The points' `jacobian_bound`, shape (n, n_u).
        turning: Mask of the commands of revolute joints, shape (n_u,) bool.
        moves: Mask of the points that each command moves, shape (n, n_u) bool.

    Returns:
        The bounds, shape (n, n_u, n_u).
    """
    outer = np.minimum(bound[:, :, None], bound[:, None, :])
    both_move = moves[:, :, None] & moves[:, None, :]
    two_turn = turning[:, None] & turning[None, :]
    one_turns = turning[:, None] ^ turning[None, :]
    return np.where(two_turn, outer, 1.0 * (one_turns & both_move))


def travel(tree: kin.KinematicTree, reach: np.ndarray, link: int) -> float:
    """Returns the largest displacement of a body's inboard joint from zero [m].

    Args:
        tree: The robot's tree.
        reach: Largest absolute position of each joint, shape (n_q,) [m, rad].
        link: Index of the body in the tree.
    """
    if tree.kind[link] != kin.PRISMATIC:
        return 0.0
    position = tree.position[link]
    return float(abs(tree.offset[link]) if position < 0 else reach[position])
