"""`MeasuredVoxels`: measurements of all depth images, averaged in voxels."""

import dataclasses as dc

import numpy as np

from remosplat_drake.capture.capture import Capture
from remosplat_drake.reconstruction.measured_space import times_looked_through
from remosplat_drake.reconstruction.surfels.surfel_gathering import DepthNoise
from remosplat_drake.reconstruction.uncertainty.voxel_normals import (
    facing_normals,
)

_VOXEL = (0.005, 0.015)
"""Least and greatest edge length of the voxels [m]."""

_NOISE_PER_VOXEL = 6.0
"""The edge of the voxels is this multiple of the noise at a depth of 1 m, so
that each voxel contains several points."""

_PAST = 0.012
"""A view shows free space at a point if it measured a surface at least this far
behind the point [m].
"""

_NEARLY_EXACT = 5e-4
"""A single view confirms a point if the point's standard deviation is less than
this [m].
"""

_MAX_SAMPLES = 6_000_000
"""At most this many pixels are used, to limit memory. They are an even
selection of all pixels.
"""


@dc.dataclass(frozen=True, eq=False)
class MeasuredVoxels:
    """n voxels in which depth images have measured a surface.

    Attributes:
        p_W: Means of the pixels' points in each voxel, shape (n, 3) [m].
        ray_W: Mean of the unit vectors from the cameras to the voxel, shape (n,
            3). It is shorter than 1 if cameras saw the voxel from different
            directions.
        sigma: Standard deviation of these means due to the depth's noise, shape
            (n,) [m].
        views: Number of views that contributed to each voxel, shape (n,).
    """

    p_W: np.ndarray
    ray_W: np.ndarray
    sigma: np.ndarray
    views: np.ndarray

    def __len__(self) -> int:
        return len(self.p_W)

    def is_confirmed(self, largest_sigma: float) -> np.ndarray:
        """Returns a mask of voxels with a confirmed surface, (n,), bool.

        Noise and silhouettes create false points in single views. So a point
        with noisy depth is confirmed only if two views measured it.

        Args:
            largest_sigma: Largest standard deviation of a confirmed point [m].
        """
        agreed = (self.views > 1) | (self.sigma < _NEARLY_EXACT)
        return agreed & (self.sigma < largest_sigma)

    def select(self, keep: np.ndarray) -> "MeasuredVoxels":
        """Returns the voxels that a mask or an index array selects."""
        return MeasuredVoxels(
            self.p_W[keep],
            self.ray_W[keep],
            self.sigma[keep],
            self.views[keep],
        )


def measured_voxels(capture: Capture, noise: DepthNoise) -> MeasuredVoxels:
    """Averages the measured points of all views in voxels.

    A point is removed if at least as many views have measured surfaces behind
    it as have measured the point. Depth cameras create such false points at
    silhouettes. Views at a grazing angle to the point's surface do not count,
    since their rays may pass on both sides of a leaf or a slat.

    Args:
        capture: Posed RGB-D images.
        noise: Noise of the images' depth.
    """
    stride = max(1, int(np.ceil(np.sqrt(capture.depth.size / _MAX_SAMPLES))))
    voxel = _NOISE_PER_VOXEL * (noise.floor + noise.growth)
    voxel = float(np.clip(voxel, *_VOXEL))
    rows = [np.zeros((0, 8))]
    for view in range(len(capture)):
        rows.append(_rows(capture, view, stride, noise))
    pooled = _pooled(np.concatenate(rows), voxel)
    return pooled.select(~_is_refuted(capture, pooled))


def _is_refuted(capture: Capture, pooled: MeasuredVoxels) -> np.ndarray:
    """Mask of the points behind which too many views saw surfaces, (n,)."""
    through = times_looked_through(capture, pooled.p_W, _PAST)
    refuted = through >= pooled.views
    doubted = pooled.select(refuted)
    normal_W = facing_normals(doubted.p_W, pooled.p_W, doubted.ray_W)
    through = times_looked_through(
        capture, doubted.p_W, _PAST, normal_W=normal_W
    )
    refuted[refuted] = through >= doubted.views
    return refuted


def _rows(
    capture: Capture, view: int, stride: int, noise: DepthNoise
) -> np.ndarray:
    """Rows [point, ray, 1 / sigma^2, view] of a view's pixels with depth."""
    z = capture.depth[view, ::stride, ::stride].reshape(-1).astype(float)
    known = z > 0
    p_W = capture.points_W(view)[::stride, ::stride].reshape(-1, 3)[known]
    weight = noise.deviation(z[known]) ** -2
    ray_W = p_W - capture.X_WC[view, :3, 3]
    ray_W /= np.linalg.norm(ray_W, axis=1, keepdims=True)
    number = np.full(len(p_W), view)
    return np.column_stack([p_W, ray_W, weight, number])


def _pooled(rows: np.ndarray, voxel: float) -> MeasuredVoxels:
    """Means of the rows that are in the same voxel."""
    cell = np.floor(rows[:, :3] / voxel).astype(np.int64)
    cell -= cell.min(axis=0, initial=0)
    shape = cell.max(axis=0, initial=0) + 1
    key = (cell[:, 0] * shape[1] + cell[:, 1]) * shape[2] + cell[:, 2]
    order = np.lexsort((rows[:, 7], key))
    rows, key = rows[order], key[order]
    fresh = np.diff(key, prepend=-1) != 0
    fresh_view = fresh | (np.diff(rows[:, 7], prepend=-1) != 0)
    group = np.cumsum(fresh) - 1
    count = int(fresh.sum())

    def total(values: np.ndarray | None, of: np.ndarray = group) -> np.ndarray:
        return np.bincount(of, weights=values, minlength=count)

    weight = total(rows[:, 6])
    means = [total(rows[:, 6] * rows[:, k]) / weight for k in range(6)]
    return MeasuredVoxels(
        p_W=np.stack(means[:3], axis=1),
        ray_W=np.stack(means[3:], axis=1),
        sigma=1 / np.sqrt(weight),
        views=total(None, group[fresh_view]),
    )
