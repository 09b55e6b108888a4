"""Normals of depth images."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from remosplat_drake.reconstruction.surfels.normals import depth_normals
from remosplat_drake.reconstruction.surfels.normals_reference import (
    depth_normals_reference,
)

K = np.array([[20.0, 0, 10], [0, 22, 8], [0, 0, 1]])


def test_a_wall_straight_ahead_faces_the_camera():
    normal = depth_normals(K, np.full((16, 20), 2.0))
    np.testing.assert_allclose(normal[8, 10], [0, 0, -1], atol=1e-7)
    assert np.isnan(normal[0]).all()


def test_a_slope_by_hand():
    """The plane z = 2 + x, which leans away to the right."""
    u = (np.arange(20) + 0.5 - 10) / 20
    depth = np.tile(2 / (1 - u), (16, 1))
    normal = depth_normals(K, depth)
    expected = np.array([1, 0, -1]) / np.sqrt(2)
    np.testing.assert_allclose(normal[8, 10], expected, atol=1e-6)


def test_there_is_no_normal_across_an_edge():
    depth = np.full((16, 20), 2.0)
    depth[:, 10:] = 1.0
    normal = depth_normals(K, depth)
    assert np.isnan(normal[:, 9:11]).all()
    assert np.isfinite(normal[8, 7]).all()


@given(seed=st.integers(0, 1000), holes=st.floats(0, 0.3))
@settings(max_examples=10)
def test_equals_the_reference(seed, holes):
    rng = np.random.default_rng(seed)
    depth = 1 + rng.normal(0, 0.02, (16, 20)) + rng.integers(0, 2, (16, 20))
    depth[rng.uniform(size=depth.shape) < holes] = 0
    with np.errstate(invalid="ignore"):
        expected = depth_normals_reference(K, depth)
    np.testing.assert_allclose(depth_normals(K, depth), expected, atol=1e-6)
