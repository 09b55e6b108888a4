"""`Trees`: the two trees of a search, in growing arrays."""

import math
from typing import NamedTuple

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.base.kernels.returns import WHOLE

START, GOAL = 0, 1
"""Indices of the tree that grows from the start, and of the tree that grows
from the goals."""

ROOT = -1
"""Parent of a tree's roots."""

_YAW = 2
"""Index in q of the base's yaw. It is the only entry of q that wraps."""


_CAPACITY = 512
"""New trees have memory for this many nodes in addition to their roots."""


class Trees(NamedTuple):
    """Two trees of configurations, with memory for m nodes in each.

    Attributes:
        q: The configurations, shape (2, n_q, m) [rad, m]. The values of each
            entry of q are contiguous over the nodes, so that nearest-neighbour
            searches are vectorised.
        parent: Parent of each node, shape (2, m); `ROOT` for a root.
        count: Number of nodes, shape (2,).
    """

    q: np.ndarray
    parent: np.ndarray
    count: np.ndarray

    @staticmethod
    def rooted(start: np.ndarray, goals: np.ndarray) -> "Trees":
        """Makes trees that contain only roots, with memory for more nodes.

        Args:
            start: Start of the paths, shape (n_q,) [rad, m].
            goals: Possible ends of the paths, shape (k, n_q) [rad, m].
        """
        k = len(goals)
        q = np.empty((2, len(start), k + _CAPACITY))
        parent = np.empty((2, k + _CAPACITY), np.int64)
        q[START, :, 0], q[GOAL, :, :k] = start, goals.T
        parent[START, 0] = parent[GOAL, :k] = ROOT
        return Trees(q, parent, np.array([1, k]))

    def with_capacity(self, more: int) -> "Trees":
        """Returns the trees with memory for more nodes in each.

        Args:
            more: Least number of further nodes.
        """
        capacity = self.q.shape[2]
        wanted = int(self.count.max()) + more
        if wanted <= capacity:
            return self
        grown = max(wanted, 2 * capacity) - capacity
        q = np.pad(self.q, ((0, 0), (0, 0), (0, grown)))
        parent = np.pad(self.parent, ((0, 0), (0, grown)), constant_values=ROOT)
        return Trees(q, parent, self.count)

    @property
    def packed(self) -> "Packed[Trees]":
        """The trees, packed for kernels, which write to the arrays."""
        return Packed(self)

    def branch(self, tree: int, node: int) -> np.ndarray:
        """Returns the configurations from a node to its root, shape (m, n_q).

        Args:
            tree: `START` or `GOAL`.
            node: The node.
        """
        nodes = []
        while node != ROOT:
            nodes.append(node)
            node = self.parent[tree, node]
        return self.q[tree][:, nodes].T


@kernel(returns=WHOLE)
def nearest(trees, tree, q, n_base):
    """Returns the node of a tree that is nearest to a configuration.

    The distance is the Euclidean distance of two q, in which a radian counts
    like a metre, and the difference of the base's yaw is wrapped.

    Args:
        trees: The `Trees`.
        tree: `START` or `GOAL`.
        q: The configuration, shape (n_q,) [rad, m].
        n_base: Number of base commands, 3, 2 or 0.
    """
    count = trees.count[tree]
    square = np.zeros(count)
    for j in range(len(q)):
        row, x = trees.q[tree, j], q[j]
        if n_base > 0 and j == _YAW:
            for i in range(count):
                d = row[i] - x
                d -= 2.0 * math.pi * math.floor(d / (2.0 * math.pi) + 0.5)
                square[i] += d * d
        else:
            for i in range(count):
                d = row[i] - x
                square[i] += d * d
    best, least = 0, np.inf
    for i in range(count):
        if square[i] < least:
            best, least = i, square[i]
    return best


@helper
def add_node(trees, tree, q, parent):
    """Adds a node to a tree that has memory for it; returns the node's index.

    Args:
        trees: The `Trees`.
        tree: `START` or `GOAL`.
        q: The configuration, shape (n_q,) [rad, m].
        parent: Index of the node's parent.
    """
    node = trees.count[tree]
    for j in range(len(q)):
        trees.q[tree, j, node] = q[j]
    trees.parent[tree, node] = parent
    trees.count[tree] = node + 1
    return node
