"""Tests of display and linear colours."""

import numpy as np

from remosplat_drake.base.colors import linear_rgb


def test_display_colours_become_linear():
    # By hand: 0.5 -> ((0.5 + 0.055) / 1.055)^2.4 = 0.2140.
    srgb = np.array([-0.1, 0.0, 0.02, 0.5, 1.0, 1.3])
    expected = [0.0, 0.0, 0.02 / 12.92, 0.214041, 1.0, 1.0]
    np.testing.assert_allclose(linear_rgb(srgb), expected, atol=1e-6)


def test_the_two_branches_meet():
    below, above = linear_rgb(np.array([0.04045, 0.04045 + 1e-9]))
    np.testing.assert_allclose(below, above, atol=1e-7)
