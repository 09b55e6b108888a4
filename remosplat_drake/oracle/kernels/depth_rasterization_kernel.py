"""Finds the nearest pixels of depth views without rendering them (Numba).

The kernel computes only the range of the nearest pixel of each view. It stores
fragments in any order. A pixel is complete when its fragments reach
`alpha_cutoff` and its median is known. A further fragment can only move the
median nearer and increase the accumulated alpha. So the smallest median of all
complete pixels found so far is an upper bound on the view's result.

Splats are visited roughly from near to far, once for all six views of a sphere,
until all remaining splats are beyond the bounds of the views. Fragments behind
a bound are discarded. Of splats that cover many pixels, at first only the
pixels on a coarse grid are drawn; the other pixels are drawn when the bounds
are tight. At the end, some pixels may have a nearer median than the bound, but
too little alpha in the stored fragments. The rays of these pixels are traced
through the hierarchy, in the order of their medians.
"""

from heapq import heappop, heappush

import numpy as np

from remosplat_drake.base.kernels import helper, numpy_kernel
from remosplat_drake.base.lanes import (
    WIDTH,
    greatest,
    lanes_from,
    lowest_bit,
    places_of,
    root,
    write_lanes,
)
from remosplat_drake.oracle.depth_sensor import N_VIEWS
from remosplat_drake.oracle.kernels.depth_view import (
    ALL_VIEWS,
    centers_in_leaf,
    children_on_ray,
    place_views,
    splats_on_ray,
    views_beyond,
    views_of_balls,
    views_of_boxes,
)
from remosplat_drake.oracle.kernels.footprints import (
    fragment,
    fragment_alpha,
    lean,
    nearest_range,
    project,
)
from remosplat_drake.oracle.kernels.node_queue import pop, push
from remosplat_drake.oracle.kernels.pixel_layers import EVERY
from remosplat_drake.oracle.kernels.pixel_runs import (
    CANDIDATES,
    DEFERRED,
    ROUNDING,
    gather,
    median_range,
    settle,
    wipe,
)
from remosplat_drake.oracle.kernels.splat_drawing import (
    ALL,
    REST,
    draw,
    draw_waiting,
)
from remosplat_drake.splat.bvh import leaf_range

_SETS = ALL_VIEWS + 1
"""Number of sets of views. An item of the queue is the integer `link * _SETS +
set`, which encodes a link of the hierarchy and a set of views."""


@numpy_kernel
def nearest_pixels(
    splats,
    rules,
    canvas,
    p_WS,
    R_WD,
    ignore_below,
    bound,
    first,
    step,
    reach,
    pixel,
):
    """Finds the nearest pixels of the views of some spheres.

    The kernel processes every `step`-th sphere, beginning with `first`.
    `splats`, `rules` and `canvas` are the packed `Footprints`, `Rules` and
    `Canvas`. The results are written to `reach` (ranges [m]) and `pixel`
    (indices), both of shape (n, 6). They are inf and -1 for a view without a
    complete pixel nearer than the sphere's `bound`.

    Returns:
        The first sphere for which the canvas is too small; n or more if all
        spheres were computed.
    """
    pixels = rules.resolution * rules.resolution
    for i in range(first, len(p_WS), step):
        place_views(canvas.views, p_WS[i], R_WD[i], ignore_below[i])
        wipe(canvas, bound[i])
        if not (
            _draw_near(splats, rules, canvas)
            and _draw_deferred(splats, rules, canvas)
        ):
            return i
        _complete(splats, rules, canvas)
        for v in range(N_VIEWS):
            reach[i, v] = canvas.best[v]
            pixel[i, v] = max(canvas.best_pixel[v] - v * pixels, -1)
    return len(p_WS)


@lean
def _draw_near(splats, rules, canvas):
    """Draws splats that are nearer than the views' nearest pixels.

    Returns False if the canvas has no capacity for the splats.
    """
    queue = canvas.queue
    push(queue, -np.inf, ALL_VIEWS)
    while True:
        place = pop(queue)
        if place < 0:
            return _draw_all_waiting(splats, rules, canvas, ALL)
        link, seen = queue.items[place] // _SETS, queue.items[place] % _SETS
        seen = views_beyond(canvas.limit, queue.keys[place], seen)
        if seen == 0:
            continue
        if link >= 0:
            has_capacity = _open_node(splats, rules, canvas, link, seen)
        else:
            has_capacity = _open_leaf(splats, rules, canvas, link, seen)
        if not has_capacity:
            return False


@lean
def _draw_all_waiting(splats, rules, canvas, part):
    for view in range(N_VIEWS):
        if canvas.ready[view] and not draw_waiting(
            splats, rules, canvas, view, part
        ):
            return False
    return True


