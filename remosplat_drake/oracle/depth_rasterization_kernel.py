"""Nearest pixels of depth views without rendering the views (numba).

Only the smallest range of each view is wanted. Fragments are kept in lists,
one a pixel, and arrive in any order; because a median along the ray can only
move nearer when a fragment is added, and accumulated alpha can only grow, the
smallest median of all complete pixels so far is an upper bound of the answer.
Boxes of splats are visited from near to far until that bound stops them, and
fragments behind the bound are not even kept. What remains are pixels with a
nearer median that the kept fragments leave too transparent to count: their
rays are followed through the tree, nearest first.
"""

from heapq import heappop, heappush
from typing import NamedTuple

import numpy as np
from numba import njit

from remosplat_drake.oracle.depth_sensor import FILTER_SCALE, N_VIEWS, R_DV
from remosplat_drake.oracle.footprint_tree import BoxTree, Footprints

_jit = njit(cache=True, nogil=True, error_model="numpy")

# Pixels that touch a splat's outline are tested exactly; this widens the
# spans by far more than rounding can move them [px].
_MARGIN = 1e-6


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
        count: Number of touched pixels, number of fragments.
        splat: The projected splat (see `_project`).
    """

    length: np.ndarray
    stamp: np.ndarray
    clear: np.ndarray
    head: np.ndarray
    touched: np.ndarray
    link: np.ndarray
    reach: np.ndarray
    alpha: np.ndarray
    count: np.ndarray
    splat: np.ndarray


@_jit
def nearest_pixels(
    splats: Footprints,
    tree: BoxTree,
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
    canvas = _new_canvas(rules.resolution)
    for i in range(first, len(p_WS), step):
        limit = bound[i]
        for v in range(N_VIEWS):
            view = _make_view(p_WS[i], R_WD[i], R_DV[v], ignore_below[i])
            canvas, reach[i, v], pixel[i, v] = _nearest_pixel(
                splats, tree, rules, view, limit, canvas, i * N_VIEWS + v
            )
            if nearest_only:
                limit = min(limit, reach[i, v])


@_jit
def _new_canvas(resolution):
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
        np.zeros(2, np.int64),
        np.empty(15),
    )


@_jit
def _with_room(canvas, fragments):
    """The canvas with room for so many more fragments."""
    capacity = len(canvas.link)
    if canvas.count[1] + fragments <= capacity:
        return canvas
    more = np.empty(capacity + fragments)
    return Canvas(
        canvas.length,
        canvas.stamp,
        canvas.clear,
        canvas.head,
        canvas.touched,
        np.concatenate((canvas.link, more.astype(np.int64))),
        np.concatenate((canvas.reach, more)),
        np.concatenate((canvas.alpha, more)),
        canvas.count,
        canvas.splat,
    )


@_jit
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


@_jit
def _nearest_pixel(splats, tree, rules, view, bound, canvas, stamp):
    """The nearest complete pixel of a view: its range, and its index."""
    canvas.count[:] = 0
    best, best_pixel = bound, -1
    spread = _filter_spread(rules)
    first_leaf = len(tree.start) - 2
    heap = [(_box_bound(tree, 0, view, spread), 0)]
    while heap:
        nearest, node = heappop(heap)
        if nearest >= best:
            break
        if node < first_leaf:
            for child in (2 * node + 1, 2 * node + 2):
                nearest = _box_bound(tree, child, view, spread)
                if nearest < best:
                    heappush(heap, (nearest, child))
            continue
        leaf = node - first_leaf
        for k in range(tree.start[leaf], tree.start[leaf + 1]):
            canvas = _with_room(canvas, rules.resolution * rules.resolution)
            best, best_pixel = _rasterize(
                splats, k, rules, view, spread, canvas, stamp, best, best_pixel
            )
    best, best_pixel = _complete(
        splats, tree, rules, view, canvas, best, best_pixel
    )
    return canvas, best if best_pixel >= 0 else np.inf, best_pixel


@_jit
def _filter_spread(rules):
    """Reach of the low-pass filter's footprint, as a part of the distance."""
    if not rules.low_pass_filter:
        return 0.0
    return 2 * np.sqrt(rules.n_sigma_squared / FILTER_SCALE) / rules.resolution


