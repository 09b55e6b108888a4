"""Threads for work on large arrays: NumPy and kernels release the GIL.

A process that is limited to one thread, see `ONE_THREAD`, uses no others.
"""

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import TypeVar

T = TypeVar("T")
R = TypeVar("R")

_MOST = 8
"""Largest number of threads; more would only wait for memory."""


def num_threads() -> int:
    """Returns the number of threads that this process may use.

    It is at most one for each core, and at most NUMBA_NUM_THREADS, as for
    Numba's threads.
    """
    try:
        cores = len(os.sched_getaffinity(0))
    except AttributeError:  # Only Linux provides this.
        cores = os.cpu_count() or 1
    allowed = os.environ.get("NUMBA_NUM_THREADS", "")
    if allowed.isdecimal():
        cores = min(cores, int(allowed))
    return max(1, min(cores, _MOST))


def in_parallel(function: Callable[[T], R], items: Iterable[T]) -> list[R]:
    """Calls a function with each item, on `num_threads` threads.

    Args:
        function: The function; its calls must not share data that one of them
            changes.
        items: Its arguments; put those that take longest first.

    Returns:
        Its results, in the order of the items.

    Raises:
        Exception: The exception of the first item that failed.
    """
    items = list(items)
    threads = min(num_threads(), len(items))
    if threads < 2:
        return [function(item) for item in items]
    with ThreadPoolExecutor(threads) as pool:
        return list(pool.map(function, items))


@cache
def kept_threads(name: str, threads: int) -> ThreadPoolExecutor:
    """Returns a persistent thread pool, for frequent short work.

    Starting threads would take as long as the work. A function that runs on one
    of these threads must use a pool of another name.

    Args:
        name: Name of the pool.
        threads: Number of threads.
    """
    return ThreadPoolExecutor(threads, name)


# A forked child inherits no threads.
os.register_at_fork(after_in_child=kept_threads.cache_clear)


def both(first: Callable[[], T], second: Callable[[], R]) -> tuple[T, R]:
    """Calls two functions at the same time, if two threads are allowed.

    Args:
        first: Function that this thread calls.
        second: Function that another thread calls.

    Returns:
        The results of both functions.

    Raises:
        Exception: The exception of the first function, or else of the second.
    """
    if num_threads() < 2:
        return first(), second()
    with ThreadPoolExecutor(1) as pool:
        other = pool.submit(second)
        return first(), other.result()


def blocks(n: int, size: int) -> list[slice]:
    """Splits n rows into blocks of at most `size`."""
    return [slice(k, min(k + size, n)) for k in range(0, n, size)]
