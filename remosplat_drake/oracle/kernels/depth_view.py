"""`DepthViews`: the six depth views of one sphere, for kernels (Numba).

A set of views is an integer whose bit v is 1 if the set contains view v. SIMD
lanes contain floats, so in lanes this integer is converted to a float. A view
contains the points whose coordinate along the view's axis, in the sensor's
frame D, exceeds the magnitudes of the two other coordinates.
"""

from typing import NamedTuple

import numpy as np

from remosplat_drake.base.lanes import (
    WIDTH,
    first_lanes,
    greatest,
    in_all,
    lanes_from,
    least,
    magnitude,
    places_of,
    root,
    where,
)
from remosplat_drake.oracle.depth_sensor import N_VIEWS, R_DV
from remosplat_drake.oracle.kernels.footprints import (
    child_margins,
    inlined,
    lean,
)
from remosplat_drake.oracle.kernels.wide_tree import ROWS
from remosplat_drake.splat.bvh import leaf_range

ALL_VIEWS = 2**N_VIEWS - 1
"""The set of all views."""

# Indices of the views along the positive and negative axes of D.
_ALONG_X, _ALONG_Y, _ALONG_Z, _AGAINST_X, _AGAINST_Y, _AGAINST_Z = (
    int(np.argmax(R_DV[:, :, 2] @ axis)) for axis in [*np.eye(3), *-np.eye(3)]
)

_ROOT_2 = np.sqrt(2.0)


class DepthViews(NamedTuple):
    """The six depth views of one sphere, which kernels place.

    Attributes:
        p_WS: Camera centre of all six views, shape (3,) [m].
        R_WD: Orientation of the sensor, shape (3, 3).
        R_WV: Orientations of the views, shape (6, 3, 3).
        ignore_below: Splats with lower centres are ignored, shape (1,) [m].
    """

    p_WS: np.ndarray
    R_WD: np.ndarray
    R_WV: np.ndarray
    ignore_below: np.ndarray


def new_views() -> DepthViews:
    """Makes six views whose poses are not set; `place_views` sets them."""
    return DepthViews(
        np.zeros(3), np.zeros((3, 3)), np.zeros((N_VIEWS, 3, 3)), np.zeros(1)
    )


@lean
def place_views(views, p_WS, R_WD, ignore_below):
    """Places the views of a sphere whose sensor has the orientation R_WD."""
    views.ignore_below[0] = ignore_below
    for i in range(3):
        views.p_WS[i] = p_WS[i]
        for j in range(3):
            views.R_WD[i, j] = R_WD[i, j]
            for v in range(N_VIEWS):
                views.R_WV[v, i, j] = (
                    R_WD[i, 0] * R_DV[v, 0, j]
                    + R_WD[i, 1] * R_DV[v, 1, j]
                    + R_WD[i, 2] * R_DV[v, 2, j]
                )


