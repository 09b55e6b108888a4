"""Renders complete depth images of a sensor, fast enough for display (Numba).

The distance oracle renders no images, since it needs only the nearest pixel of
each view. The images of this module ignore the splats' uncertainty. Apart from
that, each pixel equals that of `depth_rasterization_reference.render`.
"""

import dataclasses as dc

import numpy as np

from remosplat_drake.base.kernels import numpy_helper, numpy_kernel
from remosplat_drake.oracle.depth_rasterization_reference import DepthImages
from remosplat_drake.oracle.depth_sensor import N_VIEWS, R_DV, DepthSensor
from remosplat_drake.oracle.kernels.footprints import (
    footprint_records,
    fragment,
    fragment_alpha,
    make_rules,
    pixel_span,
    project,
)
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.splat.gaussian_splat import GaussianSplat


@dc.dataclass(frozen=True, eq=False)
class SphereViews:
    """The six depth images from the centre of one robot sphere.

    Attributes:
        images: Depth z and accumulated alpha of all pixels; see `DepthImages`.
        ranges: Distance of each pixel's point from the centre, shape (6, r, r)
            [m]; inf if the pixel does not count as a surface.
        p_WP: The pixels' points in W, shape (6, r, r, 3) [m]; not finite if the
            pixel does not count as a surface.
        nearest: Row and column of each view's nearest pixel, shape (6, 2).
        p_WS: The sphere's centre, shape (3,) [m].
        R_WD: Orientation of the sensor, shape (3, 3).
        radius: Radius of the sphere [m].
    """

    images: DepthImages
    ranges: np.ndarray
    p_WP: np.ndarray
    nearest: np.ndarray
    p_WS: np.ndarray
    R_WD: np.ndarray
    radius: float

    @property
    def clearances(self) -> np.ndarray:
        """Clearance of each view's nearest pixel, (6,) [m]; inf without one."""
        view = np.arange(N_VIEWS)
        return self.ranges[view, *self.nearest.T] - self.radius

    @property
    def nearest_points(self) -> np.ndarray:
        """Point of each view's nearest pixel in W, shape (6, 3) [m]."""
        return self.p_WP[np.arange(N_VIEWS), *self.nearest.T]


def look_around(
    splat_W: GaussianSplat, sensor: DepthSensor, spheres: Spheres, i: int
) -> SphereViews:
    """Renders six depth views of a splat in W from the centre of sphere i."""
    p_WS, radius = spheres.p_WS[i], float(spheres.radius[i])
    R_WD = np.array(sensor.R_WD(spheres.R_WL)[i])
    images = render(splat_W, p_WS, R_WD, sensor, spheres.ignore_below[i])
    x = sensor.pixel_centers()
    rays_V = np.stack([*np.meshgrid(x, x), np.ones((len(x),) * 2)], axis=2)
    ranges = images.depth * np.linalg.norm(rays_V, axis=2)
    rays_W = np.einsum("ij,vjk,rck->vrci", R_WD, R_DV, rays_V)
    with np.errstate(invalid="ignore"):
        p_SP_W = images.depth[..., None] * rays_W
    flat = ranges.reshape(N_VIEWS, -1).argmin(axis=1)
    return SphereViews(
        images,
        ranges,
        p_WS + p_SP_W,
        np.stack(np.divmod(flat, len(x)), axis=1),
        p_WS,
        R_WD,
        radius,
    )


def render(
    splat_W: GaussianSplat,
    p_WS: np.ndarray,
    R_WD: np.ndarray,
    sensor: DepthSensor,
    ignore_below: float = -np.inf,
) -> DepthImages:
    """Renders the six depth images of a sensor.

    Arguments and result are those of `depth_rasterization_reference.render`.
    """
    rules = make_rules(sensor, splat_W.is_surfel)
    # No point of a pixel is farther away than the corners of the far plane.
    largest = splat_W.scales.max(axis=1) * sensor.n_sigma
    offset = np.linalg.norm(splat_W.p_GK - p_WS, axis=1)
    reach = np.sqrt(3) * sensor.far / max(1 - rules.spread, 1e-9)
    seen = (offset - largest <= reach) & (splat_W.p_GK[:, 2] >= ignore_below)
    records, _ = footprint_records(splat_W.select(seen), sensor)
    shape = (N_VIEWS, sensor.resolution, sensor.resolution)
    depth, alpha = np.full(shape, np.inf), np.zeros(shape)
    for view in range(N_VIEWS):
        pixel, z, a = _fragments(records, rules, p_WS, R_WD @ R_DV[view])
        order = np.lexsort((z, pixel))
        _composite(
            pixel[order],
            z[order],
            a[order],
            rules,
            depth[view].reshape(-1),
            alpha[view].reshape(-1),
        )
    return DepthImages(depth, alpha)


@numpy_kernel
def _fragments(records, rules, p_WV, R_WV):
    """Returns a view's fragments (pixel, depth z, alpha) in any order."""
    pixels, depths, alphas = [0], [0.0], [0.0]
    resolution = rules.resolution
    for k in range(len(records)):
        s = project(records, k, rules, p_WV, R_WV)
        radius = records[k, 14]
        if rules.low_pass_filter:
            distance = np.sqrt(s[12] ** 2 + s[13] ** 2 + s[14] ** 2)
            radius = max(radius, rules.spread * distance)
        low, high = _ball_span(s[12], s[14], radius)
        first_column, last_column = pixel_span(low, high, resolution)
        low, high = _ball_span(s[13], s[14], radius)
        first_row, last_row = pixel_span(low, high, resolution)
        for row in range(int(first_row), int(last_row) + 1):
            y = (row + 0.5) * 2 / resolution - 1
            for column in range(int(first_column), int(last_column) + 1):
                x = (column + 0.5) * 2 / resolution - 1
                z, weight = fragment(s, rules, x, y)
                alpha = fragment_alpha(z, weight, records[k, 12], rules)
                if alpha > 0:
                    pixels.append(row * resolution + column)
                    depths.append(z)
                    alphas.append(alpha)
    return np.array(pixels)[1:], np.array(depths)[1:], np.array(alphas)[1:]


@numpy_helper
def _ball_span(x, z, radius):
    """Returns the ray coordinates that bound the image of a ball at (x, z).

    In the projection along the other image axis, the ball is a disc, and its
    tangents through the camera enclose it. The interval is empty if low > high.
    """
    distance = np.sqrt(x * x + z * z)
    if distance <= radius:
        return -1.0, 1.0
    angle, half = np.arctan2(x, z), np.arcsin(radius / distance)
    quarter = np.pi / 4
    low, high = max(angle - half, -quarter), min(angle + half, quarter)
    if low > high:
        return 2.0, -2.0
    return np.tan(low), np.tan(high)


@numpy_kernel
def _composite(pixel, z, alpha, rules, depth, accumulated):
    """Computes median depth and alpha from fragments, sorted by pixel and z."""
    first, n = 0, len(pixel)
    while first < n:
        clear, median, end = 1.0, z[first], first
        while end < n and pixel[end] == pixel[first]:
            if clear > rules.transmittance:
                median = z[end]
            clear *= 1 - alpha[end]
            end += 1
        accumulated[pixel[first]] = 1 - clear
        if 1 - clear >= rules.alpha_cutoff:
            depth[pixel[first]] = median
        first = end
