"""Computes normals of measured surfaces from neighbouring points."""

import numpy as np
from scipy.spatial import KDTree

_REACH = 0.03
"""A point's normal is computed from points up to this distance from it [m]."""

_NEIGHBORS = 12

_SMALL = 0.0005
"""Length that is added to the extent of the points [m], so that the preference
for facing planes also has an effect for a single point.
"""

_FACING = 0.1
"""Weight of the preference for planes that face the cameras, as a fraction of
the points' variance. It rotates well determined normals by at most a few
degrees."""


def facing_normals(
    p_W: np.ndarray, surface_W: np.ndarray, ray_W: np.ndarray
) -> np.ndarray:
    """Computes normals of points from the surface points around them.

    Points on a rod lie in many planes, of which the one that faces the cameras
    is used.

    Args:
        p_W: The points, shape (n, 3) [m].
        surface_W: Measured points of all surfaces, shape (m, 3) [m].
        ray_W: Mean directions from the cameras to the points, shape (n, 3).

    Returns:
        Unit normals, of either sign, shape (n, 3).
    """
    tree = KDTree(surface_W)
    apart, near = tree.query(p_W, _NEIGHBORS, distance_upper_bound=_REACH)
    weight = np.isfinite(apart)[..., None]
    around = surface_W[np.minimum(near, tree.n - 1)]
    total = np.maximum(weight.sum(axis=1, keepdims=True), 1)
    mean = (weight * around).sum(axis=1, keepdims=True) / total
    offset = (around - mean) * weight
    covariance = np.einsum("nki,nkj->nij", offset, offset)
    size = np.trace(covariance, axis1=1, axis2=2) + _SMALL**2
    facing = np.einsum("ni,nj->nij", ray_W, ray_W)
    covariance -= _FACING * size[:, None, None] * facing
    return np.linalg.eigh(covariance)[1][:, :, 0]
