"""Runs functions on several threads, for work on large arrays.

Threads run in parallel, since NumPy and kernels release the GIL. A process that
is limited to one thread (see `ONE_THREAD`) starts no further threads.
"""

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import TypeVar

T = TypeVar("T")
R = TypeVar("R")

_MOST = 8
"""At most this many threads are used. More threads would not be faster, since
the memory's bandwidth limits them."""


def num_threads() -> int:
    """Returns the number of threads that this process may use.

    It is at most the number of cores, and at most the value of the environment
    variable NUMBA_NUM_THREADS, if that is set.
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
        function: The function. A call must not change data that other calls
            use.
        items: The arguments. Those for which the function takes longest should
            be first.

    Returns:
        The results, in the order of the items.

    Raises:
        Exception: A call raised this exception; if several calls did, that of
            the first item.
    """
    items = list(items)
    threads = min(num_threads(), len(items))
    if threads < 2:
        return [function(item) for item in items]
    with ThreadPoolExecutor(threads) as pool:
        return list(pool.map(function, items))


@cache
def kept_threads(name: str, threads: int) -> ThreadPoolExecutor:
    """Returns a thread pool that persists, for short work at a high rate.

    Starting new threads would take as long as the work. A function that runs on
    a thread of a pool must not use this pool, but one of another name.

    Args:
        name: Name of the pool.
        threads: Number of threads.
    """
    return ThreadPoolExecutor(threads, name)


# The key includes the process id, since a forked child inherits no threads.
os.register_at_fork(after_in_child=kept_threads.cache_clear)


def both(first: Callable[[], T], second: Callable[[], R]) -> tuple[T, R]:
    """Calls two functions, in parallel if two threads are allowed.

    Args:
        first: Function that the calling thread calls.
        second: Function that another thread calls.

    Returns:
        The results of both functions.

    Raises:
        Exception: A function raised this exception; if both did, that of the
            first.
    """
    if num_threads() < 2:
        return first(), second()
    with ThreadPoolExecutor(1) as pool:
        other = pool.submit(second)
        return first(), other.result()


def blocks(n: int, size: int) -> list[slice]:
    """Splits n rows into consecutive blocks of at most `size` rows."""
    return [slice(k, min(k + size, n)) for k in range(0, n, size)]
