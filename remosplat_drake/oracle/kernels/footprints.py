"""`Footprints`: depth and weight of splats as functions of the ray (Numba).

In a view, the depth and the weight of a splat are functions of a pixel's ray
(x, y, 1). The weight is the squared Mahalanobis distance. A disc has three
linear forms A, B and C of the ray, and the height h of its plane. At the point
where the ray meets the plane, u = A / C, v = B / C, and the depth is h / C. The
ray misses the disc if A^2 + B^2 > w C^2, with the weight w at which the disc
ends. So the disc's outline is a conic, whose rows and columns bound the pixels
that must be tested. The outline of an ellipsoid is a conic, too.
"""

from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable

from remosplat_drake.base.lanes import (
    WIDTH,
    exponential,
    greatest,
    in_all,
    lanes_from,
    least,
    root,
    round_down,
    round_up,
    where,
)
from remosplat_drake.oracle.depth_sensor import FILTER_SCALE, DepthSensor
from remosplat_drake.oracle.kernels.wide_tree import largest_below, widen
from remosplat_drake.splat.bvh import build_hierarchy
from remosplat_drake.splat.gaussian_splat import GaussianSplat

lean = register_jitable(no_cfunc_wrapper=True, error_model="numpy", _nrt=False)
"""Decorator of helpers that create no arrays.

The compiled code does not count references to arrays, which would take a tenth
of a query's time.
"""

inlined = register_jitable(
    no_cfunc_wrapper=True, error_model="numpy", _nrt=False, forceinline=True
)
"""Decorator like `lean` that also inlines the function, because its call would
take longer than its work."""

# Margin by which spans of pixels are widened [px]. It is much larger than the
# rounding error. A wide margin changes no result, since pixels at an outline
# are tested one by one.
_MARGIN = 1e-6


class Footprints(NamedTuple):
    """The m visible splats, and a bounding volume hierarchy of them.

    Attributes:
        nodes: Nodes of the `BoundingVolumeHierarchy`.
        wide: Boxes of the wide hierarchy; see `widen`.
        children: Numbers of the children in the wide hierarchy; see `widen`.
        margins: Largest uncertainty of the splats below each child, shape (k,
            8) [m]; empty if uncertainties are not subtracted.
        records: The splats in leaf order, shape (m, 16); each takes two cache
            lines. Columns 0 to 2 are the centre in W [m]. Columns 3 to 11 are
            the rows of the matrix that maps W to the splat's axes in standard
            deviations; a disc's third row is its unit normal. Column 12 is the
            opacity, and 13 the squared Mahalanobis distance at which the
            visible part ends. Column 14 is the radius of the ball around the
            visible part [m], and 15 the uncertainty [m].
        bounds: Data of each splat for the first test: columns 0 to 2, 9 to 11,
            14 and 15 of the records. Shape (8, m + 8), padded for SIMD lanes.
    """

    nodes: np.ndarray
    wide: np.ndarray
    children: np.ndarray
    margins: np.ndarray
    records: np.ndarray
    bounds: np.ndarray


class Rules(NamedTuple):
    """The settings of a `DepthSensor`, as numbers for kernels.

    Attributes:
        resolution: Number of pixels along a side of a view.
        alpha_cutoff: Least accumulated alpha with which a pixel counts as a
            surface.
        transmittance: Threshold of the median depth.
        near: Near plane [m].
        far: Far plane [m].
        n_sigma_squared: Squared Mahalanobis distance at which splats end.
        min_alpha: Fragments below this alpha are dropped.
        is_surfel: Whether the splats are discs.
        low_pass_filter: Whether the screen-space filter of 2DGS is used.
        spread: Radius of the filter's footprint as a fraction of the distance
            of the splat's centre.
        nearest_only: Whether only the nearest view of each sphere needs a
            result.
    """

    resolution: int
    alpha_cutoff: float
    transmittance: float
    near: float
    far: float
    n_sigma_squared: float
    min_alpha: float
    is_surfel: bool
    low_pass_filter: bool
    spread: float
    nearest_only: bool


def make_rules(
    sensor: DepthSensor, is_surfel: bool, *, nearest_only: bool = False
) -> Rules:
    """Makes the `Rules` of a sensor for discs or ellipsoids."""
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
        nearest_only,
    )


