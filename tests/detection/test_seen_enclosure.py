"""Boxes around points, and the stretches behind them."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from remosplat_drake.detection.enclosure import MOST_PARTS, RoundedBox, enclose
from remosplat_drake.detection.enclosure_reference import fit

seeds = st.integers(0, 2**32 - 1)


@given(seed=seeds, n=st.integers(1, 60), most=st.integers(1, MOST_PARTS))
@settings(max_examples=60)
def test_every_stretch_lies_within_one_box(seed, n, most):
    rng = np.random.default_rng(seed)
    face_W = rng.normal(size=(n, 3)) * rng.uniform(0.01, 1, 3)
    back_W = face_W + rng.uniform(0, 0.3) * rng.normal(size=3)
    boxes = enclose(face_W, back_W, 0.02, most)
    assert 1 <= len(boxes) <= most
    depth = [
        np.maximum(box.distance(face_W), box.distance(back_W)) for box in boxes
    ]
    assert np.min(depth, axis=0).max() <= -0.02 + 1e-9


@given(seed=seeds, n=st.integers(1, 60))
@settings(max_examples=60)
def test_the_kernel_fits_as_its_readable_twin(seed, n):
    rng = np.random.default_rng(seed)
    p_W = rng.normal(size=(n, 3)) * [0.1, 0.3, 0.8] + rng.normal(size=3)
    (box,) = enclose(p_W, p_W, 0.02, most=1)
    expected = fit(p_W, 0.02)
    if n > 3:  # Fewer points have no axes of their own.
        assert np.isclose(box.volume, expected.volume, rtol=1e-6)
        assert np.allclose(box.p_WM, expected.p_WM, atol=1e-6)
    assert np.allclose(box.R_WM.T @ box.R_WM, np.eye(3), atol=1e-9)
    assert np.isclose(np.linalg.det(box.R_WM), 1.0)
    assert box.distance(p_W).max() <= -0.02 + 1e-9


def test_a_body_with_an_arm_gets_two_boxes():
    """One box around both would hold a lot of nothing."""
    rng = np.random.default_rng(0)
    body = rng.uniform([-0.2, -0.2, 0], [0.2, 0.2, 1.6], (200, 3))
    arm = rng.uniform([0.2, -0.05, 1.2], [0.9, 0.05, 1.3], (60, 3))
    points = np.concatenate([body, arm])
    boxes = enclose(points, points, 0.0)
    assert len(boxes) >= 2
    whole = enclose(points, points, 0.0, most=1)[0]
    assert sum(box.volume for box in boxes) < 0.75 * whole.volume


def test_volume_of_a_capsule():
    capsule = RoundedBox(np.eye(3), np.zeros(3), np.array([0, 0, 0.5]), 0.1)
    exact = np.pi * 0.01 * 1.0 + 4 / 3 * np.pi * 1e-3
    assert np.isclose(capsule.volume, exact)
