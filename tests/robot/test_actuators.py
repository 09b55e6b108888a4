"""The actuator model: exact steps, of any length."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from remosplat_drake.base.errors import FieldError
from remosplat_drake.robot.actuators import (
    Actuator,
    ActuatorModel,
    default_actuators,
    panda_py_actuators,
)

SPEED = st.floats(-2.0, 2.0)
KINDS = st.one_of(
    st.builds(Actuator, time_constant=st.floats(0.0, 0.3)),
    st.builds(Actuator, acceleration=st.floats(0.5, 10.0)),
    st.builds(Actuator, dead_band=st.floats(0.0, 0.3)),
)


@settings(max_examples=200)
@given(KINDS, SPEED, SPEED, st.floats(1e-3, 0.5), st.floats(0.0, 1.0))
def test_two_short_steps_are_one_long_step(axis, v, target, dt, share):
    whole, way = axis.step(v, target, dt)
    halfway, first = axis.step(v, target, share * dt)
    end, second = axis.step(halfway, target, (1.0 - share) * dt)
    assert end == pytest.approx(whole, abs=1e-12)
    assert first + second == pytest.approx(way, abs=1e-12)


@settings(max_examples=100)
@given(KINDS, SPEED, SPEED)
def test_the_way_is_the_integral_of_the_velocity(axis, v, target):
    n, dt = 2000, 2e-4
    _, way = axis.step(v, target, n * dt)
    summed = 0.0
    for _ in range(n):
        after, _ = axis.step(v, target, dt)
        summed, v = summed + 0.5 * (v + after) * dt, after
    # A jump at the start costs half a step.
    assert summed == pytest.approx(way, abs=2.5 * dt)


def test_a_lag_nears_its_command_by_the_exponential():
    v, way = Actuator(time_constant=0.2).step(0.0, 1.0, 0.2)
    assert v == pytest.approx(1 - math.exp(-1))
    assert way == pytest.approx(0.2 * math.exp(-1))


def test_a_ramp_is_at_its_command_when_it_says():
    assert Actuator(acceleration=2.0).step(0.0, 1.0, 1.0) == (1.0, 0.75)


def test_a_dead_band_swallows_what_is_too_slow():
    axis = Actuator(dead_band=0.01)
    assert axis.step(0.0, 0.009, 1.0) == (0.0, 0.0)
    assert axis.step(0.0, -0.011, 1.0) == (-0.011, -0.011)


def test_a_lag_and_a_ramp_exclude_each_other():
    with pytest.raises(FieldError, match="cannot be used with a time_constant"):
        Actuator(time_constant=0.1, acceleration=1.0)


@settings(max_examples=50)
@given(st.lists(KINDS, min_size=3, max_size=3), st.data())
def test_a_response_is_that_of_small_steps_behind_a_delay_line(kinds, data):
    tick, per_tick = 0.01, 10
    delays = [data.draw(st.integers(0, 20)) * tick / 10 for _ in kinds]
    axes = [
        Actuator(d, k.time_constant, k.acceleration, k.dead_band)
        for k, d in zip(kinds, delays, strict=True)
    ]
    rng = np.random.default_rng(data.draw(st.integers(0, 99)))
    u = rng.uniform(-1, 1, (12, 3))
    sent = 100.0 + tick * np.arange(12)
    until = 100.0 + tick * np.arange(1, 16)
    found, speeds = ActuatorModel.make(axes).response(
        sent, u, np.full(3, 100.0), np.zeros(3), np.tile(until[:, None], 3)
    )
    for j, axis in enumerate(axes):
        v = way = 0.0
        late = round(axis.delay / tick * per_tick)
        for i in range(15 * per_tick):
            k = (i - late) // per_tick
            target = u[min(k, 11), j] if k >= 0 else 0.0
            v, x = axis.step(v, target, tick / per_tick)
            way += x
            if (i + 1) % per_tick == 0:
                row = i // per_tick
                assert way == pytest.approx(found[row, j], abs=1e-9)
                # At a jump either side of it is right.
        assert v == pytest.approx(speeds[-1, j], abs=1e-6) or late == 0


def test_panda_pys_law_lags_as_its_gains_say():
    lags = [1e3 * axis.time_constant for axis in panda_py_actuators()]
    np.testing.assert_allclose(lags, [83, 83, 83, 33, 80, 133, 200], atol=0.5)


def test_the_defaults_cover_a_robot_that_follows_at_once():
    for axis in default_actuators(2, 7):
        assert axis.delay <= axis.tube
