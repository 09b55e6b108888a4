"""Fragments of the pixels of six views, in runs of neighbours (Numba).

A run holds the fragments of one splat in up to four neighbouring pixels of a
row, so that a few instructions store it. A row's runs are a linked list.

Pixels are numbered through all views: a pixel's number is the index of its view
times the number of pixels of a view, plus its row-major index in the view. Rows
are numbered in the same way.
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
"""Bound on the difference, from rounding, of two products with the same factors
in different orders."""

RUNS, CANDIDATES, DEFERRED = range(3)
"""Indices into `Canvas.count`."""

PROJECTION_SIZE = 34
"""Length of a projected splat, see `splat_drawing`."""


class Canvas(NamedTuple):
    """Scratch memory of one thread, reused from sphere to sphere.

    Attributes:
        views: The sphere's views.
        layers: The pixels of a view.
        best: Range of the nearest complete pixel of each view [m]; inf while
            there is none.
        best_pixel: Index of that pixel, -1 while there is none.
        limit: Range limit of each view: fragments beyond it are not needed [m].
        count: Number of runs, of candidates, and of deferred splats.
        light: For each pixel, the transmittance of all its kept fragments;
            valid in rows with runs. For a pixel that is known to be opaque
            enough, it is instead the transmittance of the fragments nearer than
            the limit, with a negative sign.
        latest: Latest run of each row, -1 without one.
        runs: Range [m] and alpha of each run's fragments, shape (room, 2, 4);
            alpha 0 where there is none.
        run_heads: The run before in the same row, the run's layer, and the
            place of its first pixel there, shape (room, 3).
        candidates: Pixels whose transmittance fell below the threshold of the
            median.
        order: Room to sort the fragments of a pixel.
        deferred: Pairs of a splat and a view for which only the grid pixels are
            drawn so far. A pair is stored as one number: the splat's place in
            the records, times 6 (the number of views), plus the view.
        ready: Number of splats that are collected for each view, to be drawn
            together, shape (6,).
        places: Places of the collected splats in the records, shape (6, 8).
        projections: Up to eight projected splats of one view, in SIMD lanes.
        parts: For each projected splat, the part of its pixels to draw: all,
            those of the grid, or the others.
        spans: First and last column of each projected splat in each pixel row.
            Rows are in chunks of eight; shape (8, chunks, 2, 8).
        met: For each projected splat and chunk of rows, a bit mask of the rows
            in which the splat covers a pixel, shape (8, chunks).
        pair: Memory for two SIMD lanes.
        sets: Sets of views that need a leaf's splats, in SIMD lanes.
        queue: Queued nodes, by lower bounds of their ranges.
        stack: Room for nodes on a ray.
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


def new_canvas(resolution: int, room: int) -> Packed[Canvas]:
    """Makes the scratch memory of one thread.

    Args:
        resolution: Number of pixels along a side of a view.
        room: Capacity for runs, for deferred splats, and for nodes.
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
            runs=np.empty((room, 2, FEW)),
            run_heads=np.empty((room, 3), np.int64),
            candidates=np.empty(n, np.int64),
            order=np.empty((room, 2)),
            deferred=np.empty(room, np.int64),
            ready=np.zeros(N_VIEWS, np.int64),
            places=np.zeros((N_VIEWS, WIDTH), np.int64),
            projections=np.zeros((PROJECTION_SIZE, WIDTH)),
            parts=np.zeros(WIDTH, np.int64),
            spans=np.zeros((WIDTH, chunks, 2, WIDTH)),
            met=np.zeros((WIDTH, chunks), np.int64),
            pair=np.zeros((2, WIDTH)),
            sets=np.zeros(WIDTH),
            queue=new_queue(room),
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
def has_room(canvas, rules):
    """Returns whether the canvas has room for eight more splats in one view."""
    most = WIDTH * rules.resolution * -(-rules.resolution // FEW)
    return canvas.count[RUNS] + most <= len(canvas.runs) and canvas.count[
        DEFERRED
    ] + WIDTH <= len(canvas.deferred)


@inlined
def add_run(canvas, rules, row, layer, begin, reach, alpha):
    """Keeps fragments that are nearer than the limit.

    Args:
        canvas: The canvas, which has room.
        rules: The sensor's `Rules`.
        row: Number of the row, counted through all views.
        layer: Layer of its pixels.
        begin: Place of the first pixel in that layer.
        reach: Ranges of the fragments, in SIMD lanes [m].
        alpha: Their alphas, in SIMD lanes; 0 for no fragment.

    Returns:
        The `light` of the pixels before and after the addition.
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
    # Lanes behind the last place have the index 0.
    for lane in range(FEW):
        if canvas.runs[run, 1, lane] > 0:
            canvas.light[first + index[begin + lane]] = pair[1, lane]
    return before, after


@lean
def gather(canvas, rules, pixel, limit):
    """Finds the fragments of a pixel, and puts them into `canvas.order`.

    Returns:
        Their number, the transmittance of all, and that of those nearer than
        `limit`.
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
    """Records a complete pixel if it is the nearest one of its view.

    Among pixels at the same range, the first one counts.
    """
    view = pixel // (rules.resolution * rules.resolution)
    if reach > canvas.best[view] or (
        reach == canvas.best[view] and pixel > canvas.best_pixel[view]
    ):
        return
    canvas.best[view], canvas.best_pixel[view] = reach, pixel
    # Further pixels may be equally near.
    limit = np.nextafter(reach, np.inf)
    if rules.nearest_only:
        # Of equal views, the first one counts, regardless of the order of
        # visits.
        for other in range(N_VIEWS):
            canvas.limit[other] = min(canvas.limit[other], limit)
    canvas.limit[view] = min(canvas.limit[view], limit)
