"""`HandSpheres`: the spheres of an open hand, to test poses of the hand."""

import dataclasses as dc

import numpy as np

from remosplat_drake.grasping.gripper import ParallelGripper
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.distance_field import DistanceField


@dc.dataclass(frozen=True, eq=False)
class HandSpheres:
    """The spheres of an open hand in its end effector's frame E.

    Attributes:
        p_ES: Centres of the spheres, shape (n, 3) [m].
        radius: Radii of the spheres, shape (n,) [m].
    """

    p_ES: np.ndarray
    radius: np.ndarray

    @staticmethod
    def of(gripper: ParallelGripper) -> "HandSpheres":
        """Reads the spheres of a fully open gripper."""
        robot = gripper.robot.with_hand_width(gripper.max_width)
        hand = robot.leading_spheres
        spheres = robot.spheres_at(robot.q_home).select(hand)
        X_WE = robot.end_effector_pose(robot.q_home)
        p_ES = (spheres.p_WS - X_WE[:3, 3]) @ X_WE[:3, :3]
        return HandSpheres(p_ES, spheres.radius)

    def keeps(
        self, field: DistanceField, X_WE: np.ndarray, distance: float
    ) -> bool:
        """Returns whether the hand keeps a distance from the map.

        Args:
            field: Distances to the map.
            X_WE: Pose of the end effector, shape (4, 4).
            distance: The distance [m].
        """
        p_WS = self.p_ES @ X_WE[:3, :3].T + X_WE[:3, 3]
        spheres = Spheres.at(p_WS, self.radius)
        found = field.clearances(spheres, distance + 0.01)
        return bool(found.minimum() > distance)
