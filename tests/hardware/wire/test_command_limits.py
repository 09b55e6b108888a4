"""A command keeps its direction when it is too fast for the base."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from remosplat_drake.hardware.wire.command_limits import (
    command_bounds,
    excess,
    scaled_command,
)

LOWER, UPPER = command_bounds(4, [-0.25, -0.87], [0.5, 0.87])


def test_bounds_hold_for_the_base_alone():
    np.testing.assert_array_equal(LOWER, [-0.25, -0.87, -np.inf, -np.inf])
    np.testing.assert_array_equal(UPPER, [0.5, 0.87, np.inf, np.inf])


def test_what_is_within_passes_unchanged():
    u = np.array([0.5, -0.87, 2.0, -3.0])
    np.testing.assert_array_equal(scaled_command(u, LOWER, UPPER), u)


def test_half_as_fast_backwards():
    u = scaled_command(np.array([-0.5, 0.2, 1.0, 0.0]), LOWER, UPPER)
    np.testing.assert_allclose(u, [-0.25, 0.1, 0.5, 0.0])


def test_standing_still():
    np.testing.assert_array_equal(
        scaled_command(np.zeros(4), LOWER, UPPER), np.zeros(4)
    )


def test_only_what_is_more_than_rounding_is_beyond():
    assert excess(np.array([0.5, -0.87, 9.0, 9.0]), LOWER, UPPER) is None
    assert excess(np.array([0.5001, -0.8701, 0, 0]), LOWER, UPPER) is None
    assert excess(np.array([0.0, -0.9, 0, 0]), LOWER, UPPER) == (1, -0.87)
    assert excess(np.array([-0.3, 0.9, 0, 0]), LOWER, UPPER) == (0, -0.25)


def test_a_bound_of_zero_is_one():
    lower, upper = command_bounds(1, [0.0], [0.5])
    assert excess(np.array([-1e-9]), lower, upper) is None
    assert excess(np.array([-1e-3]), lower, upper) == (0, 0.0)


@settings(max_examples=30)
@given(st.lists(st.floats(-5, 5), min_size=4, max_size=4))
def test_it_is_a_multiple_within_the_limits(values):
    u = np.array(values)
    scaled = scaled_command(u, LOWER, UPPER)
    assert (scaled >= LOWER - 1e-12).all() and (scaled <= UPPER + 1e-12).all()
    assert np.linalg.norm(scaled) <= np.linalg.norm(u) + 1e-12
    np.testing.assert_allclose(
        np.outer(scaled, u), np.outer(u, scaled), atol=1e-12
    )
