"""`BlockedPostures`: postures that a robot cannot take.

To bring a hand into a closed shell, for example, the forearm has to pass
through the shell. The pose of one link in the other depends only on the joints
between them. So a robot cannot bring two links into a relative pose if links
between them in the tree touch each other.
"""

import dataclasses as dc
from collections.abc import Mapping

import numpy as np

from remosplat_drake.robot.fitting.surface_points import (
    TOUCHING,
    SurfacePoints,
    are_touching,
)
from remosplat_drake.robot.pose_arrays import inverse_poses
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.self_collision.link_pairs import pairs_between
from remosplat_drake.robot.self_collision.shape_pairs import LinkPair

_NESTED, _SAMPLES = 0.5, 64
"""Two links touch by design, like the links of a wrist, if they touch in more
than this share (first number) of this many postures (second number)."""


@dc.dataclass(frozen=True, eq=False)
class _PairsBetween:
    """The k pairs of links that may collide between two links in the tree.

    Attributes:
        pairs: Names of the links of each pair.
        bodies: Bodies of the links of each pair, shape (k, 2).
        center: Centres of balls around their surfaces, in their frames, shape
            (k, 2, 3) [m].
        radius: Sum of the two balls' radii, shape (k,) [m].
    """

    pairs: list[LinkPair]
    bodies: np.ndarray
    center: np.ndarray
    radius: np.ndarray

    def near(self, poses: np.ndarray) -> np.ndarray:
        """Returns which balls touch, given all poses in n postures, (k, n)."""
        X = poses[:, self.bodies]
        p_W = (X[..., :3, :3] @ self.center[..., None])[..., 0] + X[..., :3, 3]
        apart = np.linalg.norm(p_W[:, :, 1] - p_W[:, :, 0], axis=2)
        return (apart - self.radius < TOUCHING).T


class BlockedPostures:
    """Finds the postures that a robot cannot take.

    Links that touch by design, in most postures, are ignored.
    """

    def __init__(
        self,
        robot: RobotModel,
        surfaces: Mapping[str, SurfacePoints],
        poses: np.ndarray,
    ):
        """Starts without results, which are computed when they are needed.

        Args:
            robot: The robot; its collision shapes are not used.
            surfaces: Surfaces of the links, keyed by their names.
            poses: Poses of all bodies in random postures, shape (p, b, 4, 4).
        """
        self._robot, self._surfaces = robot, surfaces
        self._samples = poses[:_SAMPLES]
        self._between: dict[LinkPair, _PairsBetween] = {}
        self._nested: dict[LinkPair, bool] = {}

    def are_blocked(self, links: LinkPair, poses: np.ndarray) -> np.ndarray:
        """Returns in which postures links between two links touch, (n,) bool.

        Args:
            links: Names of the two links.
            poses: Poses of all bodies in n postures, shape (n, b, 4, 4).
        """
        if links not in self._between:
            self._between[links] = self._pairs_between(links)
        between = self._between[links]
        blocked = np.zeros(len(poses), bool)
        for pair, near in zip(between.pairs, between.near(poses), strict=True):
            rows = np.flatnonzero(near & ~blocked)
            if len(rows) and not self._nested.get(pair):
                touching = self._are_touching(pair, poses[rows])
                if touching.any() and not self._is_nested(pair):
                    blocked[rows] = touching
        return blocked

    def _pairs_between(self, links: LinkPair) -> _PairsBetween:
        """Returns the pairs of links between two links."""
        pairs = pairs_between(self._robot, links, self._surfaces)
        bodies = [[self._robot.tree.index(x) for x in pair] for pair in pairs]
        balls = [
            [self._surfaces[x].balls.values for x in pair] for pair in pairs
        ]
        center = [[ball.center[0] for ball in own] for own in balls]
        radius = [[ball.radius[0] for ball in own] for own in balls]
        return _PairsBetween(
            pairs,
            np.array(bodies, int).reshape(-1, 2),
            np.array(center).reshape(-1, 2, 3),
            np.array(radius).reshape(-1, 2).sum(axis=1),
        )

    def _is_nested(self, links: LinkPair) -> bool:
        """Returns whether two links touch by design."""
        if links not in self._nested:
            touching = self._are_touching(links, self._samples)
            self._nested[links] = bool(touching.mean() > _NESTED)
        return self._nested[links]

    def _are_touching(self, links: LinkPair, poses: np.ndarray) -> np.ndarray:
        """Returns in which postures two links touch, shape (n,) bool."""
        body_a, body_b = (self._robot.tree.index(link) for link in links)
        X_AB = inverse_poses(poses[:, body_a]) @ poses[:, body_b]
        a, b = (self._surfaces[link] for link in links)
        return are_touching(a, b, X_AB)
