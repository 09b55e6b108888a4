"""Fragments of the pixels of six views, in linked lists (numba).

A pixel is numbered through all views: view times pixels of a view, plus its
row-major index there.
"""

from typing import NamedTuple

import numpy as np

from remosplat_drake.oracle.depth_sensor import N_VIEWS
from remosplat_drake.oracle.kernels.footprints import (
    PROJECTION_SIZE,
    kernel,
    lean,
)

ROUNDING = 1e-9
"""Bound on how much products of equal factors differ by their order."""


class Canvas(NamedTuple):
    """Scratch memory of one thread, reused from sphere to sphere.

    A pixel's entries are valid where `stamp` is the current sphere's number.

    Attributes:
        length: Length of the ray (x, y, 1) of each pixel of a view.
        stamp: Number of the sphere that last wrote to the pixel.
        clear: Transmittance of its kept fragments nearer than the best range.
        total: Transmittance of all its kept fragments.
        head: Latest fragment of the pixel.
        touched: The pixels written to for this sphere.
        link: Next fragment of the same pixel, -1 at the end.
        reach: Range of each fragment [m].
        alpha: Alpha of each fragment.
        order: Room to sort the fragments of a pixel.
        count: Number of touched pixels, number of fragments.
        projection: The projected splat, see `footprints.project`.
        keys: Lower bounds of the ranges in the nodes that wait [m].
        waiting: Those nodes, as a queue with `keys`.
        best: Range of the nearest complete pixel of each view, or the bound
            below which one is looked for [m].
        best_pixel: That pixel, -1 while there is none.
    """

    length: np.ndarray
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
    projection: np.ndarray
    keys: np.ndarray
    waiting: np.ndarray
    best: np.ndarray
    best_pixel: np.ndarray


@kernel
def new_canvas(resolution, n_nodes, capacity):
    """Makes the scratch memory of one thread.

    Args:
        resolution: Number of pixels along a side of a view.
        n_nodes: Number of nodes of the hierarchy.
        capacity: Number of fragments that there is room for.
    """
    length = np.empty(resolution * resolution)
    for row in range(resolution):
        y = (row + 0.5) * 2 / resolution - 1
        for column in range(resolution):
            x = (column + 0.5) * 2 / resolution - 1
            length[row * resolution + column] = np.sqrt(x * x + y * y + 1)
    n = N_VIEWS * len(length)
    return Canvas(
        length,
        np.full(n, -1, np.int32),
        np.empty(n),
        np.empty(n),
        np.empty(n, np.int32),
        np.empty(n, np.int64),
        np.empty(capacity, np.int32),
        np.empty(capacity),
        np.empty(capacity),
        np.empty(capacity, np.int32),
        np.zeros(2, np.int64),
        np.empty(PROJECTION_SIZE),
        np.empty(2 * n_nodes + 1),
        np.empty(2 * n_nodes + 1, np.int64),
        np.empty(N_VIEWS),
        np.empty(N_VIEWS, np.int64),
    )


@lean
def add_fragment(canvas, pixel, stamp, reach, alpha):
    """Keeps a fragment that is nearer than the best range."""
    if canvas.stamp[pixel] != stamp:
        canvas.stamp[pixel] = stamp
        canvas.clear[pixel] = 1.0
        canvas.total[pixel] = 1.0
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
    canvas.total[pixel] *= 1 - alpha


@lean
def has_median(canvas, pixel, rules):
    """Returns whether a pixel may have a median nearer than the best range."""
    return canvas.clear[pixel] <= rules.transmittance + ROUNDING


@lean
def median_range(canvas, pixel, rules, best):
    """Computes median range and accumulated alpha of a pixel's fragments.

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
