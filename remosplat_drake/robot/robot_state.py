"""`RobotState`: the kinematics of one configuration, computed together."""

import dataclasses as dc
from functools import cached_property

import numpy as np

from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.robot import kinematics as kin
from remosplat_drake.robot.robot_arrays import RobotArrays, StateArrays
from remosplat_drake.robot.sphere_model import Spheres


@dc.dataclass(frozen=True, eq=False)
class RobotState:
    """All kinematic quantities of one configuration, computed together.

    Attributes:
        arrays: Most of the quantities, packed for kernels.
        spheres: The robot's spheres in W.
        robot: The robot, packed for kernels.
    """

    arrays: StateArrays
    spheres: Spheres
    robot: Packed[RobotArrays]

    @cached_property
    def Jv_WS(self) -> np.ndarray:
        """Translational Jacobians of the sphere centres, (n, 3, n_u)."""
        return self.point_jacobians(self.robot.body_S, self.arrays.p_WS)

    def point_jacobians(self, body: np.ndarray, p_W: np.ndarray) -> np.ndarray:
        """Computes the translational Jacobians of points of the robot.

        Args:
            body: The body of the robot's tree to which each point is fixed,
                shape (n,).
            p_W: The points in W, shape (n, 3) [m].

        Returns:
            The Jacobians in W, shape (n, 3, n_u).
        """
        robot = self.robot
        return kin.point_jacobians(
            *self.screws_W, robot.screw_turns, robot.moves, body, p_W
        )

    @property
    def X_WB(self) -> np.ndarray:
        """Pose of the base body, a 4x4 matrix (identity if fixed)."""
        return self.arrays.X_WL[self.robot.body_B]

    @property
    def q(self) -> np.ndarray:
        """Configuration, shape (n_q,)."""
        return self.arrays.q

    @property
    def X_WEs(self) -> np.ndarray:
        """Poses of all e end effectors, shape (e, 4, 4)."""
        return self.arrays.X_WE

    @property
    def X_WE(self) -> np.ndarray:
        """Pose of the first end effector, a 4x4 matrix."""
        return self.arrays.X_WE[0]

    @property
    def Jv_WE(self) -> np.ndarray:
        """Translational Jacobian of the first E in W, shape (3, n_u)."""
        return self.arrays.Jv_WE[0]

    @property
    def Jw_WE(self) -> np.ndarray:
        """Angular Jacobian of the first end effector in W, shape (3, n_u)."""
        return self.arrays.Jw_WE[0]

    def J_WE(self, effector: int) -> np.ndarray:
        """Returns an end effector's Jacobian in W, angular first, (6, n_u).

        Args:
            effector: Index of the end effector.
        """
        arrays = self.arrays
        return np.concatenate([arrays.Jw_WE[effector], arrays.Jv_WE[effector]])

    @property
    def X_WL(self) -> np.ndarray:
        """Poses of all bodies of the robot's tree, shape (b, 4, 4)."""
        return self.arrays.X_WL

    @property
    def screws_W(self) -> tuple[np.ndarray, np.ndarray]:
        """Axes of the commands' screws in W, and a point on each, (n_u, 3)."""
        return self.arrays.a_W, self.arrays.o_W
