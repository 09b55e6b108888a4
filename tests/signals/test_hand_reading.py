"""A hand's width tells whether it may hold something."""

import numpy as np
import pytest

from remosplat_drake.signals.hand_reading import HandReading


def reading(width=0.06, rate=0.0):
    return HandReading.of(np.array([width, rate, 20.0]))


@pytest.mark.parametrize(
    ("width", "narrower", "let_go"),
    [
        (0.061, False, False),  # It was pushed apart.
        (0.056, False, False),  # Its pads give way.
        (0.054, True, True),  # A can of 60 mm has turned or is gone.
        (0.066, False, True),  # The hand has opened.
        (np.nan, False, False),  # The width is not known.
    ],
)
def test_the_width_tells_whether_something_is_held(width, narrower, let_go):
    assert reading(width).is_narrower(0.06) == narrower
    assert reading(width).has_let_go(0.06) == let_go


def test_a_width_that_is_no_number_is_not_known():
    assert reading().is_known
    assert not reading(np.nan).is_known


def test_fingers_rest_when_the_width_does_not_change():
    assert reading(rate=0.001).at_rest
    assert not reading(rate=-0.1).at_rest
