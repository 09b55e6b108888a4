"""The texture's kernel says what its reference says."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from remosplat_drake.capture.rendering.camera_poses import look_at
from remosplat_drake.capture.rendering.solid_texture import (
    brightness,
    brightness_reference,
)

K = np.array([[90.0, 0, 32], [0, 80, 24], [0, 0, 1]])


@given(seed=st.integers(0, 10_000))
@settings(max_examples=20)
def test_kernel_equals_reference(seed):
    rng = np.random.default_rng(seed)
    depth = rng.uniform(0.1, 8, (48, 64)).astype(np.float32)
    X_WC = look_at(*rng.normal(0, 2, (2, 3))).GetAsMatrix4()
    expected = brightness_reference(K, depth, X_WC)
    np.testing.assert_allclose(brightness(K, depth, X_WC), expected, atol=1e-6)


def test_it_is_neither_dark_nor_flat():
    depth = np.full((48, 64), 2, np.float32)
    image = brightness(K, depth, np.eye(4))
    assert 0.45 <= image.min() < image.max() <= 1.25
    assert image.std() > 0.05
