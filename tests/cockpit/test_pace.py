"""The pace of a simulation beside the wall clock."""

import pytest

from remosplat_drake.cockpit.pace import Pace


def test_a_third_of_real_time():
    dut = Pace()
    for k in range(100):
        dut.add(0.032 * k, 0.1 * k)
    assert dut.share == pytest.approx(0.32)


def test_a_moment_tells_nothing_and_a_new_run_starts_anew():
    dut = Pace()
    assert dut.share is None
    for k in range(50):
        dut.add(0.1 * k, 0.1 * k)
    assert dut.share == pytest.approx(1.0)
    dut.add(0.0, 5.0)
    assert dut.share is None
