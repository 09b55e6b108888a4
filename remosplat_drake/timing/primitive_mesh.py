"""Approximates the surfaces of boxes and cylinders by triangles."""

from itertools import product

import numpy as np
from scipy.spatial import ConvexHull

from remosplat_drake.scene.primitive_scene import Box, Cylinder, PrimitiveScene

SECTORS = 32
"""Number of corners of the polygons that approximate circles."""


def surface_triangles(
    scene: PrimitiveScene, longest: float = np.inf
) -> np.ndarray:
    """Covers all primitives with triangles, including hidden parts.

    Args:
        scene: Scene of boxes and cylinders.
        longest: Edge length above which a triangle is split in two [m].

    Returns:
        Corners of the t triangles in W, shape (t, 3, 3) [m].
    """
    parts = [_primitive_triangles(each) for each in scene.primitives]
    return _cut(np.concatenate(parts), longest)


def _primitive_triangles(primitive: Box | Cylinder) -> np.ndarray:
    if isinstance(primitive, Box):
        p_PV = np.array([*product((-1, 1), repeat=3)]) * primitive.half_extents
    else:
        angle = 2 * np.pi * np.arange(SECTORS) / SECTORS
        x, y = primitive.radius * np.array([np.cos(angle), np.sin(angle)])
        z = np.full(SECTORS, primitive.half_height)
        p_PV = np.stack([[*x, *x], [*y, *y], [*z, *-z]], axis=1)
    X_WP = primitive.X_WP.GetAsMatrix4()
    p_WV = p_PV @ X_WP[:3, :3].T + X_WP[:3, 3]
    return p_WV[ConvexHull(p_PV).simplices]


def _cut(triangles: np.ndarray, longest: float) -> np.ndarray:
    """Splits triangles at midpoints of their longest edges until these fit."""
    done = []
    while len(triangles):
        edges = np.roll(triangles, -1, axis=1) - triangles
        length = np.linalg.norm(edges, axis=2)
        # The longest edge is that from the first corner to the second.
        order = (length.argmax(axis=1)[:, None] + np.arange(3)) % 3
        turned = np.take_along_axis(triangles, order[:, :, None], axis=1)
        is_long = length.max(axis=1) > longest
        done.append(turned[~is_long])
        a, b, c = np.moveaxis(turned[is_long], 1, 0)
        middle = (a + b) / 2
        triangles = np.concatenate(
            [np.stack([a, middle, c], 1), np.stack([middle, b, c], 1)]
        )
    return np.concatenate(done)
