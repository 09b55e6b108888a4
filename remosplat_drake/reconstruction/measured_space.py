"""Computes measured surfaces and free space from a capture's depth images.

A pixel with a depth shows free space up to that depth. If the true geometry is
unknown, the depth images are the reference for surfaces, floaters and free
space.
"""

from functools import partial

import numpy as np
from scipy.ndimage import minimum_filter
from scipy.spatial import KDTree

from remosplat_drake.base.kernels import kernel
from remosplat_drake.base.threads import blocks, in_parallel
from remosplat_drake.capture.capture import Capture

_MAX_SAMPLES = 4_000_000
"""Largest number of pixels that are used. More pixels would not improve the
mean points of voxels, which are some millimetres large.
"""

_NOISE_DEPTH = 2.0
"""Depth beyond which a margin grows with the square of the depth [m], like the
noise of triangulating cameras.
"""

_BLOCK = 50_000
"""Number of points that a thread processes at a time."""

_GRAZING = 0.3
"""Cosine of the largest angle of incidence (73 degrees) at which a view can
contradict a surface. At more grazing angles, two neighbouring rays may pass on
both sides of a leaf or a slat.
"""

_DRAWS = 20
"""Number of attempts to find free points."""

_NOISY_VOXEL = 0.01
"""Edge length of voxels that contain enough noisy points for a mean [m]."""

_SMOOTH_RADIUS, _MIN_NEIGHBORS = 0.03, 6
"""Radius of the neighbourhood of a point to which a plane is fitted [m], and
least number of points in it.
"""


def measured_points(
    capture: Capture,
    lower: np.ndarray,
    upper: np.ndarray,
    voxel: float = 0.003,
) -> np.ndarray:
    """Computes points on the surfaces that a capture measured.

    Each result is the mean of the pixels' points in one voxel. Points are
    removed if two views measured surfaces behind them, since depth cameras
    create false points at silhouettes, between an object and its background. In
    a noisy capture, the points of a wall form a thick layer, and distances
    would be measured to the outermost points. So `thinned` reduces the points
    of a noisy capture to a thin layer, in voxels of 1 cm.

    If the points of a wall are s apart, the distance d to the nearest point
    exceeds the distance to the wall by at most s^2 / 4d. At a distance of 3 cm,
    this is 0.1 mm for points 3 mm apart, and 0.8 mm for points 1 cm apart.

    Args:
        capture: Posed RGB-D images.
        lower: Lower corner of a box in W, shape (3,) [m]; points outside are
            left out.
        upper: Upper corner of the box, shape (3,) [m].
        voxel: Edge length of a voxel [m].

    Returns:
        Points in W, shape (n, 3) [m].
    """
    height, width = capture.size
    pixels = len(capture) * height * width
    stride = max(1, int(np.ceil(np.sqrt(pixels / _MAX_SAMPLES))))
    clouds = []
    for view in range(len(capture)):
        p_W = capture.points_W(view)[::stride, ::stride].reshape(-1, 3)
        with np.errstate(invalid="ignore"):
            inside = ((p_W >= lower) & (p_W <= upper)).all(axis=1)
        clouds.append(p_W[inside])
    p_W = voxel_means(np.concatenate(clouds), voxel)
    p_W = p_W[times_looked_through(capture, p_W) < 2]
    if scatter(p_W) < voxel / 2:
        return p_W
    return thinned(voxel_means(p_W, _NOISY_VOXEL))


def voxel_means(p_W: np.ndarray, voxel: float) -> np.ndarray:
    """Returns the mean of the points (n, 3) in each occupied voxel [m]."""
    if not len(p_W):
        return p_W.reshape(0, 3)
    cell = np.floor((p_W - p_W.min(axis=0)) / voxel).astype(np.int64)
    shape = cell.max(axis=0) + 1
    key = (cell[:, 0] * shape[1] + cell[:, 1]) * shape[2] + cell[:, 2]
    _, group, count = np.unique(key, return_inverse=True, return_counts=True)
    sums = [np.bincount(group, weights=column) for column in p_W.T]
    return np.stack(sums, axis=1) / count[:, None]


