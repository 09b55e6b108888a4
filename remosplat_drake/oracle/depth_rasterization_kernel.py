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
from typing import NamedTuple

import numpy as np

from remosplat_drake.oracle.depth_sensor import FILTER_SCALE, N_VIEWS, R_DV
from remosplat_drake.oracle.footprints import (
    PROJECTION_SIZE,
    Footprints,
    Rules,
    column_span,
    fragment,
    fragment_alpha,
    kernel,
    near_span,
    nearest_range,
    outline,
    pixel_span,
    project,
    row_span,
)
from remosplat_drake.oracle.node_queue import pop, push
from remosplat_drake.splat.bvh import leaf_range


class View(NamedTuple):
    """One view of one sphere.

    Attributes:
        p_WV: Camera centre, shape (3,) [m].
        R_WV: Its orientation, shape (3, 3).
        sides_W: Inward unit normals of the frustum's sides, shape (4, 3).
        ignore_below: Splats with lower centres are not seen [m].
    """

    p_WV: np.ndarray
    R_WV: np.ndarray
    sides_W: np.ndarray
    ignore_below: float


class Canvas(NamedTuple):
    """Scratch memory of one thread, reused from view to view.

    A pixel's entries are valid where `stamp` is the current view's number.

    Attributes:
        length: Length of each pixel's ray (x, y, 1).
        stamp: Number of the view that last wrote to the pixel.
        clear: Transmittance of the pixel's kept fragments, in any order.
        head: Latest fragment of the pixel.
        touched: The pixels written to in this view.
        link: Next fragment of the same pixel, -1 at the end.
        reach: Range of each fragment [m].
        alpha: Alpha of each fragment.
        order: Room to sort the fragments of a pixel.
        count: Number of touched pixels, number of fragments.
        projection: The projected splat, see `footprints.project`.
        keys: Lower bounds of the ranges in the nodes that wait [m].
        waiting: Links of those nodes, as a queue with `keys`.
    """

    length: np.ndarray
    stamp: np.ndarray
    clear: np.ndarray
    head: np.ndarray
    touched: np.ndarray
    link: np.ndarray
    reach: np.ndarray
    alpha: np.ndarray
    order: np.ndarray
    count: np.ndarray
    projection: np.ndarray
    keys: np.ndarray
    waiting: np.ndarray


