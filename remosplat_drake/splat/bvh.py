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

    @staticmethod
    def of(nodes: np.ndarray, order: np.ndarray) -> "BoundingVolumeHierarchy":
        """Makes a hierarchy of its arrays, which become read-only."""
        for array in (nodes, order):
            array.flags.writeable = False
        return BoundingVolumeHierarchy(nodes, nodes.view(np.int32), order)

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
    boxes = np.column_stack([lower, upper, center_z, np.arange(n)])
    return hierarchy_of(np.ascontiguousarray(boxes, np.float64))


def hierarchy_of(boxes: np.ndarray) -> BoundingVolumeHierarchy:
    """Builds a hierarchy of boxes as `build_hierarchy` does.

    Args:
        boxes: Rows of lower corner, upper corner, height by which queries may
            ignore the box [m], and its index: shape (n, 8), float64. They are
            sorted in place.
    """
    nodes = _build(boxes)
    return BoundingVolumeHierarchy.of(nodes, boxes[:, 7].astype(np.int64))


def are_sound(nodes: np.ndarray, order: np.ndarray, n: int) -> bool:
    """Returns whether kernels can go through a hierarchy of n boxes.

    They trust its indices. Whether its boxes are right is not looked at.

    Args:
        nodes: As in `BoundingVolumeHierarchy`.
        order: As there.
        n: Number of boxes.
    """
    if nodes.ndim != 2 or nodes.shape[1] != 16 or nodes.dtype != np.float32:
        return False
    if order.shape != (n,) or order.min(initial=0) < 0:
        return False
    if order.max(initial=-1) >= n or not len(nodes):
        return False
    link = nodes.view(np.int32)[:, 14:].astype(np.int64)
    inner, code = link[link >= 0], -1 - link[link < 0]
    parent = np.nonzero(link >= 0)[0]
    end = code // _LEAF_STRIDE + code % _LEAF_STRIDE
    # A child is numbered after its parent: there are no circles.
    return bool(
        (inner > parent).all()
        and inner.max(initial=0) < len(nodes)
        and end.max(initial=0) <= n
    )


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
    # Boxes of the bins, of both children, and numbers of boxes and costs.
    bins = np.empty((_BINS, 7))
    children = np.empty((2, 7))
    counts, costs = np.empty(_BINS, np.int64), np.empty(_BINS)
    count = 1
    # Work items: node, first, end, depth.
    stack = np.empty((MAX_DEPTH + 1, 4), np.int64)
    stack[0] = 0, 0, len(table), 0
    height = 1
    while height:
        height -= 1
        node, first, end, depth = stack[height]
        middle = _split(table, first, end, depth, bins, children, counts, costs)
        for side in range(2):
            a, b = (first, middle) if side == 0 else (middle, end)
            _write_child(nodes, node, side, children)
            if b - a <= LEAF_SIZE:
                links[node, 14 + side] = -1 - (a * _LEAF_STRIDE + b - a)
            else:
                links[node, 14 + side] = count
                stack[height] = count, a, b, depth + 1
                height += 1
                count += 1
    return nodes[:count].copy()


@helper
def _split(table, first, end, depth, bins, children, counts, costs) -> int:
    """Partitions boxes in place, and finds what holds those of each side.

    Returns:
        The first one of the right side.
    """
    n = end - first
    if n <= LEAF_SIZE:
        return _bounded(table, first, end, end, children)
    axis, low, extent = _widest(table, first, end)
    # Boxes around one point cannot be told apart by their place.
    if not extent > 1e-200 or depth >= _BALANCE_DEPTH:
        return _bounded(table, first, first + n // 2, end, children)
    scale = _BINS * (1 - 1e-9) / extent
    _fill_bins(table, first, end, axis, low, scale, bins, counts)
    cut = _best_cut(bins, children, counts, costs)
    i, j = first, end - 1
    while i <= j:
        c = table[i, axis] + table[i, 3 + axis] - low
        if int(c * scale) < cut:
            i += 1
            continue
        for k in range(8):
            table[i, k], table[j, k] = table[j, k], table[i, k]
        j -= 1
    if not first < i < end:
        return _bounded(table, first, first + n // 2, end, children)
    _empty(children, 0)
    _empty(children, 1)
    for b in range(_BINS):
        _grow(children, 0 if b < cut else 1, bins, b)
    return i


@helper
def _widest(table, first, end):
    """The axis along which the centres spread most, where and how far."""
    x0 = y0 = z0 = np.inf
    x1 = y1 = z1 = -np.inf
    for i in range(first, end):
        x = table[i, 0] + table[i, 3]
        y = table[i, 1] + table[i, 4]
        z = table[i, 2] + table[i, 5]
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
def _fill_bins(table, first, end, axis, origin, scale, bins, counts):
    """Counts and bounds the boxes with their centres in each bin."""
    for b in range(_BINS):
        _empty(bins, b)
        counts[b] = 0
    for i in range(first, end):
        b = int((table[i, axis] + table[i, 3 + axis] - origin) * scale)
        counts[b] += 1
        _grow(bins, b, table, i)


@helper
def _best_cut(bins, grown, counts, costs) -> int:
    """The bin border with the least surface area times count on both sides."""
    total = 0
    _empty(grown, 0)
    for b in range(_BINS - 1, 0, -1):
        total += counts[b]
        _grow(grown, 0, bins, b)
        costs[b] = total * _half_surface(grown)
    total = 0
    best, least = 1, np.inf
    _empty(grown, 0)
    for b in range(1, _BINS):
        total += counts[b - 1]
        _grow(grown, 0, bins, b - 1)
        cost = total * _half_surface(grown) + costs[b]
        if cost < least:
            least = cost
            best = b
    return best


@helper
def _bounded(table, first, middle, end, children) -> int:
    """Bounds the boxes before and from `middle` on, and returns that."""
    _empty(children, 0)
    _empty(children, 1)
    for i in range(first, end):
        _grow(children, 0 if i < middle else 1, table, i)
    return middle


@helper
def _empty(boxes, b):
    """Makes a box that holds nothing."""
    for k in range(3):
        boxes[b, k] = np.inf
        boxes[b, 3 + k] = -np.inf
    boxes[b, 6] = -np.inf


@helper
def _grow(boxes, b, others, i):
    """Enlarges a box (lower, upper, top) in place until it holds the other."""
    for k in range(3):
        boxes[b, k] = min(boxes[b, k], others[i, k])
        boxes[b, 3 + k] = max(boxes[b, 3 + k], others[i, 3 + k])
    boxes[b, 6] = max(boxes[b, 6], others[i, 6])


@helper
def _half_surface(boxes) -> float:
    x = boxes[0, 3] - boxes[0, 0]
    y = boxes[0, 4] - boxes[0, 1]
    z = boxes[0, 5] - boxes[0, 2]
    return x * y + y * z + z * x if x >= 0.0 else 0.0


@helper
def _write_child(nodes, node, side, children):
    """Stores the box of one child, rounded outwards to single precision."""
    down, up = np.float32(-np.inf), np.float32(np.inf)
    for k in range(3):
        nodes[node, 6 * side + k] = np.nextafter(
            np.float32(children[side, k]), down
        )
        nodes[node, 6 * side + 3 + k] = np.nextafter(
            np.float32(children[side, 3 + k]), up
        )
    nodes[node, 12 + side] = np.nextafter(np.float32(children[side, 6]), up)
