"""The 1 kHz filter: its bounds hold for every input, and it arrives."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from remosplat_drake.hardware.drivers.panda_limits import (
    AT_REST,
    LIMITER,
    PANDA,
    TICK,
    JointCommand,
    limit_rate,
    low_pass,
    next_command,
)

targets = st.lists(
    st.tuples(
        st.lists(st.floats(-5, 5), min_size=7, max_size=7),
        st.integers(1, 60),
    ),
    min_size=1,
    max_size=6,
)


def commands(steps, advance) -> np.ndarray:
    """Joint rates tick by tick, from rest, shape (n + 1, 7)."""
    command = AT_REST
    velocities = [command.velocity]
    for target, ticks in steps:
        for _ in range(ticks):
            command = advance(np.array(target), command)
            velocities.append(command.velocity)
    return np.array(velocities)


@pytest.mark.parametrize("advance", [limit_rate, next_command])
@settings(max_examples=25)
@given(steps=targets)
def test_no_target_makes_the_robot_abort(advance, steps):
    velocity = commands(steps, advance)
    acceleration = np.diff(velocity, axis=0, prepend=0) / TICK
    jerk = np.diff(acceleration, axis=0, prepend=0) / TICK
    assert (np.abs(velocity) <= PANDA.velocity).all()
    assert (np.abs(acceleration) <= PANDA.acceleration).all()
    assert (np.abs(jerk) <= PANDA.jerk).all()


def test_the_first_tick_by_hand():
    """From rest the jerk bounds it: qdd = 7500 * 1e-3, qd = qdd * 1e-3."""
    command = limit_rate(np.full(7, 1.0), AT_REST, PANDA)
    np.testing.assert_allclose(command.acceleration, PANDA.jerk * 1e-3)
    np.testing.assert_allclose(command.velocity, PANDA.jerk * 1e-6)
    assert command.velocity[0] == pytest.approx(0.0075)


def test_a_small_step_is_taken_at_once():
    command = limit_rate(np.full(7, 1e-3), AT_REST)
    np.testing.assert_allclose(command.velocity, 1e-3)


def test_the_limiters_velocity_bound():
    """Joint 1: 2.175 - 0.001 - 3 * 0.001 * 15."""
    assert LIMITER.velocity[0] == pytest.approx(2.129)


@settings(max_examples=20)
@given(target=st.lists(st.floats(-2, 2), min_size=7, max_size=7))
def test_a_constant_target_is_reached_without_overshoot(target):
    velocity = commands([(target, 600)], next_command)
    np.testing.assert_allclose(velocity[-1], target, atol=1e-4)
    ahead = np.abs(velocity) - np.abs(target)
    assert ahead.max() < 1e-3


def test_a_target_beyond_the_bound_is_approached_from_below():
    velocity = commands([(np.full(7, 9.0), 600)], next_command)
    assert (velocity <= LIMITER.velocity).all()
    np.testing.assert_allclose(velocity[-1], LIMITER.velocity, atol=1e-4)


def test_the_low_pass_halves_a_step_in_its_time_constant():
    """Tau = 1 / (2 pi 30 Hz) = 5.3 ms; ln 2 tau = 3.7 ms."""
    value = np.zeros(1)
    for _ in range(4):
        value = low_pass(np.ones(1), value)
    assert value[0] == pytest.approx(0.5, abs=0.01)


def test_standing_still_asks_for_nothing():
    command = next_command(np.zeros(7), AT_REST)
    assert not command.velocity.any()
    assert not command.acceleration.any()


def test_braking_from_full_speed_takes_what_the_acceleration_allows():
    """Joint 2: 2.1515 rad/s at 7.5 rad/s^2 is 287 ms, and a short tail."""
    fast = JointCommand(LIMITER.velocity, np.zeros(7))
    command, ticks = fast, 0
    while np.abs(command.velocity).max() > 1e-3:
        command = next_command(np.zeros(7), command)
        ticks += 1
    assert 287 <= ticks <= 340
