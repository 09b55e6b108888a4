"""Differences between distances of convex pieces and of the meshes.

Pieces hold their mesh, so that two links are never farther apart by their
pieces than by their meshes, but may be nearer, by how far the pieces protrude.
That matters in postures in which pieces come near each other. First, random
postures are tried. Few of them bring two given links near each other, and they
may miss all postures in which the pieces protrude. So an evolution strategy
looks for worse ones: where the error is large, it changes the joints between
two links at random, keeps the worst posture, and repeats this with smaller
changes.
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
"""Distance of meshes below which that of the pieces has to be true [m]."""

_WORST = 8
"""Largest number of reported errors of a pair of links."""

_RISING = 5e-4
"""Error from which on postures are climbed from [m]."""

_PARENTS, _CHILDREN = 12, 8
"""How many postures are climbed from at once, and how many are drawn around
each."""

_STEP, _GENERATIONS = 0.05, 4
"""By how much these differ at first, as a share of the joints' ranges, and how
often they are drawn; each time they differ by half as much."""


@dc.dataclass(frozen=True, eq=False)
class PairError:
    """Two links that are nearer by their pieces than by their meshes.

    Attributes:
        links: Names of the links.
        error: By how much [m].
        distance: Distance of their meshes [m].
        shapes: Which shapes are nearest, as numbers of those that were given.
        points: The nearest point of each, in its link's frame, shape (3,) [m].
        blame: How far each point is from the surface of its link [m].
    """

    links: LinkPair
    error: float
    distance: float
    shapes: tuple[int, int]
    points: tuple[np.ndarray, np.ndarray]
    blame: tuple[float, float]


@dc.dataclass(frozen=True, eq=False)
class _Looks:
    """Two links that are near by their pieces, in n postures.

    Attributes:
        posture: Which posture, shape (n,).
        ends: The two shapes, shape (n, 2).
        distance: Their distance, shape (n,) [m].
        points: Their nearest points in the frames of their links, shape (n, 2,
            3) [m].
        off: How far these are from the surfaces, shape (n, 2) [m].
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
        """Surfaces are no farther apart than this more, shape (n,) [m]."""
        off = self.off.sum(axis=1)
        return off + np.abs(self.distance) - self.distance


class MeshTruth:
    """The surfaces of a robot's links, in some postures.

    Attributes:
        robot: The robot; its shapes do not matter.
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
            states: Configurations to look at, shape (p, n_q).
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
        """Finds the postures in which distances of links are wrong by most.

        Args:
            shapes: The convex shapes of the links.
            pairs: Names of pairs of links.
            least: Errors up to this do not count [m].

        Returns:
            Errors of each pair of links that has some, the largest first.
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
        """Looks for postures in which distances are more wrong; adds them.

        Args:
            shapes: The convex shapes of the links.
            pairs: Names of pairs of links.
            least: Errors up to this do not count [m].

        Returns:
            The pairs of links for which there are new postures.
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
        """The worst new postures of two links, shape (n, n_q)."""
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
        """Which positions move one of two links against the other, (n_q,)."""
        tree = self.robot.tree
        a, b = (set(tree.chain(tree.index(link))) for link in links)
        moving = np.zeros(self.robot.n_q, bool)
        moving[[i for i in tree.position[list(a ^ b)] if i >= 0]] = True
        return moving

    def _of(self, links: LinkPair) -> np.ndarray:
        """The known distances of two links, shape (p,) [m].

        They are NaN where they have not been measured yet.
        """
        known = self._known.get(links, np.zeros(0))
        missing = np.full(len(self.states) - len(known), np.nan)
        self._known[links] = np.concatenate([known, missing])
        return self._known[links]

    def _looks(
        self, pairs: ShapePairs, links: LinkPair, poses: np.ndarray
    ) -> _Looks:
        """Where two links are near by their shapes, in the poses of bodies."""
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
        # The points of round shapes are within them by their radii.
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
        """How wrong the distances of two links are, and the true ones [m].

        An error is minus infinite where it is at most `least`, or where the
        surfaces are far from each other, or cut each other.

        Args:
            links: Names of the links.
            looks: Where they are near, n postures.
            least: Errors up to this do not count [m].
            known: The known distances in all postures, which are completed,
                shape (p,) [m]; None for none.

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
    """The numbers of the largest errors, which are errors at all."""
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
