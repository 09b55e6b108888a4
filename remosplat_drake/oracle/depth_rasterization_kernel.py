"""Nearest pixels of depth views without rendering the views (numba).

Only the smallest range of each view is wanted. Fragments are kept in lists,
one a pixel, and arrive in any order; because a median along the ray can only
move nearer when a fragment is added, and accumulated alpha can only grow, the
smallest median of all complete pixels so far is an upper bound of the answer.
Splats are visited roughly from near to far until that bound stops them, and
fragments behind the bound are not even kept. What remains are pixels with a
nearer median that the kept fragments leave too transparent to count: their
rays are followed through the hierarchy, nearest first.
"""

from heapq import heappop, heappush

import numpy as np

from remosplat_drake.oracle.depth_sensor import FILTER_SCALE, N_VIEWS, R_DV
from remosplat_drake.oracle.depth_view import (
    box_range,
    make_view,
    ray_meets_box,
)
from remosplat_drake.oracle.footprints import (
    NEAR,
    OUTLINE,
    Footprints,
    Rules,
    column_span,
    fragment,
    fragment_alpha,
    inlined,
    kernel,
    near_outline,
    nearest_range,
    outline,
    pixel_span,
    project,
    row_span,
)
from remosplat_drake.oracle.node_queue import pop, push
from remosplat_drake.oracle.pixel_lists import (
    ROUNDING,
    add_fragment,
    has_median,
    median_range,
    new_canvas,
)
from remosplat_drake.splat.bvh import leaf_range

_FULL = -2


@kernel
def nearest_pixels(
    splats: Footprints,
    rules: Rules,
    p_WS,
    R_WD,
    ignore_below,
    bound,
    nearest_only,
    first,
    step,
    reach,
    pixel,
):
    """Fills `reach` and `pixel`, both (n, 6), for spheres first::step.

    Views without a complete pixel nearer than the sphere's `bound` get inf
    and -1. With `nearest_only`, views other than the nearest may get them.
    """
    pixels = rules.resolution * rules.resolution
    canvas = new_canvas(rules.resolution, len(splats.nodes), 8 * pixels)
    for i in range(first, len(p_WS), step):
        limit = bound[i]
        for v in range(N_VIEWS):
            view = make_view(p_WS[i], R_WD[i], R_DV[v], ignore_below[i])
            stamp = i * N_VIEWS + v
            while True:
                reach[i, v], pixel[i, v] = _nearest_pixel(
                    splats, rules, view, limit, canvas, stamp
                )
                if pixel[i, v] != _FULL:
                    break
                canvas = new_canvas(
                    rules.resolution, len(splats.nodes), 2 * len(canvas.link)
                )
            if nearest_only:
                limit = min(limit, reach[i, v])


@kernel
def _nearest_pixel(splats, rules, view, bound, canvas, stamp):
    """The nearest complete pixel of a view: its range, and its index.

    The index is _FULL where the canvas has no room for the view's fragments.
    """
    canvas.count[:] = 0
    best, best_pixel = bound, -1
    keys, waiting = canvas.keys, canvas.waiting
    size = push(keys, waiting, 0, 0.0, 0)
    while size > 0:
        nearest, link, size = pop(keys, waiting, size)
        if nearest >= best:
            break
        # Down to a leaf by the nearer child; the other one waits its turn.
        while link >= 0:
            left = box_range(splats, link, 0, view, rules.spread)
            right = box_range(splats, link, 1, view, rules.spread)
            side = 0 if left <= right else 1
            if max(left, right) < best:
                other = splats.links[link, 15 - side]
                size = push(keys, waiting, size, max(left, right), other)
            if min(left, right) >= best:
                break
            link = splats.links[link, 14 + side]
        if link >= 0:
            continue
        first, end = leaf_range(link)
        for k in range(first, end):
            if _is_visible(splats, k, view, rules, best):
                if canvas.count[1] + len(canvas.stamp) > len(canvas.link):
                    return np.inf, _FULL
                best, best_pixel = _rasterize(
                    splats, k, rules, view, canvas, stamp, best, best_pixel
                )
    best, best_pixel = _complete(splats, rules, view, canvas, best, best_pixel)
    return best if best_pixel >= 0 else np.inf, best_pixel


@kernel
def _is_visible(splats, k, view, rules, best):
    """Whether a splat can have fragments in the view nearer than `best`."""
    if splats.records[k, 2] < view.ignore_below:
        return False
    x = splats.records[k, 0] - view.p_WV[0]
    y = splats.records[k, 1] - view.p_WV[1]
    z = splats.records[k, 2] - view.p_WV[2]
    radius = splats.records[k, 14]
    if rules.low_pass_filter:
        radius = max(radius, rules.spread * np.sqrt(x * x + y * y + z * z))
    for j in range(4):
        nx, ny, nz = view.sides_W[j, 0], view.sides_W[j, 1], view.sides_W[j, 2]
        if nx * x + ny * y + nz * z < -radius:
            return False
    return nearest_range(splats.records, k, rules, x, y, z) < best