def make_footprints(splat_W: GaussianSplat, sensor: DepthSensor) -> Footprints:
    """Makes the `Footprints` of a splat that is expressed in W."""
    records, half = footprint_records(splat_W, sensor)
    center = records[:, :3]
    hierarchy = build_hierarchy(center - half, center + half, center[:, 2])
    index = records[:, 15].astype(np.int64)
    records[:, 15] = 0.0
    if splat_W.uncertainty is not None:
        records[:, 15] = splat_W.uncertainty[index]
    return footprints_of(hierarchy.nodes, records[hierarchy.order])


def footprints_of(nodes: np.ndarray, records: np.ndarray) -> Footprints:
    """Makes `Footprints` from precomputed arrays.

    Args:
        nodes: The array `Footprints.nodes`.
        records: The array `Footprints.records`.
    """
    wide, children = widen(nodes, nodes.view(np.int32), WIDTH)
    bounds = np.zeros((8, len(records) + WIDTH))
    columns = [0, 1, 2, 9, 10, 11, 14, 15]
    bounds[:, : len(records)] = records[:, columns].T
    margins = np.zeros((0, WIDTH))
    if bounds[7].any():
        margins = largest_below(children, bounds[7])
    return Footprints(nodes, wide, children, margins, records, bounds)


def footprint_records(
    splat_W: GaussianSplat, sensor: DepthSensor
) -> tuple[np.ndarray, np.ndarray]:
    """Computes the records of all visible splats.

    Returns:
        Two arrays. The first has the records of the m visible splats in the
        order of the splats, shape (m, 16). They are those of
        `Footprints.records`, except that column 15 contains the splat's index.
        The second has half edges of the boxes around the visible parts, shape
        (m, 3) [m].
    """
    opacity = splat_W.opacities.astype(float)
    with np.errstate(divide="ignore"):
        # alpha >= min_alpha is equivalent to weight <= 2 ln(opacity /
        # min_alpha).
        weight_cut = np.minimum(
            sensor.n_sigma**2, 2 * np.log(opacity / sensor.min_alpha)
        )
    seen = np.flatnonzero(weight_cut >= 0)
    axes = splat_W.R_GK[seen]
    scales = splat_W.scales[seen].astype(float)
    n_axes = scales.shape[1]
    reach = np.sqrt(weight_cut[seen])
    half = np.linalg.norm(axes[:, :, :n_axes] * scales[:, None], axis=2)
    half *= reach[:, None]
    whiten = np.swapaxes(axes, 1, 2).copy()
    whiten[:, :n_axes] /= scales[:, :, None]
    records = np.zeros((len(seen), 16))
    records[:, 0:3] = splat_W.p_GK[seen]
    records[:, 3:12] = whiten.reshape(-1, 9)
    records[:, 12] = opacity[seen]
    records[:, 13] = weight_cut[seen]
    records[:, 14] = reach * scales.max(axis=1, initial=0.0)
    records[:, 15] = seen
    return records, half


@inlined
def nearest_range(rules, center, normal, radius):
    """Returns lower bounds of the ranges of splats from a camera [m].

    Args:
        rules: The sensor's `Rules`.
        center: Vectors from the camera to the splats' centres in W, as a tuple
            of SIMD lanes [m].
        normal: Unit normal of each disc in W, as a tuple of SIMD lanes.
        radius: Radius of the ball around the visible part of each splat [m].
    """
    x, y, z = center
    square = x * x + y * y + z * z
    distance = root(square)
    bound = distance - radius
    if rules.is_surfel:
        height = normal[0] * x + normal[1] * y + normal[2] * z
        along = root(greatest(square - height * height, 0.0))
        along = greatest(along - radius, 0.0)
        bound = root(height * height + along * along)
    if rules.low_pass_filter:
        bound = least(bound, distance * (1 - rules.spread))
    return bound


@inlined
def child_margins(splats, node):
    """Returns the largest uncertainty below each child, as SIMD lanes [m]."""
    margins = in_all(0.0)
    if len(splats.margins):
        margins = lanes_from(splats.margins, WIDTH * node)
    return margins


