"""Computes the part of the discs' uncertainty that is due to depth noise."""

import numpy as np

from remosplat_drake.capture.capture import Capture
from remosplat_drake.reconstruction.surfels.surfel_gathering import (
    COLOR_SUMS,
    PLANE_SUMS,
    DepthNoise,
    Patches,
    gather_planes,
    make_view,
)
from remosplat_drake.splat.gaussian_splat import GaussianSplat

_WINDOW = (0.006, 0.05)
"""Least and largest radius of the window around a disc [m]."""

_TOLERANCE = 0.004
"""Points belong to a disc if they are at most this far from it, in addition to
their noise [m].
"""


def noise_of_means(
    capture: Capture, splat_W: GaussianSplat, noise: DepthNoise
) -> np.ndarray:
    """Computes the standard deviation of the mean height of each disc's points.

    Args:
        capture: Posed RGB-D images.
        splat_W: The n discs, in W.
        noise: Noise of the depth.

    Returns:
        Standard deviations due to the depth's noise alone, shape (n,) [m]; inf
        for a disc near which no point was measured.
    """
    R_WK = np.ascontiguousarray(splat_W.R_GK)
    patches = Patches(
        np.array(splat_W.p_GK, float, order="C"),
        R_WK,
        np.clip(2.0 * splat_W.scales.max(axis=1).astype(float), *_WINDOW),
        np.array(splat_W.colors, float, order="C"),
    )
    planes = np.zeros((len(splat_W), PLANE_SUMS))
    colors = np.zeros((len(splat_W), COLOR_SUMS))
    for i in range(len(capture)):
        view = make_view(capture, i)
        gather_planes(patches, view, noise, _TOLERANCE, planes, colors)
    weight = planes[:, 0]
    return np.where(
        weight > 0, 1 / np.sqrt(np.where(weight > 0, weight, 1)), np.inf
    )
