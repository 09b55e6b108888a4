"""Estimates the depth noise of a capture from its differences to a splat."""

import numpy as np
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
"""Surfaces are ignored if the cosine of their angle of incidence is below this,
since they tell little about depth noise."""

_MAD = 1.4826
"""Ratio of a Gaussian's standard deviation to its median absolute deviation."""


def estimate_noise(
    capture: Capture, splat_W: GaussianSplat, seed: int = 0
) -> DepthNoise:
    """Estimates the standard deviation of depths z, as floor + growth z^2.

    The depths of random pixels are compared with the plane of the nearest disc.
    Their robust spread is computed for each of a dozen ranges of depth, and the
    formula is fitted to it.

    Args:
        capture: Posed RGB-D images.
        splat_W: Discs that were fitted to them, in W.
        seed: Seed of the random choice of pixels.
    """
    rng = np.random.default_rng(seed)
    each = -(-_SAMPLES // len(capture))
    p_C = sample_points(capture, each, rng)
    p_W = np.array([to_world(capture, p, i) for i, p in enumerate(p_C)])
    known = np.isfinite(p_W[..., 0])
    ray_W = p_W - capture.X_WC[:, None, :3, 3]
    p_W, z, ray_W = p_W[known], p_C[known][:, 2], ray_W[known]
    field = SphereToEllipsoidField(splat_W, min_opacity=0.0)
    nearest, _ = field.nearest_splats(Spheres.at(p_W))
    normal_W = splat_W.R_GK[nearest, :, 2]
    height = ((p_W - splat_W.p_GK[nearest]) * normal_W).sum(axis=1)
    slope = (ray_W * normal_W).sum(axis=1) / z
    cosine = np.abs(slope) * z / np.linalg.norm(ray_W, axis=1)
    facing = cosine > _STEEPEST
    error, z = np.abs(height[facing] / slope[facing]), z[facing]
    if not len(z):
        return DepthNoise(_LEAST_NOISE, 0.0, 0.1, 0.1)
    parts = np.array_split(np.argsort(z), _BINS)
    depth = np.array([np.median(z[part]) for part in parts if len(part)])
    spread = [_MAD * np.median(error[part]) for part in parts if len(part)]
    # The fit minimises relative errors, since near surfaces matter more.
    terms = np.stack([np.ones_like(depth), depth**2], axis=1)
    spread = np.maximum(spread, _LEAST_NOISE)
    (floor, growth), _ = nnls(terms / spread[:, None], np.ones(len(depth)))
    return DepthNoise(max(floor, _LEAST_NOISE), growth, 0.1, 0.1)
