"""`Evidence`: what all depth images say about each disc of a splat."""

import dataclasses as dc

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
"""Heights over a disc that belong to it whatever the noise [m]."""


@dc.dataclass(frozen=True, eq=False)
class Evidence:
    """What depth images say about n discs.

    Attributes:
        height: Mean height of the measured points over each disc's plane, on
            the side of its normal, shape (n,) [m]; 0 where nothing was
            measured.
        sigma: Standard deviation of that mean by the depth's noise alone,
            shape (n,) [m]; inf where nothing was measured.
    """

    height: np.ndarray
    sigma: np.ndarray


def find_evidence(
    capture: Capture, splat_W: GaussianSplat, noise: DepthNoise
) -> Evidence:
    """Gathers the measured points around each disc.

    Args:
        capture: Posed RGB-D images.
        splat_W: Discs, in W.
        noise: Noise of the depth.
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
    known = weight > 0
    safe = np.where(known, weight, 1)
    return Evidence(
        height=np.where(known, planes[:, 6] / safe, 0),
        sigma=np.where(known, 1 / np.sqrt(safe), np.inf),
    )
