"""Paths by their arc length."""

import numpy as np
import pytest

from remosplat_drake.controller.program.path import Path

CORNER = Path.through(np.array([[0.0, 0], [3, 0], [3, 0], [3, 4]]))


def test_lengths_are_counted_along_the_path():
    assert CORNER.s.tolist() == [0, 3, 7]
    assert CORNER.length == 7
    assert CORNER.at(5.0) == pytest.approx([3, 2])
    assert CORNER.at(-1.0) == pytest.approx([0, 0])
    assert CORNER.at(9.0) == pytest.approx([3, 4])


def test_the_nearest_point_is_found_and_how_far_it_is():
    assert CORNER.nearest(np.array([2.0, -1.0])) == pytest.approx((2.0, 1.0))
    assert CORNER.nearest(np.array([3.5, 2.0])) == pytest.approx((5.0, 0.5))


def test_where_a_path_comes_by_twice_the_later_time_counts():
    there_and_back = Path.through(np.array([[0.0], [2], [1]]))
    assert there_and_back.nearest(np.array([1.5])) == pytest.approx((2.5, 0))


def test_a_path_can_be_cut_off():
    part = CORNER.until(5.0)
    assert part.q == pytest.approx(np.array([[0, 0], [3, 0], [3, 2]]))
    assert CORNER.until(0.0).at(1.0) == pytest.approx([0, 0])
    assert CORNER.until(0.0).nearest(np.array([0.0, 2])) == (0, 2)
