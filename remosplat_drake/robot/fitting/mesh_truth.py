"""Measures errors of distances between convex pieces that replace meshes.

Pieces enclose their mesh. The distance between two links, computed from pieces,
is therefore never too large, but it is too small where the pieces protrude.
This error matters in postures in which pieces come near each other. First,
random postures are tried. Few of them bring two given links near each other,
and they may miss all postures with large errors. An evolution strategy
therefore searches for larger errors. It starts from postures with large errors,
changes the joints between the two links at random, and keeps the postures with
the largest errors. It repeats this with smaller changes.

A robot cannot take all of these postures. An error in a posture that
`BlockedPostures` rules out does not count.
"""

import dataclasses as dc
from collections.abc import Mapping, Sequence

import numpy as np

from remosplat_drake.robot.fitting.blocked_postures import BlockedPostures
from remosplat_drake.robot.fitting.surface_points import (
    TOUCHING,
    SurfacePoints,
    surface_distances,
)
from remosplat_drake.robot.kinematics import body_poses_at
from remosplat_drake.robot.pose_arrays import inverse_poses
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
"""The distance of the pieces must be accurate if that of the meshes is less
than this [m]."""

_WORST = 8
"""For each pair of links, at most this many errors are reported."""

_BATCH = 32
"""Number of postures whose meshes are measured together."""

_CHECKED = 3e-3
"""If the error of a posture exceeds this, it is checked if the robot can take
the posture [m]. Smaller errors lead to no cut."""

_RISING = 5e-4
"""The search starts from postures with at least this error [m]."""

_PARENTS, _CHILDREN = 12, 8
"""A generation of the search keeps this many postures (first number), and draws
this many random postures around each of them (second number)."""

_STEP, _GENERATIONS = 0.05, 4
"""Initial size of the random changes, as a fraction of the joints' ranges, and
number of generations; the size halves with each generation."""


@dc.dataclass(frozen=True, eq=False)
class PairError:
    """An error: two links' pieces are nearer to each other than the meshes.

    Attributes:
        links: Names of the links.
        error: Distance of the meshes minus distance of the pieces [m].
        distance: Distance of their meshes [m].
        shapes: Indices of the two nearest shapes among the given shapes.
        points: The nearest point of each shape, in its link's frame, shape (3,)
            [m].
        blame: Distance by which each point protrudes from the surface of its
            link [m].
    """

    links: LinkPair
    error: float
    distance: float
    shapes: tuple[int, int]
    points: tuple[np.ndarray, np.ndarray]
    blame: tuple[float, float]


@dc.dataclass(frozen=True, eq=False)
class PairErrors:
    """The errors of the distance between two links, in all postures.

    Attributes:
        worst: The largest errors, the largest first.
        postures: Indices of all postures that may have an error, shape (n,).
    """

    worst: tuple[PairError, ...]
    postures: np.ndarray


