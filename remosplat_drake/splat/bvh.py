"""A bounding volume hierarchy of boxes, for queries of the nearest splat.

A node fills one cache line. It contains the boxes of its two children, the
height of the highest box centre below each child, and the links to the
children. Boxes are stored in single precision, rounded outwards.
"""

import dataclasses as dc

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.splat.bvh_build import LEAF_STRIDE, build_nodes
from remosplat_drake.splat.bvh_splits import (
    LEAF_SIZE,
    MAX_DEPTH,
    round_outwards,
)


@dc.dataclass(frozen=True, eq=False)
class BoundingVolumeHierarchy:
    """A binary tree of axis-aligned boxes, with read-only arrays.

    Attributes:
        nodes: Nodes of the tree, shape (m, 16), single precision. Columns 0 to
            5 are the left child's box: the lower x, y, z and then the upper
            [m]. Columns 6 to 11 are the right child's box, and 12 and 13 the
            highest z of a box centre below each child [m]. Columns 14 and 15
            contain `links`. The root is node 0.
        links: The memory of `nodes` as integers. links[i, 14 + side] is the
            number of the child node. It is negative if the child is a leaf;
            `leaf_range` then returns the leaf's boxes.
        order: Indices of the boxes in leaf order, shape (n,), int32.
    """

    nodes: np.ndarray
    links: np.ndarray
    order: np.ndarray

    @staticmethod
    def of(nodes: np.ndarray, order: np.ndarray) -> "BoundingVolumeHierarchy":
        """Makes a hierarchy from its arrays, which become read-only."""
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
        upper: Upper corners of the boxes, shape (n, 3) [m].
        center_z: A height z inside each box, for example that of its centre,
            shape (n,) [m]. Queries may ignore boxes whose `center_z` is below a
            given height.
    """
    boxes = np.column_stack([lower, upper, center_z]).astype(np.float64)
    table = np.empty((len(boxes), 8), np.float32)
    round_outwards(boxes, table)
    return hierarchy_of(table)


def hierarchy_of(table: np.ndarray) -> BoundingVolumeHierarchy:
    """Builds a hierarchy, like `build_hierarchy`, from a table of boxes.

    Args:
        table: The boxes, as `round_outwards` writes them, shape (n, 8). The
            rows are sorted in place.
    """
    places = table.view(np.int32)[:, 7]
    places[:] = np.arange(len(table))
    nodes = build_nodes(table)
    return BoundingVolumeHierarchy.of(nodes, places.copy())


def are_sound(nodes: np.ndarray, order: np.ndarray, n: int) -> bool:
    """Returns whether kernels can traverse a hierarchy of n boxes safely.

    This function checks the indices and the depth of the tree, which kernels do
    not check. It does not check the boxes.

    Args:
        nodes: As in `BoundingVolumeHierarchy`.
        order: As in `BoundingVolumeHierarchy`, with any integer type.
        n: Number of boxes.
    """
    if nodes.ndim != 2 or nodes.shape[1] != 16 or nodes.dtype != np.float32:
        return False
    if order.shape != (n,) or order.dtype.kind != "i" or not len(nodes):
        return False
    links = np.ascontiguousarray(nodes).view(np.int32)
    return bool(_is_tree(links, n) and _is_permutation(order))


@kernel
def _is_tree(links, n) -> bool:
    """Returns whether a traversal visits nodes and boxes in their order."""
    # Links and their depths.
    stack = np.zeros((MAX_DEPTH + 1, 2), np.int64)
    height, node, place = 1, 0, 0
    while height:
        height -= 1
        link, depth = stack[height]
        if link < 0:
            first, end = leaf_range(link)
            if first != place or end - first > LEAF_SIZE:
                return False
            place = end
            continue
        if link != node or node >= len(links) or depth >= MAX_DEPTH:
            return False
        node += 1
        for side in range(1, -1, -1):
            stack[height, 0] = links[link, 14 + side]
            stack[height, 1] = depth + 1
            height += 1
    return node == len(links) and place == n


@kernel
def _is_permutation(order) -> bool:
    """Whether n numbers are a permutation of those from 0 to n - 1."""
    met = np.zeros(len(order), np.bool_)
    for number in order:
        if number < 0 or number >= len(order) or met[number]:
            return False
        met[number] = True
    return True


@helper
def leaf_range(link: int) -> tuple[int, int]:
    """Decodes the link to a leaf into the range of its boxes in leaf order.

    Args:
        link: A negative entry of `BoundingVolumeHierarchy.links`.

    Returns:
        Index of the leaf's first box in leaf order, and the index after its
        last box.
    """
    code = -1 - link
    first = code // LEAF_STRIDE
    return first, first + code % LEAF_STRIDE
