"""A hand's width and force tell whether it holds something."""

import numpy as np
import pytest

from remosplat_drake.signals.hand_reading import (
    HandReading,
    closed_on_nothing,
    grips,
    has_opened,
    slipped,
)

CLOSE, FORCE = 0.04, 20.0
"""Command of a grasp of a can of 60 mm."""


@pytest.mark.parametrize(
    ("width", "rate", "force", "grip", "nothing"),
    [
        (0.07, -0.1, 2.0, False, False),  # It still closes.
        (0.059, 0.0, 20.0, True, False),  # It presses on the can.
        (0.059, 0.0, 3.0, False, False),  # It has stopped, and feels nothing.
        (0.04, 0.0, 0.0, False, True),  # The can was not there.
        (0.04, 0.0, 20.0, False, True),  # Fingers may press on each other.
    ],
)
def test_a_hand_grips_what_stops_it(width, rate, force, grip, nothing):
    reading = HandReading.of(np.array([width, rate, force]))
    assert grips(reading, CLOSE, FORCE) == grip
    assert closed_on_nothing(reading, CLOSE) == nothing


@pytest.mark.parametrize(
    ("width", "force", "lost"),
    [
        (0.0588, 19.0, False),  # As it was.
        (0.0560, 19.0, True),  # A can narrower than it was has turned.
        (0.0590, 5.0, True),  # Nothing presses back.
        (0.0610, 19.0, False),  # It was pushed apart, and still presses.
    ],
)
def test_what_is_narrower_or_does_not_press_has_slipped(width, force, lost):
    assert slipped(HandReading(width, 0.0, force), 0.059, FORCE) == lost


def test_a_hand_has_opened_when_it_rests_at_its_width():
    assert has_opened(HandReading(0.079, 0.0, 0.0), 0.08)
    assert not has_opened(HandReading(0.079, 0.1, 0.0), 0.08)
    assert not has_opened(HandReading(0.05, 0.0, 0.0), 0.08)
