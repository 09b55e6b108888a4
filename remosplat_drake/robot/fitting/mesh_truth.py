"""How far the distances of convex pieces are from those of the meshes.

Pieces hold their mesh, so that two links are never farther apart by their
pieces than by their meshes, and nearer by what the pieces stand out. Where that
matters is seen in postures in which pieces come near each other.
"""

import dataclasses as dc
from collections.abc import Sequence

import numpy as np
from scipy.spatial import KDTree

from remosplat_drake.robot.fitting.convex_pieces import convex_corners
from remosplat_drake.robot.fitting.link_surface import sample_triangles
from remosplat_drake.robot.fitting.simplified import clustered, grid_cells
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.self_collision.kernels.near_points import near_points
from remosplat_drake.robot.self_collision.shape_pairs import (
    LinkPair,
    ShapePairs,
)
from remosplat_drake.robot.self_collision.shapes import CollisionShapes

NEAR = 0.05
"""Distance of meshes below which that of the pieces has to be true [m]."""

SPACING = 4e-3
"""Mean distance of the points on surfaces by which meshes are measured [m]: two
that are 10 mm apart are measured 0.2 mm too far, at most."""

_LOOKS, _MOST_LOOKS = 8, 60
"""In how many postures a pair of links is measured that say something, and in
how many at all: those in which its pieces stand out most where they are
nearest come first."""

_TOUCHING = 3e-3
"""Distance of such points below which surfaces are taken to cut each other: how
far pieces overlap then says nothing about them [m]."""


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
    """Pairs of links that are near by their pieces, each in one posture.

    Attributes:
        pair: Which pair, shape (n,).
        posture: Which posture, shape (n,).
        ends: The two shapes, shape (2, n).
        distance: Their distance, shape (n,) [m].
        points: Their nearest points in the frames of their links, shape (2, n,
            3) [m].
        off: How far these are from the surfaces, shape (2, n) [m].
        way: The way from one surface over these points to the other, shape (n,)
            [m]; the surfaces are no farther apart.
    """

    pair: np.ndarray
    posture: np.ndarray
    ends: np.ndarray
    distance: np.ndarray
    points: np.ndarray
    off: np.ndarray
    way: np.ndarray


