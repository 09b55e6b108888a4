"""Differences between distances of convex pieces and of the meshes.

Pieces enclose their mesh. So the distance between two links, computed from
pieces, is never too large, but it is too small where the pieces protrude. This
error matters in postures in which pieces come near each other. First, random
postures are tried. Few of them bring two given links near each other, and they
may miss all postures with large errors. So an evolution strategy searches for
larger errors: starting from postures with large errors, it changes the joints
between the two links at random, keeps the postures with the largest errors, and
repeats this with smaller changes.
"""

import dataclasses as dc
from collections.abc import Sequence

import numpy as np

from remosplat_drake.robot.fitting.surface_points import (
    TOUCHING,
    SurfacePoints,
    surface_distances,
)
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.sampling import position_ranges
from remosplat_drake.robot.self_collision.kernels.nearest_shapes import (
    nearest_shapes,
)
from remosplat_drake.robot.self_collision.shape_pairs import (
    LinkPair,
    ShapePairs,
)
from remosplat_drake.robot.self_collision.shapes import CollisionShapes

NEAR = 0.05
"""Distance of meshes below which the pieces' distance must be accurate [m]."""

_WORST = 8
"""Largest number of reported errors of a pair of links."""

_RISING = 5e-4
"""Least error of a posture from which the search starts [m]."""

_PARENTS, _CHILDREN = 12, 8
"""Number of postures that a generation of the search keeps, and number of
random ones around each."""

_STEP, _GENERATIONS = 0.05, 4
"""Initial size of the random changes, as a fraction of the joints' ranges, and
number of generations; the size halves with each one."""


@dc.dataclass(frozen=True, eq=False)
class PairError:
    """Two links whose pieces are nearer to each other than their meshes.

    Attributes:
        links: Names of the links.
        error: Distance of the meshes minus distance of the pieces [m].
        distance: Distance of their meshes [m].
        shapes: Indices of the two nearest shapes among those given.
        points: The nearest point of each shape, in its link's frame, shape (3,)
            [m].
        blame: Distance of each point from the surface of its link [m].
    """

    links: LinkPair
    error: float
    distance: float
    shapes: tuple[int, int]
    points: tuple[np.ndarray, np.ndarray]
    blame: tuple[float, float]


@dc.dataclass(frozen=True, eq=False)
class _Looks:
    """Nearest points of two links' pieces, in n postures.

    Attributes:
        posture: Index of the posture, shape (n,).
        ends: Indices of the two shapes, shape (n, 2).
        distance: Their distance, shape (n,) [m].
        points: Their nearest points in the frames of their links, shape (n, 2,
            3) [m].
        off: Distances of these points from the surfaces, shape (n, 2) [m].
        X_AB: Pose of the second link in the first, shape (n, 4, 4).
    """

    posture: np.ndarray
    ends: np.ndarray
    distance: np.ndarray
    points: np.ndarray
    off: np.ndarray
    X_AB: np.ndarray

    @property
    def most(self) -> np.ndarray:
        """Upper bound on the error of the pieces' distance, shape (n,) [m]."""
        off = self.off.sum(axis=1)
        return off + np.abs(self.distance) - self.distance


