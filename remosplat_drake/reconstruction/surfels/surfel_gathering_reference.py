"""Reference of `surfel_gathering`: slow and readable, in NumPy."""

import numpy as np

from remosplat_drake.reconstruction.surfels.surfel_gathering import (
    GRID,
    MAX_REACH,
    NEAR,
    DepthNoise,
    DepthView,
    Patches,
)


def gather_planes(
    patches: Patches,
    view: DepthView,
    noise: DepthNoise,
    tolerance: float,
    planes: np.ndarray,
    colors: np.ndarray,
):
    """Adds a view's measured points to the sums of the patches near them.

    Arguments and results are those of `surfel_gathering.gather_planes`.
    """
    for i in range(len(patches.p_WK)):
        rows, columns, cosine = _window(patches, i, view, noise)
        z = view.depth[rows, columns].astype(float)
        rows, columns, z = rows[z > 0], columns[z > 0], z[z > 0]
        a, b, h = _points(patches, i, view, rows, columns, z).T
        sigma = noise.deviation(z)
        c = np.maximum(tolerance, 3 * sigma)
        inner = 1 - (a**2 + b**2) / patches.radius[i] ** 2
        w = cosine**2 * inner / ((1 + (h / c) ** 2) ** 2 * sigma**2)
        w = np.where((inner > 0) & (np.abs(h) <= 3 * c), w, 0)
        ones = np.ones_like(a)
        terms = [ones, a, b, a * a, a * b, b * b, h, a * h, b * h]
        planes[i] += np.stack([*terms, (h / sigma) ** 2]) @ w
        rgb = view.rgb[rows, columns] / 255.0
        off = ((rgb - patches.colors[i]) ** 2).sum(axis=1)
        w = w * inner / (1 + off / noise.color_step**2)
        colors[i] += np.append(w @ rgb, w.sum())


def gather_votes(
    patches: Patches,
    view: DepthView,
    noise: DepthNoise,
    tolerance: float,
    solid: np.ndarray,
    free: np.ndarray,
):
    """Adds a view's votes for each patch's surface and for free space.

    Arguments and results are those of `surfel_gathering.gather_votes`.
    """
    for i in range(len(patches.p_WK)):
        rows, columns, _ = _window(patches, i, view, noise)
        z = view.depth[rows, columns].astype(float)
        rows, columns, z = rows[z > 0], columns[z > 0], z[z > 0]
        point = _points(patches, i, view, rows, columns, z)
        ray = _rays(view, rows, columns) @ patches.R_WK[i]
        h, slope = point[:, 2], ray[:, 2]
        sigma = noise.deviation(z)
        c = np.maximum(tolerance, 2 * sigma * np.abs(slope))
        steep = slope <= -0.5 * noise.min_cosine
        met = point[:, :2] - (h / slope)[:, None] * ray[:, :2]
        cell = np.floor(met / (2 * patches.radius[i] / GRID) + GRID / 2)
        steep &= ((cell >= 0) & (cell < GRID)).all(axis=1)
        votes = np.zeros((2, GRID, GRID))
        for vote, kind in ((0, np.abs(h) <= c), (1, h <= -1.5 * c)):
            chosen = cell[steep & kind].astype(int)
            np.add.at(votes[vote], tuple(chosen.T), 1)
        share = votes / np.maximum(votes.sum(axis=0), 1)
        solid[i] += share[0]
        free[i] += share[1]


def _window(
    patches: Patches, i: int, view: DepthView, noise: DepthNoise
) -> tuple[np.ndarray, np.ndarray, float]:
    """Rows and columns of the pixels around a patch, and its cosine."""
    nothing = np.zeros(0, int), np.zeros(0, int), 0.0
    p_CK_W = patches.p_WK[i] - view.p_WC
    x, y, z = view.R_WC.T @ p_CK_W
    cosine = -(patches.R_WK[i, :, 2] @ p_CK_W) / np.linalg.norm(p_CK_W)
    if z < NEAR or cosine < noise.min_cosine:
        return nothing
    height, width = view.depth.shape
    column, row = np.floor(
        view.focal * np.array([x, y]) / z + view.center
    ).astype(int)
    if not (0 <= column < width and 0 <= row < height):
        return nothing
    reach = int(np.ceil(patches.radius[i] * view.focal[0] / z))
    step = -(-reach // MAX_REACH)
    reach = reach // step * step
    offsets = np.arange(-reach, reach + 1, step)
    rows, columns = row + offsets, column + offsets
    rows = rows[(rows >= 0) & (rows < height)]
    columns = columns[(columns >= 0) & (columns < width)]
    pixels = np.meshgrid(rows, columns, indexing="ij")
    return pixels[0].ravel(), pixels[1].ravel(), float(cosine)


def _rays(view: DepthView, rows: np.ndarray, columns: np.ndarray):
    """Rays of unit depth in W, shape (m, 3)."""
    pixels = np.stack([columns, rows], axis=1) + 0.5
    xy = (pixels - view.center) / view.focal
    return np.column_stack([xy, np.ones(len(xy))]) @ view.R_WC.T


def _points(
    patches: Patches,
    i: int,
    view: DepthView,
    rows: np.ndarray,
    columns: np.ndarray,
    z: np.ndarray,
) -> np.ndarray:
    """Pixels' points in a patch's frame, shape (m, 3) [m]."""
    p_WP = view.p_WC + z[:, None] * _rays(view, rows, columns)
    return (p_WP - patches.p_WK[i]) @ patches.R_WK[i]
