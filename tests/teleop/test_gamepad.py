"""The dead-man rule, and what sticks and triggers mean."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from remosplat_drake.teleop.gamepad import (
    CLOSE,
    FASTER,
    gamepad_presses,
    gamepad_velocity,
)
from remosplat_drake.teleop.teleop_config import GamepadConfig

CONFIG = GamepadConfig(dead_man=5, speed=0.2, rotation=0.5, dead_zone=0.1)
HELD = [0.0] * 5 + [1.0] + [0.0] * 11
values = st.lists(st.floats(allow_nan=True), max_size=20)


@given(values, values)
def test_nothing_moves_without_the_dead_man_button(axes, buttons):
    buttons = [*buttons[:5], *[0.0] * (5 - len(buttons)), 0.49, *buttons[6:]]
    assert gamepad_velocity(axes, buttons, CONFIG) is None


@given(values)
def test_a_gamepad_without_that_button_moves_nothing(axes):
    assert gamepad_velocity(axes, [1.0] * 5, CONFIG) is None
    assert gamepad_velocity(axes, [], CONFIG) is None


@given(values, values)
def test_what_a_broken_gamepad_says_stays_within_bounds(axes, buttons):
    buttons = [*buttons[:5], *[0.0] * (5 - len(buttons)), 1.0, *buttons[6:]]
    V_W = gamepad_velocity(axes, buttons, CONFIG)
    assert V_W is not None
    assert (np.abs(V_W) <= [0.5] * 3 + [0.2] * 3).all()


def test_a_held_button_alone_stands_still():
    V_W = gamepad_velocity([0.05, -0.1, 0.02, 0], HELD, CONFIG)
    np.testing.assert_array_equal(V_W, np.zeros(6))


@pytest.mark.parametrize(
    ("axis", "value", "component", "expected"),
    [
        (0, -1.0, 4, 0.2),  # The left stick to the left: y.
        (1, -1.0, 3, 0.2),  # Away: x.
        (1, 0.55, 3, -0.1),  # Half of what is beyond the dead zone.
        (2, -1.0, 2, 0.5),  # The right stick to the left: yaw.
        (3, -1.0, 1, 0.5),  # Away: pitch.
    ],
)
def test_sticks(axis, value, component, expected):
    axes = np.zeros(4)
    axes[axis] = value
    wanted = np.zeros(6)
    wanted[component] = expected
    V_W = gamepad_velocity(list(axes), HELD, CONFIG)
    assert V_W is not None
    np.testing.assert_allclose(V_W, wanted, atol=1e-12)


@pytest.mark.parametrize(
    ("button", "component", "expected"),
    [(7, 5, 0.2), (6, 5, -0.2), (15, 0, 0.5), (14, 0, -0.5)],
)
def test_triggers_and_pad(button, component, expected):
    buttons = list(HELD)
    buttons[button] = 1.0
    wanted = np.zeros(6)
    wanted[component] = expected
    V_W = gamepad_velocity([0.0] * 4, buttons, CONFIG)
    assert V_W is not None
    np.testing.assert_allclose(V_W, wanted, atol=1e-12)


def test_buttons_do_something_while_the_switch_is_held():
    pressed = [1.0, *[0.0] * 11, 1.0]
    assert gamepad_presses(pressed, CONFIG) == frozenset()
    pressed[CONFIG.dead_man] = 1.0
    assert gamepad_presses(pressed, CONFIG) == {CLOSE, FASTER}
    other = GamepadConfig(dead_man=0)
    assert gamepad_presses(pressed, other) == {FASTER}


@given(values)
def test_any_buttons_are_read(buttons):
    assert len(gamepad_presses(buttons, CONFIG)) <= 4
