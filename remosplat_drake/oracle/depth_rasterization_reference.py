"""Reference of depth rasterisation: slow and readable, in NumPy.

Tests compare the fast backends with this module. It computes every pixel of
every view for every splat, so it is useful for small splats and to inspect
images.
"""

import dataclasses as dc

import numpy as np

from remosplat_drake.base.errors import RemoSplatError, unknown_name
from remosplat_drake.oracle.depth_sensor import (
    FILTER_SCALE,
    N_VIEWS,
    R_DV,
    DepthSensor,
)
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.distance_field import Clearances
from remosplat_drake.splat.gaussian_splat import GaussianSplat

ORDERS = ("ray", "center")
"""Orders in which fragments are composited: "ray" sorts them along the ray,
"center" sorts them by their splats' centres, as gsplat does."""


@dc.dataclass(frozen=True, eq=False)
class DepthImages:
    """The six depth images of one sensor.

    Attributes:
        depth: Median depth z along each view's axis, shape (6, r, r) [m]; inf
            if the pixel does not count as a surface. Rows are numbered
            downwards, columns to the right.
        alpha: Accumulated alpha, shape (6, r, r).
    """

    depth: np.ndarray
    alpha: np.ndarray


def pixel_rays(sensor: DepthSensor) -> np.ndarray:
    """Returns the rays (x, y, 1) in V of all pixels, shape (r, r, 3)."""
    x = sensor.pixel_centers()
    return np.stack([*np.meshgrid(x, x), np.ones((len(x),) * 2)], axis=2)


def render(
    splat: GaussianSplat,
    p_WS: np.ndarray,
    R_WD: np.ndarray,
    sensor: DepthSensor,
    *,
    ignore_below: float = -np.inf,
    order: str = "ray",
) -> DepthImages:
    """Renders the six depth images of a sensor.

    Args:
        splat: The scene, expressed in W.
        p_WS: Position of the sensor, shape (3,) [m].
        R_WD: Orientation of the sensor, shape (3, 3).
        sensor: The views and their thresholds.
        ignore_below: Splats with lower centres are ignored [m].
        order: "ray" composites in the order of the fragments' depths, as
            `DepthSensor` defines. "center" composites in the order of the
            depths of the splats' centres, as gsplat does; splats with equal
            depths are ordered by index.
    """
    if order not in ORDERS:
        raise RemoSplatError(unknown_name("order", order, ORDERS))
    shape = (N_VIEWS, sensor.resolution, sensor.resolution)
    depth, alpha = np.full(shape, np.inf), np.zeros(shape)
    rays_V = pixel_rays(sensor).reshape(-1, 3)
    splats = np.flatnonzero(splat.p_GK[:, 2] >= ignore_below)
    if len(splats) == 0:
        return DepthImages(depth, alpha)
    p_SK_W = splat.p_GK[splats].astype(float) - p_WS
    for view in range(N_VIEWS):
        R_WV = R_WD @ R_DV[view]
        fragments = [
            _fragments(splat, k, p_WS, R_WV, rays_V, sensor)
            for k in splats.tolist()
        ]
        z, a = (np.array(values) for values in zip(*fragments, strict=True))
        center_z = p_SK_W @ R_WV[:, 2]
        for pixel in np.flatnonzero((a > 0).any(axis=0)):
            seen = np.flatnonzero(a[:, pixel] > 0)
            key = z[seen, pixel] if order == "ray" else center_z[seen]
            seen = seen[np.argsort(key, kind="stable")]
            row, column = divmod(pixel, sensor.resolution)
            depth[view, row, column], alpha[view, row, column] = composite(
                z[seen, pixel], a[seen, pixel], sensor
            )
    return DepthImages(depth, alpha)


def composite(
    z: np.ndarray, alpha: np.ndarray, sensor: DepthSensor
) -> tuple[float, float]:
    """Computes median depth and accumulated alpha of ordered fragments.

    Source: 2DGS (Huang et al., 2024) and the paper's equation for z_median
    (section on geometry-accurate splatting). This function interprets the
    equation as "the last fragment with a preceding transmittance T > 0.5".

    Args:
        z: Depths of the fragments along the ray, ascending, shape (k,) [m].
        alpha: Alphas of the fragments, shape (k,).
        sensor: The thresholds.

    Returns:
        The median depth [m] and the accumulated alpha. The depth is inf if the
        pixel does not count as a surface.
    """
    after = np.cumprod(1 - alpha)
    before = np.concatenate([[1.0], after[:-1]])
    accumulated = float(1 - after[-1])
    if accumulated < sensor.alpha_cutoff:
        return np.inf, accumulated
    median = np.flatnonzero(before > sensor.transmittance)[-1]
    return float(z[median]), accumulated