@_jit
def _box_bound(tree, node, view, spread):
    """Lower bound of the ranges inside a box; inf where the view misses it."""
    if tree.top[node] < view.ignore_below:
        return np.inf
    x = tree.middle[node, 0] - view.p_WV[0]
    y = tree.middle[node, 1] - view.p_WV[1]
    z = tree.middle[node, 2] - view.p_WV[2]
    hx, hy, hz = tree.half[node, 0], tree.half[node, 1], tree.half[node, 2]
    slack = 0.0
    if spread > 0:
        slack = spread * (
            np.sqrt(x * x + y * y + z * z)
            + np.sqrt(hx * hx + hy * hy + hz * hz)
        )
    for j in range(4):
        nx, ny, nz = view.sides_W[j, 0], view.sides_W[j, 1], view.sides_W[j, 2]
        reach = abs(nx) * hx + abs(ny) * hy + abs(nz) * hz
        if nx * x + ny * y + nz * z + reach + slack < 0:
            return np.inf
    x, y, z = max(abs(x) - hx, 0), max(abs(y) - hy, 0), max(abs(z) - hz, 0)
    return np.sqrt(x * x + y * y + z * z) * max(1 - spread, 0)


@_jit
def _is_visible(splats, k, view, spread, best):
    """Whether a splat can have fragments in the view nearer than `best`."""
    if splats.center[k, 2] < view.ignore_below:
        return False
    x = splats.center[k, 0] - view.p_WV[0]
    y = splats.center[k, 1] - view.p_WV[1]
    z = splats.center[k, 2] - view.p_WV[2]
    distance = np.sqrt(x * x + y * y + z * z)
    radius = max(splats.radius[k], spread * distance)
    if distance - radius >= best:
        return False
    for j in range(4):
        nx, ny, nz = view.sides_W[j, 0], view.sides_W[j, 1], view.sides_W[j, 2]
        if nx * x + ny * y + nz * z < -radius:
            return False
    return True


@_jit
def _project(splats, k, rules, view, s):
    """Writes the splat in the view's ray coordinates into s, shape (15,).

    For a disc, s[0:9] are the linear forms A, B, C of a ray (x, y, 1), with
    u = A / C, v = B / C and depth s[9] / C. For an ellipsoid they whiten the
    ray, and s[9:12] is its whitened centre. s[12:15] is the centre in V.
    """
    for i in range(3):
        s[9 + i] = 0.0
        s[12 + i] = 0.0
    for i in range(3):
        for j in range(3):
            s[3 * i + j] = (
                splats.whiten[k, i, 0] * view.R_WV[0, j]
                + splats.whiten[k, i, 1] * view.R_WV[1, j]
                + splats.whiten[k, i, 2] * view.R_WV[2, j]
            )
            offset = splats.center[k, j] - view.p_WV[j]
            s[9 + i] += splats.whiten[k, i, j] * offset
            s[12 + i] += view.R_WV[j, i] * offset
    if rules.is_surfel:
        u, v, height = s[9], s[10], s[11]
        for j in range(3):
            s[j] = height * s[j] - u * s[6 + j]
            s[3 + j] = height * s[3 + j] - v * s[6 + j]
        s[9] = height


@_jit
def _fragment(s, rules, x, y):
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


@_jit
def _alpha(z, weight, opacity, rules):
    """Alpha of a fragment, 0 where it is not seen."""
    if not (weight <= rules.n_sigma_squared):
        return 0.0
    if not (rules.near <= z <= rules.far):
        return 0.0
    alpha = opacity * np.exp(-0.5 * weight)
    return alpha if alpha >= rules.min_alpha else 0.0


