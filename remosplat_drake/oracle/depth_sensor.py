"""`DepthSensor`: the virtual depth camera at the centre of a robot sphere.

Frames: D is the sensor (at the sphere's centre), V one of its six views with
OpenCV axes (x right, y down, z forward). A ray through a pixel is written with
unit z, so that a point at depth z along it is z times the ray. Numba kernels
contain the code of this module.
"""

import dataclasses as dc

import numpy as np

from remosplat_drake.base.errors import FieldError, unknown_name

N_VIEWS = 6
"""Number of views of a sensor; together they cover all directions."""

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
"""Valid orientations of a sensor: fixed to the sphere's link, or to W."""

FILTER_SCALE = 2.0
"""Weight of a squared pixel distance under the low-pass filter of 2DGS
[1/px^2]."""


@dc.dataclass(frozen=True)
class DepthSensor:
    """Settings of the six depth views, and the definition of a surface in them.

    The definition, per pixel: splat k contributes a *fragment* at the depth
    z_k where the ray meets its disc (for an ellipsoid: where its density
    along the ray is greatest) with alpha_k = opacity exp(-w_k / 2), w_k being
    the squared Mahalanobis distance there. Fragments are composited in the
    order of z_k. The pixel's depth is that of the last fragment whose
    preceding transmittance exceeds `transmittance`; the pixel counts only
    when all its fragments together reach `alpha_cutoff`.

    A splat with an uncertainty u is rendered as if it were nearer by u along
    the ray: it is composited there, and `far` applies there, too. If each true
    surface is at most u before its splat, no true median is nearer than the
    rendered one.

    Fragments are ordered along the ray, not by the splats' centres as in
    gsplat. A disc whose centre is behind or beside the camera has no meaningful
    centre depth. With an order by centres, a slanted far disc may also hide a
    near one, so that the distance is over-estimated.

    The low-pass filter is off by default: on four trained scenes it moved the
    median absolute error of a sphere's distance by at most 0.1 mm (1.1 to 1.6
    mm either way; largest over-estimate 6.2 mm without, 5.7 mm with it), and it
    doubles the time of a query.

    Attributes:
        resolution: Number of pixels along each side of a view, whose field of
            view is 90 degrees (the authors' code: 80).
        alpha_cutoff: Least accumulated alpha of a pixel that counts (0.7).
        transmittance: Threshold of the median depth (0.5).
        near: Fragments nearer than this depth z are not seen [m].
        far: Fragments beyond this depth z are not seen [m].
        n_sigma: Splats end at this many standard deviations (gsplat: 3).
        min_alpha: Fragments below this alpha are dropped (gsplat: 1/255).
        orientation: "link" turns the sensor with the sphere's link, "world"
            keeps it aligned with W.
        low_pass_filter: Use the screen-space filter of 2DGS: near a splat's
            projected centre, w_k is at most `FILTER_SCALE` times the squared
            distance to it [px^2]; where that is the smaller weight, the
            fragment has the depth of the centre. Centres nearer than `near` are
            not filtered.
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
        # Otherwise a pixel could count without a median.
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
        """Returns ray coordinates of pixel columns (and rows), (resolution,).

        Pixel i has the ray coordinate (i + 1/2 - c) / f with focal length f
        and principal point c both resolution / 2.
        """
        half = self.resolution / 2
        return (np.arange(self.resolution) + 0.5 - half) / half
