"""`Footprints`: splats as a depth view sees them (numba).

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
from remosplat_drake.splat.bvh import build_hierarchy, leaf_margins
from remosplat_drake.splat.gaussian_splat import GaussianSplat

kernel = njit(cache=True, nogil=True, error_model="numpy")
"""Numba decorator of the kernels of depth views: cached, without the GIL."""

lean = njit(cache=True, nogil=True, error_model="numpy", _nrt=False)
"""Numba decorator of functions that make no arrays: no reference counts.

Counting takes a tenth of a query's time.
"""

inlined = njit(inline="always", error_model="numpy")
"""Numba decorator of functions whose arguments cost more than their work."""

PROJECTION_SIZE = 27
"""Length of the array that holds a projected splat, see `project`."""

# Pixels at an outline are tested one by one; this widens the spans by far
# more than rounding can move them [px].
_MARGIN = 1e-6


class Footprints(NamedTuple):
    """The m splats that can be seen at all, and a hierarchy over them.

    Attributes:
        nodes: Nodes of the `BoundingVolumeHierarchy`.
        links: Links of the `BoundingVolumeHierarchy`.
        records: The splats in leaf order, shape (m, 16), two cache lines
            each. Columns 0 to 2 hold the centre in W [m]; 3 to 11 the rows
            that map W to the splat's axes in standard deviations (a disc's
            third row is its unit normal); 12 the opacity, 13 the largest
            squared Mahalanobis distance that is seen, 14 the radius of the
            ball around everything that is seen [m], 15 the splat's index.
        uncertainty: Uncertainty of each splat in leaf order, shape (m,) [m];
            empty where none is subtracted.
        largest: Largest uncertainty below each node's children, shape (k, 2)
            [m]; empty where none is subtracted.
    """

    nodes: np.ndarray
    links: np.ndarray
    records: np.ndarray
    uncertainty: np.ndarray
    largest: np.ndarray


class Rules(NamedTuple):
    """The numbers of a `DepthSensor` that the kernels need.

    Attributes:
        resolution: Number of pixels along a side of a view.
        alpha_cutoff: Least accumulated alpha of a pixel that counts.
        transmittance: Threshold of the median depth.
        near: Near plane [m].
        far: Far plane [m].
        n_sigma_squared: Squared Mahalanobis distance at which splats end.
        min_alpha: Fragments below this alpha are dropped.
        is_surfel: Whether the splats are discs.
        low_pass_filter: Whether the screen-space filter of 2DGS is used.
        spread: Reach of the filter's footprint as a fraction of the centre's
            distance.
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
    # Reach of the filter's footprint, as a part of the centre's distance.
    spread: float


def make_rules(sensor: DepthSensor, is_surfel: bool) -> Rules:
    """Makes the rules by which a sensor sees discs or ellipsoids."""
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


def make_footprints(splat_W: GaussianSplat, sensor: DepthSensor) -> Footprints:
    """Prepares what a sensor can see of a splat that is expressed in W."""
    records, half = footprint_records(splat_W, sensor)
    center = records[:, :3]
    hierarchy = build_hierarchy(center - half, center + half, center[:, 2])
    values = splat_W.uncertainty
    if values is not None:
        values = values[records[:, 15].astype(np.int64)]
    return Footprints(
        hierarchy.nodes,
        hierarchy.links,
        records[hierarchy.order],
        *leaf_margins(hierarchy, values),
    )


def footprint_records(
    splat_W: GaussianSplat, sensor: DepthSensor
) -> tuple[np.ndarray, np.ndarray]:
    """Computes what a sensor can see of each splat.

    Returns:
        The records of all m splats that can be seen at all, as in
        `Footprints`, shape (m, 16), in the order of the splats, and half edges
        of the boxes around what is seen of each, shape (m, 3) [m].
    """
    opacity = splat_W.opacities.astype(float)
    with np.errstate(divide="ignore"):
        # alpha >= min_alpha is weight <= 2 ln(opacity / min_alpha).
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
def splat_margin(splats, k):
    """Returns a splat's uncertainty, 0 where none is subtracted [m]."""
    return splats.uncertainty[k] if len(splats.uncertainty) else 0.0


