"""The ramp to a standstill."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from remosplat_drake.robot.braking import (
    braking_command,
    executed_command,
    periods_between,
    spare_time,
    stopping_times,
)

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


def test_a_station_holds_a_command_for_one_and_a_half_periods():
    # Joint 0 needs 4 steps of the ramp.
    u = np.array([0.4, -0.2, 2.0])
    for age, share in (
        (0.0, 1.0),
        (0.149, 1.0),
        (0.151, 0.75),
        (0.249, 0.75),
        (0.251, 0.5),
        (0.451, 0.0),
        (99.0, 0.0),
    ):
        np.testing.assert_allclose(
            executed_command(u, LIMIT, DT, age), share * u, atol=1e-12
        )
    bad = np.array([0.1, np.nan, 0.1])
    assert not executed_command(bad, LIMIT, DT, 0.0).any()


def test_a_late_ramp_makes_up_for_what_was_held():
    u = np.array([0.4, -0.2, 2.0])
    np.testing.assert_allclose(braking_command(u, LIMIT, 2 * DT), 0.5 * u)
    assert not braking_command(u, LIMIT, 4 * DT).any()


def test_periods_are_counted_that_were_left_out():
    assert periods_between(1.0, 1.1, DT) == 1.0
    assert periods_between(1.0, 1.3, DT) == 3.0
    assert periods_between(1.0, 1.0, DT) == 1.0
    assert periods_between(1.0, 0.5, DT) == 1.0
    assert periods_between(np.nan, 0.5, DT) == 1.0


def held_by_station(u: np.ndarray, time: float) -> float:
    """For how long u would have to be held to come as far as a station."""
    knots = np.append(np.arange(0.0, time / DT, 0.5) * DT, time)
    middle = 0.5 * (knots[:-1] + knots[1:])
    share = [
        executed_command(u, LIMIT, DT, t)[0] / u[0] for t in middle.tolist()
    ]
    return float(np.diff(knots) @ share)


@given(
    speed=st.floats(0.01, 5.0),
    ages=st.lists(st.floats(0.02, 12.0), min_size=1, max_size=8),
)
@settings(max_examples=300)
def test_whenever_the_ramp_is_sent_it_ends_on_the_path(speed, ages):
    """Each step is late or early, and the last is followed by none."""
    u = np.array([speed, 0.0, 0.0])
    allowed = stopping_times(u, LIMIT, DT, spare_time(DT))[-1] * speed
    way = 0.0
    for age in ages:
        if not u.any():
            break
        way += held_by_station(u, age * DT) * u[0]
        u = braking_command(u, LIMIT, age * DT)
    if u.any():
        way += stopping_times(u, LIMIT, DT, spare_time(DT))[-1] * u[0]
    assert way <= allowed + 1e-9


@given(speed=st.floats(0.01, 5.0))
@settings(max_examples=50)
def test_the_path_ends_where_a_station_does(speed):
    u = np.array([speed, 0.0, 0.0])
    end = stopping_times(u, LIMIT, DT, spare_time(DT))[-1]
    assert end == pytest.approx(held_by_station(u, 60.0))
