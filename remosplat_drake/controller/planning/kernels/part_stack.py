"""`PartStack`: parts of a motion that are still to be checked.

Each part has a list of items that are checked in it. An item is a pair of
links, or a ball or a sphere.
"""

from typing import NamedTuple

import numpy as np

from remosplat_drake.base.kernels import helper
from remosplat_drake.base.lanes import lowest_bit
from remosplat_drake.controller.planning.kernels.motion_samples import PARTS

_DEPTH = 6
"""Largest number of times that a motion is divided."""

_MOST = 1 + _DEPTH * (PARTS - 1)
"""Largest number of parts on the stack."""


class PartStack(NamedTuple):
    """A stack of parts to check, with at most m items each.

    Python allocates this memory; `self_work.py` states the reason.

    Attributes:
        time: Start and end of each part, shape (n, 2) [s].
        count: Number of items of each part, shape (n,).
        waiting: Items of each part, shape (n, m).
        item: The items of the part that is being checked, shape (m,).
        open: For each item, the parts between two samples that are possibly not
            free, as a bit mask, shape (m,).
        next_item: Items of the parts between two samples, shape (7, m).
        next_count: Number of these items, shape (7,).
    """

    time: np.ndarray
    count: np.ndarray
    waiting: np.ndarray
    item: np.ndarray
    open: np.ndarray
    next_item: np.ndarray
    next_count: np.ndarray

    @staticmethod
    def make(m: int) -> "PartStack":
        """Allocates the memory.

        Args:
            m: Number of items.
        """
        return PartStack(
            np.zeros((_MOST, 2)),
            np.zeros(_MOST, np.int64),
            np.zeros((_MOST, m), np.int64),
            np.zeros(m, np.int64),
            np.zeros(m, np.int64),
            np.zeros((PARTS, m), np.int64),
            np.zeros(PARTS, np.int64),
        )


@helper
def begin_parts(parts, count):
    """Puts the whole motion on an empty stack.

    Args:
        parts: The `PartStack`, with the motion's items in `item`.
        count: Number of these items.

    Returns:
        The number of parts on the stack.
    """
    parts.time[0, 0], parts.time[0, 1], parts.count[0] = 0.0, 1.0, count
    for row in range(count):
        parts.waiting[0, row] = parts.item[row]
    return 1 if count else 0


@helper
def take_part(parts, top):
    """Takes the topmost part from the stack, which is checked next.

    Args:
        parts: The `PartStack`.
        top: Number of parts on the stack before the topmost part is taken.

    Returns:
        Start and end of the part [s], and the number of its items.
    """
    last = top - 1
    for row in range(parts.count[last]):
        parts.item[row] = parts.waiting[last, row]
    return parts.time[last, 0], parts.time[last, 1], parts.count[last]


@helper
def push_parts(parts, top, start, step, count):
    """Puts the parts that are possibly not free on the stack.

    Args:
        parts: The `PartStack`.
        top: Number of parts on the stack.
        start: Time of the first sample [s].
        step: Time between two samples [s].
        count: Number of items that were checked.

    Returns:
        The number of parts on the stack; -1 if it is full.
    """
    parts.next_count[:] = 0
    for row in range(count):
        left = parts.open[row]
        while left:
            k = lowest_bit(left)
            left &= left - 1
            parts.next_item[k, parts.next_count[k]] = parts.item[row]
            parts.next_count[k] += 1
    for k in range(PARTS):
        if parts.next_count[k] == 0:
            continue
        if top == len(parts.count):
            return -1
        parts.time[top, 0] = start + k * step
        parts.time[top, 1] = start + (k + 1) * step
        parts.count[top] = parts.next_count[k]
        for row in range(parts.next_count[k]):
            parts.waiting[top, row] = parts.next_item[k, row]
        top += 1
    return top