@_jit
def _conic(s, rules, cut):
    """The outline weight = cut as a quadratic form of the ray (x, y, 1).

    Returns its entries xx, xy, xz, yy, yz, zz; it is <= 0 inside.
    """
    m = np.empty((3, 3))
    if rules.is_surfel:
        for i in range(3):
            for j in range(i, 3):
                m[i, j] = (
                    s[i] * s[j]
                    + s[3 + i] * s[3 + j]
                    - cut * s[6 + i] * s[6 + j]
                )
    else:
        inside = s[9] * s[9] + s[10] * s[10] + s[11] * s[11] - cut
        for i in range(3):
            along_i = s[9] * s[i] + s[10] * s[3 + i] + s[11] * s[6 + i]
            for j in range(i, 3):
                along_j = s[9] * s[j] + s[10] * s[3 + j] + s[11] * s[6 + j]
                m[i, j] = (
                    inside
                    * (s[i] * s[j] + s[3 + i] * s[3 + j] + s[6 + i] * s[6 + j])
                    - along_i * along_j
                )
    return m[0, 0], m[0, 1], m[0, 2], m[1, 1], m[1, 2], m[2, 2]


@_jit
def _row_span(xx, xy, xz, yy, yz, zz):
    """Rows y that an outline meets: all of them unless it is an ellipse."""
    area = xx * yy - xy * xy
    if not (xx > 0 and area > 0):
        return -1.0, 1.0
    middle = xy * xz - xx * yz
    square = middle * middle + area * (xz * xz - xx * zz)
    half = np.sqrt(max(square, 0.0))
    return (middle - half) / area, (middle + half) / area


@_jit
def _column_span(xx, xy, xz, yy, yz, zz, y):
    """Columns x inside an outline in row y; empty where low > high."""
    if not xx > 0:
        return -1.0, 1.0
    middle = xy * y + xz
    square = middle * middle - xx * ((yy * y + 2 * yz) * y + zz)
    if square < 0:
        return 2.0, -2.0
    half = np.sqrt(square)
    return (-middle - half) / xx, (-middle + half) / xx


@_jit
def _pixel_span(low, high, resolution):
    """First and last pixel whose centre lies in [low, high] of a ray axis."""
    half = resolution / 2
    first = np.ceil((max(low, -1.0) + 1) * half - 0.5 - _MARGIN)
    last = np.floor((min(high, 1.0) + 1) * half - 0.5 + _MARGIN)
    return max(int(first), 0), min(int(last), resolution - 1)


@_jit
def _rasterize(splats, k, rules, view, spread, canvas, stamp, best, best_pixel):
    """Adds a splat's fragments nearer than `best`; returns the new best."""
    if not _is_visible(splats, k, view, spread, best):
        return best, best_pixel
    s = canvas.splat
    resolution = rules.resolution
    cut, opacity = splats.weight_cut[k], splats.opacity[k]
    _project(splats, k, rules, view, s)
    xx, xy, xz, yy, yz, zz = _conic(s, rules, cut)
    y_low, y_high = _row_span(xx, xy, xz, yy, yz, zz)
    filtered = rules.low_pass_filter and s[14] > rules.near
    if filtered:
        dot = 2 * np.sqrt(cut / FILTER_SCALE) / resolution
        x_dot, y_dot = s[12] / s[14], s[13] / s[14]
        y_low, y_high = min(y_low, y_dot - dot), max(y_high, y_dot + dot)
    first_row, last_row = _pixel_span(y_low, y_high, resolution)
    for row in range(first_row, last_row + 1):
        y = (row + 0.5) * 2 / resolution - 1
        x_low, x_high = _column_span(xx, xy, xz, yy, yz, zz, y)
        if filtered and abs(y - y_dot) <= dot:
            if x_low > x_high:
                x_low, x_high = x_dot - dot, x_dot + dot
            x_low, x_high = min(x_low, x_dot - dot), max(x_high, x_dot + dot)
        first, last = _pixel_span(x_low, x_high, resolution)
        for column in range(first, last + 1):
            x = (column + 0.5) * 2 / resolution - 1
            pixel = row * resolution + column
            z, weight = _fragment(s, rules, x, y)
            reach = z * canvas.length[pixel]
            if not reach < best:
                continue
            alpha = _alpha(z, weight, opacity, rules)
            if alpha == 0:
                continue
            if _add_fragment(canvas, pixel, stamp, reach, alpha) <= (
                rules.transmittance * (1 + 1e-9)
            ):
                median, accumulated = _resolve(canvas, pixel, rules, best)
                if median < best and accumulated >= rules.alpha_cutoff:
                    best, best_pixel = median, pixel
    return best, best_pixel


