"""Sine and cosine by lanes, against those of NumPy."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from remosplat_drake.base.kernels import kernel
from remosplat_drake.base.lane_angles import sine_and_cosine
from remosplat_drake.base.lanes import WIDTH, lanes_from, write_lanes


@kernel
def _angles(a, out):
    sine, cosine = sine_and_cosine(lanes_from(a, 0))
    write_lanes(out, 0, sine)
    write_lanes(out, WIDTH, cosine)


@given(st.lists(st.floats(-1e4, 1e4), min_size=WIDTH, max_size=WIDTH))
def test_sine_and_cosine_are_exact_but_for_rounding(angles):
    a, out = np.array(angles), np.empty((2, WIDTH))
    _angles(a, out)
    np.testing.assert_allclose(out, [np.sin(a), np.cos(a)], atol=4e-16)


def test_quarters_of_a_turn_keep_their_signs():
    a, out = np.arange(-3.0, 5.0) * np.pi / 2, np.empty((2, WIDTH))
    _angles(a, out)
    expected = [[1, 0, -1, 0, 1, 0, -1, 0], [0, -1, 0, 1, 0, -1, 0, 1]]
    np.testing.assert_allclose(out, expected, atol=2e-15)
