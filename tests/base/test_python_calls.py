"""Calls from kernels to Python."""

import gc
import threading
import weakref
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from remosplat_drake.base.kernels import kernel
from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.base.python_calls import (
    FAILED,
    PythonCalls,
    call_python,
    packed_at,
)


class Pair(NamedTuple):
    """Two arrays."""

    a: np.ndarray
    b: np.ndarray


LIKE = Packed(Pair(np.zeros(0), np.zeros((0, 2))))


@kernel
def asks(line, vector, matrix, index, mask, number, count, flag):
    """Asks about all kinds of values, and writes after the answer."""
    pair = Pair(vector, matrix)
    answer = call_python(line, 0, (pair, index, (mask, number), count, flag))
    return answer, vector.sum() + matrix.sum()


@given(n=st.integers(0, 5), m=st.integers(0, 3), seed=st.integers(0, 99))
def test_python_reads_and_writes_what_a_kernel_asks_about(n, m, seed):
    rng = np.random.default_rng(seed)
    vector, matrix = rng.normal(size=n), rng.normal(size=(m, n))
    index, mask = rng.integers(0, 9, n), rng.random(n) < 0.5
    number, count, flag = float(rng.normal()), int(rng.integers(9)), seed % 2

    def answer(question) -> int:
        for i, expected in enumerate((vector, matrix, index, mask)):
            assert question[i].dtype == expected.dtype
            np.testing.assert_array_equal(question[i], expected)
        assert question[4] == number and question[5] == count
        assert question[6] is bool(flag)
        question[0][:] = 2.0
        return 42

    with PythonCalls(answer) as calls:
        given = vector, matrix, index, mask, number, count, bool(flag)
        found, total = asks(calls.number, *given)
    assert calls.error is None
    assert found == 42
    assert total == pytest.approx(2.0 * n + matrix.sum())


@kernel
def reads(like, line):
    """Reads what Python hands over, twice."""
    total = 0.0
    for _ in range(2):
        address = call_python(line, 1, (np.ones(1),))
        if address == FAILED:
            return -1.0
        pair = packed_at(like, address)
        total += pair.a.sum() + 10.0 * pair.b[0, 1]
    return total


def test_a_kernel_reads_what_python_hands_over():
    def hand(question) -> int:
        b = np.array([[3.0, 4.0]])
        return calls.handed(Packed(Pair(np.array([1.0, 2.0]), b)))

    with PythonCalls(hand, hand) as calls:
        assert reads(LIKE, calls.number) == 2 * 43.0


def test_an_error_is_kept_and_nothing_is_asked_afterwards():
    asked = []

    def fail(question) -> int:
        asked.append(question[0])
        raise KeyError("x")

    with PythonCalls(fail, fail) as calls:
        assert reads(LIKE, calls.number) == -1.0
        assert reads(LIKE, calls.number) == -1.0
    assert isinstance(calls.error, KeyError)
    assert len(asked) == 1


def test_after_the_block_nothing_is_asked():
    with PythonCalls(lambda question: 1, lambda question: 1) as calls:
        pass
    assert reads(LIKE, calls.number) == -1.0


def test_no_circle_is_left():
    class Answers:
        def __init__(self):
            self.calls = PythonCalls(self.answer, self.answer)

        def answer(self, question) -> int:
            return self.calls.handed(Packed(Pair(np.zeros(1), np.ones((1, 2)))))

    answers = Answers()
    alive = weakref.ref(answers)
    gc.disable()
    try:
        with answers.calls as calls:
            assert reads(LIKE, calls.number) == 20.0
        del answers, calls
        assert alive() is None
    finally:
        gc.enable()


def test_each_thread_is_answered_by_its_own():
    start = threading.Barrier(3)

    def total(k: int) -> float:
        def hand(question) -> int:
            start.wait()
            a = np.full(2, float(k))
            return calls.handed(Packed(Pair(a, np.zeros((1, 2)))))

        with PythonCalls(hand, hand) as calls:
            return reads(LIKE, calls.number)

    with ThreadPoolExecutor(3) as threads:
        assert list(threads.map(total, range(3))) == [0.0, 4.0, 8.0]
