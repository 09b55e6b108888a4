"""Stores the fragments of pixels in six views, as runs of neighbours (Numba).

A run contains the fragments of one splat in up to four neighbouring pixels of a
row, so that a few SIMD instructions store it. The runs of a row form a linked
list.

Pixels of all views are numbered consecutively. A pixel's number is the index of
its view times the number of pixels of a view, plus the pixel's row-major index
in the view. Rows are numbered in the same way.
"""

from typing import NamedTuple

import numpy as np

from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.base.lanes import FEW, WIDTH, few_lanes_from, write_lanes
from remosplat_drake.oracle.depth_sensor import N_VIEWS
from remosplat_drake.oracle.kernels.depth_view import DepthViews, new_views
from remosplat_drake.oracle.kernels.footprints import inlined, lean
from remosplat_drake.oracle.kernels.node_queue import (
    NodeQueue,
    clear,
    new_queue,
)
from remosplat_drake.oracle.kernels.pixel_layers import (
    EVERY,
    PixelLayers,
    make_layers,
)
from remosplat_drake.oracle.kernels.wide_tree import MOST_WAITING

ROUNDING = 1e-9
"""Bound of the rounding error by which two products of the same factors, in
different orders, may differ."""

RUNS, CANDIDATES, DEFERRED = range(3)
"""Indices into `Canvas.count`."""

PROJECTION_SIZE = 34
"""Number of values of a projected splat; see `splat_drawing`."""


class Canvas(NamedTuple):
    """Working memory of one thread, which is used again for each sphere.

    Attributes:
        views: The `DepthViews` of the sphere.
        layers: The `PixelLayers` of a view.
        best: Range of the nearest complete pixel found so far in each view [m];
            inf if there is none.
        best_pixel: Index of this nearest pixel; -1 if there is none.
        limit: Range beyond which fragments are not needed, for each view [m].
        count: Number of runs, of candidates, and of deferred splats.
        light: Transmittance of all stored fragments of each pixel; valid in
            rows that have runs. If the fragments of a pixel are known to reach
            `alpha_cutoff`, the value is the negative transmittance of the
            fragments nearer than the limit.
        latest: Index of the latest run of each row; -1 if it has none.
        runs: Range [m] and alpha of each run's fragments, shape (capacity, 2,
            4); alpha is 0 for a missing fragment.
        run_heads: For each run, the previous run in the same row, the run's
            layer, and the place of its first pixel in this layer, shape
            (capacity, 3).
        candidates: Pixels whose transmittance has fallen below the threshold of
            the median.
        order: Memory in which the fragments of a pixel are sorted.
        deferred: Pairs of a splat and a view for which only the grid pixels
            have been drawn. A pair is stored as the integer 6 k + v, where k is
            the splat's index in the records, and v the view.
        ready: Number of splats that are collected for each view, shape (6,).
            The splats of a view are drawn together.
        places: Indices of the collected splats in the records, shape (6, 8).
        projections: Up to eight projected splats of one view, in SIMD lanes.
        parts: For each projected splat, the part of its pixels to draw: all
            pixels, those of the grid, or those that are not on the grid.
        spans: First and last column of each projected splat in each pixel row,
            shape (8, chunks, 2, 8). A chunk consists of eight rows.
        met: For each projected splat and chunk of rows, a bit mask of the rows
            in which the splat covers a pixel, shape (8, chunks).
        pair: Memory for two SIMD lanes.
        sets: Sets of views that need a leaf's splats, in SIMD lanes.
        queue: Queue of nodes, whose keys are lower bounds of their ranges.
        stack: Memory for the stack of nodes that a ray meets.
    """

    views: DepthViews
    layers: PixelLayers
    best: np.ndarray
    best_pixel: np.ndarray
    limit: np.ndarray
    count: np.ndarray
    light: np.ndarray
    latest: np.ndarray
    runs: np.ndarray
    run_heads: np.ndarray
    candidates: np.ndarray
    order: np.ndarray
    deferred: np.ndarray
    ready: np.ndarray
    places: np.ndarray
    projections: np.ndarray
    parts: np.ndarray
    spans: np.ndarray
    met: np.ndarray
    pair: np.ndarray
    sets: np.ndarray
    queue: NodeQueue
    stack: np.ndarray


