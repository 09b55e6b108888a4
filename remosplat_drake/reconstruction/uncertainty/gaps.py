"""Finds and closes gaps: measured surfaces that no disc of a splat covers.

If a 1-Lipschitz distance field has the value g at a surface point, it
over-estimates the distance to this point by at most g, at any position. So the
field's values at the measured points bound its over-estimates, regardless of
the method that made the discs. Discs are added at points with too large values.
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
from remosplat_drake.reconstruction.uncertainty.voxel_normals import (
    facing_normals,
)
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.splat.gaussian_splat import GaussianSplat

LARGEST_GAP = 0.0015
"""Gaps up to this size are not closed [m]."""

_TINY = 0.0005
"""There is no gap at a measured point that is at most this far from the splat
[m]."""

_SIGNIFICANT, _STEPS = 4.0, 13
"""Noise may displace a point by this many standard deviations (first number).
The distance is evaluated at this many positions within this range (second
number).
"""

_VOXEL = 0.008
"""Points get a common disc if their distance is less than about this [m]."""


def gaps(
    splat_W: GaussianSplat, measured: MeasuredVoxels
) -> tuple[np.ndarray, np.ndarray]:
    """Computes the distances of measured points from a splat.

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
    splat_W: GaussianSplat, measured: MeasuredVoxels, confirmed: np.ndarray
) -> GaussianSplat:
    """Adds discs at measured points that are far from all discs.

    They are necessary at thin objects, at edges, and at surfaces seen at
    grazing angles, whose discs may have been lost or never made. Discs are also
    added at unconfirmed points, since no view has shown free space at these
    points. But the gap of an unconfirmed point must exceed its noise, and more
    of these points get a common disc.

    Args:
        splat_W: Discs, in W.
        measured: The n measurements.
        confirmed: Mask of the confirmed measurements, shape (n,), bool.

    Returns:
        The splat, with the added discs at the end of its arrays.
    """
    splat_W = _covering(splat_W, measured, confirmed, LARGEST_GAP, _VOXEL)
    if confirmed.all():
        return splat_W
    noise = np.maximum(measured.sigma, LARGEST_GAP)
    voxel = max(_VOXEL, 2 * float(np.median(noise[~confirmed])))
    return _covering(splat_W, measured, ~confirmed, noise, voxel)


def _covering(
    splat_W: GaussianSplat,
    measured: MeasuredVoxels,
    chosen: np.ndarray,
    largest: np.ndarray | float,
    voxel: float,
) -> GaussianSplat:
    """Adds discs at those of the chosen points that have too large gaps."""
    distance, nearest = np.zeros(len(measured)), np.zeros(len(measured), int)
    distance[chosen], nearest[chosen] = gaps(splat_W, measured.select(chosen))
    bare = distance > largest
    if not bare.any():
        return splat_W
    p_WK = voxel_means(measured.p_W[bare], voxel)
    own = np.flatnonzero(bare)[KDTree(measured.p_W[bare]).query(p_WK)[1]]
    patches = Surfels(
        p_WK,
        facing_normals(p_WK, measured.p_W, measured.ray_W[own]),
        splat_W.colors[nearest[own]].astype(float),
        np.full(len(p_WK), voxel),
    )
    return splat_W.joined_with(splat_of_surfels(patches, scale=0.75))
