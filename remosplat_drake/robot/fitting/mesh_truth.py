"""How far the distances of convex pieces are from those of the meshes.

Pieces hold their mesh, so that two links are never farther apart by their
pieces than by their meshes, and nearer by what the pieces stand out. Where that
matters is seen in postures in which pieces come near each other.
"""

import dataclasses as dc

import numpy as np
from scipy.spatial import KDTree

from remosplat_drake.robot.fitting.link_surface import sample_triangles
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.self_collision.kernels.near_points import near_points
from remosplat_drake.robot.self_collision.link_pairs import (
    ALWAYS,
    find_link_pairs,
)
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


@dc.dataclass(frozen=True)
class PairError:
    """Two links that are nearer by their pieces than by their meshes.

    Attributes:
        links: Names of the links.
        error: By how much [m].
        distance: Distance of their meshes [m].
        blame: How far the pieces of each stand out of its surface where they
            are nearest [m].
    """

    links: LinkPair
    error: float
    distance: float
    blame: tuple[float, float]


@dc.dataclass(frozen=True)
class _Look:
    """Two links that are near by their pieces, in one posture.

    The way from one surface over the pieces' nearest points to the other bounds
    the distance of the surfaces, and so the error: `most`.
    """

    most: float
    distance: float
    blame: tuple[float, float]
    posture: int


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
        self._surfaces = surfaces
        rng = np.random.default_rng(0)
        self._trees = {
            link: KDTree(_points(surface, rng))
            for link, surface in surfaces.items()
        }
        self._known: dict[tuple[LinkPair, int], float] = {}

    def worst_errors(
        self, shapes: CollisionShapes, least: float
    ) -> dict[LinkPair, PairError]:
        """Finds the pairs of links whose distances are wrong by most.

        Args:
            shapes: The convex shapes of the links.
            least: Errors up to this do not count [m].

        Returns:
            The worst error of each pair of links that has one, by their names.
        """
        robot = self.robot
        found = find_link_pairs(robot, shapes)
        always = [p for p, why in found.left_out.items() if why == ALWAYS]
        watched = [*found.watched, *always]
        pairs = ShapePairs.make(robot, shapes, watched)
        arrays = pairs.arrays(np.zeros(len(pairs)))
        link_pair = np.searchsorted(pairs.start, range(len(pairs)), "right") - 1
        radius = shapes.radius
        looks: dict[LinkPair, list[_Look]] = {}
        for i, X_WL in enumerate(self.postures):
            rows, distance, _, p_WA, p_WB = near_points(
                arrays, X_WL, NEAR, -np.inf
            )
            # The nearest points of two links come before further ones.
            found_pairs, first = np.unique(link_pair[rows], return_index=True)
            for k, n in zip(found_pairs, first, strict=True):
                links = watched[k]
                ends = pairs.first[rows[n]], pairs.second[rows[n]]
                # The points of round shapes are within them by their radii.
                off_a, off_b = (
                    abs(self._off(link, X_WL, p_W[n]) - float(radius[end]))
                    for link, p_W, end in zip(
                        links, (p_WA, p_WB), ends, strict=True
                    )
                )
                blame = off_a, off_b
                way = float(np.linalg.norm(p_WB[n] - p_WA[n])) + sum(blame)
                apart = float(distance[n])
                look = _Look(way - apart, apart, blame, i)
                looks.setdefault(links, []).append(look)
        worst = {}
        for links, own in looks.items():
            own.sort(key=lambda look: -look.most)
            errors = []
            for look in own[:_MOST_LOOKS]:
                if look.most <= least or len(errors) == _LOOKS:
                    break
                true = self._distance(links, look.posture)
                if _TOUCHING < true < NEAR:
                    error = true - look.distance
                    errors.append(PairError(links, error, true, look.blame))
            largest = max(errors, key=lambda x: x.error, default=None)
            if largest is not None and largest.error > least:
                worst[links] = largest
        return worst

    def _off(self, link: str, X_WL: np.ndarray, p_W: np.ndarray) -> float:
        """The distance of a point from a link's surface [m]."""
        X = X_WL[self.robot.tree.index(link)]
        p_L = (p_W - X[:3, 3]) @ X[:3, :3]
        return float(self._trees[link].query(p_L)[0])

    def _distance(self, links: LinkPair, posture: int) -> float:
        """The distance of two links' surfaces in a posture [m].

        It is infinite beyond `NEAR`, and zero where one link is in the other.
        """
        key = links, posture
        if key not in self._known:
            self._known[key] = self._measured(links, posture)
        return self._known[key]

    def _measured(self, links: LinkPair, posture: int) -> float:
        a, b = (self._trees[link] for link in links)
        X_WA, X_WB = (
            self.postures[posture][self.robot.tree.index(link)]
            for link in links
        )
        R_AB = X_WA[:3, :3].T @ X_WB[:3, :3]
        p_AB = X_WA[:3, :3].T @ (X_WB[:3, 3] - X_WA[:3, 3])
        p_A = b.data @ R_AB.T + p_AB
        inside = (p_A > a.mins - NEAR) & (p_A < a.maxes + NEAR)
        p_A = p_A[inside.all(axis=1)]
        away, nearest = map(np.asarray, a.query(p_A, distance_upper_bound=NEAR))
        i = int(away.argmin()) if len(away) else 0
        if not (away[i : i + 1] < np.inf).any():
            return np.inf
        on_a = a.data[nearest[i]]
        if is_inside(p_A[i], self._surfaces[links[0]]) or is_inside(
            (on_a - p_AB) @ R_AB, self._surfaces[links[1]]
        ):
            return 0.0
        return float(away[i])


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
    corners = np.arange(3 * len(surface)).reshape(-1, 3)
    return sample_triangles(surface.reshape(-1, 3), corners, SPACING, rng)
