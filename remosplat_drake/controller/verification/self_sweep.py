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
        robot: The robot.
        pairs: Pairs that may meet.
        stopping: Distance that they keep [m].
        rate: Bounds on how fast the distances of each pair of links change
            with each command, shape (l, n_u).
    """

    robot: RobotModel
    pairs: SelfCollisionPairs
    stopping: float
    rate: np.ndarray

    @staticmethod
    def make(robot: RobotModel, stopping: float) -> "SelfClearance":
        """The clearance of all pairs that are worth watching.

        Args:
            robot: The robot.
            stopping: Distance that they keep [m].
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
        """Between the surfaces of all pairs, plus allowances, shape (p,) [m].

        Args:
            p_WS: Centres of all spheres, shape (n, 3) [m].
        """
        radius, pairs = self.robot.arrays[3], self.pairs
        return pair_distances(
            p_WS, radius, pairs.first, pairs.second, pairs.allowance
        )

    def is_kept(
        self, path: StoppingPath, distance: np.ndarray, tolerance: float
    ) -> bool:
        """Whether every pair keeps min(stopping, its present distance).

        It does so at the path's `times`, and less a tolerance at all times on
        it: see `kernels/between_looks.py`.

        Args:
            path: The path.
            distance: Of all pairs where it starts, as `distances` has it,
                shape (p,) [m].
            tolerance: See above [m].
        """
        pairs = self.pairs
        return pairs_keep_apart(
            self.robot.arrays,
            path.arrays,
            (pairs.first, pairs.second, pairs.link_pair, pairs.allowance),
            self.rate,
            distance,
            self.stopping,
            tolerance,
        )
