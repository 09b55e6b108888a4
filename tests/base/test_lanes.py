"""Lanes give what numbers alone give, to the last bit."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from remosplat_drake.base.kernels import kernel
from remosplat_drake.base.lanes import (
    FEW,
    WIDTH,
    columns_of,
    exponential,
    few_lanes_from,
    first_lanes,
    greatest,
    greatest_of,
    in_all,
    lane_of,
    lanes_from,
    least,
    lowest_bit,
    magnitude,
    places_of,
    root,
    round_down,
    round_up,
    where,
    write_lanes,
)

_FLOATS = st.floats(-1e3, 1e3)
_EIGHT = st.lists(_FLOATS, min_size=WIDTH, max_size=WIDTH).map(np.array)


@kernel
def _calculate(a, b, c, out):
    x, y = lanes_from(a, 0), lanes_from(b, 0)
    write_lanes(out, 0, (x + y * c) / 3 - (-x))
    write_lanes(out, 8, root(magnitude(x - 2.5)))
    write_lanes(out, 16, greatest(least(x, y), c) + round_up(x) * 0.5)
    write_lanes(out, 24, where((x < y) | (x >= c), round_down(y), 1.0))
    write_lanes(out, 32, in_all(c))
    return places_of((x > 0.0) & ~(y <= c))


@kernel
def _calculate_a_few(a, place, n, out):
    x = few_lanes_from(a, place)
    write_lanes(out, 1, where(first_lanes(n, x), x, -1.0))


@kernel
def _singles(a, place):
    x, y = lanes_from(a, 0), few_lanes_from(a, 0)
    return greatest_of(x), greatest_of(y), lane_of(x, place)


@kernel
def _alone(x, y):
    return greatest(x, y), where(x < y, 1, 2.0), round_down(x), exponential(x)


@kernel
def _exponential(a, out):
    write_lanes(out, 0, exponential(lanes_from(a, 0)))


@kernel
def _columns(array, places, out):
    columns = columns_of(array, places)
    for i in range(len(columns)):
        write_lanes(out, i * WIDTH, columns[i])


@kernel
def _bits(bits):
    found = []
    while bits:
        found.append(lowest_bit(bits))
        bits &= bits - 1
    return found


@given(_EIGHT, _EIGHT, _FLOATS)
def test_lanes_are_numbers_side_by_side(a, b, c):
    out = np.empty((5, WIDTH))
    bits = _calculate(a, b, c, out)
    expected = [
        (a + b * c) / 3 - (-a),
        np.sqrt(np.abs(a - 2.5)),
        np.maximum(np.minimum(a, b), c) + np.ceil(a) * 0.5,
        np.where((a < b) | (a >= c), np.floor(b), 1.0),
        np.full(WIDTH, c),
    ]
    np.testing.assert_array_equal(out, expected)
    met = (a > 0) & (b > c)
    assert bits == sum(1 << i for i in np.flatnonzero(met).tolist())


@given(_EIGHT, _FLOATS)
def test_what_is_not_a_number_compares_as_false(a, c):
    a = np.where(np.arange(WIDTH) % 2, a, np.nan)
    bits = _calculate(a, np.full(WIDTH, c + 1), c, np.empty((5, WIDTH)))
    assert bits & 0b01010101 == 0


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("n", [-1, 0, 1, 3, 4, 9])
def test_a_few_are_read_from_anywhere_and_written_there(dtype, n):
    numbers = np.arange(12.0, dtype=dtype).reshape(3, 4) + 0.1
    out = np.zeros(FEW + 2)
    _calculate_a_few(numbers, 5, n, out)
    expected = numbers.reshape(-1)[5 : 5 + FEW].astype(float)
    expected[max(n, 0) :] = -1.0
    np.testing.assert_array_equal(out, [0.0, *expected, 0.0])


@given(st.lists(st.floats(-700, 0), min_size=WIDTH, max_size=WIDTH))
def test_powers_of_e_are_right_but_for_the_last_digit(exponents):
    a, out = np.array(exponents), np.empty(WIDTH)
    _exponential(a, out)
    np.testing.assert_allclose(out, np.exp(a), rtol=5e-16)
    # One lane does as all, and as a number does.
    assert [_alone(x, 0.0)[3] for x in exponents] == out.tolist()


def test_the_power_of_nothing_is_one_and_of_very_little_nearly_nothing():
    out = np.empty(WIDTH)
    _exponential(np.array([0.0, -0.0, -1e9, -np.inf, -701, -1, -2, -3]), out)
    assert out[:2].tolist() == [1.0, 1.0]
    assert (out[2:5] < 1e-300).all()
    assert out[5] == pytest.approx(1 / math.e, rel=1e-15)


def test_numbers_alone_are_numbers():
    assert _alone(-1.5, 2.0)[:3] == (2.0, 1.0, -2.0)


@given(st.integers(0, 2**32 - 1))
def test_rows_become_lanes_by_column(seed):
    rng = np.random.default_rng(seed)
    array, places = rng.normal(size=(20, 16)), rng.integers(0, 20, WIDTH)
    out = np.empty((16, WIDTH))
    _columns(array, places, out)
    np.testing.assert_array_equal(out, array[places].T)


@given(st.sets(st.integers(0, 62), min_size=1))
def test_bits_come_from_the_lowest_on(places):
    assert _bits(sum(1 << place for place in places)) == sorted(places)


@given(_EIGHT, st.integers(0, WIDTH - 1))
def test_the_greatest_lane_and_any_single_one_are_read(a, place):
    assert _singles(a, place) == (a.max(), a[:FEW].max(), a[place])
