"""Estimates the depth noise of a capture from the distances to a splat."""

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.optimize import nnls

from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.checks.overlap import sample_points, to_world
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.reconstruction.surfels.surfel_gathering import DepthNoise
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.splat.gaussian_splat import GaussianSplat

_SAMPLES = 100_000
_BINS = 12
_LEAST_NOISE = 1e-4
"""Least assumed standard deviation of depth [m]."""

_STEEPEST = 0.3
"""A surface is used only if the cosine of the angle of incidence is at least
this. Other surfaces contain little information about depth noise.
"""

_WINDOW = 2
"""Half width of the window of pixels whose median depth determines the disc."""

_LEAST_SHARE = 0.7
"""A window is used only if at least this fraction of its pixels has a depth."""

_MAD = 1.4826
"""Ratio of a Gaussian's standard deviation to its median absolute deviation."""


def estimate_noise(
    capture: Capture, splat_W: GaussianSplat, seed: int = 0
) -> DepthNoise:
    """Estimates the standard deviation of depths z, as floor + growth z^2.

    The depths of random pixels are compared with the plane of a disc. This is
    the disc nearest to the median depth of the pixel's surroundings. The disc
    nearest to the pixel's own depth would be a biased choice: discs that were
    placed on noise attract pixels with the same noise. The robust spread of the
    differences is computed for each of a dozen ranges of depth, and the formula
    is fitted to it.

    Args:
        capture: Posed RGB-D images.
        splat_W: Discs that were fitted to the images, in W.
        seed: Seed of the random choice of pixels.
    """
    rng = np.random.default_rng(seed)
    each = -(-_SAMPLES // len(capture))
    p_C = sample_points(capture, each, rng)
    smooth = _median_depths(capture, p_C)
    known = np.isfinite(smooth)
    p_W = np.array([to_world(capture, p, i) for i, p in enumerate(p_C)])
    p_WC = np.broadcast_to(capture.X_WC[:, None, :3, 3], p_W.shape)[known]
    z = p_C[known][:, 2]
    ray_W = (p_W[known] - p_WC) / z[:, None]
    field = SphereToEllipsoidField(splat_W, min_opacity=0.0)
    nearest, _ = field.nearest_splats(
        Spheres.at(p_WC + smooth[known][:, None] * ray_W)
    )
    normal_W = splat_W.R_GK[nearest, :, 2]
    slope = (ray_W * normal_W).sum(axis=1)
    facing = np.abs(slope) > _STEEPEST * np.linalg.norm(ray_W, axis=1)
    if not facing.any():
        return DepthNoise(_LEAST_NOISE, 0.0, 0.1, 0.1)
    above = ((splat_W.p_GK[nearest] - p_WC) * normal_W).sum(axis=1)
    true = above[facing] / slope[facing]
    error = np.abs(z[facing] - true)
    parts = np.array_split(np.argsort(true), _BINS)
    depth = np.array([np.median(true[part]) for part in parts if len(part)])
    spread = [_MAD * np.median(error[part]) for part in parts if len(part)]
    # The fit minimises relative errors, since near surfaces matter more.
    terms = np.stack([np.ones_like(depth), depth**2], axis=1)
    spread = np.maximum(spread, _LEAST_NOISE)
    (floor, growth), _ = nnls(terms / spread[:, None], np.ones(len(depth)))
    return DepthNoise(max(floor, _LEAST_NOISE), growth, 0.1, 0.1)


def _median_depths(capture: Capture, p_C: np.ndarray) -> np.ndarray:
    """Median depths of the windows around pixels.

    On a plane, 1/z is linear in the pixel, so the median of 1/z is that of the
    middle pixel.

    Args:
        capture: The n views.
        p_C: Points of k pixels of each view, shape (n, k, 3) [m] or NaN.

    Returns:
        Shape (n, k) [m]; NaN where too few pixels have a depth.
    """
    median = np.full(p_C.shape[:2], np.nan)
    size = 2 * _WINDOW + 1
    for view in np.flatnonzero(capture.depth.any(axis=(1, 2))):
        u, v, _ = (p_C[view] / p_C[view, :, 2:] @ capture.K[view].T).T
        z = np.pad(capture.depth[view], _WINDOW)
        z = sliding_window_view(z, (size, size))[v.astype(int), u.astype(int)]
        z = np.where(z > 0, z, np.nan).reshape(len(u), -1)
        enough = np.isfinite(z).mean(axis=1) >= _LEAST_SHARE
        median[view, enough] = 1 / np.nanmedian(1 / z[enough], axis=1)
    return median
