"""Functions that kernels call by their addresses."""

import gc
from typing import NamedTuple

import numpy as np
import pytest

from remosplat_drake.base.address_calls import (
    DONE,
    MISFIT,
    RAISED,
    AddressedFunction,
    call_address,
)
from remosplat_drake.base.kernels import kernel
from remosplat_drake.base.kernels.packed import Packed


class Inner(NamedTuple):
    """What is packed already, or not yet."""

    matrix: np.ndarray
    number: float


class Told(NamedTuple):
    """Values of all kinds."""

    vector: np.ndarray
    packed: Inner
    inner: Inner
    count: int
    is_there: bool
    mask: np.ndarray
    several: tuple


class Settings(NamedTuple):
    """Settings of a function."""

    gain: float
    offsets: np.ndarray


@kernel
def calls(words, packed, vector, mask, count):
    """Tells a function what a kernel knows."""
    inner = Inner(np.full((2, 3), 5.0), 0.25)
    several = (count + 1, vector)
    told = Told(vector, packed, inner, count, count > 2, mask, several)
    return call_address(words, told)


def told(n: int) -> Packed[Told]:
    inner = Inner(np.zeros((0, 0)), 0.0)
    vector, mask = np.zeros(n), np.zeros(n, bool)
    return Packed(Told(vector, inner, inner, 0, True, mask, (0, vector)))


def work(own, told):
    """Reads everything, and writes."""
    total = own.gain * (own.offsets.sum() + told.packed.matrix.sum())
    total += 10.0 * told.inner.matrix[1, 2] + told.inner.number
    total += 100.0 * told.count + 1000.0 * told.several[0]
    if told.is_there:
        total += 1e4
    if told.count == 7:
        raise ValueError("seven")
    for i in range(len(told.vector)):
        if told.mask[i]:
            told.vector[i] = total / (told.count - 3)


@pytest.fixture(scope="module")
def function() -> AddressedFunction:
    settings = Packed(Settings(2.0, np.array([1.0, 2.0])))
    return AddressedFunction(work, settings, told(0))


def run(function, count: int) -> tuple[int, np.ndarray]:
    vector, mask = np.ones(3), np.array([True, False, True])
    packed = Packed(Inner(np.full((3, 4), 0.5), 1.0))
    ended = calls(function.words, packed, vector, mask, count)
    return ended, vector


def test_it_reads_and_writes_what_the_kernel_has(function):
    gc.collect()
    ended, vector = run(function, 4)
    assert ended == DONE
    total = 2.0 * (3.0 + 6.0) + 50.0 + 0.25 + 400.0 + 5000.0 + 1e4
    np.testing.assert_array_equal(vector, [total, 1.0, total])


def test_it_divides_as_numpy_does(function):
    ended, vector = run(function, 3)
    assert ended == DONE
    np.testing.assert_array_equal(vector, [np.inf, 1.0, np.inf])


def test_what_it_raises_ends_the_call_alone(function):
    assert run(function, 7)[0] == RAISED
    assert run(function, 4)[0] == DONE


def test_it_is_not_called_with_what_it_was_not_compiled_for():
    settings = Packed(Settings(2.0, np.zeros(2)))
    inner = Packed(Inner(np.zeros((0, 0)), 0.0))
    function = AddressedFunction(ignore, settings, inner)
    ended, vector = run(function, 4)
    assert ended == MISFIT
    np.testing.assert_array_equal(vector, 1.0)


def ignore(own, told):
    pass


def test_settings_that_look_alike_share_their_code(function):
    settings = Packed(Settings(0.0, np.zeros(5)))
    other = AddressedFunction(work, settings, told(4))
    assert other.words[0] == function.words[0]
    _, vector = run(other, 4)
    assert vector[0] == 50.0 + 0.25 + 400.0 + 5000.0 + 1e4
