"""Work that threads share."""

import os
import subprocess
import threading

import numba
import pytest

from remosplat_drake.base import threads
from remosplat_drake.base.child_process import (
    ONE_THREAD,
    ChildProcess,
    one_thread_environment,
)
from remosplat_drake.base.threads import blocks, both, in_parallel, num_threads


def test_results_come_in_order():
    assert in_parallel(lambda x: x * x, range(50)) == [x * x for x in range(50)]
    assert in_parallel(str, []) == []


def test_one_thread_is_the_caller_s_own(monkeypatch):
    monkeypatch.setenv("NUMBA_NUM_THREADS", "1")
    assert num_threads() == 1
    names = in_parallel(lambda _: threading.current_thread(), range(3))
    assert set(names) == {threading.current_thread()}


def test_starting_children_changes_nothing_for_good():
    """Blocks that overlap: the last one that ends restores the environment."""
    before, threads_before = dict(os.environ), num_threads()
    inherited = _environment_of_a_child()
    one, two = one_thread_environment(), one_thread_environment()
    one.__enter__()
    two.__enter__()
    assert _environment_of_a_child() == inherited | ONE_THREAD
    assert (dict(os.environ), num_threads()) == (before, threads_before)
    one.__exit__(None, None, None)
    assert _environment_of_a_child() == inherited | ONE_THREAD
    two.__exit__(None, None, None)
    assert _environment_of_a_child() == inherited


def _environment_of_a_child() -> dict[str, str]:
    lines = subprocess.run(["env", "-0"], capture_output=True, text=True).stdout
    return dict(line.split("=", 1) for line in lines.split("\0") if line)


def test_kernels_compile_while_a_child_is_started():
    """Numba compares its variable with its threads at each compilation."""
    numba.set_num_threads(numba.get_num_threads())  # Starts Numba's threads.
    with one_thread_environment():
        assert numba.njit(lambda x: x + 1)(1) == 2
    assert numba.njit(lambda x: x + 2)(1) == 3


def _threads_of_a_child(connection):
    connection.send((numba.get_num_threads(), num_threads()))


def test_a_child_keeps_to_one_thread():
    child = ChildProcess(_threads_of_a_child, "threads", niceness=0)
    child.start()
    connection, _ = child.wait_until_started()
    assert connection.recv() == (1, 1)
    child.end()


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
