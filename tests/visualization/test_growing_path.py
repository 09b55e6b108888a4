"""Tests of traces that are sent piece by piece."""

import numpy as np
import pytest
from pydrake.geometry import Rgba

from remosplat_drake.visualization.growing_path import GrowingPath


@pytest.fixture
def dut(page) -> GrowingPath:
    return GrowingPath(page, "/trace", Rgba(1, 1, 0))


def walk(dut, steps, start=0):
    for k in range(start, start + steps):
        dut.append(np.array([0.1 * k, 0.0, 0.0]), time=0.1 * k)


def test_needs_two_points(dut, page):
    walk(dut, 1)
    assert not page.meshcat.HasPath("/trace/0")
    walk(dut, 1, start=1)
    assert page.meshcat.HasPath("/trace/0")


def test_old_pieces_are_not_sent_again(dut, page):
    walk(dut, 13)
    first = page.meshcat._GetPackedObject("/trace/0")
    second = page.meshcat._GetPackedObject("/trace/1")
    walk(dut, 3, start=13)
    # Every object that is sent gets identifiers of its own.
    assert page.meshcat._GetPackedObject("/trace/0") == first
    assert page.meshcat._GetPackedObject("/trace/1") != second


def test_standing_still_sends_nothing(dut, page):
    walk(dut, 2)
    packed = page.meshcat._GetPackedObject("/trace/0")
    dut.append(np.array([0.1, 0.001, 0.0]), time=9.0)
    assert page.meshcat._GetPackedObject("/trace/0") == packed


def test_clear_removes_all(dut, page):
    walk(dut, 30)
    dut.clear()
    assert not page.meshcat.HasPath("/trace")
    walk(dut, 2)
    assert page.meshcat.HasPath("/trace/0")
