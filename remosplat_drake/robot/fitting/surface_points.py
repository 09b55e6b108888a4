"""`SurfacePoints`: points on a link's surface, for measuring distances."""

from functools import cached_property

import numpy as np
from scipy.spatial import KDTree

from remosplat_drake.robot.fitting.convex_pieces import convex_corners
from remosplat_drake.robot.fitting.kernels.points_distance import (
    points_distances,
)
from remosplat_drake.robot.fitting.kernels.winding import is_inside
from remosplat_drake.robot.fitting.link_surface import sample_triangles
from remosplat_drake.robot.fitting.point_tree import point_tree
from remosplat_drake.robot.fitting.simplified import clustered, grid_cells

SPACING = 2.5e-3
"""Mean distance of the sample points on meshes [m]. The measured distance of
two meshes 5 mm apart is at most 0.3 mm too large."""

TOUCHING = 3e-3
"""Two surfaces are assumed to intersect if sample points of them are nearer to
each other than this [m]. An overlap of their pieces then does not count as an
error."""


class SurfacePoints:
    """Points on a surface, dense enough to measure distances.

    Attributes:
        tree: Tree for nearest-neighbour queries.
        surface: The surface, with corners moved by up to `TOUCHING`, shape
            (t, 3, 3) [m].
    """

    def __init__(self, surface: np.ndarray, rng: np.random.Generator):
        """Draws points on a surface.

        Args:
            surface: Triangles, shape (t, 3, 3) [m].
            rng: Source of randomness.
        """
        corners = surface.reshape(-1, 3)
        triangles = np.arange(len(corners)).reshape(-1, 3)
        p = sample_triangles(corners, triangles, SPACING, rng)
        # Keeps one point of each cell with many points, and all extreme points.
        one = np.unique(grid_cells(p, 0.5 * SPACING), return_index=True)[1]
        self.tree = KDTree(np.vstack([p[one], convex_corners(corners)]))
        self.surface = clustered(surface, TOUCHING)

    @cached_property
    def balls(self):
        """The points packed for kernels."""
        return point_tree(self.tree.data)


def surface_distances(
    a: SurfacePoints,
    b: SurfacePoints,
    X_AB: np.ndarray,
    enough: np.ndarray,
    within: np.ndarray,
    may_hold: np.ndarray,
) -> np.ndarray:
    """Measures the distances between two surfaces in m poses.

    Args:
        a: The first surface, in frame A.
        b: The second surface, in frame B.
        X_AB: Poses, shape (m, 4, 4).
        enough: Distances up to which the result may be too large, shape (m,)
            [m]; at least `TOUCHING`.
        within: Distances at or beyond which the result is infinite, shape (m,)
            [m].
        may_hold: Whether one surface may lie inside the other, shape (m,) bool.

    Returns:
        The distances, shape (m,) [m]; infinite from `within` on, approximate up
        to `TOUCHING`, and zero if one surface is inside the other.
    """
    distance, at_a, at_b = points_distances(
        a.balls, b.balls, X_AB, enough, within
    )
    apart = (distance > enough) & (distance < np.inf)
    for i in np.flatnonzero(apart & may_hold):
        R_AB, p_AB = X_AB[i, :3, :3], X_AB[i, :3, 3]
        p_BP = (a.balls.values.points[at_a[i]] - p_AB) @ R_AB
        p_AQ = R_AB @ b.balls.values.points[at_b[i]] + p_AB
        if is_inside(p_AQ, a.surface) or is_inside(p_BP, b.surface):
            distance[i] = 0.0
    return distance


def are_touching(
    a: SurfacePoints, b: SurfacePoints, X_AB: np.ndarray
) -> np.ndarray:
    """Returns in which of m poses two surfaces are nearer than `TOUCHING`.

    Args:
        a: The first surface, in frame A.
        b: The second surface, in frame B.
        X_AB: Poses, shape (m, 4, 4).

    Returns:
        Shape (m,) bool.
    """
    within = np.full(len(X_AB), TOUCHING)
    distance, _, _ = points_distances(
        a.balls, b.balls, X_AB, within - 1e-9, within
    )
    return distance < TOUCHING