@lean
def _open_node(splats, rules, canvas, node, seen):
    """Queues the children of a node that any view of a set needs."""
    nearest, sets = views_of_boxes(
        splats, node, canvas.views, seen, canvas.limit, rules.spread
    )
    write_lanes(canvas.pair, 0, nearest)
    write_lanes(canvas.pair, WIDTH, sets)
    needed = places_of(sets > 0)
    while needed:
        k = lowest_bit(needed)
        needed &= needed - 1
        item = np.int64(splats.children[node, k]) * _SETS
        item += int(canvas.pair[1, k])
        if not push(canvas.queue, canvas.pair[0, k], item):
            return False
    return True


@lean
def _open_leaf(splats, rules, canvas, leaf, seen):
    """Draws the splats of a leaf that any view of a set needs."""
    first, _ = leaf_range(leaf)
    center, is_seen = centers_in_leaf(splats, leaf, canvas.views)
    bounds, row = splats.bounds, splats.bounds.shape[1]
    normal = (
        lanes_from(bounds, first + 3 * row),
        lanes_from(bounds, first + 4 * row),
        lanes_from(bounds, first + 5 * row),
    )
    radius = lanes_from(bounds, first + 6 * row)
    nearest = nearest_range(rules, center, normal, radius)
    nearest = nearest - lanes_from(bounds, first + 7 * row)
    if rules.low_pass_filter:
        x, y, z = center
        radius = greatest(radius, rules.spread * root(x * x + y * y + z * z))
    sets = views_of_balls(
        canvas.views, center, radius, nearest, seen, canvas.limit
    )
    needed = places_of(is_seen & (sets > 0))
    # The sets are stored in separate memory, since drawing overwrites the other
    # SIMD lanes of the canvas.
    write_lanes(canvas.sets, 0, sets)
    while needed:
        k = lowest_bit(needed)
        needed &= needed - 1
        meets = int(canvas.sets[k])
        while meets:
            view = lowest_bit(meets)
            meets &= meets - 1
            if not draw(splats, rules, canvas, view, first + k, ALL):
                return False
    return True


@lean
def _draw_deferred(splats, rules, canvas):
    """Draws those pixels of deferred splats that are not on the grid.

    Returns False if the canvas has no capacity for the fragments.
    """
    for i in range(canvas.count[DEFERRED]):
        k, view = divmod(canvas.deferred[i], N_VIEWS)
        if not draw(splats, rules, canvas, view, k, REST):
            return False
    return _draw_all_waiting(splats, rules, canvas, REST)


@helper
def _complete(splats, rules, canvas):
    """Traces rays of pixels with a nearer median, but too little alpha."""
    heap = [(np.inf, -1)]
    pixels = rules.resolution * rules.resolution
    for i in range(canvas.count[CANDIDATES]):
        pixel = canvas.candidates[i]
        if canvas.light[pixel] > 0:
            limit = canvas.limit[pixel // pixels]
            n, _, near_clear = gather(canvas, rules, pixel, limit)
            if near_clear <= rules.transmittance + ROUNDING:
                median = median_range(canvas, rules, n)
                if median < limit:
                    heappush(heap, (median, pixel))
    while True:
        median, pixel = heappop(heap)
        if pixel < 0:
            return
        if median < canvas.limit[pixel // pixels] and _is_opaque(
            splats, rules, canvas, pixel
        ):
            settle(canvas, rules, median, pixel)


@lean
def _is_opaque(splats, rules, canvas, pixel):
    """Whether the accumulated alpha of a pixel's ray reaches `alpha_cutoff`."""
    views, layers, n = canvas.views, canvas.layers, rules.resolution
    view, pixel = divmod(pixel, n * n)
    x, y = layers.axis[EVERY, pixel % n], layers.axis[EVERY, pixel // n]
    length = layers.length[pixel]
    R_WV = views.R_WV[view]
    ray_W = (
        R_WV[0, 0] * x + R_WV[0, 1] * y + R_WV[0, 2],
        R_WV[1, 0] * x + R_WV[1, 1] * y + R_WV[1, 2],
        R_WV[2, 0] * x + R_WV[2, 1] * y + R_WV[2, 2],
    )
    clear, stack = 1.0, canvas.stack
    stack[0], size = 0, 1
    while size > 0:
        size -= 1
        link = stack[size]
        if link >= 0:
            met = children_on_ray(splats, link, views, ray_W, rules)
            while met:
                stack[size] = splats.children[link, lowest_bit(met)]
                met &= met - 1
                size += 1
            continue
        first, _ = leaf_range(link)
        met = splats_on_ray(splats, link, views, ray_W, rules)
        while met:
            k = first + lowest_bit(met)
            met &= met - 1
            s = project(splats.records, k, rules, views.p_WS, R_WV)
            z, weight = fragment(s, rules, x, y)
            shift = splats.records[k, 15] / length
            opacity = splats.records[k, 12]
            clear *= 1 - fragment_alpha(z, weight, opacity, rules, shift)
        if 1 - clear >= rules.alpha_cutoff:
            return True
    return False
