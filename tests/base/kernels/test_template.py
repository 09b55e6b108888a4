"""Packed copies of a named tuple, each with memory of its own."""

import gc
from typing import NamedTuple

import numpy as np
import pytest

from remosplat_drake.base.kernels import kernel
from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.base.kernels.template import Template


class Inner(NamedTuple):
    flags: np.ndarray
    gain: float


class Outer(NamedTuple):
    table: np.ndarray
    nothing: np.ndarray
    pair: tuple
    inner: Inner


@kernel
def raised(outer):
    outer.table[0, 1] += 1.0
    count = len(outer.nothing) + outer.pair[0][0] + outer.pair[1]
    if outer.inner.flags[2]:
        count += outer.inner.gain
    return outer.table.sum() + count


@pytest.fixture
def values():
    return Outer(
        np.arange(6.0).reshape(2, 3),
        np.zeros((0, 3)),
        (np.array([7], np.int32), 2),
        Inner(np.array([False, False, True]), 0.5),
    )


def test_kernels_read_a_copy_as_the_values(values):
    copy = Template(values).copy()
    assert raised(copy) == 16.0 + 7 + 2 + 0.5
    assert copy._numba_type_ == Packed(values)._numba_type_
    np.testing.assert_array_equal(copy.table, [[0, 2, 2], [3, 4, 5]])
    assert copy.inner.gain == 0.5


def test_each_copy_has_arrays_of_its_own(values):
    template = Template(values)
    first, second = template.copy(), template.copy()
    once = raised(first)
    assert raised(first) == once + 1.0
    assert raised(second) == once
    assert values.table[0, 1] == 1.0


def test_a_packed_value_keeps_the_copies_in_it_alive(values):
    packed = Packed(Two(Template(values).copy(), 3))
    gc.collect()
    _ = [np.full(40, -1.0) for _ in range(100)]
    assert raised_within(packed) == 16.0 + 7 + 2 + 0.5


class Two(NamedTuple):
    outer: Outer | Packed[Outer]
    count: int


@kernel
def raised_within(two):
    return raised(two.outer)
