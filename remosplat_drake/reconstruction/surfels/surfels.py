"""Makes the surfels (oriented points) with which a reconstruction starts.

Every pixel with a depth is a point on a surface; its normal is computed from
neighbouring pixels. The points are averaged in voxels, so that the surfels
cover the measured surfaces evenly. The voxels are as small as the largest
number of surfels allows.
"""

import dataclasses as dc

import numpy as np
from scipy.spatial import KDTree

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.capture.capture import Capture
from remosplat_drake.reconstruction.surfels.normals import depth_normals
from remosplat_drake.splat.gaussian_splat import GaussianSplat

_FINE_RADIUS = 0.6
"""Voxels within this distance of the focus have the smallest size [m]."""

_MAX_SAMPLES = 6_000_000
"""At most this many pixels are used, which limits memory to 216 MB."""

_LARGEST_VOXEL = 16.0
"""To limit the number of surfels, voxels are enlarged, at most to this edge
length [m].
"""


@dc.dataclass(frozen=True, eq=False)
class Surfels:
    """Oriented, coloured points on surfaces (Pfister et al., 2000); n surfels.

    Attributes:
        p_WK: Centres, shape (n, 3) [m].
        normal_W: Unit normals, towards the camera, shape (n, 3).
        colors: RGB in [0, 1], shape (n, 3).
        spacing: Mean distance to the three nearest surfels, shape (n,) [m].
    """

    p_WK: np.ndarray
    normal_W: np.ndarray
    colors: np.ndarray
    spacing: np.ndarray

    def __len__(self) -> int:
        return len(self.p_WK)


def surfels_from_capture(
    capture: Capture,
    count: int = 60_000,
    focus: np.ndarray | None = None,
    stride: int = 2,
) -> Surfels:
    """Covers the captured surfaces evenly with at most `count` surfels.

    Args:
        capture: Posed RGB-D images.
        count: Largest number of surfels; the result has nearly as many.
        focus: A point in W around which the spacing is smallest, shape (3,)
            [m]. Beyond 0.6 m, the spacing doubles with every doubling of the
            distance. None: the spacing is the same everywhere.
        stride: Step between the rows, and between the columns, of the images
            that are used; it is increased if there are too many pixels.

    Raises:
        RemoSplatError: No pixel of the capture has a depth with a normal.
    """
    pixels = capture.depth.size
    stride = max(stride, int(np.ceil(np.sqrt(pixels / _MAX_SAMPLES))))
    views = [_view_samples(capture, i, stride) for i in range(len(capture))]
    samples = np.concatenate(views)
    if not len(samples):
        raise RemoSplatError("the capture has no depth to start from")
    level = np.zeros(len(samples), np.int64)
    if focus is not None:
        distance = np.linalg.norm(samples[:, :3] - focus, axis=1)
        doublings = np.log2(np.maximum(distance / _FINE_RADIUS, 1))
        level = np.ceil(doublings).astype(np.int64)
    voxel = _voxel_for(samples, level, count)
    pooled = _pool(samples, _voxel_keys(samples, level, voxel))
    p_WK, normal_W = pooled[:, :3], pooled[:, 3:6]
    neighbors, _ = KDTree(p_WK).query(p_WK, k=min(4, len(p_WK)))
    return Surfels(
        p_WK=p_WK,
        normal_W=normal_W / np.linalg.norm(normal_W, axis=1, keepdims=True),
        colors=pooled[:, 6:],
        spacing=neighbors[:, 1:].mean(axis=1),
    )


