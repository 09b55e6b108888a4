"""Reference renderer of a splat: slow and readable, in NumPy."""

import numpy as np

from remosplat_drake.oracle.depth_sensor import FILTER_SCALE
from remosplat_drake.reconstruction.report.splat_image import (
    FAR,
    NEAR,
    SENSOR,
    SplatImage,
)
from remosplat_drake.splat.gaussian_splat import GaussianSplat


def render(
    splat_W: GaussianSplat,
    K: np.ndarray,
    X_WC: np.ndarray,
    size: tuple[int, int],
    low_pass_filter: bool = True,
) -> SplatImage:
    """Renders the image of a camera; arguments are those of `SplatRenderer`."""
    height, width = size
    u, v = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    pixels = np.stack([u, v, np.ones_like(u)], axis=-1).reshape(-1, 3)
    fragments = [
        _fragments(splat_W, k, K, X_WC, pixels, low_pass_filter)
        for k in range(len(splat_W))
    ]
    z, a = (np.array(x) for x in zip(*fragments, strict=True))
    color, depth = np.zeros((len(pixels), 3)), np.zeros(len(pixels))
    alpha = np.zeros(len(pixels))
    for pixel in range(len(pixels)):
        seen = np.flatnonzero(a[:, pixel] > 0)
        seen = seen[np.argsort(z[seen, pixel], kind="stable")]
        after = np.cumprod(1 - a[seen, pixel])
        before = np.concatenate([[1.0], after[:-1]])[: len(seen)]
        color[pixel] = (before * a[seen, pixel]) @ splat_W.colors[seen]
        alpha[pixel] = 1 - after[-1] if len(seen) else 0.0
        if alpha[pixel] > 0.5:
            median = np.flatnonzero(before > 0.5)[-1]
            depth[pixel] = z[seen[median], pixel]
    return SplatImage(
        color.reshape(height, width, 3).astype(np.float32),
        depth.reshape(height, width).astype(np.float32),
        alpha.reshape(height, width).astype(np.float32),
    )


def _fragments(
    splat_W: GaussianSplat,
    k: int,
    K: np.ndarray,
    X_WC: np.ndarray,
    pixels: np.ndarray,
    low_pass_filter: bool,
) -> tuple[np.ndarray, np.ndarray]:
    """Depth z and alpha of splat k in all pixels; alpha 0 where unseen."""
    R_WC = X_WC[:3, :3]
    rays_C = pixels @ np.linalg.inv(K).T
    p_CK = R_WC.T @ (splat_W.p_GK[k] - X_WC[:3, 3])
    R_CK = R_WC.T @ splat_W.R_GK[k]
    scales = splat_W.scales[k].astype(float)
    with np.errstate(divide="ignore", invalid="ignore"):
        if splat_W.is_surfel:
            normal_C = R_CK[:, 2]
            z = (normal_C @ p_CK) / (rays_C @ normal_C)
            offset = (z[:, None] * rays_C - p_CK) @ (R_CK[:, :2] / scales)
        else:
            center, rays = (p_CK @ R_CK) / scales, (rays_C @ R_CK) / scales
            z = (rays @ center) / (rays**2).sum(axis=1)
            offset = z[:, None] * rays - center
        weight = (offset**2).sum(axis=1)
        if low_pass_filter and p_CK[2] > NEAR:
            uvw = K @ p_CK
            square = ((pixels[:, :2] - uvw[:2] / uvw[2]) ** 2).sum(axis=1)
            filtered = FILTER_SCALE * square
            wins = ~(weight <= filtered)
            z = np.where(wins, p_CK[2], z)
            weight = np.where(wins, filtered, weight)
        alpha = float(splat_W.opacities[k]) * np.exp(-0.5 * weight)
        seen = (weight <= SENSOR.n_sigma**2) & (alpha >= SENSOR.min_alpha)
        seen &= (z >= NEAR) & (z <= FAR)
    return z, np.where(seen, alpha, 0.0)
