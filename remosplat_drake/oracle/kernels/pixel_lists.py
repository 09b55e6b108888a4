"""Fragments of the pixels of six views, in linked lists (numba).

A pixel is numbered through all views: view times pixels of a view, plus its
row-major index there.
"""

from typing import NamedTuple

import numpy as np

from remosplat_drake.base.packed import Packed
from remosplat_drake.oracle.depth_sensor import N_VIEWS
from remosplat_drake.oracle.kernels.depth_view import DepthViews, new_views
from remosplat_drake.oracle.kernels.footprints import (
    PROJECTION_SIZE,
    inlined,
    lean,
)
from remosplat_drake.splat.bvh import MAX_DEPTH

ROUNDING = 1e-9
"""Bound on how much products of equal factors differ by their order."""

TOUCHED, FRAGMENTS, DRAWING, DEFERRED = range(4)
"""What `Canvas.count` counts."""

GRID = 5
"""Number of pixels from one row or column of the grid to the next."""


class Canvas(NamedTuple):
    """Scratch memory of one thread, reused from sphere to sphere.

    A pixel's entries are valid where `stamp` is the number of this drawing.

    Attributes:
        views: The sphere's views.
        axis: Ray coordinate of each row and column of a view.
        length: Length of the ray (x, y, 1) of each pixel of a view.
        every: All rows and columns, and the number of them.
        grid: Rows and columns of a coarse grid of pixels, up to the edges.
        grid_from: Place in the grid of the first one that is not before a row
            or column, shape (resolution + 1,).
        stamp: Number of the drawing that last wrote to the pixel.
        clear: Transmittance of its kept fragments nearer than the limit.
        total: Transmittance of all its kept fragments.
        head: Latest fragment of the pixel.
        touched: The pixels written to in this drawing.
        link: Next fragment of the same pixel, -1 at the end.
        reach: Range of each fragment [m].
        alpha: Alpha of each fragment.
        order: Room to sort the fragments of a pixel.
        count: Number of touched pixels, of fragments, of drawings so far, and
            of deferred splats.
        deferred: Splats of which only the grid's pixels are drawn: place in
            the records times the number of views, plus the view.
        projection: The projected splat, see `footprints.project`.
        keys: Lower bounds of the ranges in the nodes that wait [m].
        waiting: Those nodes, as a queue with `keys`.
        best: Range of the nearest complete pixel of each view [m]; inf while
            there is none.
        best_pixel: That pixel, -1 while there is none.
        limit: Range from which on nothing is needed of each view [m].
    """

    views: DepthViews
    axis: np.ndarray
    length: np.ndarray
    every: np.ndarray
    grid: np.ndarray
    grid_from: np.ndarray
    stamp: np.ndarray
    clear: np.ndarray
    total: np.ndarray
    head: np.ndarray
    touched: np.ndarray
    link: np.ndarray
    reach: np.ndarray
    alpha: np.ndarray
    order: np.ndarray
    count: np.ndarray
    deferred: np.ndarray
    projection: np.ndarray
    keys: np.ndarray
    waiting: np.ndarray
    best: np.ndarray
    best_pixel: np.ndarray
    limit: np.ndarray


def new_canvas(resolution: int, room: int) -> Packed[Canvas]:
    """Makes the scratch memory of one thread.

    Args:
        resolution: Number of pixels along a side of a view.
        room: Number of fragments that there is room for.
    """
    axis = (np.arange(resolution) + 0.5) * 2 / resolution - 1
    x, y = np.meshgrid(axis, axis)
    grid = np.unique(
        np.linspace(0, resolution - 1, 1 + -(-resolution // GRID)).round()
    ).astype(np.int64)
    pixels = resolution * resolution
    n = N_VIEWS * pixels
    queue = max(room, 2 * MAX_DEPTH)
    return Packed(
        Canvas(
            views=new_views(),
            axis=axis,
            length=np.sqrt(x * x + y * y + 1).reshape(-1),
            every=np.arange(resolution + 1),
            grid=grid,
            grid_from=np.searchsorted(grid, np.arange(resolution + 1)),
            stamp=np.zeros(n, np.int64),
            clear=np.empty(n),
            total=np.empty(n),
            head=np.empty(n, np.int32),
            touched=np.empty(n, np.int64),
            link=np.empty(room, np.int32),
            reach=np.empty(room),
            alpha=np.empty(room),
            order=np.empty(room, np.int32),
            count=np.zeros(4, np.int64),
            deferred=np.empty(room, np.int64),
            projection=np.empty(PROJECTION_SIZE),
            keys=np.empty(queue),
            waiting=np.empty(queue, np.int64),
            best=np.empty(N_VIEWS),
            best_pixel=np.empty(N_VIEWS, np.int64),
            limit=np.empty(N_VIEWS),
        )
    )


@lean
def wipe(canvas, bound):
    """Begins a drawing of what is nearer than `bound`."""
    canvas.count[TOUCHED] = 0
    canvas.count[FRAGMENTS] = 0
    canvas.count[DEFERRED] = 0
    canvas.count[DRAWING] += 1
    for view in range(N_VIEWS):
        canvas.best[view] = np.inf
        canvas.best_pixel[view] = -1
        canvas.limit[view] = bound


@inlined
def add_fragment(canvas, pixel, reach, alpha):
    """Keeps a fragment that is nearer than the limit."""
    if canvas.stamp[pixel] != canvas.count[DRAWING]:
        canvas.stamp[pixel] = canvas.count[DRAWING]
        canvas.clear[pixel] = 1.0
        canvas.total[pixel] = 1.0
        canvas.head[pixel] = -1
        canvas.touched[canvas.count[TOUCHED]] = pixel
        canvas.count[TOUCHED] += 1
    f = canvas.count[FRAGMENTS]
    canvas.count[FRAGMENTS] += 1
    canvas.link[f] = canvas.head[pixel]
    canvas.reach[f] = reach
    canvas.alpha[f] = alpha
    canvas.head[pixel] = f
    canvas.clear[pixel] *= 1 - alpha
    canvas.total[pixel] *= 1 - alpha


@inlined
def has_median(canvas, pixel, rules):
    """Returns whether a pixel may have a median nearer than the limit."""
    return canvas.clear[pixel] <= rules.transmittance + ROUNDING


@lean
def median_range(canvas, pixel, rules, limit):
    """Computes median range and accumulated alpha of a pixel's fragments.

    Fragments at or beyond `limit` no longer count towards `canvas.clear`.
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
    median, clear, clear_before_limit = np.inf, 1.0, 1.0
    for i in range(n):
        f = order[i]
        clear *= 1 - canvas.alpha[f]
        if canvas.reach[f] < limit:
            clear_before_limit = clear
        if median == np.inf and clear <= rules.transmittance:
            median = canvas.reach[f]
    canvas.clear[pixel] = clear_before_limit
    return median, 1 - clear


@lean
def settle(canvas, reach, pixel, nearest_only):
    """Takes a complete pixel for its view's nearest one, if it is.

    Of pixels at the same range the first one is.
    """
    view = pixel // len(canvas.length)
    if reach > canvas.best[view] or (
        reach == canvas.best[view] and pixel > canvas.best_pixel[view]
    ):
        return
    canvas.best[view], canvas.best_pixel[view] = reach, pixel
    # Pixels that are equally near may still come.
    limit = np.nextafter(reach, np.inf)
    if nearest_only:
        # Of equal views the first is meant, whichever is met first.
        for other in range(N_VIEWS):
            canvas.limit[other] = min(canvas.limit[other], limit)
    canvas.limit[view] = min(canvas.limit[view], limit)
