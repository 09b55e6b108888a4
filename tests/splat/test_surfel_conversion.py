"""Discs from ellipsoids and back, against the rotation matrices."""

import dataclasses as dc

import numpy as np
from toy_splats import random_splat

from remosplat_drake.splat.surfel_conversion import (
    THICKNESS,
    flattened,
    is_flat,
    with_thickness,
    without_thickness,
)


def test_the_shortest_axis_becomes_the_normal():
    splat = random_splat(3, n=200)
    discs = flattened(splat)
    shortest = splat.scales.argmin(axis=1)
    assert set(shortest) == {0, 1, 2}
    for i, axis in enumerate(shortest):
        others = [(axis + 1) % 3, (axis + 2) % 3]
        np.testing.assert_allclose(
            discs.R_GK[i], splat.R_GK[i][:, [*others, axis]], atol=1e-6
        )
        np.testing.assert_array_equal(discs.scales[i], splat.scales[i, others])
    # The rest is as it was, and an equal last axis stays the normal.
    np.testing.assert_array_equal(discs.p_GK, splat.p_GK)
    ball = dc.replace(splat, scales=np.ones((200, 3)))
    np.testing.assert_allclose(flattened(ball).R_GK, ball.R_GK, atol=1e-6)
    assert flattened(discs) is discs


def test_thickness_is_recognised():
    discs = random_splat(2)
    thick = with_thickness(discs)
    assert with_thickness(thick) is thick
    np.testing.assert_allclose(thick.scales[:, 2], THICKNESS, rtol=1e-6)
    assert is_flat(thick)
    assert not is_flat(discs)
    assert not is_flat(random_splat(3))
    again = without_thickness(thick)
    np.testing.assert_array_equal(again.scales, discs.scales)
    np.testing.assert_allclose(again.R_GK, discs.R_GK, atol=1e-6)
    # As thin, but of a thickness of its own: no disc.
    scales = thick.scales.copy()
    scales[0, 2] *= 1.1
    assert not is_flat(dc.replace(thick, scales=scales))
    # All alike, but thick.
    scales[:, 2] = 0.01
    assert not is_flat(dc.replace(thick, scales=scales))