@inlined
def views_of_boxes(splats, node, views, seen, limit, spread):
    """Returns range bounds of a node's children, and the views that need them.

    Args:
        splats: The `Footprints`.
        node: Number of the node.
        views: The `DepthViews`.
        seen: Set of the views that need the node.
        limit: Range beyond which fragments of each view are irrelevant, shape
            (6,) [m].
        spread: Reach of the low-pass filter; see `Rules.spread`.

    Returns:
        Lower bounds of the ranges of fragments in the children [m], and for
        each child the set of the views that need it. Both are SIMD lanes.
    """
    at, p = ROWS * WIDTH * node, views.p_WS
    x, hx = _middle(splats.wide, at, p[0])
    y, hy = _middle(splats.wide, at + WIDTH, p[1])
    z, hz = _middle(splats.wide, at + 2 * WIDTH, p[2])
    dx = greatest(magnitude(x) - hx, 0.0)
    dy = greatest(magnitude(y) - hy, 0.0)
    dz = greatest(magnitude(z) - hz, 0.0)
    nearest = root(dx * dx + dy * dy + dz * dz) * max(1 - spread, 0.0)
    nearest = nearest - child_margins(splats, node)
    slack = in_all(0.0)
    if spread > 0:
        dx, dy, dz = magnitude(x) + hx, magnitude(y) + hy, magnitude(z) + hz
        slack = spread * root(dx * dx + dy * dy + dz * dz)
    R = views.R_WD
    hx, hy, hz = (
        abs(R[0, 0]) * hx + abs(R[1, 0]) * hy + abs(R[2, 0]) * hz + slack,
        abs(R[0, 1]) * hx + abs(R[1, 1]) * hy + abs(R[2, 1]) * hz + slack,
        abs(R[0, 2]) * hx + abs(R[1, 2]) * hy + abs(R[2, 2]) * hz + slack,
    )
    x, y, z = _in_sensor(R, x, y, z)
    ahead = magnitude(x) - hx, magnitude(y) - hy, magnitude(z) - hz
    # Missing children have a box without height.
    height = lanes_from(splats.wide, at + 6 * WIDTH)
    nearest = where(height >= views.ignore_below[0], nearest, np.inf)
    return nearest, _views_beyond_sides(
        (x, y, z), (hx, hy, hz), ahead, nearest, seen, limit
    )


@inlined
def _middle(wide, at, p):
    """Returns the centres of intervals relative to p, and half lengths."""
    low = lanes_from(wide, at) - p
    high = lanes_from(wide, at + 3 * WIDTH) - p
    return 0.5 * (low + high), 0.5 * (high - low)


@inlined
def views_of_balls(views, center, radius, nearest, seen, limit):
    """Returns the sets of the views that intersect balls, as SIMD lanes.

    Args:
        views: The `DepthViews`.
        center: Vectors from the camera to the balls' centres in W, as a tuple
            of SIMD lanes [m].
        radius: Radii of the balls [m].
        nearest: Lower bounds of the ranges of fragments in the balls [m].
        seen: Set of the requested views.
        limit: Range beyond which fragments of each view are irrelevant, shape
            (6,) [m].
    """
    center = _in_sensor(views.R_WD, center[0], center[1], center[2])
    # Planes at 45 degrees separate the views.
    reach = _ROOT_2 * radius
    ahead = magnitude(center[0]), magnitude(center[1]), magnitude(center[2])
    return _views_beyond_sides(
        center, (reach, reach, reach), ahead, nearest, seen, limit
    )


@inlined
def _in_sensor(R, x, y, z):
    """Rotates a vector from frame W into the sensor's frame D."""
    return (
        R[0, 0] * x + R[1, 0] * y + R[2, 0] * z,
        R[0, 1] * x + R[1, 1] * y + R[2, 1] * z,
        R[0, 2] * x + R[1, 2] * y + R[2, 2] * z,
    )


@inlined
def _views_beyond_sides(p, half, ahead, nearest, seen, limit):
    """Returns the views that boxes may intersect, as SIMD lanes.

    A view contains the points whose distance along its axis exceeds that to any
    side. The boxes have the centre p and the half edges `half` in D. `ahead` is
    their least distance from the camera along each axis.
    """
    beside_x = greatest(greatest(ahead[1], ahead[2]), 0.0)
    beside_y = greatest(greatest(ahead[2], ahead[0]), 0.0)
    beside_z = greatest(greatest(ahead[0], ahead[1]), 0.0)
    return (
        _if_seen(_ALONG_X, half[0] + p[0], beside_x, nearest, seen, limit)
        + _if_seen(_ALONG_Y, half[1] + p[1], beside_y, nearest, seen, limit)
        + _if_seen(_ALONG_Z, half[2] + p[2], beside_z, nearest, seen, limit)
        + _if_seen(_AGAINST_X, half[0] - p[0], beside_x, nearest, seen, limit)
        + _if_seen(_AGAINST_Y, half[1] - p[1], beside_y, nearest, seen, limit)
        + _if_seen(_AGAINST_Z, half[2] - p[2], beside_z, nearest, seen, limit)
    )


