"""A queue of tree nodes, approximately ordered by key (Numba).

Keys are sorted into buckets of equal width. Within a bucket, the latest node
comes first, so that successive nodes are near in memory.
"""

from typing import NamedTuple

import numpy as np

from remosplat_drake.base.kernels import helper
from remosplat_drake.base.lanes import greatest, least

BUCKETS = 64
"""Number of buckets. With few, the order is too coarse; with many, empty
buckets cost more than needless visits of nodes."""

_SIZE, _BUCKET = range(2)


class NodeQueue(NamedTuple):
    """The queued nodes, with a fixed capacity.

    Attributes:
        keys: Key of each node.
        items: Number of each node, with data of the caller.
        links: Place of the next node in the same bucket, -1 at the end.
        first: Place of the first node of each bucket, -1 without one.
        scale: Buckets per unit of the key, shape (1,).
        count: Number of nodes pushed so far, and the first bucket that may be
            non-empty.
    """

    keys: np.ndarray
    items: np.ndarray
    links: np.ndarray
    first: np.ndarray
    scale: np.ndarray
    count: np.ndarray


def new_queue(room: int) -> NodeQueue:
    """Makes a queue with room for a number of nodes."""
    return NodeQueue(
        keys=np.empty(room),
        items=np.empty(room, np.int64),
        links=np.empty(room, np.int32),
        first=np.empty(BUCKETS, np.int32),
        scale=np.empty(1),
        count=np.zeros(2, np.int64),
    )


@helper
def clear(queue, limit):
    """Empties a queue for keys up to a limit."""
    queue.first[:] = -1
    queue.scale[0] = BUCKETS / limit if limit > 0 else 0.0
    queue.count[_SIZE] = 0
    queue.count[_BUCKET] = 0


@helper
def push(queue, key, item) -> bool:
    """Adds a node to the queue.

    If nodes with larger keys were already removed, it is the next one to be
    removed.

    Returns:
        Whether there was room for it.
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
    """Removes a node of the first bucket; returns its index, -1 for none."""
    bucket = queue.count[_BUCKET]
    while queue.first[bucket] < 0:
        bucket += 1
        if bucket == BUCKETS:
            return -1
    queue.count[_BUCKET] = bucket
    place = queue.first[bucket]
    queue.first[bucket] = queue.links[place]
    return place