def splat_of_surfels(
    surfels: Surfels, scale: float = 0.6, opacity: float = 0.95
) -> GaussianSplat:
    """Makes a splat with one disc per surfel, without training or a GPU.

    Args:
        surfels: The surfels; each becomes a disc.
        scale: Standard deviation of a disc, as a multiple of its surfel's
            spacing. With 0.6, discs overlap just enough that no gaps are
            visible.
        opacity: Opacity of every disc.
    """
    n = len(surfels)
    return GaussianSplat(
        p_GK=surfels.p_WK,
        quaternions=quaternions_onto(surfels.normal_W),
        scales=np.repeat(scale * surfels.spacing[:, None], 2, axis=1),
        opacities=np.full(n, opacity),
        colors=surfels.colors,
    )


def quaternions_onto(normals: np.ndarray) -> np.ndarray:
    """Computes the shortest rotations of the z axis onto unit normals.

    Args:
        normals: Unit vectors, shape (n, 3).

    Returns:
        Quaternions wxyz, shape (n, 4).
    """
    x, y, z = normals.T
    zero = np.zeros_like(x)
    quaternions = np.stack([1 + z, -y, x, zero], axis=1)
    # For the -z axis, the shortest rotation is not unique; half a turn about x
    # is used.
    quaternions[1 + z < 1e-8] = [0, 1, 0, 0]
    return quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True)


def _view_samples(capture: Capture, view: int, stride: int) -> np.ndarray:
    """Rows [point, normal, colour] of a view's usable pixels, (m, 9)."""
    pick = (slice(None, None, stride),) * 2
    normal_C = depth_normals(capture.K[view], capture.depth[view])[pick]
    samples = np.concatenate(
        [
            capture.points_W(view)[pick],
            normal_C @ capture.X_WC[view, :3, :3].T,
            capture.rgb[view][pick] / 255.0,
        ],
        axis=-1,
    ).reshape(-1, 9)
    return samples[np.isfinite(samples).all(axis=1)].astype(np.float32)


def _voxel_for(samples: np.ndarray, level: np.ndarray, count: int) -> float:
    """Edge length that makes nearly `count` voxels, and not more [m].

    For a first estimate, the number of a surface's voxels is proportional to 1
        / edge^2.
    """

    def found_with(voxel: float) -> int:
        return len(np.unique(_voxel_keys(samples, level, voxel)))

    fine, coarse = 0.001, 0.128
    while coarse < _LARGEST_VOXEL and found_with(coarse) > count:
        fine, coarse = coarse, 2 * coarse
    voxel = np.sqrt(fine * coarse)
    for _ in range(12):
        found = found_with(voxel)
        fine, coarse = (voxel, coarse) if found > count else (fine, voxel)
        if 0.98 * count <= found <= count or coarse < 1.003 * fine:
            break
        guess = voxel * np.sqrt(found / (0.99 * count))
        voxel = guess if fine < guess < coarse else np.sqrt(fine * coarse)
    return coarse


def _voxel_keys(
    samples: np.ndarray, level: np.ndarray, voxel: float
) -> np.ndarray:
    """One integer per sample, from its voxel, level and the side it faces.

    Because of the side, samples of the two sides of a thin board, or of two
    faces that meet at an edge, are not averaged to a surface that does not
    exist.
    """
    cell = np.floor(samples[:, :3] / (voxel * 2.0**level)[:, None])
    cell = cell.astype(np.int64) + (1 << 15)
    normal = samples[:, 3:6]
    axis = np.abs(normal).argmax(axis=1)
    positive = np.take_along_axis(normal, axis[:, None], axis=1)[:, 0] > 0
    face = 2 * axis + positive
    key = cell[:, 0]
    for part, size in (
        (cell[:, 1], 1 << 16),
        (cell[:, 2], 1 << 16),
        (face, 8),
        (level, 8),
    ):
        key = key * size + part
    return key


def _pool(samples: np.ndarray, keys: np.ndarray) -> np.ndarray:
    """Means of the samples that have the same key, (n, 9)."""
    _, group, counts = np.unique(keys, return_inverse=True, return_counts=True)
    sums = np.stack(
        [np.bincount(group, weights=column) for column in samples.T], axis=1
    )
    return sums / counts[:, None]