def new_canvas(resolution: int, capacity: int) -> Packed[Canvas]:
    """Makes the working memory of one thread.

    Args:
        resolution: Number of pixels along a side of a view.
        capacity: Capacity for runs, for deferred splats, and for nodes.
    """
    n = N_VIEWS * resolution * resolution
    chunks = -(-resolution // WIDTH)
    return Packed(
        Canvas(
            views=new_views(),
            layers=make_layers(resolution),
            best=np.empty(N_VIEWS),
            best_pixel=np.empty(N_VIEWS, np.int64),
            limit=np.empty(N_VIEWS),
            count=np.zeros(3, np.int64),
            light=np.ones(n + FEW),
            latest=np.full(N_VIEWS * resolution, -1),
            runs=np.empty((capacity, 2, FEW)),
            run_heads=np.empty((capacity, 3), np.int64),
            candidates=np.empty(n, np.int64),
            order=np.empty((capacity, 2)),
            deferred=np.empty(capacity, np.int64),
            ready=np.zeros(N_VIEWS, np.int64),
            places=np.zeros((N_VIEWS, WIDTH), np.int64),
            projections=np.zeros((PROJECTION_SIZE, WIDTH)),
            parts=np.zeros(WIDTH, np.int64),
            spans=np.zeros((WIDTH, chunks, 2, WIDTH)),
            met=np.zeros((WIDTH, chunks), np.int64),
            pair=np.zeros((2, WIDTH)),
            sets=np.zeros(WIDTH),
            queue=new_queue(capacity),
            stack=np.empty(MOST_WAITING, np.int64),
        )
    )


@lean
def wipe(canvas, bound):
    """Clears the canvas for fragments nearer than `bound`."""
    canvas.count[:] = 0
    canvas.latest[:] = -1
    canvas.ready[:] = 0
    clear(canvas.queue, bound)
    for view in range(N_VIEWS):
        canvas.best[view] = np.inf
        canvas.best_pixel[view] = -1
        canvas.limit[view] = bound


@inlined
def has_capacity(canvas, rules):
    """Returns whether the canvas can take eight more splats in one view."""
    most = WIDTH * rules.resolution * -(-rules.resolution // FEW)
    return canvas.count[RUNS] + most <= len(canvas.runs) and canvas.count[
        DEFERRED
    ] + WIDTH <= len(canvas.deferred)


@inlined
def add_run(canvas, rules, row, layer, begin, reach, alpha):
    """Stores the fragments of a run that are nearer than the view's limit.

    Args:
        canvas: The canvas; `has_capacity` must be true.
        rules: The sensor's `Rules`.
        row: Number of the row, counted through all views.
        layer: Layer of the run's pixels.
        begin: Place of the run's first pixel in this layer.
        reach: Ranges of the fragments, in SIMD lanes [m].
        alpha: Alphas of the fragments, in SIMD lanes; 0 for a missing fragment.

    Returns:
        The values of `Canvas.light` of the pixels before and after the
        addition.
    """
    run, first = canvas.count[RUNS], row * rules.resolution
    canvas.count[RUNS] = run + 1
    if canvas.latest[row] < 0:
        canvas.light[first : first + rules.resolution] = 1.0
    canvas.run_heads[run, 0] = canvas.latest[row]
    canvas.run_heads[run, 1] = layer
    canvas.run_heads[run, 2] = begin
    canvas.latest[row] = run
    write_lanes(canvas.runs, 2 * FEW * run, reach)
    write_lanes(canvas.runs, 2 * FEW * run + FEW, alpha)
    if layer == EVERY:
        before = few_lanes_from(canvas.light, first + begin)
        after = before * (1 - alpha)
        write_lanes(canvas.light, first + begin, after)
        return before, after
    index, pair = canvas.layers.index[layer], canvas.pair
    for lane in range(FEW):
        pair[0, lane] = canvas.light[first + index[begin + lane]]
    before = few_lanes_from(pair, 0)
    after = before * (1 - alpha)
    write_lanes(pair, WIDTH, after)
    # Lanes after the last place have the index 0.
    for lane in range(FEW):
        if canvas.runs[run, 1, lane] > 0:
            canvas.light[first + index[begin + lane]] = pair[1, lane]
    return before, after


@lean
def gather(canvas, rules, pixel, limit):
    """Finds the fragments of a pixel, and writes them to `canvas.order`.

    Returns:
        The number of fragments, the transmittance of all fragments, and the
        transmittance of the fragments nearer than `limit`.
    """
    n, all_clear, near_clear = 0, 1.0, 1.0
    row, column = divmod(pixel, rules.resolution)
    run = canvas.latest[row]
    while run >= 0:
        layer = canvas.run_heads[run, 1]
        lane = canvas.layers.place[layer, column] - canvas.run_heads[run, 2]
        if 0 <= lane < FEW:
            reach, alpha = canvas.runs[run, 0, lane], canvas.runs[run, 1, lane]
            if alpha > 0:
                canvas.order[n, 0], canvas.order[n, 1] = reach, alpha
                n += 1
                all_clear *= 1 - alpha
                near_clear *= 1 - alpha if reach < limit else 1.0
        run = canvas.run_heads[run, 0]
    return n, all_clear, near_clear


@lean
def median_range(canvas, rules, n):
    """Computes the median range of the first n fragments in `canvas.order`."""
    order = canvas.order
    for i in range(1, n):
        reach, alpha, j = order[i, 0], order[i, 1], i
        while j > 0 and order[j - 1, 0] > reach:
            order[j, 0], order[j, 1] = order[j - 1, 0], order[j - 1, 1]
            j -= 1
        order[j, 0], order[j, 1] = reach, alpha
    clear = 1.0
    for i in range(n):
        clear *= 1 - order[i, 1]
        if clear <= rules.transmittance:
            return order[i, 0]
    return np.inf


@lean
def settle(canvas, rules, reach, pixel):
    """Records a complete pixel if it is the nearest pixel of its view.

    If several pixels have the same range, the one with the lowest index is
    recorded.
    """
    view = pixel // (rules.resolution * rules.resolution)
    if reach > canvas.best[view] or (
        reach == canvas.best[view] and pixel > canvas.best_pixel[view]
    ):
        return
    canvas.best[view], canvas.best_pixel[view] = reach, pixel
    # Other pixels may be equally near.
    limit = np.nextafter(reach, np.inf)
    if rules.nearest_only:
        # If several views have the same range, the first view counts. So the
        # result does not depend on the order of visits.
        for other in range(N_VIEWS):
            canvas.limit[other] = min(canvas.limit[other], limit)
    canvas.limit[view] = min(canvas.limit[view], limit)
