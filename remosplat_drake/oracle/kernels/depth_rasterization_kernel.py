"""Nearest pixels of depth views without rendering the views (numba).

Only the smallest range of each view is wanted. Fragments are kept in lists,
one a pixel, and arrive in any order; because a median along the ray can only
move nearer when a fragment is added, and accumulated alpha can only grow, the
smallest median of all complete pixels so far is an upper bound of the answer.
Splats are visited roughly from near to far, once for all six views of a
sphere, until those bounds stop them; fragments behind the bound are not even
kept. Of splats that fill many pixels only those of a grid are drawn at first,
and the others once the bounds are tight. What remains are pixels with a nearer
median that the kept fragments leave too transparent to count: their rays are
followed through the hierarchy, nearest first.
"""

from heapq import heappop, heappush

import numpy as np

from remosplat_drake.oracle.depth_sensor import N_VIEWS
from remosplat_drake.oracle.kernels.depth_view import (
    ALL_VIEWS,
    place_views,
    ray_meets_box,
    views_beyond,
    views_of_ball,
    views_of_box,
)
from remosplat_drake.oracle.kernels.footprints import (
    fragment,
    fragment_alpha,
    inlined,
    kernel,
    lean,
    nearest_range,
    project,
    splat_margin,
)
from remosplat_drake.oracle.kernels.node_queue import pop, push
from remosplat_drake.oracle.kernels.pixel_lists import (
    DEFERRED,
    ROUNDING,
    TOUCHED,
    has_median,
    median_range,
    settle,
    wipe,
)
from remosplat_drake.oracle.kernels.splat_drawing import draw, draw_the_rest
from remosplat_drake.splat.bvh import leaf_range

_SETS = ALL_VIEWS + 1


