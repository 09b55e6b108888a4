"""A bounding volume hierarchy over boxes, built for nearest-splat queries.

A node is one cache line: both children's boxes, the highest centre below
each, and two links. Boxes are stored in single precision, rounded outwards.
"""

import dataclasses as dc

import numpy as np
from numba import njit

LEAF_SIZE = 4
"""The most boxes a leaf holds."""

MAX_DEPTH = 96
"""Deepest node; far below it splits go by count, so it is never reached."""

_BINS = 16
_BALANCE_DEPTH = 48


@dc.dataclass(frozen=True, eq=False)
class BoundingVolumeHierarchy:
    """A binary tree of axis-aligned boxes; the arrays are read-only.

    Attributes:
        nodes: Shape (m, 16), single precision. Columns 0 to 5 hold the left
            child's box (x, y, z lower, then upper) [m], 6 to 11 the right
            child's, 12 and 13 the highest z of a box centre below each [m].
            Columns 14 and 15 are `links` in the same memory. The root is
            node 0.
        links: The same memory as integers: links[i, 14 + side] is the child
            node, or negative for a leaf, whose boxes `leaf_range` tells.
        order: Box indices in leaf order, shape (n,).
    """

    nodes: np.ndarray
    links: np.ndarray
    order: np.ndarray

    def __len__(self) -> int:
        return len(self.order)

    def __deepcopy__(self, memo) -> "BoundingVolumeHierarchy":
        return self


def build_hierarchy(
    lower: np.ndarray, upper: np.ndarray, center_z: np.ndarray
) -> BoundingVolumeHierarchy:
    """Builds a hierarchy by binned surface-area splits.

    Args:
        lower: Lower corners of the boxes, shape (n, 3) [m].
        upper: Upper corners, shape (n, 3) [m].
        center_z: The height by which queries may ignore a box, shape (n,);
            it lies inside the box [m].
    """
    nodes, order = _build(
        np.ascontiguousarray(lower, np.float64),
        np.ascontiguousarray(upper, np.float64),
        np.ascontiguousarray(center_z, np.float64),
    )
    for array in (nodes, order):
        array.flags.writeable = False
    return BoundingVolumeHierarchy(nodes, nodes.view(np.int32), order)


@njit(cache=True)
def leaf_range(link: int) -> tuple[int, int]:
    """First and one-past-last place in leaf order of a leaf's boxes."""
    code = -1 - link
    first = code // (LEAF_SIZE + 1)
    return first, first + code % (LEAF_SIZE + 1)


@njit(cache=True)
def _build(lower, upper, center_z):
    n = len(lower)
    order = np.arange(n)
    nodes = np.zeros((max(1, n), 16), np.float32)
    links = nodes.view(np.int32)
    count = 1
    # Work items: node, first, end, depth.
    stack = np.empty((MAX_DEPTH + 1, 4), np.int64)
    stack[0] = 0, 0, n, 0
    height = 1
    while height:
        height -= 1
        node, first, end, depth = stack[height]
        middle = _split(lower, upper, order, first, end, depth)
        for side in range(2):
            a, b = (first, middle) if side == 0 else (middle, end)
            _write_child(nodes, node, side, lower, upper, center_z, order[a:b])
            if b - a <= LEAF_SIZE:
                links[node, 14 + side] = -1 - (a * (LEAF_SIZE + 1) + b - a)
            else:
                links[node, 14 + side] = count
                stack[height] = count, a, b, depth + 1
                height += 1
                count += 1
    return nodes[:count].copy(), order


@njit(cache=True)
def _split(lower, upper, order, first, end, depth) -> int:
    """Partitions order[first:end] in place; returns the place of the cut."""
    if end - first <= LEAF_SIZE:
        return end
    low = np.full(3, np.inf)
    high = np.full(3, -np.inf)
    for i in range(first, end):
        for k in range(3):
            c = lower[order[i], k] + upper[order[i], k]
            low[k] = min(low[k], c)
            high[k] = max(high[k], c)
    axis = np.argmax(high - low)
    extent = high[axis] - low[axis]
    middle = (first + end) // 2
    if not extent > 0.0 or depth >= _BALANCE_DEPTH:
        return middle
    scale = _BINS * (1 - 1e-9) / extent
    cut = _best_cut(lower, upper, order[first:end], axis, low[axis], scale)
    i, j = first, end - 1
    while i <= j:
        k = order[i]
        if int((lower[k, axis] + upper[k, axis] - low[axis]) * scale) < cut:
            i += 1
        else:
            order[i], order[j] = order[j], k
            j -= 1
    return i if first < i < end else middle


@njit(cache=True)
def _best_cut(lower, upper, members, axis, origin, scale) -> int:
    """The bin border with the least surface area times count on both sides."""
    counts = np.zeros(_BINS, np.int64)
    boxes = np.empty((_BINS, 6))
    boxes[:, :3] = np.inf
    boxes[:, 3:] = -np.inf
    for k in members:
        b = int((lower[k, axis] + upper[k, axis] - origin) * scale)
        counts[b] += 1
        for j in range(3):
            boxes[b, j] = min(boxes[b, j], lower[k, j])
            boxes[b, 3 + j] = max(boxes[b, 3 + j], upper[k, j])
    right_cost = np.empty(_BINS)
    box = np.array([np.inf, np.inf, np.inf, -np.inf, -np.inf, -np.inf])
    total = 0
    for b in range(_BINS - 1, 0, -1):
        total += counts[b]
        right_cost[b] = total * _grow(box, boxes[b])
    box[:3] = np.inf
    box[3:] = -np.inf
    total = 0
    best, best_cost = 1, np.inf
    for b in range(1, _BINS):
        total += counts[b - 1]
        cost = total * _grow(box, boxes[b - 1]) + right_cost[b]
        if cost < best_cost:
            best, best_cost = b, cost
    return best


@njit(cache=True)
def _grow(box, other) -> float:
    """Enlarges `box` by `other` in place and returns half its surface."""
    for j in range(3):
        box[j] = min(box[j], other[j])
        box[3 + j] = max(box[3 + j], other[3 + j])
    x, y, z = box[3] - box[0], box[4] - box[1], box[5] - box[2]
    return x * y + y * z + z * x if x >= 0.0 else 0.0


@njit(cache=True)
def _write_child(nodes, node, side, lower, upper, center_z, members):
    """Stores the box of one child, rounded outwards to single precision."""
    box = np.array([np.inf, np.inf, np.inf, -np.inf, -np.inf, -np.inf])
    top = -np.inf
    for k in members:
        for j in range(3):
            box[j] = min(box[j], lower[k, j])
            box[3 + j] = max(box[3 + j], upper[k, j])
        top = max(top, center_z[k])
    down, up = np.float32(-np.inf), np.float32(np.inf)
    column = 6 * side
    for j in range(3):
        nodes[node, column + j] = np.nextafter(np.float32(box[j]), down)
        nodes[node, column + 3 + j] = np.nextafter(np.float32(box[3 + j]), up)
    nodes[node, 12 + side] = np.nextafter(np.float32(top), up)