def _fragments(
    splat: GaussianSplat,
    k: int,
    p_WS: np.ndarray,
    R_WV: np.ndarray,
    rays_V: np.ndarray,
    sensor: DepthSensor,
) -> tuple[np.ndarray, np.ndarray]:
    """Returns depth and alpha of splat k on each ray; alpha is 0 if unseen.

    The uncertainty is subtracted from the depth.
    """
    p_SK_V = R_WV.T @ (splat.p_GK[k].astype(float) - p_WS)
    R_VK = R_WV.T @ splat.R_GK[k]
    scales = splat.scales[k].astype(float)
    with np.errstate(divide="ignore", invalid="ignore"):
        if splat.is_surfel:
            z, weight = _meet_disc(p_SK_V, R_VK, scales, rays_V)
        else:
            z, weight = _densest_point(p_SK_V, R_VK, scales, rays_V)
        if sensor.low_pass_filter and p_SK_V[2] > sensor.near:
            center = p_SK_V / p_SK_V[2]
            pixels = (rays_V - center) * (sensor.resolution / 2)
            filtered = FILTER_SCALE * (pixels**2).sum(axis=1)
            wins = ~(weight <= filtered)
            z = np.where(wins, p_SK_V[2], z)
            weight = np.where(wins, filtered, weight)
        alpha = float(splat.opacities[k]) * np.exp(-0.5 * weight)
        seen = (weight <= sensor.n_sigma**2) & (alpha >= sensor.min_alpha)
        seen &= z >= sensor.near
        if splat.uncertainty is not None:
            z = z - float(splat.uncertainty[k]) / np.linalg.norm(rays_V, axis=1)
        seen &= z <= sensor.far
    return z, np.where(seen, alpha, 0.0)


def _meet_disc(p_SK_V, R_VK, scales, rays_V):
    """Returns depth and squared (u, v) of rays at a disc's plane."""
    normal_V = R_VK[:, 2]
    z = (normal_V @ p_SK_V) / (rays_V @ normal_V)
    uv = (z[:, None] * rays_V - p_SK_V) @ (R_VK[:, :2] / scales)
    return z, (uv**2).sum(axis=1)


def _densest_point(p_SK_V, R_VK, scales, rays_V):
    """Returns depth and squared distance of an ellipsoid's densest points."""
    center = (p_SK_V @ R_VK) / scales
    rays = (rays_V @ R_VK) / scales
    z = (rays @ center) / (rays**2).sum(axis=1)
    return z, ((z[:, None] * rays - center) ** 2).sum(axis=1)


def clearances(
    splat: GaussianSplat,
    spheres: Spheres,
    sensor: DepthSensor,
    max_distance: float = np.inf,
    order: str = "ray",
) -> Clearances:
    """Measures each sphere's clearance from the nearest pixel of each view.

    Rows are ordered by sphere and then by view. A view without a surface nearer
    than `max_distance` has no row.

    Args:
        splat: The scene, expressed in W.
        spheres: The robot's spheres, placed in W.
        sensor: The views and their thresholds.
        max_distance: Rows at or beyond this distance are omitted [m].
        order: One of `ORDERS`, see `render`.
    """
    rays_V = pixel_rays(sensor)
    lengths = np.linalg.norm(rays_V, axis=2)
    rows = []
    for i, R_WD in enumerate(sensor.R_WD(spheres.R_WL)):
        images = render(
            splat,
            spheres.p_WS[i],
            R_WD,
            sensor,
            ignore_below=spheres.ignore_below[i],
            order=order,
        )
        for view in range(N_VIEWS):
            ranges = images.depth[view] * lengths
            pixel = np.unravel_index(ranges.argmin(), ranges.shape)
            distance = ranges[pixel] - spheres.radius[i]
            if distance < max_distance and np.isfinite(distance):
                ray_W = R_WD @ R_DV[view] @ rays_V[pixel] / lengths[pixel]
                rows.append((i, distance, ray_W, ranges[pixel]))
    if not rows:
        return Clearances.none()
    sphere, distance, direction_W, reach = (
        np.array(c) for c in zip(*rows, strict=True)
    )
    p_WC = spheres.p_WS[sphere] + reach[:, None] * direction_W
    return Clearances(sphere, distance, direction_W, p_WC)
