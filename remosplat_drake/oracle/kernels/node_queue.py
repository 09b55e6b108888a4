"""A queue of tree nodes, approximately ordered by key (Numba).

Nodes are sorted into buckets by their keys; all buckets have the same width.
The node that was added last to a bucket is removed first, so that successive
nodes are near in memory.
"""

from typing import NamedTuple

import numpy as np

from remosplat_drake.base.kernels import helper
from remosplat_drake.base.lanes import greatest, least

BUCKETS = 64
"""Number of buckets. If there are too few, the order is coarse, and nodes are
visited unnecessarily. If there are too many, the search of empty buckets takes
more time than these visits."""

_SIZE, _BUCKET = range(2)


class NodeQueue(NamedTuple):
    """The queued nodes, with a fixed capacity.

    Attributes:
        keys: Key of each node, for example a range [m].
        items: Number of each node, with data of the caller.
        links: Index of the next node in the same bucket; -1 at the end.
        first: Index of the first node of each bucket; -1 if the bucket is
            empty.
        scale: Number of buckets per unit of the key, shape (1,).
        count: Number of nodes pushed so far, and the first bucket that may be
            non-empty.
    """

    keys: np.ndarray
    items: np.ndarray
    links: np.ndarray
    first: np.ndarray
    scale: np.ndarray
    count: np.ndarray


def new_queue(capacity: int) -> NodeQueue:
    """Makes an empty queue with a given capacity."""
    return NodeQueue(
        keys=np.empty(capacity),
        items=np.empty(capacity, np.int64),
        links=np.empty(capacity, np.int32),
        first=np.empty(BUCKETS, np.int32),
        scale=np.empty(1),
        count=np.zeros(2, np.int64),
    )


@helper
def clear(queue, limit):
    """Empties a queue, and prepares it for keys up to a limit."""
    queue.first[:] = -1
    queue.scale[0] = BUCKETS / limit if limit > 0 else 0.0
    queue.count[_SIZE] = 0
    queue.count[_BUCKET] = 0


@helper
def push(queue, key, item) -> bool:
    """Adds a node to the queue.

    If nodes with larger keys have been removed before, this node is the next
    one that is removed.

    Returns:
        Whether the queue had capacity for the node.
    """
    place = queue.count[_SIZE]
    if place == len(queue.keys):
        return False
    bucket = greatest(key * queue.scale[0], queue.count[_BUCKET])
    bucket = int(least(bucket, BUCKETS - 1))
    queue.keys[place], queue.items[place] = key, item
    queue.links[place] = queue.first[bucket]
    queue.first[bucket] = place
    queue.count[_SIZE] += 1
    return True


@helper
def pop(queue) -> int:
    """Removes a node with a low key; returns its index, or -1 if empty."""
    bucket = queue.count[_BUCKET]
    while queue.first[bucket] < 0:
        bucket += 1
        if bucket == BUCKETS:
            return -1
    queue.count[_BUCKET] = bucket
    place = queue.first[bucket]
    queue.first[bucket] = queue.links[place]
    return place
