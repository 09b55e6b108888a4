"""Work that threads share."""

import os
import threading

import pytest

from remosplat_drake.base import threads
from remosplat_drake.base.child_process import one_thread_environment
from remosplat_drake.base.threads import blocks, both, in_parallel, num_threads


def test_results_come_in_order():
    assert in_parallel(lambda x: x * x, range(50)) == [x * x for x in range(50)]
    assert in_parallel(str, []) == []


def test_one_thread_is_the_caller_s_own(monkeypatch):
    monkeypatch.setattr(threads, "_ALLOWED", "1")
    assert num_threads() == 1
    names = in_parallel(lambda _: threading.current_thread(), range(3))
    assert set(names) == {threading.current_thread()}


def test_starting_children_changes_nothing_for_good():
    """Whoever leaves first, the last one restores; and nobody counts less."""
    before, threads_before = dict(os.environ), num_threads()
    one, two = one_thread_environment(), one_thread_environment()
    one.__enter__()
    two.__enter__()
    assert os.environ["NUMBA_NUM_THREADS"] == "1"
    assert num_threads() == threads_before
    one.__exit__(None, None, None)
    assert os.environ["NUMBA_NUM_THREADS"] == "1"
    two.__exit__(None, None, None)
    assert dict(os.environ) == before


def test_what_one_raises_is_raised():
    with pytest.raises(ZeroDivisionError):
        in_parallel(lambda x: 1 / x, [2, 1, 0])


@pytest.mark.parametrize("count", [1, 2])
def test_both_are_done(monkeypatch, count):
    monkeypatch.setattr(threads, "num_threads", lambda: count)
    assert both(lambda: 1, lambda: "a") == (1, "a")
    for pair in ((lambda: 1 / 0, lambda: 1), (lambda: 1, lambda: 1 / 0)):
        with pytest.raises(ZeroDivisionError):
            both(*pair)


def test_blocks_cover_all_rows_once():
    for n, size in ((0, 3), (1, 3), (3, 3), (10, 3)):
        rows = [k for b in blocks(n, size) for k in range(n)[b]]
        assert rows == list(range(n))
        assert all(b.stop - b.start <= size for b in blocks(n, size))
