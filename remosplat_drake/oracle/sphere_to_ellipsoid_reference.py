"""Slow reference of the distance from points to ellipsoids, by bisection.

Unlike `sphere_to_ellipsoid.py`, this module uses no hierarchy, no bounds and no
Newton steps. Tests and benchmarks compare the two modules.
"""

import numpy as np

from remosplat_drake.splat.gaussian_splat import GaussianSplat


def nearest_splats(
    splat_W: GaussianSplat,
    p_WQ: np.ndarray,
    n_sigma: float = 1.0,
    chunk: int = 8,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Finds the nearest splat of each query point by a search over all splats.

    The uncertainty of a splat, if it has one, is subtracted from its distance.

    Args:
        splat_W: Discs or ellipsoids in W.
        p_WQ: Query points, shape (n, 3) [m].
        n_sigma: Length of a splat's semi-axes in standard deviations.
        chunk: Number of query points that are processed together. A small
            number takes less memory.

    Returns:
        Three arrays: the signed distance minus the uncertainty, shape (n,) [m];
        the closest point p_WC, shape (n, 3) [m]; and the index of the nearest
        splat, shape (n,), which is the lowest index if several splats are
        equally near.
    """
    distance = np.empty(len(p_WQ))
    p_WC = np.empty((len(p_WQ), 3))
    nearest = np.empty(len(p_WQ), np.int64)
    semi_axes = np.zeros((len(splat_W), 3))
    semi_axes[:, : splat_W.scales.shape[1]] = splat_W.scales
    semi_axes *= n_sigma
    p_WK = splat_W.p_GK.astype(np.float64)
    for start in range(0, len(p_WQ), chunk):
        rows = slice(start, start + chunk)
        p_KQ_W = p_WQ[rows, None, :] - p_WK
        p_KQ = np.einsum("kji,nkj->nki", splat_W.R_GK, p_KQ_W)
        p_KC = closest_points(p_KQ, semi_axes)
        d = np.linalg.norm(p_KQ - p_KC, axis=2)
        if not splat_W.is_surfel:
            inside = np.sum((p_KQ / semi_axes) ** 2, axis=2) < 1
            d = np.where(inside, -d, d)
        if splat_W.uncertainty is not None:
            d = d - splat_W.uncertainty
        k = d.argmin(axis=1)
        n = np.arange(len(k))
        nearest[rows] = k
        distance[rows] = d[n, k]
        p_WC[rows] = p_WK[k] + np.einsum(
            "nij,nj->ni", splat_W.R_GK[k], p_KC[n, k]
        )
    return distance, p_WC, nearest


def closest_points(y: np.ndarray, semi_axes: np.ndarray) -> np.ndarray:
    """Computes closest surface points of centred ellipsoids and solid discs.

    The closest point is x_i = e_i^2 y_i / (T + e_i^2). T is computed by
    bisection, such that x is on the surface (Eberly, "Distance from a Point to
    an Ellipse, an Ellipsoid, or a Hyperellipsoid").

    Args:
        y: Points, shape (..., 3) [m].
        semi_axes: Semi-axes, shape (..., 3) [m]. If the third is zero, the
            shape is a filled disc.

    Returns:
        The closest points, shape (..., 3) [m].
    """
    y, e = np.broadcast_arrays(y, semi_axes)
    is_disc = e[..., 2] == 0
    plane = np.where(is_disc[..., None], [1.0, 1.0, 0.0], 1.0)
    e = np.where(e == 0, 1.0, e)
    over_disc = is_disc & (np.sum(plane * (y / e) ** 2, axis=-1) <= 1)
    in_plane = plane * y
    shortest = np.min(np.where(plane > 0, e, np.inf), axis=-1, keepdims=True)
    n = (e / shortest) ** 2 * np.abs(in_plane) / e
    shift = (e / shortest) ** 2 - 1
    low = np.min(np.where(shift == 0, n, np.inf), axis=-1, keepdims=True)
    high = np.linalg.norm(n, axis=-1, keepdims=True)
    for _ in range(1100):
        t = 0.5 * (low + high)
        if np.all((t <= low) | (t >= high)):
            break
        outside = np.sum(_ratio(n, t + shift) ** 2, -1, keepdims=True) > 1
        low, high = np.where(outside, t, low), np.where(outside, high, t)
    p = _ratio(n, t + shift)
    # For a point in the plane of the two longer axes and near the centre, no
    # root exists. The closest point is then outside this plane, along the
    # shortest axis (the last of equally short axes).
    rest = 1 - np.sum(p**2, axis=-1)
    leaves = ~is_disc & (rest > 0) & (high[..., 0] < 1) & _none_along(n, shift)
    last = 2 - np.argmax(shift[..., ::-1] == 0, axis=-1)
    up = np.sqrt(np.maximum(rest, 0))
    axis = np.arange(3) == last[..., None]
    p = np.where(axis & leaves[..., None], up[..., None], p)
    return np.where(
        over_disc[..., None], in_plane, np.copysign(e * p, y) * plane
    )


def _ratio(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Returns the quotient a / b, or 0 where a is 0."""
    return np.divide(a, b, out=np.zeros_like(a), where=a > 0)


def _none_along(n: np.ndarray, shift: np.ndarray) -> np.ndarray:
    """Whether y has no component along any of the shortest axes."""
    return np.all((shift > 0) | (n == 0), axis=-1)


def splat_records(
    splat_W: GaussianSplat, min_opacity: float, n_sigma: float
) -> tuple[np.ndarray, np.ndarray]:
    """Returns splats in the form of `prepared_solids.splat_records`."""
    index = np.flatnonzero(splat_W.opacities >= min_opacity)
    scales = splat_W.scales[index]
    semi_axes = np.zeros((len(index), 3))
    semi_axes[:, : scales.shape[1]] = scales
    semi_axes *= n_sigma
    order = np.argsort(-semi_axes, axis=1, kind="stable")
    axes = splat_W.R_GK[index].transpose(0, 2, 1)
    records = np.empty((len(index), 16))
    records[:, :3] = splat_W.p_GK[index]
    records[:, 3:12] = np.take_along_axis(
        axes, order[:, :, None], axis=1
    ).reshape(-1, 9)
    records[:, 12:15] = np.take_along_axis(semi_axes, order, axis=1)
    records[:, 15] = 0.0
    if splat_W.uncertainty is not None:
        records[:, 15] = splat_W.uncertainty[index]
    return records, index


def boxes(records: np.ndarray, solved: bool) -> np.ndarray:
    """Computes boxes around all possible closest points, like `fill_boxes`."""
    axes = records[:, 3:12].reshape(-1, 3, 3)
    extent = np.abs(axes * records[:, 12:15, None])
    half = np.sqrt(np.sum(extent**2, axis=1)) if solved else extent.sum(axis=1)
    half += records[:, 15:]
    half += 1e-12 * (half + np.abs(records[:, :3]))
    p_WK = records[:, :3]
    return np.column_stack([p_WK - half, p_WK + half, p_WK[:, 2]])