@inlined
def child_margin(splats, link, side):
    """Returns the largest uncertainty below a node's child [m]."""
    return splats.largest[link, side] if len(splats.largest) else 0.0


@inlined
def nearest_range(records, k, rules, x, y, z):
    """Bounds from below the ranges at which a camera sees splat k [m].

    (x, y, z) is the vector from the camera to the centre, in W [m].
    """
    square = x * x + y * y + z * z
    distance = np.sqrt(square)
    radius = records[k, 14]
    if rules.is_surfel:
        height = records[k, 9] * x + records[k, 10] * y + records[k, 11] * z
        along = np.sqrt(max(square - height * height, 0.0))
        along = max(along - radius, 0.0)
        bound = np.sqrt(height * height + along * along)
    else:
        bound = distance - radius
    if rules.low_pass_filter:
        bound = min(bound, distance * (1 - rules.spread))
    return bound


@lean
def project(records, k, rules, p_WV, R_WV, s):
    """Writes splat k in the ray coordinates of a view into s.

    s[0:9] are the forms A, B, C and, for a disc, s[9] its height. For an
    ellipsoid the forms whiten the ray, and s[9:12] is its whitened centre.
    s[12:15] is the centre in V; the rest is left to the outlines.
    """
    whiten(records, k, p_WV, R_WV, s)
    if rules.is_surfel:
        meet_plane(s)


@lean
def whiten(records, k, p_WV, R_WV, s):
    """Writes splat k in a view's axes into s.

    s[0:9] are the rows that map V to the splat's axes in standard deviations
    (a disc's third row is its unit normal), s[9:12] is the centre mapped by
    them, s[12:15] the centre in V [m].
    """
    x = records[k, 0] - p_WV[0]
    y = records[k, 1] - p_WV[1]
    z = records[k, 2] - p_WV[2]
    for i in range(3):
        a, b, c = (
            records[k, 3 + 3 * i],
            records[k, 4 + 3 * i],
            records[k, 5 + 3 * i],
        )
        for j in range(3):
            s[3 * i + j] = a * R_WV[0, j] + b * R_WV[1, j] + c * R_WV[2, j]
        s[9 + i] = a * x + b * y + c * z
        s[12 + i] = R_WV[0, i] * x + R_WV[1, i] * y + R_WV[2, i] * z


@lean
def meet_plane(s):
    """Turns a whitened disc into the forms of where a ray meets its plane."""
    u, v, height = s[9], s[10], s[11]
    for j in range(3):
        s[j] = height * s[j] - u * s[6 + j]
        s[3 + j] = height * s[3 + j] - v * s[6 + j]
    s[9] = height


@lean
def fragment(s, rules, x, y):
    """Returns depth and weight of the projected splat s on a ray (x, y, 1)."""
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


@lean
def fragment_alpha(z, weight, opacity, rules, shift=0.0):
    """Returns the alpha of a fragment, 0 where it is not seen.

    `shift` is how much nearer than z uncertainty puts it [m].
    """
    if not (weight <= rules.n_sigma_squared):
        return 0.0
    if not (rules.near <= z and z - shift <= rules.far):
        return 0.0
    alpha = opacity * np.exp(-0.5 * weight)
    return alpha if alpha >= rules.min_alpha else 0.0


@lean
def pixel_span(low, high, resolution):
    """Returns the first and last pixel with centres in [low, high] of a row."""
    half = resolution / 2
    first = np.ceil((max(low, -1.0) + 1) * half - 0.5 - _MARGIN)
    last = np.floor((min(high, 1.0) + 1) * half - 0.5 + _MARGIN)
    return max(int(first), 0), min(int(last), resolution - 1)
