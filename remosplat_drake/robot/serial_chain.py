"""`SerialChain`: the joints from the world to an end effector.

Inverse kinematics evaluates only the end effector, thousands of times. For
speed, fixed transforms between two joints are merged, and other branches of the
tree are omitted.
"""

from typing import NamedTuple

import numpy as np

from remosplat_drake.robot import kinematics as kin


class SerialChain(NamedTuple):
    """The n joints that move an end effector E, from the base outwards.

    Attributes:
        kind: `kinematics.REVOLUTE` or PRISMATIC, shape (n,).
        position: Index in q of each joint, shape (n,).
        axis_F: Axes in the joints' inboard frames F, shape (n, 3).
        X_MF: Pose of each joint's inboard frame F in the outboard frame M of
            the previous joint, or in W for the first joint, shape (n, 4, 4).
        X_ME: Pose of E in the frame M of the last joint, shape (4, 4).
    """

    kind: np.ndarray
    position: np.ndarray
    axis_F: np.ndarray
    X_MF: np.ndarray
    X_ME: np.ndarray

    @staticmethod
    def make(
        tree: kin.KinematicTree, body_E: int, X_LE: np.ndarray
    ) -> "SerialChain":
        """Makes the chain to an end effector.

        Args:
            tree: The robot's tree.
            body_E: Body that carries the end effector.
            X_LE: Pose of the end effector in that body, shape (4, 4).
        """
        outward = tree.chain(body_E)
        joints = [body for body in outward if tree.position[body] >= 0]
        X_MF, X = [], np.eye(4)
        for body in outward:
            X = X @ tree.X_PF[body]
            if body in joints:
                X_MF.append(X)
                X = np.eye(4)
            elif tree.kind[body] != kin.FIXED:
                X_FM = np.zeros((4, 4))
                kin.joint_pose(
                    tree.kind[body],
                    tree.axis_F[body],
                    tree.offset[body],
                    X_FM,
                )
                X = X @ X_FM
            X = X @ tree.X_MB[body]
        return SerialChain(
            tree.kind[joints],
            tree.position[joints],
            tree.axis_F[joints],
            np.array(X_MF),
            X @ X_LE,
        )
