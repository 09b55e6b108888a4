"""`SurfacePoints`: a link's surface as points, between which it is measured."""

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
"""Mean distance of the points on surfaces by which meshes are measured [m]: two
that are 5 mm apart are measured 0.3 mm too far, at most."""

TOUCHING = 3e-3
"""Distance of such points below which surfaces are taken to cut each other: how
far pieces overlap then says nothing about them [m]."""


class SurfacePoints:
    """Points on a surface, dense enough to measure distances by.

    Attributes:
        tree: Finds the points nearest to others.
        surface: The surface, with corners moved by up to `TOUCHING`, shape
            (t, 3, 3) [m].
    """

    def __init__(self, surface: np.ndarray, rng: np.random.Generator):
        """Draws points on a surface.

        Args:
            surface: Triangles, shape (t, 3, 3) [m].
            rng: Source of randomness.
        """
        corners = np.arange(3 * len(surface)).reshape(-1, 3)
        p = sample_triangles(surface.reshape(-1, 3), corners, SPACING, rng)
        # One a cell of those that crowd, and all extremes.
        one = np.unique(grid_cells(p, 0.5 * SPACING), return_index=True)[1]
        self.tree = KDTree(np.vstack([p[one], convex_corners(p)]))
        self.surface = clustered(surface, TOUCHING)

    @cached_property
    def balls(self):
        """The points packed for kernels."""
        return point_tree(self.tree.data)


def surface_distances(
    a: SurfacePoints,
    b: SurfacePoints,
    X_AB: np.ndarray,
    within: np.ndarray,
    may_hold: np.ndarray,
) -> np.ndarray:
    """Measures the distances of two surfaces in m poses.

    Args:
        a: The first, in frame A.
        b: The second, in frame B.
        X_AB: Poses, shape (m, 4, 4).
        within: Distances from which on it does not matter, shape (m,) [m].
        may_hold: Whether one may be in the other, shape (m,) bool.

    Returns:
        The distances, shape (m,) [m]; infinite from `within` on, not the least
        up to `TOUCHING`, and zero where one surface is in the other.
    """
    distance, at_a, at_b = points_distances(
        a.balls, b.balls, X_AB, TOUCHING, within
    )
    apart = (distance > TOUCHING) & (distance < np.inf)
    for i in np.flatnonzero(apart & may_hold):
        R_AB, p_AB = X_AB[i, :3, :3], X_AB[i, :3, 3]
        p_BP = (a.balls.values.points[at_a[i]] - p_AB) @ R_AB
        p_AQ = R_AB @ b.balls.values.points[at_b[i]] + p_AB
        if is_inside(p_AQ, a.surface) or is_inside(p_BP, b.surface):
            distance[i] = 0.0
    return distance
