"""The ramp to a standstill."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from remosplat_drake.controller.verification.braking import braking_command

LIMIT = np.array([1.0, 2.0, 10.0])
DT = 0.1


def test_the_slowest_joint_sets_the_pace():
    # In steps of 0.1, 0.2 and 1: joint 0 needs 4 steps, the others fewer.
    u = np.array([0.4, -0.2, 2.0])
    np.testing.assert_allclose(braking_command(u, LIMIT, DT), [0.3, -0.15, 1.5])


def test_the_last_step_stops():
    u = np.array([0.1, -0.2, 0.5])
    np.testing.assert_array_equal(braking_command(u, LIMIT, DT), np.zeros(3))


def test_standing_still_stays():
    np.testing.assert_array_equal(
        braking_command(np.zeros(3), LIMIT, DT), np.zeros(3)
    )


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_an_unknown_command_is_replaced_by_a_standstill(bad):
    u = np.array([0.1, bad, 0.1])
    np.testing.assert_array_equal(braking_command(u, LIMIT, DT), np.zeros(3))


@given(u=st.tuples(*[st.floats(-5, 5)] * 3))
@settings(max_examples=100)
def test_the_ramp_is_straight_within_limits_and_ends(u):
    u = np.array(u)
    steps = int(np.ceil((np.abs(u) / (LIMIT * DT)).max())) + 1
    for _ in range(steps):
        slower = braking_command(u, LIMIT, DT)
        assert (np.abs(slower - u) <= LIMIT * DT * (1 + 1e-9)).all()
        # A shrunken u: the robot stays on the path it was on.
        np.testing.assert_allclose(
            np.linalg.norm(slower) * u, np.linalg.norm(u) * slower, atol=1e-12
        )
        u = slower
    np.testing.assert_array_equal(u, np.zeros(3))