@inlined
def whiten(p, axes, R_WV):
    """Returns a splat's matrix and centre in a view's frame V.

    The arguments are scalars of one splat, or SIMD lanes of eight splats.

    Args:
        p: Vector from the camera to the splat's centre in W, as a tuple [m].
        axes: The three rows, as nine values, that map W to the splat's axes in
            standard deviations. A disc's third row is its unit normal.
        R_WV: Orientation of the view.

    Returns:
        Fifteen values: the nine entries of the rows that map V to the splat's
        axes, the splat's centre after this map, and the centre in V [m].
    """
    x, y, z = p
    center = (
        axes[0] * x + axes[1] * y + axes[2] * z,
        axes[3] * x + axes[4] * y + axes[5] * z,
        axes[6] * x + axes[7] * y + axes[8] * z,
    )
    return (
        _in_view(R_WV, axes[0], axes[1], axes[2])
        + _in_view(R_WV, axes[3], axes[4], axes[5])
        + _in_view(R_WV, axes[6], axes[7], axes[8])
        + center
        + _in_view(R_WV, x, y, z)
    )


@inlined
def _in_view(R, a, b, c):
    return (
        a * R[0, 0] + b * R[1, 0] + c * R[2, 0],
        a * R[0, 1] + b * R[1, 1] + c * R[2, 1],
        a * R[0, 2] + b * R[1, 2] + c * R[2, 2],
    )


@inlined
def meet_plane(s):
    """Computes the linear forms A, B and C of a disc from its `whiten` values.

    Args:
        s: The fifteen values that `whiten` returns.

    Returns:
        Fifteen values. The forms A, B and C replace the rows, and the height of
        the plane replaces the first coordinate of the mapped centre. All other
        values are those of `s`.
    """
    u, v, height = s[9], s[10], s[11]
    forms = (
        height * s[0] - u * s[6],
        height * s[1] - u * s[7],
        height * s[2] - u * s[8],
        height * s[3] - v * s[6],
        height * s[4] - v * s[7],
        height * s[5] - v * s[8],
    )
    return forms + s[6:9] + (height,) + s[10:]


@inlined
def project(records, k, rules, p_WV, R_WV):
    """Projects splat k into a view: returns the coefficients for `fragment`.

    Returns:
        Fifteen numbers: the result of `meet_plane` for a disc, and that of
        `whiten` for an ellipsoid.
    """
    p = (
        records[k, 0] - p_WV[0],
        records[k, 1] - p_WV[1],
        records[k, 2] - p_WV[2],
    )
    r = records[k]
    axes = r[3], r[4], r[5], r[6], r[7], r[8], r[9], r[10], r[11]
    s = whiten(p, axes, R_WV)
    return meet_plane(s) if rules.is_surfel else s


@inlined
def fragment(s, rules, x, y):
    """Returns depth and weight of a projected splat s on a ray (x, y, 1).

    Either the splat or the ray may consist of SIMD lanes.
    """
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
        keeps = weight <= filtered
        z, weight = where(keeps, z, s[14]), where(keeps, weight, filtered)
    return z, weight


@inlined
def fragment_alpha(z, weight, opacity, rules, shift=0.0):
    """Returns the alpha of a fragment; 0 if the fragment is not visible.

    `shift` is the uncertainty, subtracted from z [m].
    """
    if not is_within(z, weight, rules, shift):
        return 0.0
    alpha = opacity * exponential(-0.5 * weight)
    return alpha if alpha >= rules.min_alpha else 0.0


@inlined
def is_within(z, weight, rules, shift):
    """Returns whether a fragment is inside its splat's outline and depth range.

    The depth range is between the view's near and far planes. The arguments are
    those of `fragment_alpha`, as scalars or SIMD lanes.
    """
    return (
        (weight <= rules.n_sigma_squared)
        & (z >= rules.near)
        & (z - shift <= rules.far)
    )


@inlined
def pixel_span(low, high, resolution):
    """Returns the first and last pixel of a row with centres in [low, high].

    Both are integers, represented as floats or as SIMD lanes of floats.
    """
    half = resolution / 2
    first = round_up((greatest(low, -1.0) + 1) * half - 0.5 - _MARGIN)
    last = round_down((least(high, 1.0) + 1) * half - 0.5 + _MARGIN)
    return greatest(first, 0.0), least(last, resolution - 1.0)
