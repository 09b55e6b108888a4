"""Builds a `BoundingVolumeHierarchy` from the root down (Numba).

Large tables of boxes are first split into pieces, which are then sorted by
several threads. The hierarchy does not depend on the number of threads.
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
"""The link to a leaf encodes the leaf's first place times this factor, plus the
number of its boxes; see `leaf_range`."""

PIECE = 1 << 17
"""Largest number of boxes of a piece, which is sorted by one thread."""


@dc.dataclass
class _Part:
    """The boxes from `first` to `end`, sorted below one node at this depth.

    Attributes:
        first: Place of the first box.
        end: Place after the last one.
        depth: Depth of the node.
        nodes: The part's nodes, with links relative to the first one; only that
            one if the part has been cut in two.
        sides: The parts below it, if it has been cut.
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
    """Sorts boxes into leaf order, and returns the nodes over them.

    Nodes are numbered in preorder: a node, then the nodes below its left child,
    then the nodes below its right child.

    Args:
        table: The boxes, shape (n, 8), sorted in place.

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
    """Cuts a part in two."""
    part.nodes = np.zeros((1, 16), np.float32)
    middle = _cut_boxes(table, part.first, part.end, part.depth, part.nodes)
    part.sides = [
        _Part(first, end, part.depth + 1)
        for first, end in ((part.first, middle), (middle, part.end))
    ]
    return part.sides


def _sort(table: np.ndarray, part: _Part) -> None:
    """Sorts a part down to its leaves; a leaf is left unchanged."""
    if len(part) > LEAF_SIZE or not part.depth:
        part.nodes = _build(table, part.first, part.end, part.depth)


def _joined(root: _Part) -> np.ndarray:
    """The nodes of all parts, counted from the root."""
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
    """Partitions boxes into the two sides of a node, and fills the node in.

    Returns:
        The first box of the right side.
    """
    memory = scratch()
    middle = split(table, first, end, depth, memory)
    write_children(nodes[0], memory[1])
    return middle


@kernel
def _build(table, first, end, depth):
    """Sorts the boxes from `first` to `end` and returns the nodes over them.

    Links are indices relative to the first of these nodes, which is at `depth`.
    """
    nodes = np.zeros((max(1, end - first), 16), np.float32)
    links = nodes.view(np.int32)
    memory = scratch()
    count = 0
    # Work items: parent, its column for the link, first, end, depth.
    stack = np.empty((MAX_DEPTH + 2, 5), np.int64)
    stack[0] = 0, 14, first, end, depth
    height = 1
    while height:
        height -= 1
        parent, column, first, end, depth = stack[height]
        # The root's own entry is overwritten below.
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
    """Encodes the range of a leaf's boxes, as `leaf_range` decodes it."""
    return -1 - (first * LEAF_STRIDE + end - first)