@inlined
def _if_seen(view, farthest, beside, nearest, seen, limit):
    """Returns, for each box, the set of this view, or the empty set."""
    reach = limit[view] if (seen >> view) & 1 else -np.inf
    # Infinite boxes give NaN here, so they count as visible.
    reaches_in = ~(farthest < beside)
    return where(reaches_in & (nearest < reach), float(1 << view), 0.0)


@inlined
def views_beyond(limit, distance, seen):
    """Returns the set of the views in `seen` whose limit exceeds `distance`."""
    for v in range(N_VIEWS):
        if distance >= limit[v]:
            seen &= ~(1 << v)
    return seen


@inlined
def children_on_ray(splats, node, views, ray_W, rules):
    """Returns the children that a ray meets between `near` and `far`, as bits.

    Boxes are enlarged by the spread of the low-pass filter. A child is also
    returned if its box is behind `far` by at most the uncertainty of its
    splats.
    """
    at = ROWS * WIDTH * node
    slack = in_all(0.0)
    if rules.spread > 0:
        square = in_all(0.0)
        for i in range(3):
            low, high = _interval(splats.wide, at, i, views)
            most = greatest(-low, high)
            square = square + most * most
        slack = rules.spread * root(square)
    enter = in_all(rules.near)
    leave = rules.far + child_margins(splats, node)
    for i in range(3):
        low, high = _interval(splats.wide, at, i, views)
        low, high = low - slack, high + slack
        if ray_W[i] == 0:
            leave = where((low > 0.0) | (high < 0.0), -np.inf, leave)
            continue
        a, b = low / ray_W[i], high / ray_W[i]
        enter = greatest(enter, least(a, b))
        leave = least(leave, greatest(a, b))
    height = lanes_from(splats.wide, at + 6 * WIDTH)
    return places_of((enter <= leave) & (height >= views.ignore_below[0]))


@inlined
def _interval(wide, at, axis, views):
    """Returns the corners of children along an axis, relative to the camera."""
    at += axis * WIDTH
    p = views.p_WS[axis]
    return lanes_from(wide, at) - p, lanes_from(wide, at + 3 * WIDTH) - p


@inlined
def centers_in_leaf(splats, leaf, views):
    """Returns the positions of a leaf's splats, and a mask of those to use.

    Args:
        splats: The `Footprints`.
        leaf: Link that encodes the leaf.
        views: The `DepthViews`.

    Returns:
        Vectors from the camera to the splats' centres in W, as a tuple of SIMD
        lanes [m], and a mask that is false for ignored splats.
    """
    first, end = leaf_range(leaf)
    p, row = views.p_WS, splats.bounds.shape[1]
    height = lanes_from(splats.bounds, first + 2 * row)
    center = (
        lanes_from(splats.bounds, first) - p[0],
        lanes_from(splats.bounds, first + row) - p[1],
        height - p[2],
    )
    is_there = first_lanes(end - first, height)
    return center, is_there & (height >= views.ignore_below[0])


@inlined
def splats_on_ray(splats, leaf, views, ray_W, rules):
    """Returns the splats of a leaf that a ray may meet, as bits."""
    first, _ = leaf_range(leaf)
    (x, y, z), is_seen = centers_in_leaf(splats, leaf, views)
    radius = lanes_from(splats.bounds, first + 6 * splats.bounds.shape[1])
    square = x * x + y * y + z * z
    if rules.spread > 0:
        radius = greatest(radius, rules.spread * root(square))
    along = x * ray_W[0] + y * ray_W[1] + z * ray_W[2]
    along = along * along / (ray_W[0] ** 2 + ray_W[1] ** 2 + ray_W[2] ** 2)
    # This is a bound of the rounding error of the distance to the ray.
    slack = 1e-9 * square
    return places_of(is_seen & (square - along <= radius * radius + slack))
