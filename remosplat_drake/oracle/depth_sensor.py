"""`DepthSensor`: the virtual depth camera at the centre of a robot sphere.

Frame D is that of the sensor, at the sphere's centre. Frame V is that of one of
its six views, with OpenCV axes (x right, y down, z forward). The ray through a
pixel is a vector with z = 1, so that the point at depth z on it is z times the
ray. Numba kernels contain the code of this module.
"""

import dataclasses as dc

import numpy as np

from remosplat_drake.base.errors import FieldError, unknown_name

N_VIEWS = 6
"""Number of views of a sensor. Together the views cover all directions."""

R_DV = np.array(
    [
        [[1, 0, 0], [0, 1, 0], [0, 0, 1]],  # R_x(0): z forward
        [[1, 0, 0], [0, 0, -1], [0, 1, 0]],  # R_x(pi/2): -y
        [[1, 0, 0], [0, 0, 1], [0, -1, 0]],  # R_x(-pi/2): y
        [[0, 0, 1], [0, 1, 0], [-1, 0, 0]],  # R_y(pi/2): x
        [[-1, 0, 0], [0, 1, 0], [0, 0, -1]],  # R_y(pi): -z
        [[0, 0, -1], [0, 1, 0], [1, 0, 0]],  # R_y(3 pi/2): -x
    ],
    float,
)
"""Orientations of the six views in the sensor (paper section IV-C.2).

Shape (6, 3, 3), read-only.
"""
R_DV.flags.writeable = False

ORIENTATIONS = ("link", "world")
"""Valid orientations of a sensor: fixed to the sphere's link, or fixed to W."""

FILTER_SCALE = 2.0
"""Weight of the squared distance between pixels in the low-pass filter of 2DGS
[1/px^2]."""


@dc.dataclass(frozen=True)
class DepthSensor:
    """Settings of the six depth views, and the definition of a surface in them.

    For each pixel, a surface is defined as follows. Splat k contributes a
    *fragment* at the depth z_k at which the ray meets the splat's disc. For an
    ellipsoid, z_k is the depth at which the splat's density along the ray is
    greatest. The fragment has alpha_k = opacity exp(-w_k / 2), where w_k is the
    squared Mahalanobis distance at this point. Fragments are composited in the
    order of z_k. The pixel's depth is that of the last fragment whose preceding
    transmittance exceeds `transmittance`. The pixel counts as a surface only if
    the accumulated alpha of all its fragments reaches `alpha_cutoff`.

    A splat with an uncertainty u is rendered as if it were nearer to the camera
    by u along the ray. It is composited at this nearer depth, to which `far`
    applies, too. If each true surface is at most u in front of its splat, no
    true median is nearer than the rendered median.

    Fragments are ordered along the ray, and not by the splats' centres as in
    gsplat. If the centre of a disc is behind or beside the camera, the depth of
    this centre has no meaning for the order. If discs are ordered by their
    centres, a slanted far disc may also hide a near disc, so that the distance
    is over-estimated.

    The low-pass filter is off by default, since it doubles the time of a query
    and has little effect. In four trained scenes, it changed the median
    absolute error of a sphere's distance, 1.1 to 1.6 mm, by at most 0.1 mm. The
    largest over-estimate was 6.2 mm without the filter, and 5.7 mm with it.

    Attributes:
        resolution: Number of pixels along each side of a view, whose field of
            view is 90 degrees. The authors' code has 80 pixels.
        alpha_cutoff: A pixel counts as a surface if its accumulated alpha is at
            least this value (0.7).
        transmittance: Threshold of the median depth (0.5).
        near: Fragments nearer than this depth z are ignored [m].
        far: Fragments beyond this depth z are ignored [m].
        n_sigma: Distance from a splat's centre at which the splat ends, in
            standard deviations (gsplat: 3).
        min_alpha: Fragments below this alpha are dropped (gsplat: 1/255).
        orientation: "link" fixes the sensor's orientation to the sphere's link,
            "world" fixes it to W.
        low_pass_filter: Whether the screen-space filter of 2DGS is used. It
            limits w_k to `FILTER_SCALE` times the squared distance between the
            pixel and the splat's projected centre [px^2]. If the limit reduces
            w_k, the fragment has the depth of the centre. Splats with centres
            nearer than `near` are not filtered.
    """

    resolution: int = 80
    alpha_cutoff: float = 0.7
    transmittance: float = 0.5
    near: float = 0.0106
    far: float = 0.9
    n_sigma: float = 3.0
    min_alpha: float = 1 / 255
    orientation: str = "link"
    low_pass_filter: bool = False

    def __post_init__(self):
        if self.orientation not in ORIENTATIONS:
            self._reject(
                "orientation",
                unknown_name("orientation", self.orientation, ORIENTATIONS),
            )
        if self.resolution < 1:
            self._reject("resolution", f"{self.resolution} is not positive")
        if not 0 < self.near < self.far:
            self._reject("near", f"needs 0 < near < far = {self.far}")
        if not 0 < self.transmittance < 1:
            self._reject("transmittance", "must lie in (0, 1)")
        # Otherwise a pixel without a median could count as a surface.
        if not 1 - self.transmittance <= self.alpha_cutoff < 1:
            self._reject("alpha_cutoff", "must lie in [1 - transmittance, 1)")
        if not self.n_sigma > 0:
            self._reject("n_sigma", f"{self.n_sigma} is not positive")
        if not 0 <= self.min_alpha < 1:
            self._reject("min_alpha", "must lie in [0, 1)")

    def _reject(self, field: str, problem: str):
        raise FieldError("depth sensor", field, problem)

    def R_WD(self, R_WL: np.ndarray) -> np.ndarray:
        """Returns sensor orientations for link orientations, both (n, 3, 3)."""
        if self.orientation == "link":
            return R_WL
        return np.broadcast_to(np.eye(3), R_WL.shape)

    def pixel_centers(self) -> np.ndarray:
        """Returns the ray coordinates of pixel columns, shape (resolution,).

        Pixel i has the ray coordinate (i + 1/2 - c) / f. The focal length f and
        the principal point c are both resolution / 2. Pixel rows have the same
        coordinates as columns.
        """
        half = self.resolution / 2
        return (np.arange(self.resolution) + 0.5 - half) / half
