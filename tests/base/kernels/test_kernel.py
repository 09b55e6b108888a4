"""Kernels that call each other by their addresses."""

import os
import subprocess
import sys
from collections import namedtuple
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from numba import types
from numba.core.errors import TypingError

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.packed import Packed, PackedType


class Scale(NamedTuple):
    factor: np.ndarray
    most: int


@kernel(returns=types.float64)
def scaled(scale, x, k):
    if k > scale.most:
        raise ValueError("too far", k)
    return scale.factor[k] * x


@helper
def both(scale, x):
    return scaled(scale, x, 0) + scaled(scale, x, 1)


@kernel
def extremes(x):
    return x.min(), x.max(), x.copy()


@kernel
def caller(factor, x, k):
    low, high, copy = extremes(x)
    scale = Scale(factor, 1)
    return both(scale, high - low) + scaled(scale, copy.sum(), k)


FACTOR, X = np.array([2.0, 3.0]), np.array([1.0, 4.0])


def test_they_call_each_other_with_all_kinds_of_values():
    assert caller(FACTOR, X, 1) == 2 * 3 + 3 * 3 + 3 * 5


def test_named_tuples_are_handed_over_packed():
    caller(FACTOR, X, 1)
    (variant,) = scaled.variants
    assert isinstance(variant.arguments[0], PackedType)
    assert scaled(Packed(Scale(FACTOR, 1)), 2.0, 1) == 6.0
    assert scaled.variants == [variant]


@kernel
def calls_the_caller(factor, x, k):
    return caller(factor, x, k)


def test_what_one_raises_goes_through_all():
    with pytest.raises(ValueError, match=r"too far.*2"):
        calls_the_caller(FACTOR, X, 2)
    with pytest.raises(ValueError, match=r"too far.*2"):
        scaled(Packed(Scale(FACTOR, 1)), 2.0, 2)


@kernel(returns=types.int64)
def half(x):
    return 0.5 * x


@kernel
def uses_half(x):
    return half(x)


def test_one_that_returns_something_else_than_it_says_is_refused():
    with pytest.raises(TypingError, match="half returns float64, not int64"):
        uses_half(1.0)


@kernel
def first_factor(scale):
    return scale.factor


@kernel
def borrows(factor):
    return first_factor(Scale(factor, 0)).sum()


def test_none_returns_the_memory_of_an_argument():
    """It might be freed while it is read."""
    with pytest.raises(RuntimeError, match="first_factor returns an array"):
        borrows(FACTOR)


def test_one_that_is_not_loaded_stops_its_caller():
    caller(FACTOR, X, 1)
    (variant,) = extremes.variants
    address, variant._cell.value = variant._cell.value, 0
    try:
        with pytest.raises(RuntimeError, match="extremes is not compiled"):
            caller(FACTOR, X, 1)
    finally:
        variant._cell.value = address
    assert caller(FACTOR, X, 1) == 30.0


def test_arrays_of_all_layouts():
    x = np.arange(12.0).reshape(3, 4).T[::2]
    low, high, copy = extremes(x)
    assert (low, high) == (0.0, 10.0)
    np.testing.assert_array_equal(copy, x)


def test_named_tuples_whose_fields_change_places_are_told_apart():
    """Numba's names of their types have the class and the types alone."""

    def kinds_of(*names):
        pair = namedtuple("Pair", names)
        return types.NamedUniTuple(types.float64, 2, pair)

    @kernel
    def first(pair):
        return pair.a

    kinds = kinds_of("a", "b"), kinds_of("b", "a")
    assert str(kinds[0]) == str(kinds[1])
    files = {
        first.variant((types.Tuple((kind, types.int64)),)).file
        for kind in kinds
    }
    assert len(files | {first.variant((kind,)).file for kind in kinds}) == 4


ELSEWHERE = """
from test_kernel import *
print(caller(FACTOR, X, 1), all(
    variant.was_kept
    for function in (caller, scaled, extremes)
    for variant in function.variants
))
"""


def elsewhere(program: str) -> str:
    result = subprocess.run(
        [sys.executable, "-c", program],
        cwd=Path(__file__).parent,
        capture_output=True,
        text=True,
    )
    assert result.returncode == 0, result.stderr
    return result.stdout


def test_other_processes_find_them_all_on_disk():
    caller(FACTOR, X, 1)
    assert elsewhere(ELSEWHERE) == "30.0 True\n"


SLOW = """
import threading, time
import kernels_of_threads as mine
from remosplat_drake.base.kernels import compilation
finish = compilation.finish
def finish_slowly(variant):
    begun.set()
    time.sleep(0.5)
    finish(variant)
compilation.finish = finish_slowly
begun = threading.Event()
answers = []
first = threading.Thread(target=lambda: answers.append(mine.outer(1.0)))
first.start()
begun.wait()
answers.append(mine.outer(2.0))
first.join()
answers.append(mine.inner(4.0))
print(sorted(answers))
"""


@pytest.mark.slow
def test_no_thread_calls_one_before_all_that_it_calls_is_there(tmp_path):
    (tmp_path / "kernels_of_threads.py").write_text(
        "from remosplat_drake.base.kernels import kernel\n"
        "from remosplat_drake.base.kernels.returns import REAL\n"
        "@kernel(returns=REAL)\n"
        "def inner(x):\n    return 2.0 * x\n"
        "@kernel\n"
        "def outer(x):\n    return inner(x) + 1.0\n"
    )
    for _ in range(2):  # Compiled, and from disk.
        result = subprocess.run(
            [sys.executable, "-c", SLOW],
            cwd=tmp_path,
            env=os.environ
            | {
                "NUMBA_CACHE_DIR": str(tmp_path / "kernels"),
                "REMOSPLAT_COMPILERS": "0",
            },
            capture_output=True,
            text=True,
        )
        assert result.stdout == "[3.0, 5.0, 8.0]\n", result.stderr
