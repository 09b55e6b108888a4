"""`SelfClearance`: what the robot keeps from itself, all along a path."""

import dataclasses as dc

import numpy as np

from remosplat_drake.controller.verification.kernels.pair_sweep import (
    pair_distances,
    pairs_keep_apart,
)
from remosplat_drake.controller.verification.stopping_path import StoppingPath
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.self_collision import (
    SelfCollisionPairs,
    self_collision_pairs,
)


@dc.dataclass(frozen=True, eq=False)
class SelfClearance:
    """Pairs of a robot's spheres, and the distance that they keep.

    Attributes:
        robot: The robot, with its spheres and kinematics.
        pairs: The p pairs of spheres that may meet.
        stopping: Stopping distance that the pairs keep [m].
        rate: Bounds on how fast the distances of each of l pairs of links
            change with each entry of the command, shape (l, n_u).
    """

    robot: RobotModel
    pairs: SelfCollisionPairs
    stopping: float
    rate: np.ndarray

    @staticmethod
    def make(robot: RobotModel, stopping: float) -> "SelfClearance":
        """Makes the self-clearance of all pairs that are worth watching.

        Args:
            robot: The robot, with its spheres and kinematics.
            stopping: Stopping distance that the pairs keep [m].
        """
        pairs = self_collision_pairs(robot, stopping)
        bound = robot.jacobian_bound
        first, second = bound[pairs.first], bound[pairs.second]
        # What carries both around leaves their distance as it is.
        one_moves = (first > 0.0) ^ (second > 0.0)
        rate = np.zeros((pairs.link_pair.max(initial=-1) + 1, robot.n_u))
        np.maximum.at(
            rate, pairs.link_pair, np.where(one_moves, first + second, 0.0)
        )
        return SelfClearance(robot, pairs, stopping, rate)

    def distances(self, p_WS: np.ndarray) -> np.ndarray:
        """Computes the distances between the surfaces of all pairs.

        Args:
            p_WS: Centres of all of the robot's spheres in W, shape (n, 3) [m].

        Returns:
            The distances plus the pairs' allowances, shape (p,) [m].
        """
        radius, pairs = self.robot.arrays[3], self.pairs
        return pair_distances(
            p_WS, radius, pairs.first, pairs.second, pairs.allowance
        )

    def is_kept(
        self, path: StoppingPath, distance: np.ndarray, tolerance: float
    ) -> bool:
        """Tells whether every pair keeps min(stopping, its present distance).

        Where the robot may be off the path, the stopping distance grows by as
        much as that may change a pair's distance.

        Pairs keep it at the path's `times`, and less a tolerance at all times
        in between, see `kernels/between_looks.py`.

        Args:
            path: The path of a command and its braking ramp.
            distance: Distances of all pairs at the start of the path, as
                `distances` returns them, shape (p,) [m].
            tolerance: How far below its level a distance may fall between the
                path's times [m].
        """
        pairs = self.pairs
        tube = self.rate @ (path.tube * path.peak)
        return pairs_keep_apart(
            self.robot.arrays,
            path.arrays,
            (pairs.first, pairs.second, pairs.link_pair, pairs.allowance),
            self.rate,
            distance,
            self.stopping + tube,
            tolerance,
        )
