"""Bounds the distance of the true surface in front of each disc of a splat.

The bound is u = g + z s + max(a, e). g is the largest gap between the disc and
the measurements of its surface. s is the standard deviation of the disc's
position, due to depth noise and to errors of the poses and of the camera. a is
the distance between neighbouring pixels at the disc, since an edge may be
between them. e is the largest distance of an edge from the last pixel on the
surface.

z and the limit of a were chosen on rendered scenes with known truth, and then
frozen; see the studies `map_bound` and `true_maps`, and
docs/theory/uncertainty.md.
"""

import dataclasses as dc

import numpy as np

from remosplat_drake.capture.capture import Capture
from remosplat_drake.reconstruction.alignment.pose_errors import PoseErrors
from remosplat_drake.reconstruction.surfels.surfel_gathering import DepthNoise
from remosplat_drake.reconstruction.uncertainty.depth_noise import (
    estimate_noise,
)
from remosplat_drake.reconstruction.uncertainty.disc_errors import disc_errors
from remosplat_drake.reconstruction.uncertainty.evidence import noise_of_means
from remosplat_drake.reconstruction.uncertainty.gaps import close_gaps, gaps
from remosplat_drake.reconstruction.uncertainty.measured_voxels import (
    MeasuredVoxels,
    measured_voxels,
)
from remosplat_drake.splat.gaussian_splat import GaussianSplat

SIGNIFICANCE = 4.0
"""The factor z: the number of standard deviations that the bound contains."""

LARGEST_PITCH = 0.002
"""Limit of the pixel pitch a [m]. A larger pitch would overstate the error,
since the pixels of different views are at different positions of the same edge.
"""

LARGEST_EDGE = 0.008
"""Limit of the distance e of an unseen edge [m]. A surface extends beyond its
last pixels in one direction only, but the bound u applies in all directions. So
a larger limit would block too much free space.
"""

LARGEST_SIGMA = 0.005
"""A point counts as confirmed only if its standard deviation is at most this
[m]."""


@dc.dataclass(frozen=True, eq=False)
class Bounds:
    """The terms of the error bounds of a splat's n discs.

    Attributes:
        splat_W: The splat with discs on all gaps.
        noise: Noise of the capture's depth.
        gap: Largest gaps g, shape (n,) [m].
        noise_sigma: Standard deviations due to the depth's noise, shape (n,)
            [m].
        shift: Mean errors of the discs' positions due to errors of poses and
            scale, shape (n,) [m].
        pose_sigma: Standard deviations due to errors of poses and scale, shape
            (n,) [m].
        pitch: Distances a between pixels, shape (n,) [m].
        edge: Distances e by which surfaces may extend beyond the last pixels on
            them, shape (n,) [m].
    """

    splat_W: GaussianSplat
    noise: DepthNoise
    gap: np.ndarray
    noise_sigma: np.ndarray
    shift: np.ndarray
    pose_sigma: np.ndarray
    pitch: np.ndarray
    edge: np.ndarray

    @property
    def bounded_W(self) -> GaussianSplat:
        """The splat, with the bounds as the discs' uncertainty."""
        return self.splat_W.with_uncertainty(self.uncertainty())

    def uncertainty(
        self,
        significance: float = SIGNIFICANCE,
        largest_pitch: float = LARGEST_PITCH,
    ) -> np.ndarray:
        """Computes the bound u of each disc.

        Args:
            significance: The factor z.
            largest_pitch: Limit of the pitch a [m].

        Returns:
            Shape (n,) [m].
        """
        sigma = np.hypot(self.noise_sigma, self.pose_sigma)
        return (
            self.gap
            + self.shift
            + significance * sigma
            + np.maximum(
                np.minimum(self.pitch, largest_pitch),
                np.minimum(self.edge, LARGEST_EDGE),
            )
        )


def bound_splat(
    capture: Capture,
    splat_W: GaussianSplat,
    errors: PoseErrors | None = None,
) -> Bounds:
    """Closes the gaps of a splat, and bounds the error of each disc.

    Args:
        capture: The posed RGB-D images from which the splat was made.
        splat_W: Discs, in W.
        errors: Samples of the errors of the poses and of the camera; None means
            that poses and camera are exact.
    """
    noise = estimate_noise(capture, splat_W)
    measured = measured_voxels(capture, noise)
    confirmed = measured.is_confirmed(LARGEST_SIGMA)
    splat_W = close_gaps(splat_W, measured, confirmed)
    errors = PoseErrors.none(len(capture)) if errors is None else errors
    moved, pitch, edge = disc_errors(capture, splat_W, noise, errors)
    gap, sigma = _at_discs(splat_W, measured)
    averaged = noise_of_means(capture, splat_W, noise)
    known = np.isfinite(pitch)
    farthest = float(pitch[known].max(initial=0.0))
    pitch = np.where(known, pitch, farthest)
    edge = np.where(known, edge, farthest)
    # If no points were averaged, the noise of a single pixel is used.
    z = pitch * float(capture.K[:, 0, 0].mean())
    single = noise.deviation(z)
    single[~known] = np.minimum(single[~known], LARGEST_SIGMA)
    sigma = np.minimum(np.minimum(sigma, averaged), single)
    return Bounds(
        splat_W=splat_W,
        noise=noise,
        gap=gap,
        noise_sigma=sigma,
        shift=np.abs(moved.mean(axis=1)),
        pose_sigma=moved.std(axis=1),
        pitch=pitch,
        edge=edge,
    )


def _at_discs(
    splat_W: GaussianSplat, measured: MeasuredVoxels
) -> tuple[np.ndarray, np.ndarray]:
    """The largest gap and least noise of the voxels nearest to each disc."""
    distance, nearest = gaps(splat_W, measured)
    gap, sigma = np.zeros(len(splat_W)), np.full(len(splat_W), np.inf)
    np.maximum.at(gap, nearest, distance)
    np.minimum.at(sigma, nearest, measured.sigma)
    return gap, sigma
