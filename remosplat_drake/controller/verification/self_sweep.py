"""`SelfClearance`: the pairs of shapes that verification keeps apart."""

import dataclasses as dc
from functools import cached_property, lru_cache

import numpy as np

from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.base.lanes import WIDTH
from remosplat_drake.controller.verification.kernels.verified import (
    SelfCollisionArrays,
)
from remosplat_drake.robot.motion_bounds import hessian_bound
from remosplat_drake.robot.relative_motion import levers
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.self_collision.pair_arrays import PairArrays
from remosplat_drake.robot.self_collision.pairs import (
    SelfCollisionPairs,
    self_collision_pairs,
)
from remosplat_drake.robot.self_collision.shapes import CollisionShapes


@lru_cache(maxsize=16)
def no_self_collision_arrays(robot: RobotModel) -> Packed[SelfCollisionArrays]:
    """Returns arrays without pairs, for a robot without self-collision checks.

    Args:
        robot: The robot.
    """
    no_index = np.zeros(0, np.int64)
    no_shapes = CollisionShapes((), ()).arrays(no_index)
    no_boxes = np.zeros((0, 2), np.int64)
    pairs = PairArrays(
        *(no_index, no_index, np.zeros(1, np.int64), np.zeros(0)),
        *(no_boxes, no_shapes, no_shapes),
    )
    no_rate = np.zeros((0, robot.n_u))
    return Packed(
        SelfCollisionArrays(pairs, no_rate, no_rate, robot.screw_turns)
    )


@dc.dataclass(frozen=True, eq=False)
class SelfClearance:
    """Pairs of a robot's convex shapes, and the distance that they keep.

    Attributes:
        robot: The robot, with its kinematics.
        pairs: The k pairs of shapes that may collide.
        stopping: Stopping distance that the pairs keep [m].
        lever: The result of `relative_motion.levers` for each of l pairs of
            links, shape (l, n_u) [m].
        rate: Bounds of the rate at which the distance of each pair of links
            changes, per entry of the command, shape (l, n_u).
    """

    robot: RobotModel
    pairs: SelfCollisionPairs
    stopping: float
    lever: np.ndarray
    rate: np.ndarray

    @staticmethod
    def make(robot: RobotModel, stopping: float) -> "SelfClearance":
        """Makes the object for all pairs of shapes that are checked.

        Args:
            robot: The robot, with its kinematics.
            stopping: Stopping distance that the pairs keep [m].
        """
        pairs = self_collision_pairs(robot, stopping)
        links = pairs.pairs.links
        lever = np.array([levers(robot, a, b) for a, b in links])
        lever = lever.reshape(-1, robot.n_u)
        shapes = pairs.shapes
        size = [
            max(np.linalg.norm(s.vertices, axis=1).max() for s in shapes.of(b))
            for _, b in links
        ]
        arm = lever + np.array(size).reshape(-1, 1)
        rate = np.where(robot.screw_turns, arm, lever)
        return SelfClearance(
            robot, pairs, stopping, lever, np.where(lever < 0.0, 0.0, rate)
        )

    @cached_property
    def arrays(self) -> Packed[SelfCollisionArrays]:
        """The pairs and the bounds of their approach, packed for kernels."""
        return Packed(
            SelfCollisionArrays(
                self.pairs.pair_arrays.values,
                self.rate,
                self.lever,
                self.robot.screw_turns,
            )
        )

    @cached_property
    def bend(self) -> np.ndarray:
        """Bounds of the acceleration of one link relative to another.

        The array has the shape (n_u, n_u, m), with a bound for each two entries
        of the command and each pair of links. In the last dimension, it is
        padded, so that kernels can read eight numbers at a time.
        """
        bound = hessian_bound(
            self.rate, self.robot.screw_turns, self.lever >= 0.0
        )
        missing = -len(bound) % WIDTH
        bound = np.pad(bound, ((0, missing), (0, 0), (0, 0)))
        return np.ascontiguousarray(bound.transpose(1, 2, 0))

    def distances(self, q: np.ndarray, enough: float = np.inf) -> np.ndarray:
        """Computes the distances of all pairs of shapes.

        Args:
            q: Configuration, shape (n_q,) [rad, m].
            enough: Distance above which a lower bound is sufficient [m].

        Returns:
            The distances plus the allowances of the pairs, shape (k,) [m].
        """
        return self.pairs.distances(q, enough)
