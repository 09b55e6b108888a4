"""Named tuples that kernels take by their address."""

import gc
import pickle
from typing import NamedTuple

import numpy as np
import pytest

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.packed import Packed


class Inner(NamedTuple):
    weights: np.ndarray
    gain: float


class Outer(NamedTuple):
    table: np.ndarray
    pair: tuple
    count: int
    enabled: bool
    inner: Inner


@helper
def weighted(inner):
    return inner.gain * inner.weights.sum()


@kernel
def total(outer, factor):
    first, (second, third) = outer.pair
    value = outer.table[1, 2] + first[0] + second[1] + third
    if outer.enabled:
        value += weighted(outer.inner)
    return factor * value * outer.count


@pytest.fixture
def values():
    return Outer(
        np.arange(6.0).reshape(2, 3),
        (np.array([7], np.int32), (np.array([1.0, 2.0]), 0.5)),
        3,
        True,
        Inner(np.ones(4), -2.5),
    )


def test_kernels_read_all_kinds_of_fields(values):
    assert total(Packed(values), 2.0) == 2.0 * 3 * (5 + 7 + 2 + 0.5 - 10)
    changed = values._replace(enabled=False, count=1)
    assert total(Packed(changed), 1.0) == 14.5


def test_python_reads_the_fields_as_well(values):
    packed = Packed(values)
    assert packed.count == 3 and packed.inner.gain == -2.5
    assert packed.table is values.table
    with pytest.raises(AttributeError):
        _ = packed.nothing


def test_one_type_whatever_may_be_written_and_however_it_lies(values):
    frozen = values.table.copy()
    frozen.flags.writeable = False
    strided = np.asfortranarray(values.table)
    for table in (values.table, frozen, strided):
        assert total(Packed(values._replace(table=table)), 1.0) == 13.5
    assert len(total.variants) == 1


def test_it_sees_what_is_written_later(values):
    packed = Packed(values)
    values.table[1, 2] = 105.0
    assert total(packed, 1.0) == 3 * 104.5


def test_it_keeps_its_arrays_alive(values):
    packed = Packed(values._replace(table=np.full((2, 3), 5.0)))
    gc.collect()
    _ = [np.full((2, 3), -1.0) for _ in range(100)]
    assert total(packed, 1.0) == 13.5


def test_what_is_packed_within_is_packed_with_it(values):
    inner = Packed(values.inner)
    assert total(Packed(values._replace(inner=inner)), 1.0) == 13.5


def test_a_pickle_has_addresses_of_its_own(values):
    packed = Packed(values)
    received = pickle.loads(pickle.dumps(packed))
    assert received.address != packed.address
    assert total(received, 1.0) == total(packed, 1.0)
