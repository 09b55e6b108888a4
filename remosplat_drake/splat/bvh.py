"""A bounding volume hierarchy over boxes, built for nearest-splat queries.

A node is one cache line: both children's boxes, the highest centre below
each, and two links. Boxes are stored in single precision, rounded outwards.
"""

import dataclasses as dc

import numpy as np

from remosplat_drake.base.kernels import helper, kernel

LEAF_SIZE = 4
"""Largest number of boxes in a leaf; must be below 16, see `leaf_range`."""

MAX_DEPTH = 96
"""Depth that no node reaches, since deep nodes are split by count."""

_LEAF_STRIDE = 16
_BINS = 16
_BALANCE_DEPTH = 48


@dc.dataclass(frozen=True, eq=False)
class BoundingVolumeHierarchy:
    """A binary tree of axis-aligned boxes; the arrays are read-only.

    Attributes:
        nodes: Nodes of the tree, shape (m, 16), single precision. Columns 0 to
            5 hold the left child's box (x, y, z lower, then upper) [m], 6 to 11
            the right child's, 12 and 13 the highest z of a box centre below
            each [m]. Columns 14 and 15 are `links` in the same memory. The root
            is node 0.
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
    """Builds a hierarchy by the binned surface area heuristic (SAH).

    Args:
        lower: Lower corners of the boxes, shape (n, 3) [m].
        upper: Upper corners, shape (n, 3) [m].
        center_z: Height by which queries may ignore a box, shape (n,) [m]; it
            lies inside the box.
    """
    n = len(lower)
    table = np.column_stack([lower, upper, center_z, np.arange(n)])
    nodes = _build(np.ascontiguousarray(table, np.float64))
    order = table[:, 7].astype(np.int64)
    for array in (nodes, order):
        array.flags.writeable = False
    return BoundingVolumeHierarchy(nodes, nodes.view(np.int32), order)


@helper
def leaf_range(link: int) -> tuple[int, int]:
    """Decodes a leaf's link into the range of its boxes in leaf order.

    Args:
        link: A negative entry of `BoundingVolumeHierarchy.links`.

    Returns:
        The first and the one-past-last place.
    """
    code = -1 - link
    first = code // _LEAF_STRIDE
    return first, first + code % _LEAF_STRIDE


def leaf_margins(
    hierarchy: BoundingVolumeHierarchy, values: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray]:
    """Sorts the boxes' values into leaf order and finds the largest below.

    Args:
        hierarchy: The hierarchy.
        values: A value of each box, not negative, shape (n,), or None.

    Returns:
        The values in leaf order, shape (n,), and the largest below the left
        and the right child of each node, shape (m, 2); both are empty for None.
    """
    if values is None:
        return np.zeros(0), np.zeros((0, 2))
    values = values[hierarchy.order].astype(np.float64)
    return values, _largest_below(hierarchy.links, values)


@kernel
def _largest_below(links, values):
    """The largest value below both children of each node, 0 without any."""
    largest = np.zeros((len(links), 2))
    # A child is numbered after its parent.
    for node in range(len(links) - 1, -1, -1):
        for side in range(2):
            link = links[node, 14 + side]
            if link >= 0:
                largest[node, side] = largest[link].max()
                continue
            first, end = leaf_range(link)
            for place in range(first, end):
                value = max(largest[node, side], values[place])
                largest[node, side] = value
    return largest


@kernel
def _build(table):
    """Sorts the boxes into leaf order in place and returns the nodes.

    A row of the table is a box: lower, upper, z of the centre, index.
    """
    nodes = np.zeros((max(1, len(table)), 16), np.float32)
    links = nodes.view(np.int32)
    count = 1
    # Work items: node, first, end, depth.
    stack = np.empty((MAX_DEPTH + 1, 4), np.int64)
    stack[0] = 0, 0, len(table), 0
    height = 1
    while height:
        height -= 1
        node, first, end, depth = stack[height]
        middle = first + _split(table[first:end], depth)
        for side in range(2):
            a, b = (first, middle) if side == 0 else (middle, end)
            _write_child(nodes[node], side, table[a:b])
            if b - a <= LEAF_SIZE:
                links[node, 14 + side] = -1 - (a * _LEAF_STRIDE + b - a)
            else:
                links[node, 14 + side] = count
                stack[height] = count, a, b, depth + 1
                height += 1
                count += 1
    return nodes[:count].copy()


@helper
def _split(boxes, depth) -> int:
    """Partitions the boxes in place; returns how many go left."""
    n = len(boxes)
    if n <= LEAF_SIZE:
        return n
    low = np.full(3, np.inf)
    high = np.full(3, -np.inf)
    for i in range(n):
        for k in range(3):
            c = boxes[i, k] + boxes[i, 3 + k]
            low[k] = min(low[k], c)
            high[k] = max(high[k], c)
    axis = np.argmax(high - low)
    extent = high[axis] - low[axis]
    # Boxes around one point cannot be told apart by their place.
    if not extent > 1e-200 or depth >= _BALANCE_DEPTH:
        return n // 2
    scale = _BINS * (1 - 1e-9) / extent
    cut = _best_cut(boxes, axis, low[axis], scale)
    i, j = 0, n - 1
    while i <= j:
        c = boxes[i, axis] + boxes[i, 3 + axis] - low[axis]
        if int(c * scale) < cut:
            i += 1
            continue
        for k in range(8):
            boxes[i, k], boxes[j, k] = boxes[j, k], boxes[i, k]
        j -= 1
    return i if 0 < i < n else n // 2


@helper
def _best_cut(boxes, axis, origin, scale) -> int:
    """The bin border with the least surface area times count on both sides."""
    counts = np.zeros(_BINS, np.int64)
    bins = np.empty((_BINS, 6))
    bins[:, :3] = np.inf
    bins[:, 3:] = -np.inf
    for i in range(len(boxes)):
        b = int((boxes[i, axis] + boxes[i, 3 + axis] - origin) * scale)
        counts[b] += 1
        _grow(bins[b], boxes[i])
    right_cost = np.empty(_BINS)
    grown = bins[_BINS - 1].copy()
    total = 0
    for b in range(_BINS - 1, 0, -1):
        total += counts[b]
        _grow(grown, bins[b])
        right_cost[b] = total * _half_surface(grown)
    grown[:] = bins[0]
    total = 0
    best, best_cost = 1, np.inf
    for b in range(1, _BINS):
        total += counts[b - 1]
        _grow(grown, bins[b - 1])
        cost = total * _half_surface(grown) + right_cost[b]
        if cost < best_cost:
            best, best_cost = b, cost
    return best


@helper
def _grow(box, other):
    """Enlarges a box (lower, upper) in place until it holds the other."""
    for k in range(3):
        box[k] = min(box[k], other[k])
        box[3 + k] = max(box[3 + k], other[3 + k])


@helper
def _half_surface(box) -> float:
    x, y, z = box[3] - box[0], box[4] - box[1], box[5] - box[2]
    return x * y + y * z + z * x if x >= 0.0 else 0.0


@helper
def _write_child(node, side, boxes):
    """Stores the box of one child, rounded outwards to single precision."""
    box = np.empty(6)
    box[:3] = np.inf
    box[3:] = -np.inf
    top = -np.inf
    for i in range(len(boxes)):
        _grow(box, boxes[i])
        top = max(top, boxes[i, 6])
    down, up = np.float32(-np.inf), np.float32(np.inf)
    for k in range(3):
        node[6 * side + k] = np.nextafter(np.float32(box[k]), down)
        node[6 * side + 3 + k] = np.nextafter(np.float32(box[3 + k]), up)
    node[12 + side] = np.nextafter(np.float32(top), up)
