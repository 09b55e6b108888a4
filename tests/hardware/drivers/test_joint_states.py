"""Joint states without velocities: differences behind a low pass, by hand."""

import math
from types import SimpleNamespace as Fields

import numpy as np
import pytest

from remosplat_drake.hardware.drivers.joint_states import JointStates

PERIOD = 0.02


def message(t: float, position: list[float], names=("a", "b")) -> Fields:
    stamp = Fields(sec=int(t), nanosec=round(1e9 * (t - int(t))))
    return Fields(
        header=Fields(stamp=stamp),
        name=list(names),
        position=position,
        velocity=[],
    )


def test_a_ramp_has_its_rate_and_a_step_is_smoothed():
    states = JointStates(["b", "a"], cutoff=5.0)
    assert states.read(message(10.0, [0.0, 1.0])) is None, "no rate yet"
    # The first difference is taken as it is.
    report = states.read(message(10.02, [0.0, 1.01]))
    np.testing.assert_allclose(report.v, [0.5, 0.0], atol=1e-6)
    report = states.read(message(10.04, [0.02, 1.02]))
    share = 1 - math.exp(-2 * math.pi * 5.0 * PERIOD)
    np.testing.assert_allclose(report.v, [0.5, share * 1.0], rtol=1e-3)
    assert report.utime == 10_040_000


def test_a_constant_rate_is_met_after_the_filter_s_delay():
    states = JointStates(["a"], cutoff=5.0)
    for k in range(100):
        q = 0.3 * PERIOD * max(k - 50, 0)
        report = states.read(message(1 + k * PERIOD, [q], ["a"]))
    assert report.v[0] == pytest.approx(0.3, rel=1e-3)


def test_a_gap_begins_anew_and_a_repeated_message_changes_nothing():
    states = JointStates(["a"], cutoff=5.0)
    states.read(message(1.0, [0.0], ["a"]))
    first = states.read(message(1.02, [0.01], ["a"]))
    again = states.read(message(1.02, [0.01], ["a"]))
    np.testing.assert_array_equal(first.v, again.v)
    assert states.read(message(3.0, [1.0], ["a"])) is None
    assert states.read(message(2.9, [1.0], ["a"])) is None, "a clock went back"