def scatter(p_W: np.ndarray, count: int = 500, seed: int = 0) -> float:
    """Estimates the noise of a point cloud: the thickness of its surfaces [m].

    For each of `count` random points, a plane is fitted to the points around
    it, and the standard deviation of their distances from this plane is
    computed. The result is the median of these deviations. It is 0 if no point
    has enough neighbours.
    """
    if len(p_W) < _MIN_NEIGHBORS:
        return 0.0
    tree = KDTree(p_W)
    chosen = np.random.default_rng(seed).choice(len(p_W), count)
    spreads = [
        np.sqrt(max(np.linalg.eigvalsh(np.cov(p_W[near].T))[0], 0))
        for near in tree.query_ball_point(p_W[chosen], _SMOOTH_RADIUS)
        if len(near) >= _MIN_NEIGHBORS
    ]
    return float(np.median(spreads)) if spreads else 0.0


def thinned(p_W: np.ndarray, passes: int = 2) -> np.ndarray:
    """Thins a point cloud: moves each point onto the mean of its surroundings.

    Points move along their normals, so that a layer of noisy points becomes a
    surface (moving least squares of degree 0). Edges are rounded off by
    millimetres.

    Args:
        p_W: Points, shape (n, 3) [m].
        passes: Number of iterations, each of which moves every point.
    """
    for _ in range(passes):
        tree = KDTree(p_W)
        # Points are moved in parts, to limit the memory.
        parts = np.array_split(p_W, max(1, len(p_W) // 50_000))
        moved = in_parallel(partial(_onto_mean, tree=tree), parts)
        p_W = np.concatenate(moved)
    return p_W


def _onto_mean(p_W: np.ndarray, tree: KDTree) -> np.ndarray:
    """The points, each moved along the normal onto the mean around it."""
    offset, near = tree.query(p_W, k=32, distance_upper_bound=_SMOOTH_RADIUS)
    weight = np.isfinite(offset).astype(float)
    around = tree.data[np.minimum(near, tree.n - 1)]
    total = weight.sum(axis=1, keepdims=True)
    mean = (weight[:, None] @ around)[:, 0] / total
    centered = (around - mean[:, None]) * weight[..., None]
    covariance = centered.transpose(0, 2, 1) @ centered
    normal = np.linalg.eigh(covariance)[1][:, :, 0]
    height = ((mean - p_W) * normal).sum(axis=1, keepdims=True)
    return np.where(total >= _MIN_NEIGHBORS, p_W + height * normal, p_W)


def times_looked_through(
    capture: Capture,
    p_W: np.ndarray,
    margin: float = 0.03,
    pitch: np.ndarray | None = None,
    normal_W: np.ndarray | None = None,
) -> np.ndarray:
    """Counts the views that have measured a surface behind each point.

    Args:
        capture: Posed RGB-D images.
        p_W: Points in W, shape (n, 3) [m].
        margin: A view counts if its depths at the point's pixel and at all
            neighbours of this pixel exceed the point's depth by more than this
            [m]; beyond a depth of 2 m, the margin grows with the square of the
            depth.
        pitch: Largest distance between a view's pixels at each point, shape
            (n,) [m]; None for any distance.
        normal_W: Unit normals of the surfaces that contain the points, shape
            (n, 3). The margin is then measured along the normals, so that a
            camera whose pose is slightly too low does not contradict a floor. A
            view at a grazing angle (beyond 73 degrees) does not count. None:
            the margin is measured along the depth.

    Returns:
        Number of views for each point, shape (n,).
    """
    fronts = in_parallel(nearest_around, capture.depth)

    def counted(rows: slice) -> np.ndarray:
        count = np.zeros(len(p_W[rows]), np.int64)
        near = None if pitch is None else pitch[rows]
        normals = None if normal_W is None else normal_W[rows]
        for view, front in enumerate(fronts):
            count += is_behind(
                capture, view, front, p_W[rows], margin, near, normals
            )
        return count

    counts = in_parallel(counted, blocks(len(p_W), _BLOCK))
    return np.concatenate([np.zeros(0, np.int64), *counts])


def is_behind(
    capture: Capture,
    view: int,
    front: np.ndarray,
    p_W: np.ndarray,
    margin: float,
    pitch: np.ndarray | None = None,
    normal_W: np.ndarray | None = None,
) -> np.ndarray:
    """Returns a mask of the points behind which a view measured a surface.

    Args:
        capture: Posed RGB-D images.
        view: Index of the view.
        front: The result of `nearest_around` for its depth, shape (h, w) [m].
        p_W: Points in W, shape (n, 3) [m].
        margin: See `times_looked_through` [m].
        pitch: See `times_looked_through` [m].
        normal_W: See `times_looked_through`.

    Returns:
        Shape (n,), bool.
    """
    behind = np.zeros(len(p_W), bool)
    if normal_W is None:
        # Without normals, the margin is along the depth.
        normal_W = np.tile(capture.X_WC[view, :3, 2], (len(p_W), 1))
    _find_behind(
        front,
        capture.K[view].astype(float),
        capture.X_WC[view].astype(float),
        np.ascontiguousarray(p_W, float),
        margin,
        np.full(len(p_W), np.inf) if pitch is None else pitch,
        np.ascontiguousarray(normal_W, float),
        behind,
    )
    return behind


@kernel
def _find_behind(front, K, X_WC, p_W, margin, pitch, normal_W, behind):
    """Marks the points in front of a depth image's surfaces."""
    height, width = front.shape
    for i in range(len(p_W)):
        x = p_W[i, 0] - X_WC[0, 3]
        y = p_W[i, 1] - X_WC[1, 3]
        z = p_W[i, 2] - X_WC[2, 3]
        z_C = X_WC[0, 2] * x + X_WC[1, 2] * y + X_WC[2, 2] * z
        if z_C <= 0 or z_C > pitch[i] * min(K[0, 0], K[1, 1]):
            continue
        x_C = X_WC[0, 0] * x + X_WC[1, 0] * y + X_WC[2, 0] * z
        y_C = X_WC[0, 1] * x + X_WC[1, 1] * y + X_WC[2, 1] * z
        column = np.floor(K[0, 0] * x_C / z_C + K[0, 2])
        row = np.floor(K[1, 1] * y_C / z_C + K[1, 2])
        if 0 <= column < width and 0 <= row < height:
            along = abs(
                normal_W[i, 0] * x + normal_W[i, 1] * y + normal_W[i, 2] * z
            )
            if along < _GRAZING * np.sqrt(x * x + y * y + z * z):
                continue
            # Distance from the surface per depth along the ray.
            steepness = min(along / z_C, 1.0)
            enough = margin * max(1.0, z_C / _NOISE_DEPTH) ** 2 / steepness
            behind[i] = front[int(row), int(column)] > z_C + enough


def nearest_around(depth: np.ndarray) -> np.ndarray:
    """Returns the least depth of each pixel and its neighbours, (h, w) [m].

    It is 0 (unknown) where the pixel or one of its neighbours is unknown.
    """
    return minimum_filter(depth, 3, mode="nearest")


def free_points(
    capture: Capture,
    count: int,
    lower: np.ndarray,
    upper: np.ndarray,
    farthest: float = 0.5,
    seed: int = 0,
) -> np.ndarray:
    """Draws points of free space in a box of W.

    Each point is on the ray of a random pixel, in front of the measured surface
    by a random length of up to `farthest`.

    Args:
        capture: Posed RGB-D images.
        count: Number of points.
        lower: Lower corner of the box, shape (3,) [m].
        upper: Upper corner of the box, shape (3,) [m].
        farthest: Largest distance from the measured point, along the ray [m].
        seed: Seed of the random choice.

    Returns:
        Shape (n, 3) [m]; n < count if only a small part of the box was seen.
    """
    rng = np.random.default_rng(seed)
    points, found = [], 0
    for _ in range(_DRAWS):
        p_W = _draw_before_surfaces(capture, count, farthest, rng)
        p_W = p_W[((p_W >= lower) & (p_W <= upper)).all(axis=1)]
        points.append(p_W)
        found += len(p_W)
        if found >= count:
            break
    return np.concatenate(points)[:count]


def _draw_before_surfaces(
    capture: Capture, count: int, farthest: float, rng: np.random.Generator
) -> np.ndarray:
    """Draws points on the rays of `count` random pixels that have a depth."""
    height, width = capture.size
    view = np.sort(rng.integers(len(capture), size=count))
    pixel = rng.integers(height * width, size=count)
    z = capture.depth.reshape(len(capture), -1)[view, pixel].astype(float)
    row, column = np.divmod(pixel, width)
    uv1 = np.stack([column + 0.5, row + 0.5, np.ones(count)], axis=1)
    ray_C = np.einsum("nij,nj->ni", np.linalg.inv(capture.K)[view], uv1)
    length = z * np.linalg.norm(ray_C, axis=1)
    back = rng.uniform(0, farthest, count)
    ahead = back < length
    part = z[ahead] * (1 - back[ahead] / length[ahead])
    X_WC = capture.X_WC[view[ahead]]
    p_C = part[:, None] * ray_C[ahead]
    return np.einsum("nij,nj->ni", X_WC[:, :3, :3], p_C) + X_WC[:, :3, 3]
