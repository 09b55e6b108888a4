"""`Footprints`: splats as a depth view sees them (arrays and numba kernels).

In a view, everything about a splat is a function of the ray (x, y, 1) of a
pixel. A disc has three linear forms A, B, C and its plane's height h with
u = A / C, v = B / C and depth h / C; the ray misses it where
A^2 + B^2 > w C^2. That outline is a conic, whose rows and columns bound the
pixels that need to be looked at. So it is for ellipsoids.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from remosplat_drake.oracle.depth_sensor import FILTER_SCALE, DepthSensor
from remosplat_drake.splat.bvh import (
    BoundingVolumeHierarchy,
    build_hierarchy,
)
from remosplat_drake.splat.gaussian_splat import GaussianSplat

kernel = njit(cache=True, nogil=True, error_model="numpy")
"""Compiles a function as all kernels of the depth views are compiled."""

PROJECTION_SIZE = 21
"""Length of the array that `project` fills."""

# Pixels at an outline are tested one by one; this widens the spans by far
# more than rounding can move them [px].
_MARGIN = 1e-6


class Footprints(NamedTuple):
    """The m splats that can be seen at all, in the order of their hierarchy.

    Attributes:
        center: Centres in W, shape (m, 3) [m].
        whiten: Rows map W to the splat's axes in standard deviations, shape
            (m, 3, 3). A disc's third row is its unit normal.
        opacity: Shape (m,).
        weight_cut: Largest squared Mahalanobis distance that is seen, (m,).
        radius: Of the ball around everything that is seen, shape (m,) [m].
    """

    center: np.ndarray
    whiten: np.ndarray
    opacity: np.ndarray
    weight_cut: np.ndarray
    radius: np.ndarray


class Rules(NamedTuple):
    """The numbers of a `DepthSensor` that the kernels need."""

    resolution: int
    alpha_cutoff: float
    transmittance: float
    near: float
    far: float
    n_sigma_squared: float
    min_alpha: float
    is_surfel: bool
    low_pass_filter: bool
    # Reach of the filter's footprint, as a part of the centre's distance.
    spread: float


def make_rules(sensor: DepthSensor, is_surfel: bool) -> Rules:
    """The rules by which a sensor looks at discs or at ellipsoids."""
    dot = 2 * sensor.n_sigma / np.sqrt(FILTER_SCALE) / sensor.resolution
    return Rules(
        sensor.resolution,
        sensor.alpha_cutoff,
        sensor.transmittance,
        sensor.near,
        sensor.far,
        float(sensor.n_sigma) ** 2,
        float(sensor.min_alpha),
        is_surfel,
        sensor.low_pass_filter,
        float(dot) if sensor.low_pass_filter else 0.0,
    )


def prepare(
    splat_W: GaussianSplat, sensor: DepthSensor
) -> tuple[Footprints, BoundingVolumeHierarchy]:
    """What a sensor can see of a splat, and the hierarchy over it."""
    opacity = splat_W.opacities.astype(float)
    with np.errstate(divide="ignore"):
        # alpha >= min_alpha is weight <= 2 ln(opacity / min_alpha).
        weight_cut = np.minimum(
            sensor.n_sigma**2, 2 * np.log(opacity / sensor.min_alpha)
        )
    seen = np.flatnonzero(weight_cut >= 0)
    center, axes = splat_W.p_GK[seen].astype(float), splat_W.R_GK[seen]
    scales = splat_W.scales[seen].astype(float)
    n_axes = scales.shape[1]
    reach = np.sqrt(weight_cut[seen])
    half = np.linalg.norm(axes[:, :, :n_axes] * scales[:, None], axis=2)
    half *= reach[:, None]
    hierarchy = build_hierarchy(center - half, center + half, center[:, 2])
    whiten = np.swapaxes(axes, 1, 2).copy()
    whiten[:, :n_axes] /= scales[:, :, None]
    order = hierarchy.order
    footprints = Footprints(
        center[order],
        whiten[order],
        opacity[seen][order],
        weight_cut[seen][order],
        (reach * scales.max(axis=1, initial=0.0))[order],
    )
    return footprints, hierarchy


@kernel
def nearest_range(splats, k, rules, p_WV):
    """Lower bound of the ranges at which a camera can see a splat."""
    x = splats.center[k, 0] - p_WV[0]
    y = splats.center[k, 1] - p_WV[1]
    z = splats.center[k, 2] - p_WV[2]
    square = x * x + y * y + z * z
    distance = np.sqrt(square)
    radius = splats.radius[k]
    if rules.is_surfel:
        normal = splats.whiten[k, 2]
        height = normal[0] * x + normal[1] * y + normal[2] * z
        along = np.sqrt(max(square - height * height, 0.0))
        along = max(along - radius, 0.0)
        bound = np.sqrt(height * height + along * along)
    else:
        bound = distance - radius
    if rules.low_pass_filter:
        bound = min(bound, distance * (1 - rules.spread))
    return bound


@kernel
def project(splats, k, rules, p_WV, R_WV, s):
    """Writes splat k in the ray coordinates of a view into s.

    s[0:9] are the forms A, B, C and, for a disc, s[9] its height. For an
    ellipsoid the forms whiten the ray, and s[9:12] is its whitened centre.
    s[12:15] is the centre in V and s[15:21] is free for `outline`.
    """
    for i in range(3):
        s[9 + i] = 0.0
        s[12 + i] = 0.0
    for i in range(3):
        for j in range(3):
            s[3 * i + j] = (
                splats.whiten[k, i, 0] * R_WV[0, j]
                + splats.whiten[k, i, 1] * R_WV[1, j]
                + splats.whiten[k, i, 2] * R_WV[2, j]
            )
            offset = splats.center[k, j] - p_WV[j]
            s[9 + i] += splats.whiten[k, i, j] * offset
            s[12 + i] += R_WV[j, i] * offset
    if rules.is_surfel:
        u, v, height = s[9], s[10], s[11]
        for j in range(3):
            s[j] = height * s[j] - u * s[6 + j]
            s[3 + j] = height * s[3 + j] - v * s[6 + j]
        s[9] = height


@kernel
def fragment(s, rules, x, y):
    """Depth and weight of the projected splat s on the ray (x, y, 1)."""
    a = s[0] * x + s[1] * y + s[2]
    b = s[3] * x + s[4] * y + s[5]
    c = s[6] * x + s[7] * y + s[8]
    if rules.is_surfel:
        z = s[9] / c
        u, v = a / c, b / c
        weight = u * u + v * v
    else:
        z = (a * s[9] + b * s[10] + c * s[11]) / (a * a + b * b + c * c)
        da, db, dc = z * a - s[9], z * b - s[10], z * c - s[11]
        weight = da * da + db * db + dc * dc
    if rules.low_pass_filter and s[14] > rules.near:
        dx, dy = x - s[12] / s[14], y - s[13] / s[14]
        scale = FILTER_SCALE * (rules.resolution * rules.resolution / 4)
        filtered = scale * (dx * dx + dy * dy)
        if not weight <= filtered:
            return s[14], filtered
    return z, weight


@kernel
def fragment_alpha(z, weight, opacity, rules):
    """Alpha of a fragment, 0 where it is not seen."""
    if not (weight <= rules.n_sigma_squared):
        return 0.0
    if not (rules.near <= z <= rules.far):
        return 0.0
    alpha = opacity * np.exp(-0.5 * weight)
    return alpha if alpha >= rules.min_alpha else 0.0


@kernel
def outline(s, rules, cut):
    """Writes the outline weight = cut of the projected splat into s[15:21].

    It is a quadratic form of the ray, <= 0 inside: entries xx, xy, xz, yy,
    yz, zz.
    """
    inside = s[9] * s[9] + s[10] * s[10] + s[11] * s[11] - cut
    entry = 15
    for i in range(3):
        for j in range(i, 3):
            ab = s[i] * s[j] + s[3 + i] * s[3 + j]
            cc = s[6 + i] * s[6 + j]
            if rules.is_surfel:
                s[entry] = ab - cut * cc
            else:
                along_i = s[9] * s[i] + s[10] * s[3 + i] + s[11] * s[6 + i]
                along_j = s[9] * s[j] + s[10] * s[3 + j] + s[11] * s[6 + j]
                s[entry] = inside * (ab + cc) - along_i * along_j
            entry += 1


@kernel
def row_span(s):
    """Rows y that the outline meets: all of them unless it is an ellipse."""
    xx, xy, xz, yy, yz, zz = s[15], s[16], s[17], s[18], s[19], s[20]
    area = xx * yy - xy * xy
    if not (xx > 0 and area > 0):
        return -1.0, 1.0
    middle = xy * xz - xx * yz
    square = middle * middle + area * (xz * xz - xx * zz)
    half = np.sqrt(max(square, 0.0))
    return (middle - half) / area, (middle + half) / area


@kernel
def column_span(s, rules, y):
    """Columns x inside the outline in row y; empty where low > high."""
    side = s[9] * s[6] if rules.is_surfel else 0.0
    return _quadratic_span(
        s[15],
        s[16] * y + s[17],
        (s[18] * y + 2 * s[19]) * y + s[20],
        side,
    )


@kernel
def near_span(s, reach, y):
    """Columns x of row y where a disc's plane is nearer than `reach`.

    Its range there is h |(x, y, 1)| / C.
    """
    h, c = s[9], s[7] * y + s[8]
    return _quadratic_span(
        h * h - reach * reach * s[6] * s[6],
        -reach * reach * s[6] * c,
        h * h * (y * y + 1) - reach * reach * c * c,
        h * s[6],
    )


@kernel
def _quadratic_span(xx, x, one, side):
    """Where xx t^2 + 2 x t + one <= 0, as a closed interval of t.

    Where xx < 0 that is two half-lines: one before and one behind the
    camera. `side` > 0 selects the upper one, < 0 the lower one, 0 everything.
    """
    square = x * x - xx * one
    if xx > 0:
        if square < 0:
            return 2.0, -2.0
        half = np.sqrt(square)
        return (-x - half) / xx, (-x + half) / xx
    if square < 0 or side == 0 or xx == 0:
        return -1.0, 1.0
    half = np.sqrt(square)
    if side > 0:
        return (-x - half) / xx, 1.0
    return -1.0, (-x + half) / xx


@kernel
def pixel_span(low, high, resolution):
    """First and last pixel whose centre lies in [low, high] of a ray axis."""
    half = resolution / 2
    first = np.ceil((max(low, -1.0) + 1) * half - 0.5 - _MARGIN)
    last = np.floor((min(high, 1.0) + 1) * half - 0.5 + _MARGIN)
    return max(int(first), 0), min(int(last), resolution - 1)
