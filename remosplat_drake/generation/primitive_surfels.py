"""Samples surfels on true geometry, which form a splat without training."""

import numpy as np

from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.reconstruction.surfels.surfels import (
    Surfels,
    splat_of_surfels,
)
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.box_surface import box_surface, cell_centers
from remosplat_drake.scene.primitive_scene import Box, Cylinder, PrimitiveScene
from remosplat_drake.splat.gaussian_splat import GaussianSplat

SURFEL_COUNT = 60_000
"""Default number of surfels, about the number in the paper's splats."""

_GRAY = 0.6


def surfel_splat(
    scene: PrimitiveScene, count: int = SURFEL_COUNT
) -> GaussianSplat:
    """Covers a scene's visible surfaces evenly and deterministically.

    Surface points inside another primitive are omitted, since a camera cannot
    see them.

    Args:
        scene: Scene of boxes and cylinders.
        count: Approximate number of surfels, including hidden surfels, which
            are omitted.

    Returns:
        The surfels as a splat, expressed in W.
    """
    area = sum(_area(primitive) for primitive in scene.primitives)
    spacing = np.sqrt(area / count)
    samples = [_sample(primitive, spacing) for primitive in scene.primitives]
    p_WK = np.concatenate([points for points, _ in samples])
    normal_W = np.concatenate([normals for _, normals in samples])
    # A point on a surface is at distance 0 of its own primitive.
    distance = SignedDistanceField(scene).clearances(Spheres.at(p_WK))
    visible = distance.per_sphere(len(p_WK)) > -1e-6
    p_WK, normal_W = p_WK[visible], normal_W[visible]
    n = len(p_WK)
    return splat_of_surfels(
        Surfels(p_WK, normal_W, np.full((n, 3), _GRAY), np.full(n, spacing))
    )


def _sample(
    primitive: Box | Cylinder, spacing: float
) -> tuple[np.ndarray, np.ndarray]:
    """Samples points (n, 3) and outward normals (n, 3) on a surface."""
    if isinstance(primitive, Box):
        p_PK, normal_P = box_surface(primitive.half_extents, spacing)
    else:
        p_PK, normal_P = _cylinder_samples(primitive, spacing)
    X_WP = primitive.X_WP.GetAsMatrix4()
    return p_PK @ X_WP[:3, :3].T + X_WP[:3, 3], normal_P @ X_WP[:3, :3].T


def _cylinder_samples(
    cylinder: Cylinder, spacing: float
) -> tuple[np.ndarray, np.ndarray]:
    radius, half = cylinder.radius, cylinder.half_height
    angles = _circle(radius, spacing)
    A, Z = (x.ravel() for x in np.meshgrid(angles, cell_centers(half, spacing)))
    outward = np.stack([np.cos(A), np.sin(A), np.zeros_like(A)], axis=1)
    points = [radius * outward + Z[:, None] * [0, 0, 1]]
    normals = [outward]
    rings = cell_centers(radius / 2, spacing) + radius / 2
    disc = np.concatenate(
        [
            r * np.stack([np.cos(a), np.sin(a), 0 * a], axis=1)
            for r in rings
            for a in [_circle(r, spacing)]
        ]
    )
    for side in (-1.0, 1.0):
        points.append(disc + np.array([0, 0, side * half]))
        normals.append(np.tile([0, 0, side], (len(disc), 1)))
    return np.concatenate(points), np.concatenate(normals)


def _circle(radius: float, spacing: float) -> np.ndarray:
    """Returns angles that divide a circle evenly [rad]."""
    n = max(3, int(np.ceil(2 * np.pi * radius / spacing)))
    return 2 * np.pi * np.arange(n) / n


def _area(primitive: Box | Cylinder) -> float:
    if isinstance(primitive, Box):
        x, y, z = 2 * primitive.half_extents
        return float(2 * (x * y + y * z + z * x))
    r, h = primitive.radius, 2 * primitive.half_height
    return float(2 * np.pi * r * (r + h))
