"""Colours moved against depths by a known number of pixels."""

import dataclasses as dc

import numpy as np
import pytest

from remosplat_drake.capture.checks.registration import (
    color_edges,
    depth_edges,
    measure_registration,
)


def with_moved_colors(capture, right: int, down: int):
    moved = np.roll(capture.rgb, (down, right), (1, 2))
    return dc.replace(capture, rgb=moved)


def test_rendered_images_are_registered(scene_capture):
    registration = measure_registration(scene_capture)
    assert registration is not None
    # In twelve small images chance may move the best match by some pixels.
    assert np.hypot(*registration.shift) <= 1.5 * registration.tolerance
    assert not registration.is_off


def test_edges_of_what_hides_the_scene_do_not_count(scene_capture):
    hidden = np.zeros(scene_capture.depth.shape, bool)
    hidden[:, 60:] = True
    masked = dc.replace(scene_capture, hidden=hidden)
    striped = masked.rgb.copy()
    striped[:, 60:, ::4] = 255
    found = measure_registration(dc.replace(masked, rgb=striped))
    expected = measure_registration(masked)
    assert found is not None and expected is not None
    # The border of what is hidden remains.
    assert found.correlation == pytest.approx(expected.correlation, abs=0.05)


@pytest.mark.parametrize(("right", "down"), [(8, 0), (0, 8), (-6, 5)])
def test_a_shift_is_measured(scene_capture, right, down):
    moved = measure_registration(with_moved_colors(scene_capture, right, down))
    assert moved is not None
    assert moved.correlation > moved.unshifted
    still = measure_registration(scene_capture)
    assert still is not None
    expected = np.array(still.shift) - (right, down)
    assert np.abs(np.array(moved.shift) - expected).max() <= 2


def test_few_images_or_edges_say_nothing(scene_capture):
    assert measure_registration(scene_capture.select(np.arange(2))) is None
    flat = np.ones_like(scene_capture.depth)
    assert measure_registration(dc.replace(scene_capture, depth=flat)) is None


def test_edges_of_a_step():
    depth = np.full((4, 6), 2.0)
    depth[:, 3:] = 1.0
    depth[0] = 0
    edges = depth_edges(depth)
    expected = np.zeros((4, 6))
    expected[1:, 3] = 1
    np.testing.assert_array_equal(edges, expected)
    rgb = np.zeros((4, 6, 3), np.uint8)
    rgb[:, 3:] = 100
    np.testing.assert_array_equal(color_edges(rgb)[0], [0, 0, 50, 50, 0, 0])
