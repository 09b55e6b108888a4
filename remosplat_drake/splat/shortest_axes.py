"""`shortest_axes`: the directions in which Gaussians are flat."""

import numpy as np

from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.splat.quaternions import rotation_matrices


def shortest_axes(splat: GaussianSplat) -> np.ndarray:
    """Returns the shortest axis of each Gaussian; its sign is arbitrary.

    For a Gaussian on a surface, this axis is a normal of the surface.

    Args:
        splat: The N Gaussians.

    Returns:
        Unit vectors in the splat's frame, shape (N, 3).
    """
    R_GK = rotation_matrices(np.asarray(splat.quaternions, float))
    flat = np.full(len(R_GK), 2)
    if not splat.is_surfel:
        flat = np.argmin(splat.scales, axis=1)
    return np.take_along_axis(R_GK, flat[:, None, None], axis=2)[:, :, 0]
