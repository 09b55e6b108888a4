"""Work on large arrays that threads share: NumPy and kernels let go of the GIL.

Where a process is to keep to one thread, see `ONE_THREAD`, nothing is shared.
"""

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import TypeVar

T = TypeVar("T")
R = TypeVar("R")

_MOST = 8
"""Threads beyond this wait for the memory."""


def num_threads() -> int:
    """Returns how many threads may share the work of this process.

    At most one for each of its cores, and no more than NUMBA_NUM_THREADS, as
    with Numba's own threads.
    """
    try:
        cores = len(os.sched_getaffinity(0))
    except AttributeError:  # Only Linux tells.
        cores = os.cpu_count() or 1
    allowed = os.environ.get("NUMBA_NUM_THREADS", "")
    if allowed.isdecimal():
        cores = min(cores, int(allowed))
    return max(1, min(cores, _MOST))


def in_parallel(function: Callable[[T], R], items: Iterable[T]) -> list[R]:
    """Calls a function with each item, on as many threads as are allowed.

    Args:
        function: It changes nothing that its other calls read or change.
        items: Its arguments; those that take longest come first.

    Returns:
        Its results, in the order of the items.

    Raises:
        Exception: What the first of the items that failed has raised.
    """
    items = list(items)
    threads = min(num_threads(), len(items))
    if threads < 2:
        return [function(item) for item in items]
    with ThreadPoolExecutor(threads) as pool:
        return list(pool.map(function, items))


@cache
def kept_threads(name: str, threads: int) -> ThreadPoolExecutor:
    """Returns threads that wait for work that comes again and again.

    For short work starting them would take as long. Whoever may be called by
    one of them needs others, of another name.

    Args:
        name: What they work on.
        threads: Number of threads.
    """
    return ThreadPoolExecutor(threads, name)


# A forked child has none of them.
os.register_at_fork(after_in_child=kept_threads.cache_clear)


def both(first: Callable[[], T], second: Callable[[], R]) -> tuple[T, R]:
    """Calls two functions at the same time, if two threads are allowed.

    Args:
        first: Is called by this thread.
        second: Is called by another one.

    Returns:
        What they return.

    Raises:
        Exception: What one of them has raised, or else the other.
    """
    if num_threads() < 2:
        return first(), second()
    with ThreadPoolExecutor(1) as pool:
        other = pool.submit(second)
        return first(), other.result()


def blocks(n: int, size: int) -> list[slice]:
    """Cuts n rows into blocks of at most so many."""
    return [slice(k, min(k + size, n)) for k in range(0, n, size)]
