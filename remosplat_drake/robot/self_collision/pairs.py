"""Computes distances of pairs of the robot's convex shapes."""

import dataclasses as dc
from functools import cached_property, lru_cache

import numpy as np

from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.self_collision.kernels.all_distances import (
    pair_distances,
)
from remosplat_drake.robot.self_collision.kernels.near_points import near_points
from remosplat_drake.robot.self_collision.link_pairs import (
    LinkPairs,
    find_link_pairs,
)
from remosplat_drake.robot.self_collision.pair_arrays import PairArrays
from remosplat_drake.robot.self_collision.shape_pairs import ShapePairs
from remosplat_drake.robot.self_collision.shapes import (
    CollisionShapes,
    read_collision_shapes,
)

# Shapes that overlap at home may overlap by this much more elsewhere [m].
_WOBBLE = 0.005


@dc.dataclass(frozen=True, eq=False)
class NearPoints:
    """m pairs of points at which links of the robot are near each other.

    Attributes:
        pair: Index of the pair of shapes that each pair of points is on, shape
            (m,).
        distance: Distance along the normal plus the pair's allowance, shape
            (m,) [m].
        normal_W: Unit vectors from the first link to the second, in W, shape
            (m, 3).
        p_WA: The points on the first link, shape (m, 3) [m].
        p_WB: The points on the second link, shape (m, 3) [m].
    """

    pair: np.ndarray
    distance: np.ndarray
    normal_W: np.ndarray
    p_WA: np.ndarray
    p_WB: np.ndarray

    def __len__(self) -> int:
        return len(self.pair)


@dc.dataclass(frozen=True, eq=False)
class SelfCollisionPairs:
    """All k pairs of the robot's convex shapes that are checked.

    Attributes:
        robot: The robot.
        shapes: The robot's convex shapes.
        found: The checked pairs of links, and the reasons for excluded pairs.
        pairs: The pairs of shapes.
        allowance: Length that is added to each pair's distance, so that this
            pair may come nearer than other pairs, shape (k,) [m].
    """

    robot: RobotModel
    shapes: CollisionShapes
    found: LinkPairs
    pairs: ShapePairs
    allowance: np.ndarray

    def __len__(self) -> int:
        return len(self.allowance)

    @cached_property
    def pair_arrays(self) -> Packed[PairArrays]:
        """The pairs packed for kernels."""
        return self.pairs.arrays(self.allowance)

    def links(self, pair: int) -> tuple[str, str]:
        """Returns the names of the two links that carry a pair of shapes."""
        links, pairs = self.shapes.links, self.pairs
        return links[pairs.first[pair]], links[pairs.second[pair]]

    def distances(self, q: np.ndarray, enough: float = np.inf) -> np.ndarray:
        """Computes the distances of all pairs of shapes.

        Args:
            q: Configuration, shape (n_q,) [rad, m].
            enough: Above this value, lower bounds suffice [m].

        Returns:
            The signed distances plus the pairs' allowances, shape (k,) [m].
        """
        X_WL = self.robot.body_poses(q)
        return pair_distances(self.pair_arrays, X_WL, float(enough))

    def near(
        self, X_WL: np.ndarray, within: float, crowded: float = -np.inf
    ) -> NearPoints:
        """Finds the points at which links are near each other.

        Args:
            X_WL: Poses of all bodies of the robot's tree, shape (b, 4, 4).
            within: Links at or beyond this distance are left out [m].
            crowded: Distance below which all pairs of shapes of two links are
                returned, not only the nearest pair [m].
        """
        return NearPoints(
            *near_points(self.pair_arrays, X_WL, float(within), float(crowded))
        )


def self_collision_pairs(
    robot: RobotModel, margin: float
) -> SelfCollisionPairs:
    """Lists the pairs of shapes that are checked.

    At a short wrist, shapes may be nearer than `margin` even in the home
    configuration. Such a pair gets an allowance: its shapes may touch or, if
    they overlap at home, may overlap slightly more than at home.

    Args:
        robot: The robot.
        margin: Distance that pairs without an allowance keep [m].

    Raises:
        RemoSplatError: A shape has no bounded hull, or the SRDF file of the
            robot's description cannot be read.
    """
    shapes, found, pairs, at_home = _watched(robot)
    lowest = np.where(at_home < 0.0, at_home - _WOBBLE, 0.0)
    allowance = np.where(at_home > margin, 0.0, margin - lowest)
    return SelfCollisionPairs(robot, shapes, found, pairs, allowance)


@lru_cache(maxsize=16)
def _watched(
    robot: RobotModel,
) -> tuple[CollisionShapes, LinkPairs, ShapePairs, np.ndarray]:
    """Returns the pairs of shapes, and their distances at home [m]."""
    if robot is robot.as_described:
        shapes = read_collision_shapes(robot.description, robot.spheres)
        found = find_link_pairs(robot, shapes)
    elif robot.payload is None:
        shapes, found, _, _ = _watched(robot.as_described)
    else:
        shapes, found, _, _ = _watched(robot.holding(None))
        shapes = shapes.with_payload(robot.payload)
        found = found.with_payload(robot, robot.payload, shapes)
    pairs = ShapePairs.make(robot, shapes, found.watched)
    bare = SelfCollisionPairs(robot, shapes, found, pairs, np.zeros(len(pairs)))
    return shapes, found, pairs, bare.distances(robot.q_home)