@dc.dataclass(frozen=True, eq=False)
class _Looks:
    """Nearest points of two links' pieces, in n postures.

    Attributes:
        links: Names of the links.
        posture: Index of the posture, shape (n,).
        poses: Poses of all bodies in some postures, shape (m, b, 4, 4).
        row: Index of each posture among these poses, shape (n,).
        ends: Indices of the two shapes, shape (n, 2).
        distance: Distance of the two shapes, shape (n,) [m].
        points: The nearest points of the two shapes, in the frames of their
            links, shape (n, 2, 3) [m]; those of round shapes are on their
            cores.
        radius: The radii of the two shapes, shape (n, 2) [m].
        X_AB: Pose of the second link in the first, shape (n, 4, 4).
        true: Distances of the links' meshes, shape (n,) [m]; NaN where they
            have not been measured, zero where links on the way between the two
            touch.
        bound: Upper bounds on these distances, shape (n,) [m].
        bounded: Distances of the pieces for which these bounds were computed,
            shape (n,) [m].
    """

    links: LinkPair
    posture: np.ndarray
    poses: np.ndarray
    row: np.ndarray
    ends: np.ndarray
    distance: np.ndarray
    points: np.ndarray
    radius: np.ndarray
    X_AB: np.ndarray
    true: np.ndarray
    bound: np.ndarray
    bounded: np.ndarray

    def on_shapes(self, rows: np.ndarray, side: int) -> np.ndarray:
        """Returns nearest points on the surfaces of shapes, shape (n, 3) [m].

        Args:
            rows: Indices of n postures among these.
            side: 0 for the first link, 1 for the second; points are in its
                frame.
        """
        p, radius = self.points[rows, side], self.radius[rows, side, None]
        if not radius.any():
            return p
        X = self.X_AB[rows] if side == 0 else inverse_poses(self.X_AB[rows])
        other = (X[:, :3, :3] @ self.points[rows, 1 - side, :, None])[..., 0]
        way = other + X[:, :3, 3] - p
        length = np.linalg.norm(way, axis=1, keepdims=True)
        return p + radius * way / np.maximum(length, 1e-12)

    @property
    def known(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Values that stay valid if pieces are cut: true, bound, bounded."""
        return self.true, self.bound, self.bounded

    @property
    def error(self) -> np.ndarray:
        """Errors of the distances, shape (n,) [m].

        An error is minus infinity if the surfaces are far from each other or
        intersect, if the robot cannot take the posture, or if the distance has
        not been measured.
        """
        counts = (self.true > TOUCHING) & (self.true < NEAR)
        return np.where(counts, self.true - self.distance, -np.inf)


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
        self._poses = body_poses_at(robot.tree.arrays, states)
        self._rng = np.random.default_rng(0)
        self._surfaces = {
            link: SurfacePoints(surface, self._rng)
            for link, surface in surfaces.items()
        }
        self._known: dict[LinkPair, np.ndarray] = {}
        self._blocks = BlockedPostures(robot, self._surfaces, self._poses)

    def errors(
        self,
        shapes: CollisionShapes,
        among: Mapping[LinkPair, np.ndarray | None],
        least: float,
    ) -> dict[LinkPair, PairErrors]:
        """Finds the postures with the largest errors of the links' distances.

        Args:
            shapes: The convex shapes of the links.
            among: Indices of the postures to examine, by the names of two
                links; None for all postures.
            least: Errors up to this value are ignored [m].

        Returns:
            The errors of each pair of links that has any.
        """
        pairs = ShapePairs.make(self.robot, shapes, list(among))
        found = {}
        for links, postures in among.items():
            looks = self._looks(pairs, links, postures)
            may_have = looks.posture[self._measure(looks, least, _WORST)]
            self._known[links][:, looks.posture] = looks.known
            chosen = _largest(looks.error, least, _WORST)
            off = self._off(looks, chosen)
            worst = tuple(
                PairError(
                    links,
                    float(looks.error[i]),
                    float(looks.true[i]),
                    tuple(looks.ends[i].tolist()),
                    tuple(looks.points[i]),
                    tuple(away),
                )
                for i, away in zip(chosen, off.tolist(), strict=True)
            )
            if worst:
                found[links] = PairErrors(worst, may_have)
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
        tree = self.robot.tree.arrays
        self._poses = np.concatenate(
            [self._poses, *(body_poses_at(tree, states) for states in added)]
        )
        return [links for links, states in worst.items() if len(states)]

    def _climb(
        self, shape_pairs: ShapePairs, links: LinkPair, least: float
    ) -> np.ndarray:
        """Returns new postures with large errors of two links, (n, n_q)."""
        looks = self._looks(shape_pairs, links)
        self._measure(looks, _RISING, _PARENTS)
        self._known[links][:, looks.posture] = looks.known
        chosen = _largest(looks.error, _RISING, _PARENTS)
        states, error = self.states[looks.posture[chosen]], looks.error[chosen]
        is_new = np.zeros(len(states), bool)
        lower, upper = position_ranges(self.robot)
        step = _STEP * (upper - lower) * self._between(links)
        for _ in range(_GENERATIONS if len(states) else 0):
            drawn = np.repeat(states, _CHILDREN, axis=0)
            drawn += step * self._rng.standard_normal(drawn.shape)
            drawn = np.clip(drawn, lower, upper)
            poses = body_poses_at(self.robot.tree.arrays, drawn)
            looks = self._looks_at(shape_pairs, links, poses)
            self._measure(looks, _RISING, _PARENTS, error.tolist())
            states = np.vstack([states, drawn[looks.posture]])
            error = np.concatenate([error, looks.error])
            is_new = np.append(is_new, np.ones(len(looks.error), bool))
            chosen = _largest(error, _RISING, _PARENTS)
            states, error = states[chosen], error[chosen]
            is_new, step = is_new[chosen], 0.5 * step
        return states[is_new & (error > least)]

    def _between(self, links: LinkPair) -> np.ndarray:
        """Returns a mask of the joints between two links, shape (n_q,)."""
        tree = self.robot.tree
        a, b = (set(tree.chain(tree.index(link))) for link in links)
        moving = np.zeros(self.robot.n_q, bool)
        moving[[i for i in tree.position[list(a ^ b)] if i >= 0]] = True
        return moving

    def _looks(
        self,
        pairs: ShapePairs,
        links: LinkPair,
        postures: np.ndarray | None = None,
    ) -> _Looks:
        """Returns the nearest points of two links' shapes in some postures."""
        poses = self._poses if postures is None else self._poses[postures]
        looks = self._looks_at(pairs, links, poses)
        posture = looks.posture
        if postures is not None:
            posture = postures[posture]
        known = self._known.get(links, np.zeros((3, 0)))
        missing = np.full((3, len(self.states) - known.shape[1]), np.inf)
        missing[0], missing[2] = np.nan, -np.inf
        known = self._known[links] = np.hstack([known, missing])
        true, bound, bounded = known[:, posture]
        return dc.replace(
            looks, posture=posture, true=true, bound=bound, bounded=bounded
        )

    def _looks_at(
        self, pairs: ShapePairs, links: LinkPair, poses: np.ndarray
    ) -> _Looks:
        """Returns the nearest points of two links' shapes, given all poses."""
        posture, row, distance, p_A = nearest_shapes(
            pairs.arrays(np.zeros(len(pairs))),
            pairs.links.index(links),
            poses,
            NEAR,
        )
        body_a, body_b = (self.robot.tree.index(link) for link in links)
        X_WA, X_WB = poses[posture, body_a], poses[posture, body_b]
        X_AB = inverse_poses(X_WA) @ X_WB
        points = p_A.copy()
        X_BA = inverse_poses(X_AB)
        points[:, 1] = (X_BA[:, :3, :3] @ p_A[:, 1, :, None])[:, :, 0]
        points[:, 1] += X_BA[:, :3, 3]
        ends = np.stack([pairs.first[row], pairs.second[row]], axis=1)
        return _Looks(
            links,
            posture,
            poses,
            posture,
            ends,
            distance,
            points,
            pairs.shapes.radius[ends],
            X_AB,
            np.full(len(posture), np.nan),
            np.full(len(posture), np.inf),
            np.full(len(posture), -np.inf),
        )

    def _off(self, looks: _Looks, rows: np.ndarray) -> np.ndarray:
        """Returns the distances of nearest points from the surfaces, (n, 2)."""
        away = [
            self._surfaces[link].tree.query(looks.on_shapes(rows, side))[0]
            for side, link in enumerate(looks.links)
        ]
        return np.stack(away, axis=1)

    def _measure(
        self,
        looks: _Looks,
        least: float,
        count: int,
        others: Sequence[float] = (),
    ) -> np.ndarray:
        """Measures distances of meshes until the largest errors are known.

        The points' distances from the surfaces bound the error. Postures are
        measured in the order of this bound, until no further posture can have
        one of the largest errors. A measurement ends early when the error of
        its posture cannot be one of the largest.

        Args:
            looks: Nearest points in n postures; measured distances are added.
            least: Errors up to this value are ignored [m].
            count: Number of errors that must be known.
            others: Errors in other postures, among which the largest errors may
                be [m].

        Returns:
            Indices of the postures that may have larger errors than `least`.
        """
        self._bound(looks)
        new = np.flatnonzero(np.isnan(looks.true))
        most = np.full(len(looks.true), -np.inf)
        most[new] = looks.bound[new] - looks.distance[new]
        new = new[np.argsort(-most[new])]
        a, b = (self._surfaces[link] for link in looks.links)
        for done in range(0, len(new), _BATCH):
            errors = np.concatenate([looks.error, others])
            chosen = _largest(errors, least, count)
            limit = errors[chosen[-1]] if len(chosen) == count else least
            rows = new[done : done + _BATCH]
            rows = rows[most[rows] > limit]
            if not len(rows):
                break
            distance = looks.distance[rows]
            within = np.minimum(NEAR, distance + most[rows] + 1e-6)
            enough = np.clip(distance + limit, TOUCHING, within - 1e-9)
            found = surface_distances(
                a,
                b,
                looks.X_AB[rows],
                enough,
                within,
                distance < 0.0,
            )
            large = (found > enough) & (found - distance > _CHECKED)
            large = np.flatnonzero(large & (found < NEAR))
            if len(large):
                poses = looks.poses[looks.row[rows[large]]]
                found[large[self._blocks.are_blocked(looks.links, poses)]] = 0.0
            is_exact = (found > enough) | (found <= TOUCHING)
            looks.true[rows] = np.where(is_exact, found, np.nan)
            looks.bound[rows] = found
            most[rows] = np.where(is_exact, -np.inf, found - distance)
        return np.flatnonzero(np.maximum(looks.error, most) > least)

    def _bound(self, looks: _Looks) -> None:
        """Bounds the distances of meshes that have not been measured.

        A bound stays valid if pieces are cut. It is computed again where the
        pieces' distance has changed, since it may then be tighter.
        """
        has_changed = looks.distance > looks.bounded
        rows = np.flatnonzero(np.isnan(looks.true) & has_changed)
        distance = looks.distance[rows]
        bound = self._off(looks, rows).sum(axis=1) + np.abs(distance)
        looks.bound[rows] = np.minimum(looks.bound[rows], bound)
        looks.bounded[rows] = distance


def _largest(error: np.ndarray, least: float, count: int) -> np.ndarray:
    """Returns the indices of the largest errors above a value."""
    chosen = np.argsort(-error)[:count]
    return chosen[error[chosen] > least]