class MeshTruth:
    """Distances between the surfaces of a robot's links, in some postures.

    Attributes:
        robot: The robot; its collision shapes are not used.
        states: The postures, shape (p, n_q).
    """

    def __init__(
        self,
        robot: RobotModel,
        surfaces: dict[str, np.ndarray],
        states: np.ndarray,
    ):
        """Draws points on the surfaces.

        Args:
            robot: The robot.
            surfaces: Triangles of each link, by its name and in its frame,
                shape (t, 3, 3) [m].
            states: Configurations to examine, shape (p, n_q) [m, rad].
        """
        self.robot, self.states = robot, states
        self._poses = _poses(robot, states)
        self._rng = np.random.default_rng(0)
        self._surfaces = {
            link: SurfacePoints(surface, self._rng)
            for link, surface in surfaces.items()
        }
        self._known: dict[LinkPair, np.ndarray] = {}

    def errors(
        self, shapes: CollisionShapes, pairs: Sequence[LinkPair], least: float
    ) -> dict[LinkPair, list[PairError]]:
        """Finds the postures with the largest errors of the links' distances.

        Args:
            shapes: The convex shapes of the links.
            pairs: Names of pairs of links.
            least: Errors up to this value are ignored [m].

        Returns:
            The errors of each pair of links that has any, the largest first.
        """
        shape_pairs = ShapePairs.make(self.robot, shapes, pairs)
        found = {}
        for links in pairs:
            looks = self._looks(shape_pairs, links, self._poses)
            error, true = self._measured(links, looks, least, self._of(links))
            errors = [
                PairError(
                    links,
                    float(error[i]),
                    float(true[i]),
                    tuple(looks.ends[i].tolist()),
                    tuple(looks.points[i]),
                    tuple(looks.off[i].tolist()),
                )
                for i in _largest(error, _WORST)
            ]
            if errors:
                found[links] = errors
        return found

    def add_worst(
        self, shapes: CollisionShapes, pairs: Sequence[LinkPair], least: float
    ) -> list[LinkPair]:
        """Searches for postures with larger errors, and adds them.

        Args:
            shapes: The convex shapes of the links.
            pairs: Names of pairs of links.
            least: Errors up to this value are ignored [m].

        Returns:
            The pairs of links for which postures were added.
        """
        shape_pairs = ShapePairs.make(self.robot, shapes, pairs)
        worst = {
            links: self._climb(shape_pairs, links, least) for links in pairs
        }
        added = [states for states in worst.values() if len(states)]
        self.states = np.vstack([self.states, *added])
        self._poses = np.concatenate(
            [self._poses, *(_poses(self.robot, states) for states in added)]
        )
        return [links for links, states in worst.items() if len(states)]

    def _climb(
        self, shape_pairs: ShapePairs, links: LinkPair, least: float
    ) -> np.ndarray:
        """Returns new postures with large errors of two links, (n, n_q)."""
        looks = self._looks(shape_pairs, links, self._poses)
        error, _ = self._measured(links, looks, _RISING, self._of(links))
        chosen = _largest(error, _PARENTS)
        states, error = self.states[looks.posture[chosen]], error[chosen]
        is_new = np.zeros(len(states), bool)
        lower, upper = position_ranges(self.robot)
        step = _STEP * (upper - lower) * self._between(links)
        for _ in range(_GENERATIONS if len(states) else 0):
            drawn = np.repeat(states, _CHILDREN, axis=0)
            drawn += step * self._rng.standard_normal(drawn.shape)
            drawn = np.clip(drawn, lower, upper)
            looks = self._looks(shape_pairs, links, _poses(self.robot, drawn))
            theirs, _ = self._measured(links, looks, _RISING)
            states = np.vstack([states, drawn[looks.posture]])
            error = np.concatenate([error, theirs])
            is_new = np.append(is_new, np.ones(len(theirs), bool))
            chosen = _largest(error, _PARENTS)
            states, error = states[chosen], error[chosen]
            is_new, step = is_new[chosen], 0.5 * step
        return states[is_new & (error > least)]

    def _between(self, links: LinkPair) -> np.ndarray:
        """Returns which joints move two links against each other, (n_q,)."""
        tree = self.robot.tree
        a, b = (set(tree.chain(tree.index(link))) for link in links)
        moving = np.zeros(self.robot.n_q, bool)
        moving[[i for i in tree.position[list(a ^ b)] if i >= 0]] = True
        return moving

    def _of(self, links: LinkPair) -> np.ndarray:
        """Returns the measured distances of two links' meshes, shape (p,) [m].

        They are NaN where they have not been measured yet.
        """
        known = self._known.get(links, np.zeros(0))
        missing = np.full(len(self.states) - len(known), np.nan)
        self._known[links] = np.concatenate([known, missing])
        return self._known[links]

    def _looks(
        self, pairs: ShapePairs, links: LinkPair, poses: np.ndarray
    ) -> _Looks:
        """Returns the nearest points of two links' shapes, in all postures."""
        arrays = pairs.arrays(np.zeros(len(pairs)))
        posture, row, distance, p_A = nearest_shapes(
            arrays, pairs.links.index(links), poses, NEAR
        )
        body_a, body_b = (self.robot.tree.index(link) for link in links)
        X_WA, X_WB = poses[posture, body_a], poses[posture, body_b]
        X_AB = _inverse(X_WA) @ X_WB
        points = p_A.copy()
        X_BA = _inverse(X_AB)
        points[:, 1] = (X_BA[:, :3, :3] @ p_A[:, 1, :, None])[:, :, 0]
        points[:, 1] += X_BA[:, :3, 3]
        ends = np.stack([pairs.first[row], pairs.second[row]], axis=1)
        # Points of round shapes are on their cores, a radius inside the shapes.
        away = [
            self._surfaces[link].tree.query(points[:, side])[0]
            for side, link in enumerate(links)
        ]
        off = np.abs(np.stack(away, axis=1) - pairs.shapes.radius[ends])
        return _Looks(posture, ends, distance, points, off, X_AB)

    def _measured(
        self,
        links: LinkPair,
        looks: _Looks,
        least: float,
        known: np.ndarray | None = None,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Returns errors of two links' distances, and the true distances [m].

        An error is minus infinity if it is at most `least`, or if the surfaces
        are far from each other or intersect.

        Args:
            links: Names of the links.
            looks: The links' nearest points in n postures.
            least: Errors up to this value are ignored [m].
            known: The measured distances in all postures, shape (p,) [m], to
                which new ones are added; None for none.

        Returns:
            Errors and true distances, shape (n,) each [m].
        """
        true = np.full(len(looks.distance), np.nan)
        if known is not None:
            true = known[looks.posture]
        most = looks.most
        new = np.flatnonzero((most > least) & np.isnan(true))
        a, b = (self._surfaces[link] for link in links)
        true[new] = surface_distances(
            a,
            b,
            looks.X_AB[new],
            np.minimum(NEAR, (looks.distance + most)[new] + 1e-6),
            looks.distance[new] < 0.0,
        )
        if known is not None:
            known[looks.posture] = true
        counts = (most > least) & (true > TOUCHING) & (true < NEAR)
        error = np.where(counts, true - looks.distance, -np.inf)
        return np.where(error > least, error, -np.inf), true


def _poses(robot: RobotModel, states: np.ndarray) -> np.ndarray:
    """Poses of all bodies in some configurations, shape (p, b, 4, 4)."""
    return np.array([robot.body_poses(q) for q in states]).reshape(
        len(states), len(robot.tree.names), 4, 4
    )


def _largest(error: np.ndarray, count: int) -> np.ndarray:
    """Returns the indices of the largest finite errors."""
    chosen = np.argsort(-error)[:count]
    return chosen[error[chosen] > -np.inf]


def _inverse(X: np.ndarray) -> np.ndarray:
    """Inverts poses, shape (n, 4, 4)."""
    R = np.swapaxes(X[:, :3, :3], 1, 2)
    inverse = np.zeros_like(X)
    inverse[:, :3, :3] = R
    inverse[:, :3, 3] = -(R @ X[:, :3, 3, None])[:, :, 0]
    inverse[:, 3, 3] = 1.0
    return inverse
