"""`Trees`: the two trees of a search, as arrays that grow."""

import math
from typing import NamedTuple

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.base.kernels.returns import WHOLE

START, GOAL = 0, 1
"""The tree that grows from the start, and the one that grows from the goals."""

ROOT = -1
"""Parent of a tree's roots."""

_YAW = 2
"""Entry of q that is a base's yaw; without a base, no entry is an angle that
wraps."""


class Trees(NamedTuple):
    """Two trees of configurations, with room for m of them each.

    Attributes:
        q: The configurations, shape (2, n_q, m) [rad, m]: an entry of all nodes
            lies in a row, so that a search for the nearest runs in lanes.
        parent: Node towards the root, shape (2, m); `ROOT` of a root.
        count: Number of nodes, shape (2,).
    """

    q: np.ndarray
    parent: np.ndarray
    count: np.ndarray

    @staticmethod
    def rooted(start: np.ndarray, goals: np.ndarray) -> "Trees":
        """Makes trees of roots alone.

        Args:
            start: Where paths start, shape (n_q,) [rad, m].
            goals: Where they may end, shape (k, n_q) [rad, m].
        """
        k = len(goals)
        q = np.zeros((2, len(start), k))
        q[START, :, 0], q[GOAL] = start, goals.T
        return Trees(q, np.full((2, k), ROOT), np.array([1, k]))

    def with_room(self, more: int) -> "Trees":
        """Returns the trees with room for at least so many more nodes in each.

        Args:
            more: Number of nodes.
        """
        room = self.q.shape[2]
        wanted = int(self.count.max()) + more
        if wanted <= room:
            return self
        grown = max(wanted, 2 * room) - room
        q = np.pad(self.q, ((0, 0), (0, 0), (0, grown)))
        parent = np.pad(self.parent, ((0, 0), (0, grown)), constant_values=ROOT)
        return Trees(q, parent, self.count)

    @property
    def packed(self) -> "Packed[Trees]":
        """The trees for kernels, which write to these arrays."""
        return Packed(self)

    def branch(self, tree: int, node: int) -> np.ndarray:
        """Returns the nodes from one to its root, both included, (m, n_q).

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

    Distances are those of q as a vector, radians and metres alike, except for
    the yaw of a base, which takes the shorter way.

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
    """Adds a node to a tree, which has room, and returns its number.

    Args:
        trees: The `Trees`.
        tree: `START` or `GOAL`.
        q: The configuration, shape (n_q,) [rad, m].
        parent: Node that it hangs on.
    """
    node = trees.count[tree]
    for j in range(len(q)):
        trees.q[tree, j, node] = q[j]
    trees.parent[tree, node] = parent
    trees.count[tree] = node + 1
    return node