@_jit
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


@_jit
def _resolve(canvas, pixel, rules, best):
    """Median range and accumulated alpha of a pixel's kept fragments.

    Fragments at or beyond `best` no longer count towards `canvas.clear`.
    """
    order = [canvas.head[pixel]]
    f = canvas.link[order[0]]
    while f >= 0:
        order.append(f)
        j = len(order) - 1
        while j > 0 and canvas.reach[order[j - 1]] > canvas.reach[f]:
            order[j] = order[j - 1]
            j -= 1
        order[j] = f
        f = canvas.link[f]
    median, clear, clear_before_best = np.inf, 1.0, 1.0
    for f in order:
        clear *= 1 - canvas.alpha[f]
        if canvas.reach[f] < best:
            clear_before_best = clear
        if median == np.inf and clear <= rules.transmittance:
            median = canvas.reach[f]
    canvas.clear[pixel] = clear_before_best
    return median, 1 - clear


@_jit
def _complete(splats, tree, rules, view, canvas, best, best_pixel):
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
        if _accumulates(splats, tree, rules, view, x, y, canvas.splat):
            return median, pixel


@_jit
def _accumulates(splats, tree, rules, view, x, y, s):
    """Whether all fragments of a ray together reach the alpha cut-off."""
    ray_W = view.R_WV[:, 0] * x + view.R_WV[:, 1] * y + view.R_WV[:, 2]
    spread = _filter_spread(rules)
    first_leaf = len(tree.start) - 2
    clear = 1.0
    stack = [0]
    while stack:
        node = stack.pop()
        if not _ray_meets_box(tree, node, view, ray_W, rules, spread):
            continue
        if node < first_leaf:
            stack.append(2 * node + 1)
            stack.append(2 * node + 2)
            continue
        leaf = node - first_leaf
        for k in range(tree.start[leaf], tree.start[leaf + 1]):
            if splats.center[k, 2] < view.ignore_below:
                continue
            _project(splats, k, rules, view, s)
            z, weight = _fragment(s, rules, x, y)
            clear *= 1 - _alpha(z, weight, splats.opacity[k], rules)
        if 1 - clear >= rules.alpha_cutoff:
            return True
    return False


@_jit
def _ray_meets_box(tree, node, view, ray_W, rules, spread):
    """Whether a ray between near and far passes a box (with its spread)."""
    if tree.top[node] < view.ignore_below:
        return False
    enter, leave = rules.near, rules.far
    slack = 0.0
    if spread > 0:
        square = 0.0
        for i in range(3):
            farthest = (
                abs(tree.middle[node, i] - view.p_WV[i]) + tree.half[node, i]
            )
            square += farthest * farthest
        slack = spread * np.sqrt(square)
    for i in range(3):
        middle = tree.middle[node, i] - view.p_WV[i]
        half = tree.half[node, i] + slack
        if ray_W[i] == 0:
            if abs(middle) > half:
                return False
            continue
        a, b = (middle - half) / ray_W[i], (middle + half) / ray_W[i]
        enter, leave = max(enter, min(a, b)), min(leave, max(a, b))
    return enter <= leave
