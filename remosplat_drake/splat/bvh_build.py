"""Builds a `BoundingVolumeHierarchy` from the root down (Numba).

Large tables of boxes are first split into pieces, which several threads then
sort. The hierarchy does not depend on the number of threads.
"""

import dataclasses as dc
from functools import partial
from itertools import chain

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.threads import in_parallel
from remosplat_drake.splat.bvh_splits import (
    LEAF_SIZE,
    MAX_DEPTH,
    scratch,
    split,
    write_children,
)

LEAF_STRIDE = 16
"""Factor in the link to a leaf. The link encodes the index of the leaf's first
box times this factor, plus the number of its boxes; see `leaf_range`."""

PIECE = 1 << 17
"""Largest number of boxes of a piece, which one thread sorts."""


@dc.dataclass
class _Part:
    """A range of the table of boxes, which are sorted below one node.

    Attributes:
        first: Row of the first box.
        end: Row after that of the last box.
        depth: Depth of the node in the tree.
        nodes: The nodes of the part, with links relative to the first node. If
            the part has been cut in two, only its first node.
        sides: The two parts into which the part has been cut; empty if it has
            not.
    """

    first: int
    end: int
    depth: int
    nodes: np.ndarray = dc.field(
        default_factory=lambda: np.zeros((0, 16), np.float32)
    )
    sides: list["_Part"] = dc.field(default_factory=list)

    def __len__(self) -> int:
        return self.end - self.first


def build_nodes(table: np.ndarray) -> np.ndarray:
    """Sorts boxes into leaf order, and returns the nodes of their hierarchy.

    Nodes are numbered in preorder: first a node, then the nodes below its left
    child, then those below its right child.

    Args:
        table: The boxes, shape (n, 8). The rows are sorted in place.

    Returns:
        Nodes as in `BoundingVolumeHierarchy`, shape (m, 16).
    """
    root = _Part(0, len(table), 0)
    level, pieces = [root], []
    while level:
        pieces += [part for part in level if len(part) <= PIECE]
        large = [part for part in level if len(part) > PIECE]
        level = list(chain(*in_parallel(partial(_cut, table), large)))
    pieces.sort(key=len, reverse=True)
    in_parallel(partial(_sort, table), pieces)
    return _joined(root)


def _cut(table: np.ndarray, part: _Part) -> list[_Part]:
    """Cuts a part in two, at its first node."""
    part.nodes = np.zeros((1, 16), np.float32)
    middle = _cut_boxes(table, part.first, part.end, part.depth, part.nodes)
    part.sides = [
        _Part(first, end, part.depth + 1)
        for first, end in ((part.first, middle), (middle, part.end))
    ]
    return part.sides


def _sort(table: np.ndarray, part: _Part) -> None:
    """Sorts a part down to its leaves; a part that is a leaf is unchanged."""
    if len(part) > LEAF_SIZE or not part.depth:
        part.nodes = _build(table, part.first, part.end, part.depth)


def _joined(root: _Part) -> np.ndarray:
    """Returns the nodes of all parts, numbered from the root on."""
    parts, waiting = [], [root]
    while waiting:
        parts.append(waiting.pop())
        waiting += reversed(parts[-1].sides)
    nodes = np.concatenate([part.nodes for part in parts])
    starts = np.cumsum([0, *(len(part.nodes) for part in parts)])
    number = dict(zip(map(id, parts), starts.tolist(), strict=False))
    for part in parts:
        start = number[id(part)]
        links = nodes.view(np.int32)[start : start + len(part.nodes), 14:]
        links[links >= 0] += start
        if part.sides:
            links[0] = [
                number[id(side)]
                if len(side.nodes)
                else leaf_link(side.first, side.end)
                for side in part.sides
            ]
    return nodes


@kernel
def _cut_boxes(table, first, end, depth, nodes):
    """Partitions boxes into the two sides of a node, and writes the node.

    Returns:
        Row of the first box of the right side.
    """
    memory = scratch()
    middle = split(table, first, end, depth, memory)
    write_children(nodes[0], memory[1])
    return middle


@kernel
def _build(table, first, end, depth):
    """Sorts the boxes from `first` to `end`, and returns their nodes.

    Links are relative to the first of these nodes, whose depth is `depth`.
    """
    nodes = np.zeros((max(1, end - first), 16), np.float32)
    links = nodes.view(np.int32)
    memory = scratch()
    count = 0
    # A work item consists of the parent, the parent's column for the link, the
    # first row, the end row, and the depth.
    stack = np.empty((MAX_DEPTH + 2, 5), np.int64)
    stack[0] = 0, 14, first, end, depth
    height = 1
    while height:
        height -= 1
        parent, column, first, end, depth = stack[height]
        # The root has no parent; this entry is overwritten below.
        links[parent, column] = node = count
        count += 1
        middle = split(table, first, end, depth, memory)
        write_children(nodes[node], memory[1])
        for side in range(1, -1, -1):
            a, b = (first, middle) if side == 0 else (middle, end)
            if b - a <= LEAF_SIZE:
                links[node, 14 + side] = leaf_link(a, b)
            else:
                stack[height] = node, 14 + side, a, b, depth + 1
                height += 1
    return nodes[:count].copy()


@helper
def leaf_link(first: int, end: int) -> int:
    """Encodes the range of a leaf's boxes, which `leaf_range` decodes."""
    return -1 - (first * LEAF_STRIDE + end - first)