class MeshTruth:
    """The surfaces of a robot's links, in some postures.

    Attributes:
        robot: The robot; its shapes do not matter.
        postures: Poses of all bodies, shape (p, b, 4, 4).
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
        self.robot = robot
        self.postures = np.array([robot.body_poses(q) for q in states])
        self._surfaces = {
            link: clustered(surface, _TOUCHING)
            for link, surface in surfaces.items()
        }
        rng = np.random.default_rng(0)
        self._trees = {
            link: KDTree(_points(surface, rng))
            for link, surface in surfaces.items()
        }
        self._known: dict[tuple[LinkPair, int], float] = {}

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
        looks = self._looks(shapes, pairs)
        most = looks.way - looks.distance
        found = {}
        for k, links in enumerate(pairs):
            rows = np.flatnonzero((looks.pair == k) & (most > least))
            rows = rows[np.argsort(-most[rows])]
            errors, measured = [], 0
            for i in rows[:_MOST_LOOKS]:
                true = self._distance(
                    links, int(looks.posture[i]), float(looks.way[i])
                )
                if _TOUCHING < true < NEAR:
                    measured += 1
                    error = true - float(looks.distance[i])
                    if error > least:
                        first, second = looks.ends[:, i].tolist()
                        off_a, off_b = looks.off[:, i].tolist()
                        p_A, p_B = looks.points[:, i]
                        errors.append(
                            PairError(
                                links,
                                error,
                                true,
                                (first, second),
                                (p_A, p_B),
                                (off_a, off_b),
                            )
                        )
                if measured == _LOOKS:
                    break
            if errors:
                found[links] = sorted(errors, key=lambda x: -x.error)
        return found

    def _looks(
        self, shapes: CollisionShapes, links: Sequence[LinkPair]
    ) -> _Looks:
        """The nearest points of all pairs of links that are near."""
        pairs = ShapePairs.make(self.robot, shapes, links)
        arrays = pairs.arrays(np.zeros(len(pairs)))
        link_pair = np.searchsorted(pairs.start, range(len(pairs)), "right") - 1
        parts = [_nothing_near()]
        for i, X_WL in enumerate(self.postures):
            rows, distance, _, p_WA, p_WB = near_points(
                arrays, X_WL, NEAR, -np.inf
            )
            # The nearest points of two links come before further ones.
            k, first = np.unique(link_pair[rows], return_index=True)
            row, p_W = rows[first], (p_WA[first], p_WB[first])
            parts.append((k, np.full(len(k), i), row, distance[first], *p_W))
        pair, posture, row, distance, *p_W = map(
            np.concatenate, zip(*parts, strict=True)
        )
        ends = np.array([pairs.first[row], pairs.second[row]])
        bodies = np.array(
            [[self.robot.tree.index(link) for link in two] for two in links],
            int,
        ).reshape(-1, 2)
        points, off = np.empty((2, len(pair), 3)), np.empty((2, len(pair)))
        for side in (0, 1):
            body = np.array([two[side] for two in bodies], int)[pair]
            X = self.postures[posture, body]
            p = p_W[side] - X[:, :3, 3]
            points[side] = np.einsum("nji,nj->ni", X[:, :3, :3], p)
            # The points of round shapes are within them by their radii.
            radius = shapes.radius[ends[side]]
            names = np.array([two[side] for two in links])[pair]
            for link in np.unique(names):
                own = names == link
                away = self._trees[str(link)].query(points[side][own])[0]
                off[side, own] = np.abs(away - radius[own])
        way = np.linalg.norm(p_W[1] - p_W[0], axis=1) + off.sum(axis=0)
        return _Looks(pair, posture, ends, distance, points, off, way)

    def _distance(self, links: LinkPair, posture: int, most: float) -> float:
        """The distance of two links' surfaces in a posture [m].

        It is infinite beyond `NEAR`, and zero where one link is in the other.

        Args:
            links: Names of the links.
            posture: Number of the posture.
            most: What it is not beyond [m].
        """
        key = links, posture
        if key not in self._known:
            within = min(NEAR, most + 1e-6)
            self._known[key] = self._measured(links, posture, within)
        return self._known[key]

    def _measured(self, links: LinkPair, posture: int, within: float) -> float:
        a, b = (self._trees[link] for link in links)
        X_WA, X_WB = (
            self.postures[posture][self.robot.tree.index(link)]
            for link in links
        )
        R_AB = X_WA[:3, :3].T @ X_WB[:3, :3]
        p_AB = X_WA[:3, :3].T @ (X_WB[:3, 3] - X_WA[:3, 3])
        p_A = b.data @ R_AB.T + p_AB
        inside = (p_A > a.mins - within) & (p_A < a.maxes + within)
        p_A = p_A[inside.all(axis=1)]
        away, nearest = map(
            np.asarray, a.query(p_A, distance_upper_bound=within)
        )
        i = int(away.argmin()) if len(away) else 0
        if not (away[i : i + 1] < np.inf).any():
            return np.inf
        on_a = a.data[nearest[i]]
        if is_inside(p_A[i], self._surfaces[links[0]]) or is_inside(
            (on_a - p_AB) @ R_AB, self._surfaces[links[1]]
        ):
            return 0.0
        return float(away[i])


def _nothing_near() -> tuple[np.ndarray, ...]:
    none = np.zeros(0, int)
    return none, none, none, np.zeros(0), np.zeros((0, 3)), np.zeros((0, 3))


def is_inside(p: np.ndarray, surface: np.ndarray) -> bool:
    """Tells whether a surface winds around a point.

    Args:
        p: The point, shape (3,) [m].
        surface: Triangles, shape (t, 3, 3) [m]; gaps hardly matter.
    """
    a, b, c = (surface - p).transpose(1, 0, 2)
    x, y, z = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    # The solid angle of each triangle (van Oosterom and Strackee 1983).
    volume = np.einsum("ij,ij->i", a, np.cross(b, c))
    dots = [np.einsum("ij,ij->i", v, w) for v, w in ((a, b), (b, c), (c, a))]
    rest = x * y * z + dots[0] * z + dots[1] * x + dots[2] * y
    angle = 2.0 * np.arctan2(volume, rest)
    return abs(angle.sum()) > 2.0 * np.pi


def _points(surface: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Points on a surface, of those that crowd one a cell, and all extremes."""
    corners = np.arange(3 * len(surface)).reshape(-1, 3)
    p = sample_triangles(surface.reshape(-1, 3), corners, SPACING, rng)
    one = np.unique(grid_cells(p, 0.5 * SPACING), return_index=True)[1]
    return np.vstack([p[one], convex_corners(p)])
