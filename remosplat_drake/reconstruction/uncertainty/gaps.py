"""Gaps: measured surfaces that no disc of a splat covers.

If a 1-Lipschitz distance field has the value g at a surface point, it
over-estimates the distance to this point nowhere by more than g. So the field's
values at the measured points bound its over-estimates, for any method that made
the discs. At points with too large values, discs are added.
"""

import numpy as np
from scipy.spatial import KDTree

from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.reconstruction.measured_space import voxel_means
from remosplat_drake.reconstruction.surfels.surfels import (
    Surfels,
    splat_of_surfels,
)
from remosplat_drake.reconstruction.uncertainty.measured_voxels import (
    MeasuredVoxels,
)
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.splat.gaussian_splat import GaussianSplat

LARGEST_GAP = 0.0015
"""Largest gap that remains [m]."""

_TINY = 0.0005
"""Distances up to this are not gaps [m]."""

_SIGNIFICANT, _STEPS = 4.0, 13
"""Number of standard deviations by which noise may displace points, and number
of positions that are tried in this range."""

_VOXEL = 0.008
"""Points that are nearer to each other than about this share a disc [m]."""

_REACH = 0.03
"""Points up to this distance apart belong to one surface [m]."""

_NEIGHBORS = 12

_FACING = 0.1
"""Weight of the preference for planes that face the cameras, as a fraction of
the points' variance. It rotates well determined normals by at most a few
degrees."""


def gaps(
    splat_W: GaussianSplat, measured: MeasuredVoxels
) -> tuple[np.ndarray, np.ndarray]:
    """Measures the distances of measured points from a splat, less noise.

    Noise displaces a point along its ray. So the result for a point is the
    least distance between the splat and any position on the ray within
    `_SIGNIFICANT` standard deviations of the point.

    Args:
        splat_W: Discs, in W.
        measured: The measurements.

    Returns:
        Distances, shape (n,) [m], and the indices of the nearest discs, (n,).
    """
    field = SphereToEllipsoidField(splat_W, min_opacity=0.0)
    nearest, distance = field.nearest_splats(Spheres.at(measured.p_W))
    open_ = np.flatnonzero(distance > _TINY)
    for step in np.linspace(-_SIGNIFICANT, _SIGNIFICANT, _STEPS):
        offset = step * measured.sigma[open_, None] * measured.ray_W[open_]
        points = Spheres.at(measured.p_W[open_] + offset)
        moved = field.clearances(points).per_sphere(len(points))
        distance[open_] = np.minimum(distance[open_], moved)
    return distance, nearest


def close_gaps(
    splat_W: GaussianSplat,
    measured: MeasuredVoxels,
    largest: float = LARGEST_GAP,
) -> GaussianSplat:
    """Adds discs at measured points that are far from all discs.

    They are necessary at thin objects, at edges, and at surfaces seen at
    grazing angles, whose discs may have been lost or never made.

    Args:
        splat_W: Discs, in W.
        measured: The measurements.
        largest: Largest gap that remains [m].

    Returns:
        The splat, with more discs at its end.
    """
    distance, nearest = gaps(splat_W, measured)
    bare = distance > largest
    if not bare.any():
        return splat_W
    p_WK = voxel_means(measured.p_W[bare], _VOXEL)
    voxel = KDTree(measured.p_W).query(p_WK)[1]
    colors = splat_W.colors[nearest[voxel]]
    patches = Surfels(
        p_WK,
        _normals(p_WK, measured.p_W, measured.ray_W[voxel]),
        colors.astype(float),
        np.full(len(p_WK), _VOXEL),
    )
    return splat_W.joined_with(splat_of_surfels(patches, scale=0.75))


def _normals(
    p_W: np.ndarray, surface_W: np.ndarray, ray_W: np.ndarray
) -> np.ndarray:
    """Returns normals of planes through the points around each, (n, 3).

    Points on a rod lie in many planes. The plane that faces the cameras is
    used.
    """
    tree = KDTree(surface_W)
    apart, near = tree.query(p_W, _NEIGHBORS, distance_upper_bound=_REACH)
    weight = np.isfinite(apart)[..., None]
    around = surface_W[np.minimum(near, tree.n - 1)]
    total = np.maximum(weight.sum(axis=1, keepdims=True), 1)
    mean = (weight * around).sum(axis=1, keepdims=True) / total
    offset = (around - mean) * weight
    covariance = np.einsum("nki,nkj->nij", offset, offset)
    size = np.trace(covariance, axis1=1, axis2=2) + _TINY**2
    facing = np.einsum("ni,nj->nij", ray_W, ray_W)
    covariance -= _FACING * size[:, None, None] * facing
    return np.linalg.eigh(covariance)[1][:, :, 0]
