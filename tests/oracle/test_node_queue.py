"""The queue of nodes loses none, and gives them roughly in order."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from remosplat_drake.base.kernels import kernel
from remosplat_drake.oracle.kernels.node_queue import (
    BUCKETS,
    NodeQueue,
    clear,
    new_queue,
    pop,
    push,
)


@kernel
def _push_all(queue, keys, first):
    has_room = True
    for i in range(len(keys)):
        has_room &= push(queue, keys[i], first + i)
    return has_room


@kernel
def _pop(queue):
    return pop(queue)


@kernel
def _clear(queue, limit):
    clear(queue, limit)


def _popped(queue: NodeQueue, most: int) -> list[int]:
    places = []
    while len(places) < most and (place := _pop(queue)) >= 0:
        places.append(place)
    return [int(queue.items[place]) for place in places]


@given(
    st.integers(0, 2**32 - 1),
    st.integers(0, 40),
    st.integers(0, 40),
    st.sampled_from([-1.0, 0.0, 0.3, 2.0]),
)
def test_all_come_and_near_ones_first(seed, n, between, limit):
    rng = np.random.default_rng(seed)
    # Below zero where nodes are uncertain; without an end at the root.
    keys = rng.uniform(-0.5, 3.0, n)
    late = rng.uniform(-0.5, 3.0, 10)
    keys[:1] = -np.inf
    queue = new_queue(100)
    _clear(queue, 1.0)
    _push_all(queue, np.ones(7), 0)
    _clear(queue, limit)
    assert _push_all(queue, keys, 0)
    order = _popped(queue, between)
    # Some come late, with keys below those that have gone.
    assert _push_all(queue, late, n)
    order += _popped(queue, 100)
    assert sorted(order) == list(range(n + 10))
    if limit > 0:
        width = limit / BUCKETS
        there = [i for i in order if i < n]
        sorted_keys = np.clip(keys[there], 0, limit)
        assert (np.diff(sorted_keys) >= -width * (1 + 1e-9)).all()


def test_it_says_when_it_is_full():
    queue = new_queue(3)
    _clear(queue, 1.0)
    assert _push_all(queue, np.array([0.1, 0.2, 0.3]), 0)
    assert not _push_all(queue, np.array([0.4]), 3)
    assert sorted(_popped(queue, 9)) == [0, 1, 2]