@kernel
def nearest_pixels(
    splats: Footprints,
    nodes,
    links,
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
    canvas = _new_canvas(rules.resolution, len(nodes))
    for i in range(first, len(p_WS), step):
        limit = bound[i]
        for v in range(N_VIEWS):
            view = _make_view(p_WS[i], R_WD[i], R_DV[v], ignore_below[i])
            canvas, reach[i, v], pixel[i, v] = _nearest_pixel(
                splats,
                nodes,
                links,
                rules,
                view,
                limit,
                canvas,
                i * N_VIEWS + v,
            )
            if nearest_only:
                limit = min(limit, reach[i, v])


@kernel
def _new_canvas(resolution, n_nodes):
    n = resolution * resolution
    length = np.empty(n)
    for row in range(resolution):
        y = (row + 0.5) * 2 / resolution - 1
        for column in range(resolution):
            x = (column + 0.5) * 2 / resolution - 1
            length[row * resolution + column] = np.sqrt(x * x + y * y + 1)
    return Canvas(
        length,
        np.full(n, -1),
        np.empty(n),
        np.empty(n, np.int64),
        np.empty(n, np.int64),
        np.empty(4 * n, np.int64),
        np.empty(4 * n),
        np.empty(4 * n),
        np.empty(4 * n, np.int64),
        np.zeros(2, np.int64),
        np.empty(PROJECTION_SIZE),
        np.empty(2 * n_nodes + 1),
        np.empty(2 * n_nodes + 1, np.int64),
    )


@kernel
def _with_room(canvas, n):
    """The canvas with room for n more fragments."""
    if canvas.count[1] + n <= len(canvas.link):
        return canvas
    more = np.empty(len(canvas.link) + n)
    more_links = np.empty(len(more), np.int64)
    return Canvas(
        canvas.length,
        canvas.stamp,
        canvas.clear,
        canvas.head,
        canvas.touched,
        np.concatenate((canvas.link, more_links)),
        np.concatenate((canvas.reach, more)),
        np.concatenate((canvas.alpha, more)),
        np.concatenate((canvas.order, more_links)),
        canvas.count,
        canvas.projection,
        canvas.keys,
        canvas.waiting,
    )


@kernel
def _make_view(p_WS, R_WD, R_DV, ignore_below):
    R_WV = np.empty((3, 3))
    sides_W = np.empty((4, 3))
    for i in range(3):
        for j in range(3):
            R_WV[i, j] = (
                R_WD[i, 0] * R_DV[0, j]
                + R_WD[i, 1] * R_DV[1, j]
                + R_WD[i, 2] * R_DV[2, j]
            )
        for j in range(2):
            sides_W[2 * j, i] = (R_WV[i, 2] - R_WV[i, j]) * np.sqrt(0.5)
            sides_W[2 * j + 1, i] = (R_WV[i, 2] + R_WV[i, j]) * np.sqrt(0.5)
    return View(p_WS, R_WV, sides_W, ignore_below)


@kernel
def _nearest_pixel(splats, nodes, links, rules, view, bound, canvas, stamp):
    """The nearest complete pixel of a view: its range, and its index."""
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
            left = _box_range(nodes, link, 0, view, rules.spread)
            right = _box_range(nodes, link, 1, view, rules.spread)
            side = 0 if left <= right else 1
            if max(left, right) < best:
                other = links[link, 15 - side]
                size = push(keys, waiting, size, max(left, right), other)
            if min(left, right) >= best:
                break
            link = links[link, 14 + side]
        if link >= 0:
            continue
        first, end = leaf_range(link)
        for k in range(first, end):
            if _is_visible(splats, k, view, rules, best):
                canvas = _with_room(canvas, len(canvas.length))
                best, best_pixel = _rasterize(
                    splats, k, rules, view, canvas, stamp, best, best_pixel
                )
    best, best_pixel = _complete(
        splats, nodes, links, rules, view, canvas, best, best_pixel
    )
    return canvas, best if best_pixel >= 0 else np.inf, best_pixel


@kernel
def _box_range(nodes, link, side, view, spread):
    """Lower bound of the ranges in a child's box; inf if the view misses it."""
    if nodes[link, 12 + side] < view.ignore_below:
        return np.inf
    column = 6 * side
    p = view.p_WV
    x_low, x_high = nodes[link, column] - p[0], nodes[link, column + 3] - p[0]
    y_low, y_high = (
        nodes[link, column + 1] - p[1],
        nodes[link, column + 4] - p[1],
    )
    z_low, z_high = (
        nodes[link, column + 2] - p[2],
        nodes[link, column + 5] - p[2],
    )
    slack = 0.0
    if spread > 0:
        x = max(-x_low, x_high)
        y = max(-y_low, y_high)
        z = max(-z_low, z_high)
        slack = spread * np.sqrt(x * x + y * y + z * z)
    for j in range(4):
        nx, ny, nz = view.sides_W[j, 0], view.sides_W[j, 1], view.sides_W[j, 2]
        farthest = nx * (x_high if nx > 0 else x_low)
        farthest += ny * (y_high if ny > 0 else y_low)
        farthest += nz * (z_high if nz > 0 else z_low)
        if farthest + slack < 0:
            return np.inf
    x = max(x_low, -x_high, 0.0)
    y = max(y_low, -y_high, 0.0)
    z = max(z_low, -z_high, 0.0)
    return np.sqrt(x * x + y * y + z * z) * max(1 - spread, 0.0)


@kernel
def _is_visible(splats, k, view, rules, best):
    """Whether a splat can have fragments in the view nearer than `best`."""
    if splats.center[k, 2] < view.ignore_below:
        return False
    x = splats.center[k, 0] - view.p_WV[0]
    y = splats.center[k, 1] - view.p_WV[1]
    z = splats.center[k, 2] - view.p_WV[2]
    radius = splats.radius[k]
    if rules.low_pass_filter:
        radius = max(radius, rules.spread * np.sqrt(x * x + y * y + z * z))
    for j in range(4):
        nx, ny, nz = view.sides_W[j, 0], view.sides_W[j, 1], view.sides_W[j, 2]
        if nx * x + ny * y + nz * z < -radius:
            return False
    return nearest_range(splats, k, rules, view.p_WV) < best


@kernel
def _rasterize(splats, k, rules, view, canvas, stamp, best, best_pixel):
    """Adds a splat's fragments nearer than `best`; returns the new best."""
    s = canvas.projection
    resolution = rules.resolution
    cut, opacity = splats.weight_cut[k], splats.opacity[k]
    project(splats, k, rules, view.p_WV, view.R_WV, s)
    outline(s, rules, cut)
    y_low, y_high = row_span(s)
    # The dot that the low-pass filter puts on the splat's centre.
    dot, x_dot, y_dot = -1.0, 0.0, 0.0
    if rules.low_pass_filter and s[14] > rules.near:
        dot = 2 * np.sqrt(cut / FILTER_SCALE) / resolution
        x_dot, y_dot = s[12] / s[14], s[13] / s[14]
        y_low, y_high = min(y_low, y_dot - dot), max(y_high, y_dot + dot)
    first_row, last_row = pixel_span(y_low, y_high, resolution)
    for row in range(first_row, last_row + 1):
        y = (row + 0.5) * 2 / resolution - 1
        x_low, x_high = column_span(s, rules, y)
        if rules.is_surfel:
            x_near, x_far = near_span(s, best, y)
            x_low, x_high = max(x_low, x_near), min(x_high, x_far)
        if abs(y - y_dot) <= dot:
            if x_low > x_high:
                x_low, x_high = x_dot - dot, x_dot + dot
            x_low, x_high = min(x_low, x_dot - dot), max(x_high, x_dot + dot)
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
            if _add_fragment(canvas, pixel, stamp, reach, alpha) <= (
                rules.transmittance * (1 + 1e-9)
            ):
                median, accumulated = _resolve(canvas, pixel, rules, best)
                if median < best and accumulated >= rules.alpha_cutoff:
                    best, best_pixel = median, pixel
    return best, best_pixel


@kernel
def _add_fragment(canvas, pixel, stamp, reach, alpha):
    """Keeps a fragment; returns the transmittance of the pixel's kept ones."""
    if canvas.stamp[pixel] != stamp:
        canvas.stamp[pixel] = stamp
        canvas.clear[pixel] = 1.0
        canvas.head[pixel] = -1
        canvas.touched[canvas.count[0]] = pixel
        canvas.count[0] += 1
    f = canvas.count[1]
    canvas.count[1] += 1
    canvas.link[f] = canvas.head[pixel]
    canvas.reach[f] = reach
    canvas.alpha[f] = alpha
    canvas.head[pixel] = f
    canvas.clear[pixel] *= 1 - alpha
    return canvas.clear[pixel]


@kernel
def _resolve(canvas, pixel, rules, best):
    """Median range and accumulated alpha of a pixel's kept fragments.

    Fragments at or beyond `best` no longer count towards `canvas.clear`.
    """
    order, n = canvas.order, 0
    f = canvas.head[pixel]
    while f >= 0:
        j = n
        while j > 0 and canvas.reach[order[j - 1]] > canvas.reach[f]:
            order[j] = order[j - 1]
            j -= 1
        order[j] = f
        n += 1
        f = canvas.link[f]
    median, clear, clear_before_best = np.inf, 1.0, 1.0
    for f in order[:n]:
        clear *= 1 - canvas.alpha[f]
        if canvas.reach[f] < best:
            clear_before_best = clear
        if median == np.inf and clear <= rules.transmittance:
            median = canvas.reach[f]
    canvas.clear[pixel] = clear_before_best
    return median, 1 - clear


@kernel
def _complete(splats, nodes, links, rules, view, canvas, best, best_pixel):
    """Judges the pixels with a nearer median that are too transparent yet."""
    heap = [(best, best_pixel)]
    for i in range(canvas.count[0]):
        pixel = canvas.touched[i]
        if canvas.clear[pixel] <= rules.transmittance * (1 + 1e-9):
            median, _ = _resolve(canvas, pixel, rules, best)
            if median < best:
                heappush(heap, (median, pixel))
    while True:
        median, pixel = heappop(heap)
        if median == best:
            return best, best_pixel
        x = (pixel % rules.resolution + 0.5) * 2 / rules.resolution - 1
        y = (pixel // rules.resolution + 0.5) * 2 / rules.resolution - 1
        if _is_opaque(
            splats, nodes, links, rules, view, x, y, canvas.projection
        ):
            return median, pixel


@kernel
def _is_opaque(splats, nodes, links, rules, view, x, y, s):
    """Whether all fragments of a ray together reach the alpha cut-off."""
    ray_W = view.R_WV[:, 0] * x + view.R_WV[:, 1] * y + view.R_WV[:, 2]
    clear = 1.0
    stack = [0]
    while stack:
        link = stack.pop()
        if link >= 0:
            for side in range(2):
                if _ray_meets_box(nodes, link, side, view, ray_W, rules):
                    stack.append(np.int64(links[link, 14 + side]))
            continue
        first, end = leaf_range(link)
        for k in range(first, end):
            if splats.center[k, 2] < view.ignore_below:
                continue
            project(splats, k, rules, view.p_WV, view.R_WV, s)
            z, weight = fragment(s, rules, x, y)
            clear *= 1 - fragment_alpha(z, weight, splats.opacity[k], rules)
        if 1 - clear >= rules.alpha_cutoff:
            return True
    return False


@kernel
def _ray_meets_box(nodes, link, side, view, ray_W, rules):
    """Whether a ray passes a child's box (and its spread) in near to far."""
    if nodes[link, 12 + side] < view.ignore_below:
        return False
    column = 6 * side
    slack = 0.0
    if rules.spread > 0:
        square = 0.0
        for i in range(3):
            low = nodes[link, column + i] - view.p_WV[i]
            high = nodes[link, column + 3 + i] - view.p_WV[i]
            square += max(-low, high) ** 2
        slack = rules.spread * np.sqrt(square)
    enter, leave = rules.near, rules.far
    for i in range(3):
        low = nodes[link, column + i] - view.p_WV[i] - slack
        high = nodes[link, column + 3 + i] - view.p_WV[i] + slack
        if ray_W[i] == 0:
            if low > 0 or high < 0:
                return False
            continue
        a, b = low / ray_W[i], high / ray_W[i]
        enter, leave = max(enter, min(a, b)), min(leave, max(a, b))
    return enter <= leave
