"""A hierarchy whose nodes have eight children, looked at all at once (numba).

It is made of a `BoundingVolumeHierarchy`: a node takes its children's children
in until it has eight, the largest first. Its leaves are single boxes. A query
visits less than half as many nodes, and reads fewer leaves, of which each is in
memory of its own; and processors compare eight numbers in single precision as
fast as one.
"""

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.splat.bvh import MAX_DEPTH, leaf_range

WIDTH = 8
"""Number of children of a node."""

MOST_WAITING = MAX_DEPTH * (WIDTH - 1) + 1
"""Most nodes that wait at a time for their turn in a query."""

ROWS = 7
"""Numbers of a child: lower corner, upper corner, and height."""


@kernel
def widen(nodes, links, boxes):
    """Makes the wide hierarchy of a binary one.

    Args:
        nodes: Nodes of the `BoundingVolumeHierarchy`.
        links: Their links.
        boxes: What is in its leaves, in leaf order: lower and upper corners
            and heights, shape (n, 7 or more) [m].

    Returns:
        For each of the nodes the lower and the upper corners of its children's
        boxes, and the highest height below each, all rounded outwards, shape
        (m, 7, 8) [m], of children that there are not NaN; and the children's
        numbers, or -1 - i for box i of the leaves, shape (m, 8). The root is
        node 0.
    """
    wide, children = _make_nodes(len(nodes) // 2 + WIDTH)
    # Nodes to fill: their number here and there.
    waiting = np.zeros((MOST_WAITING, 2), np.int64)
    # The children of a node: one side of a binary node, or a box of a leaf.
    found = np.empty((WIDTH, 2), np.int64)
    height, count = 1, 1
    while height:
        height -= 1
        if count + WIDTH > len(wide):
            more_wide, more_children = _make_nodes(2 * len(wide))
            more_wide[: len(wide)] = wide
            more_children[: len(wide)] = children
            wide, children = more_wide, more_children
        number, node = waiting[height, 0], waiting[height, 1]
        size = _gather(nodes, links, node, found)
        for k in range(size):
            binary, side = found[k, 0], found[k, 1]
            if side < 0:
                _set_box(wide[number], k, boxes[binary])
                children[number, k] = -1 - binary
                continue
            _copy_box(wide[number], k, nodes[binary], side)
            children[number, k] = count
            link = links[binary, 14 + side]
            if link >= 0:
                waiting[height, 0], waiting[height, 1] = count, link
                height += 1
            else:
                first, end = leaf_range(link)
                for place in range(first, end):
                    _set_box(wide[count], place - first, boxes[place])
                    children[count, place - first] = -1 - place
            count += 1
    return wide[:count].copy(), children[:count].copy()


@helper
def _make_nodes(n):
    """Makes n nodes without children."""
    wide = np.full((n, ROWS, WIDTH), np.nan, np.float32)
    return wide, np.zeros((n, WIDTH), np.int32)


@helper
def _gather(nodes, links, node, found):
    """Finds up to eight nodes and boxes below a binary node; counts them."""
    size = 2
    for side in range(2):
        found[side, 0], found[side, 1] = node, side
    while True:
        chosen, widest = -1, -1.0
        for k in range(size):
            binary, side = found[k, 0], found[k, 1]
            if side < 0 or size + _gained(links[binary, 14 + side]) > WIDTH:
                continue
            # Leaves last: whoever is at their boxes need not have been there.
            surface = _half_surface(nodes[binary], side)
            if links[binary, 14 + side] < 0:
                surface *= 1e-3
            if surface > widest:
                chosen, widest = k, surface
        if chosen < 0:
            return size
        link = int(links[found[chosen, 0], 14 + found[chosen, 1]])
        if link >= 0:
            found[chosen, 0], found[chosen, 1] = link, 0
            found[size, 0], found[size, 1] = link, 1
            size += 1
            continue
        first, end = leaf_range(link)
        size -= 1
        found[chosen, 0], found[chosen, 1] = found[size, 0], found[size, 1]
        for place in range(first, end):
            found[size, 0], found[size, 1] = place, -1
            size += 1


@helper
def _gained(link) -> int:
    """How many more children there are where one's children take its place."""
    if link >= 0:
        return 1
    first, end = leaf_range(link)
    return end - first - 1


@helper
def _half_surface(node, side) -> float:
    c = 6 * side
    x, y = node[c + 3] - node[c], node[c + 4] - node[c + 1]
    z = node[c + 5] - node[c + 2]
    return x * y + y * z + z * x


@helper
def _set_box(rows, k, box) -> None:
    """Writes a box in double precision, rounded outwards."""
    down, up = np.float32(-np.inf), np.float32(np.inf)
    for c in range(ROWS):
        rows[c, k] = np.nextafter(np.float32(box[c]), down if c < 3 else up)


@helper
def _copy_box(rows, k, node, side) -> None:
    """Copies the box of a child of a binary node."""
    for c in range(6):
        rows[c, k] = node[6 * side + c]
    rows[6, k] = node[12 + side]