@inlined
def _rasterize(splats, k, rules, view, canvas, stamp, best, best_pixel):
    """Adds a splat's fragments nearer than `best`; returns the new best."""
    s = canvas.projection
    resolution = rules.resolution
    cut, opacity = splats.records[k, 13], splats.records[k, 12]
    project(splats.records, k, rules, view.p_WV, view.R_WV, s)
    outline(s, rules, cut)
    y_low, y_high = row_span(s, rules, OUTLINE)
    if rules.is_surfel:
        near_outline(s, best)
        y_near, y_far = row_span(s, rules, NEAR)
        y_low, y_high = max(y_low, y_near), min(y_high, y_far)
    # The dot that the low-pass filter puts on the splat's centre.
    dot, x_dot, y_dot = -1.0, 0.0, 0.0
    if rules.low_pass_filter and s[14] > rules.near:
        dot = 2 * np.sqrt(cut / FILTER_SCALE) / resolution
        x_dot, y_dot = s[12] / s[14], s[13] / s[14]
        y_low, y_high = _with_dot(y_low, y_high, y_dot, dot)
    first_row, last_row = pixel_span(y_low, y_high, resolution)
    for row in range(first_row, last_row + 1):
        y = (row + 0.5) * 2 / resolution - 1
        x_low, x_high = column_span(s, rules, OUTLINE, y)
        if rules.is_surfel:
            x_near, x_far = column_span(s, rules, NEAR, y)
            x_low, x_high = max(x_low, x_near), min(x_high, x_far)
        if abs(y - y_dot) <= dot:
            x_low, x_high = _with_dot(x_low, x_high, x_dot, dot)
        first, last = pixel_span(x_low, x_high, resolution)
        for column in range(first, last + 1):
            x = (column + 0.5) * 2 / resolution - 1
            pixel = row * resolution + column
            z, weight = fragment(s, rules, x, y)
            reach = z * canvas.length[pixel]
            if not reach < best:
                continue
            alpha = fragment_alpha(z, weight, opacity, rules)
            if alpha == 0:
                continue
            add_fragment(canvas, pixel, stamp, reach, alpha)
            if has_median(canvas, pixel, rules) and (
                1 - canvas.total[pixel] >= rules.alpha_cutoff - ROUNDING
            ):
                median, accumulated = median_range(canvas, pixel, rules, best)
                if median < best and accumulated >= rules.alpha_cutoff:
                    best, best_pixel = median, pixel
    return best, best_pixel


@kernel
def _with_dot(low, high, center, half):
    """An interval, empty if low > high, enlarged by center +- half."""
    if low > high:
        return center - half, center + half
    return min(low, center - half), max(high, center + half)


@kernel
def _complete(splats, rules, view, canvas, best, best_pixel):
    """Judges the pixels with a nearer median that are too transparent yet."""
    heap = [(best, best_pixel)]
    for i in range(canvas.count[0]):
        pixel = canvas.touched[i]
        if has_median(canvas, pixel, rules) and (
            1 - canvas.total[pixel] < rules.alpha_cutoff + ROUNDING
        ):
            median, _ = median_range(canvas, pixel, rules, best)
            if median < best:
                heappush(heap, (median, pixel))
    while True:
        median, pixel = heappop(heap)
        if median == best:
            return best, best_pixel
        x = (pixel % rules.resolution + 0.5) * 2 / rules.resolution - 1
        y = (pixel // rules.resolution + 0.5) * 2 / rules.resolution - 1
        if _is_opaque(splats, rules, view, x, y, canvas.projection):
            return median, pixel


@kernel
def _is_opaque(splats, rules, view, x, y, s):
    """Whether all fragments of a ray together reach the alpha cut-off."""
    ray_W = view.R_WV[:, 0] * x + view.R_WV[:, 1] * y + view.R_WV[:, 2]
    clear = 1.0
    stack = [np.int64(0)]
    while stack:
        link = int(stack.pop())
        if link >= 0:
            for side in range(2):
                if ray_meets_box(splats, link, side, view, ray_W, rules):
                    stack.append(np.int64(splats.links[link, 14 + side]))
            continue
        first, end = leaf_range(link)
        for k in range(first, end):
            if splats.records[k, 2] < view.ignore_below:
                continue
            project(splats.records, k, rules, view.p_WV, view.R_WV, s)
            z, weight = fragment(s, rules, x, y)
            clear *= 1 - fragment_alpha(z, weight, splats.records[k, 12], rules)
        if 1 - clear >= rules.alpha_cutoff:
            return True
    return False
