"""Splits boxes into two sides at the best border between bins (Numba).

The boxes are the rows of a table, which are sorted in place. A row has 8
numbers in single precision: the negative lower corner, the upper corner, the
height of the centre, and the index of the box, which is stored as an integer.
So the union of boxes is the maximum of each column.
"""

import numpy as np

from remosplat_drake.base.kernels import helper, kernel

LEAF_SIZE = 4
"""Largest number of boxes in a leaf. It must be less than 16; see
`leaf_range`."""

MAX_DEPTH = 96
"""Upper bound of the depth of a hierarchy. To keep this bound, deep nodes are
split into two sides with equal numbers of boxes."""

_BINS = 16
_FEW_BINS = 8
"""Number of bins for nodes with few boxes. With more bins, filling them would
take longer than the better split saves."""

_FEW = 16
_BALANCE_DEPTH = 48
_LOWEST = np.float32(-np.finfo(np.float32).max)


@kernel
def round_outwards(boxes, table):
    """Writes boxes to rows of this module's table, rounded outwards.

    Args:
        boxes: Lower corner, upper corner, height of the centre [m], shape (n,
            7), double precision.
        table: Output: the table, except its last column, shape (n, 8).
    """
    up = np.float32(np.inf)
    for i in range(len(boxes)):
        for k in range(3):
            table[i, k] = np.nextafter(np.float32(-boxes[i, k]), up)
            table[i, 3 + k] = np.nextafter(np.float32(boxes[i, 3 + k]), up)
        table[i, 6] = np.nextafter(np.float32(boxes[i, 6]), up)


@helper
def scratch():
    """Allocates working memory for `split`."""
    return (
        np.empty((_BINS, 8), np.float32),
        np.empty((2, 8), np.float32),
        np.empty(_BINS, np.int64),
        np.empty(_BINS),
    )


@helper
def split(table, first, end, depth, memory) -> int:
    """Partitions boxes in place into two sides, and computes their boxes.

    Returns:
        Row of the first box of the right side.
    """
    bins, children, counts, costs = memory
    n = end - first
    if n <= LEAF_SIZE:
        return _bounded(table, first, end, end, children)
    axis, low, extent = _widest(table, first, end)
    # Boxes with the same centre, and infinite boxes, cannot be separated by
    # position.
    if not 1e-200 < extent < np.inf or depth >= _BALANCE_DEPTH:
        return _bounded(table, first, first + n // 2, end, children)
    n_bins = _FEW_BINS if n <= _FEW else _BINS
    scale = n_bins * (1 - 1e-9) / extent
    bins, counts = bins[:n_bins], counts[:n_bins]
    _fill_bins(table, first, end, axis, low, scale, bins, counts)
    cut = _best_cut(bins, children, counts, costs)
    middle = _partition(table, first, end, axis, low, scale, cut)
    if not first < middle < end:
        return _bounded(table, first, first + n // 2, end, children)
    _empty(children, 0)
    _empty(children, 1)
    for b in range(n_bins):
        _grow(children, 0 if b < cut else 1, bins, b)
    return middle


@helper
def _center(table, i, axis):
    """Returns twice the coordinate of a box's centre along an axis."""
    return np.float64(table[i, 3 + axis]) - np.float64(table[i, axis])


@helper
def _widest(table, first, end):
    """Returns the axis with the largest spread of centres, and the spread.

    The spread is returned as its start and its length. It is infinite if a box
    is infinite, since the centre of such a box may be NaN.
    """
    x0 = y0 = z0 = np.inf
    x1 = y1 = z1 = -np.inf
    for i in range(first, end):
        x, y, z = (
            _center(table, i, 0),
            _center(table, i, 1),
            _center(table, i, 2),
        )
        if not np.isfinite(x + y + z):
            return 0, 0.0, np.inf
        x0, x1 = min(x0, x), max(x1, x)
        y0, y1 = min(y0, y), max(y1, y)
        z0, z1 = min(z0, z), max(z1, z)
    dx, dy, dz = x1 - x0, y1 - y0, z1 - z0
    if dx >= dy and dx >= dz:
        return 0, x0, dx
    if dy >= dz:
        return 1, y0, dy
    return 2, z0, dz


@helper
def _fill_bins(table, first, end, axis, low, scale, bins, counts):
    """Computes the number and the union of the boxes in each bin."""
    for b in range(len(bins)):
        _empty(bins, b)
        counts[b] = 0
    for i in range(first, end):
        b = int((_center(table, i, axis) - low) * scale)
        counts[b] += 1
        _grow(bins, b, table, i)


@helper
def _best_cut(bins, grown, counts, costs) -> int:
    """Returns the border of bins for which a split has the least cost."""
    total = 0
    _empty(grown, 0)
    for b in range(len(bins) - 1, 0, -1):
        total += counts[b]
        _grow(grown, 0, bins, b)
        costs[b] = total * _half_surface(grown)
    total = 0
    best, least = 1, np.inf
    _empty(grown, 0)
    for b in range(1, len(bins)):
        total += counts[b - 1]
        _grow(grown, 0, bins, b - 1)
        cost = total * _half_surface(grown) + costs[b]
        if cost < least:
            least = cost
            best = b
    return best


@helper
def _partition(table, first, end, axis, low, scale, cut) -> int:
    """Moves the boxes of the bins before `cut` to the front.

    Returns:
        Row of the first box of the remaining bins.
    """
    i, j = first, end - 1
    while True:
        while i <= j and int((_center(table, i, axis) - low) * scale) < cut:
            i += 1
        while i <= j and int((_center(table, j, axis) - low) * scale) >= cut:
            j -= 1
        if i >= j:
            return i
        for k in range(8):
            table[i, k], table[j, k] = table[j, k], table[i, k]
        i += 1
        j -= 1


@helper
def _bounded(table, first, middle, end, children) -> int:
    """Computes the union of the boxes before `middle`, and that of the rest."""
    _empty(children, 0)
    _empty(children, 1)
    for i in range(first, end):
        _grow(children, 0 if i < middle else 1, table, i)
    return middle


@helper
def _empty(boxes, b):
    """Makes an empty box, for the union with other boxes."""
    for k in range(8):
        boxes[b, k] = _LOWEST


@helper
def _grow(boxes, b, others, i):
    """Enlarges a box in place to its union with another box."""
    for k in range(7):
        boxes[b, k] = max(boxes[b, k], others[i, k])


@helper
def _half_surface(boxes) -> float:
    x = np.float64(boxes[0, 3]) + np.float64(boxes[0, 0])
    y = np.float64(boxes[0, 4]) + np.float64(boxes[0, 1])
    z = np.float64(boxes[0, 5]) + np.float64(boxes[0, 2])
    return x * y + y * z + z * x if x >= 0.0 else 0.0


@helper
def write_children(node, children):
    """Writes the boxes of the two children of a node."""
    for side in range(2):
        for k in range(3):
            node[6 * side + k] = -children[side, k]
            node[6 * side + 3 + k] = children[side, 3 + k]
        node[12 + side] = children[side, 6]
