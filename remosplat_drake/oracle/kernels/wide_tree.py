"""Builds a hierarchy whose nodes have eight children, for SIMD (Numba).

The hierarchy is built from a binary `BoundingVolumeHierarchy`: the largest
child of a node is replaced by its own children until the node has eight
children. A query of the wide hierarchy visits less than half as many nodes as
one of the binary hierarchy. A processor compares eight numbers in single
precision as fast as one.
"""

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.lanes import WIDTH
from remosplat_drake.splat.bvh import LEAF_SIZE, MAX_DEPTH, leaf_range
from remosplat_drake.splat.bvh_build import leaf_link

MOST_WAITING = MAX_DEPTH * (WIDTH - 1) + 1
"""Largest number of queued nodes in a query."""

ROWS = 7
"""Number of values of a child: lower corner, upper corner, and the greatest z
of the box centres below it."""


@kernel
def widen(nodes, links, leaf_size):
    """Makes the wide hierarchy from a binary hierarchy.

    Args:
        nodes: Nodes of the `BoundingVolumeHierarchy`.
        links: Links of the `BoundingVolumeHierarchy`.
        leaf_size: Largest number of boxes in a leaf; below 16.

    Returns:
        Two arrays, whose row i is node i; the root is node 0. The first array
        has shape (m, 7, 8) [m]. For each child, it contains the lower and the
        upper corner of the child's box, and the greatest z of the box centres
        in its subtree; NaN for missing children. The second array has shape (m,
        8). It contains the number of each child, or the link of a child that is
        a leaf.
    """
    # This is the usual number of nodes. Allocating many more would take long.
    wide, children = _make_nodes(len(nodes) // 3 + 1)
    # Nodes that are still without children: their numbers in the wide and in
    # the binary hierarchy.
    waiting = np.zeros((MOST_WAITING, 2), np.int64)
    found = np.empty((WIDTH, 2), np.int64)
    height, count = 1, 1
    while height:
        height -= 1
        if count + WIDTH > len(wide):
            more_wide, more_children = _make_nodes(len(wide) + len(nodes) // 6)
            more_wide[:count] = wide[:count]
            more_children[:count] = children[:count]
            wide, children = more_wide, more_children
        number, node = waiting[height, 0], waiting[height, 1]
        size = _gather(nodes, links, node, leaf_size, found)
        for k in range(WIDTH):
            if k >= size:
                wide[number, :, k], children[number, k] = np.nan, 0
                continue
            binary, side = found[k, 0], found[k, 1]
            for c in range(6):
                wide[number, c, k] = nodes[binary, 6 * side + c]
            wide[number, 6, k] = nodes[binary, 12 + side]
            link = _leaf_or_node(links, links[binary, 14 + side], leaf_size)
            children[number, k] = link
            if link >= 0:
                waiting[height, 0] = children[number, k] = count
                waiting[height, 1] = links[binary, 14 + side]
                height += 1
                count += 1
    return wide[:count], children[:count]


@kernel(linked=True)
def largest_below(children, values):
    """Finds the largest value below each child of a wide hierarchy.

    Args:
        children: The second array of `widen`, with the numbers of the children.
        values: A value >= 0 of each box, in leaf order.

    Returns:
        The largest values, shape (m, 8); 0 for missing children.
    """
    largest = np.zeros(children.shape)
    # The number of a child is greater than that of its parent.
    for node in range(len(children) - 1, -1, -1):
        for k in range(WIDTH):
            link = children[node, k]
            if link > 0:
                largest[node, k] = largest[link].max()
            elif link < 0:
                first, end = leaf_range(link)
                for place in range(first, end):
                    largest[node, k] = max(largest[node, k], values[place])
    return largest


@helper
def _make_nodes(n):
    """Allocates arrays for n nodes and a few more."""
    wide = np.empty((n + WIDTH, ROWS, WIDTH), np.float32)
    return wide, np.empty((n + WIDTH, WIDTH), np.int32)


@helper
def _gather(nodes, links, node, leaf_size, found):
    """Finds up to eight descendants of a binary node, as node and side.

    Returns:
        The number of descendants found.
    """
    for side in range(2):
        found[side, 0], found[side, 1] = node, side
    size = 2
    while size < WIDTH:
        chosen, widest = -1, -1.0
        for k in range(size):
            binary, side = found[k, 0], found[k, 1]
            surface = _half_surface(nodes[binary], side)
            link = _leaf_or_node(links, links[binary, 14 + side], leaf_size)
            if link >= 0 and surface > widest:
                chosen, widest = k, surface
        if chosen < 0:
            break
        child = int(links[found[chosen, 0], 14 + found[chosen, 1]])
        found[chosen, 0], found[chosen, 1] = child, 0
        found[size, 0], found[size, 1] = child, 1
        size += 1
    return size


@helper
def _leaf_or_node(links, link, leaf_size):
    """Returns a child's link, or a leaf's link if few boxes are below it."""
    if link < 0 or leaf_size <= LEAF_SIZE:
        return link
    left = right = link
    while left >= 0:
        left = links[left, 14]
    while right >= 0:
        right = links[right, 15]
    first, (_, end) = leaf_range(left)[0], leaf_range(right)
    return leaf_link(first, end) if end - first <= leaf_size else link


@helper
def _half_surface(node, side) -> float:
    c = 6 * side
    x, y = node[c + 3] - node[c], node[c + 4] - node[c + 1]
    z = node[c + 5] - node[c + 2]
    return x * y + y * z + z * x