@kernel
def nearest_pixels(
    splats,
    rules,
    canvas,
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
    """Finds the nearest pixels of the views of the spheres first::step.

    `splats`, `rules` and `canvas` are packed: `Footprints`, `Rules`, `Canvas`.
    The results are written into `reach`, ranges [m], and `pixel`, indices, both
    of shape (n, 6). Views without a complete pixel nearer than the sphere's
    `bound` get inf and -1. With `nearest_only`, views other than the nearest
    may get them.

    Returns:
        The first of the spheres that is not answered, for which the canvas has
        too little room; not below n if all are.
    """
    pixels = len(canvas.length)
    for i in range(first, len(p_WS), step):
        place_views(canvas.views, p_WS[i], R_WD[i], ignore_below[i])
        wipe(canvas, bound[i])
        if not (
            _gather(splats, rules, canvas, nearest_only)
            and _draw_deferred(splats, rules, canvas, nearest_only)
        ):
            return i
        _complete(splats, rules, canvas, nearest_only)
        for v in range(N_VIEWS):
            reach[i, v] = canvas.best[v]
            pixel[i, v] = max(canvas.best_pixel[v] - v * pixels, -1)
    return len(p_WS)


@lean
def _gather(splats, rules, canvas, nearest_only):
    """Draws the splats that are nearer than the nearest pixels of the views.

    Returns False where the canvas has no room for their fragments.
    """
    keys, waiting = canvas.keys, canvas.waiting
    views, limit = canvas.views, canvas.limit
    size = push(keys, waiting, 0, -np.inf, ALL_VIEWS)
    while size > 0:
        near, item, size = pop(keys, waiting, size)
        if views_beyond(limit, near, ALL_VIEWS) == 0:
            break
        link, seen = item // _SETS, item % _SETS
        seen = views_beyond(limit, near, seen)
        # Down to a leaf by the nearer child; the other one waits its turn.
        while link >= 0 and seen > 0:
            side = 0
            near, seen_near = views_of_box(
                splats, link, 0, views, seen, limit, rules.spread
            )
            far, seen_far = views_of_box(
                splats, link, 1, views, seen, limit, rules.spread
            )
            if seen_near == 0 or (seen_far > 0 and far < near):
                side, near, far = 1, far, near
                seen_near, seen_far = seen_far, seen_near
            if seen_far > 0:
                other = np.int64(splats.links[link, 15 - side]) * _SETS
                if size == len(keys):
                    return False
                size = push(keys, waiting, size, far, other + seen_far)
            link, seen = np.int64(splats.links[link, 14 + side]), seen_near
        if seen == 0:
            continue
        first, end = leaf_range(int(link))
        for k in range(first, end):
            meets = _views_of_splat(splats, k, rules, views, seen, limit)
            for v in range(N_VIEWS):
                if not (meets >> v) & 1:
                    continue
                if not draw(splats, k, rules, v, canvas, nearest_only):
                    return False
    return True


@lean
def _draw_deferred(splats, rules, canvas, nearest_only):
    """Draws the pixels beside the grid of the splats that were deferred.

    Returns False where the canvas has no room for their fragments.
    """
    for i in range(canvas.count[DEFERRED]):
        k, v = divmod(canvas.deferred[i], N_VIEWS)
        if not draw_the_rest(splats, k, rules, v, canvas, nearest_only):
            return False
    return True


@inlined
def _views_of_splat(splats, k, rules, views, seen, limit):
    """Which views of the set `seen` a splat can meet nearer than `limit`."""
    if splats.records[k, 2] < views.ignore_below[0]:
        return 0
    x = splats.records[k, 0] - views.p_WS[0]
    y = splats.records[k, 1] - views.p_WS[1]
    z = splats.records[k, 2] - views.p_WS[2]
    start = nearest_range(splats.records, k, rules, x, y, z)
    start -= splat_margin(splats, k)
    seen = views_beyond(limit, start, seen)
    if seen == 0:
        return 0
    radius = splats.records[k, 14]
    if rules.low_pass_filter:
        radius = max(radius, rules.spread * np.sqrt(x * x + y * y + z * z))
    return seen & views_of_ball(views, x, y, z, radius)


@kernel
def _complete(splats, rules, canvas, nearest_only):
    """Judges the pixels with a nearer median that are too transparent yet."""
    heap = [(np.inf, -1)]
    pixels = len(canvas.length)
    for i in range(canvas.count[TOUCHED]):
        pixel = canvas.touched[i]
        if has_median(canvas, pixel, rules) and (
            1 - canvas.total[pixel] < rules.alpha_cutoff + ROUNDING
        ):
            limit = canvas.limit[pixel // pixels]
            median, _ = median_range(canvas, pixel, rules, limit)
            if median < limit:
                heappush(heap, (median, pixel))
    while True:
        median, pixel = heappop(heap)
        if pixel < 0:
            return
        if median < canvas.limit[pixel // pixels] and _is_opaque(
            splats, rules, canvas, pixel
        ):
            settle(canvas, median, pixel, nearest_only)


@lean
def _is_opaque(splats, rules, canvas, pixel):
    """Whether all fragments of a pixel's ray reach the alpha cut-off."""
    views = canvas.views
    view, pixel = divmod(pixel, len(canvas.length))
    x = canvas.axis[pixel % rules.resolution]
    y = canvas.axis[pixel // rules.resolution]
    length = canvas.length[pixel]
    R_WV = views.R_WV[view]
    ray_W = (
        R_WV[0, 0] * x + R_WV[0, 1] * y + R_WV[0, 2],
        R_WV[1, 0] * x + R_WV[1, 1] * y + R_WV[1, 2],
        R_WV[2, 0] * x + R_WV[2, 1] * y + R_WV[2, 2],
    )
    clear = 1.0
    s, stack = canvas.projection, canvas.waiting
    stack[0] = 0
    size = 1
    while size > 0:
        size -= 1
        link = stack[size]
        if link >= 0:
            for side in range(2):
                if ray_meets_box(splats, link, side, views, ray_W, rules):
                    stack[size] = splats.links[link, 14 + side]
                    size += 1
            continue
        first, end = leaf_range(link)
        for k in range(first, end):
            if splats.records[k, 2] < views.ignore_below[0]:
                continue
            project(splats.records, k, rules, views.p_WS, R_WV, s)
            z, weight = fragment(s, rules, x, y)
            shift = splat_margin(splats, k) / length
            opacity = splats.records[k, 12]
            clear *= 1 - fragment_alpha(z, weight, opacity, rules, shift)
        if 1 - clear >= rules.alpha_cutoff:
            return True
    return False
