"""Views of a plane that agree, contradict each other or hide points."""

import dataclasses as dc

import numpy as np
import pytest

from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.checks.overlap import (
    compare,
    measure_overlap,
    neighbours,
    wrong_frames,
)

K = np.array([[50.0, 0, 20], [0, 50.0, 15], [0, 0, 1]])


def views_of_a_plane(heights, x=None) -> Capture:
    """Cameras that look straight up at the ceiling z = 2 m."""
    n = len(heights)
    X_WC = np.tile(np.eye(4), (n, 1, 1))
    X_WC[:, 0, 3] = np.zeros(n) if x is None else x
    X_WC[:, 2, 3] = heights
    depth = np.broadcast_to((2 - X_WC[:, 2, 3])[:, None, None], (n, 30, 40))
    return Capture(
        np.tile(K, (n, 1, 1)),
        X_WC,
        np.zeros((n, 30, 40, 3), np.uint8),
        depth.astype(np.float32),
    )


def test_views_of_a_plane_agree():
    overlap = measure_overlap(views_of_a_plane([0, 0.2, 0.4]))
    assert overlap.pairs.tolist() == [[0, 1], [0, 2], [1, 2]]
    assert overlap.agreement == 1
    np.testing.assert_allclose(overlap.agreements, 1)
    assert overlap.median < 1e-6
    assert overlap.within(1e-5) == 1
    assert wrong_frames(overlap).tolist() == []


def test_a_point_is_found_where_the_other_view_measures_it():
    capture = views_of_a_plane([0, 0.5])
    z, measured = compare(capture, np.array([[0.1, 0.05, 1.9]]), 0, 1)
    np.testing.assert_allclose(z, 1.4)
    np.testing.assert_allclose(measured, 1.5, rtol=1e-6)


def test_a_slanted_plane_is_interpolated_exactly():
    """On z = 2 + x depths between pixels are no mean of depths."""
    capture = views_of_a_plane([0, 0])
    u = np.arange(40) + 0.5
    capture.depth[:] = 2 / (1 - (u - 20) / 50)
    x = np.linspace(-0.5, 0.5, 7)
    z, measured = compare(capture, np.stack([x, 0.3 * x, 2 + x], axis=1), 0, 1)
    np.testing.assert_allclose(measured, z, rtol=1e-6)


def test_points_outside_behind_or_at_edges_are_not_compared():
    capture = views_of_a_plane([0, 0])
    capture.depth[1, :, 25:] = 4.0
    capture.depth[1, :10] = 0
    points = [
        [0, 0, -1],
        [5, 0, 2],
        [(25 - 20) / 50 * 2, 0, 2],
        [0, (5 - 15) / 50 * 2, 2],
    ]
    z, measured = compare(capture, np.array(points, float), 0, 1)
    assert np.isnan(z).all()
    assert np.isnan(measured).all()


def test_a_view_that_looks_through_anothers_points_contradicts_it():
    capture = views_of_a_plane([0, 0.1, 0.2, 0.3])
    capture.X_WC[1, 2, 3] -= 0.5
    overlap = measure_overlap(capture)
    assert wrong_frames(overlap).tolist() == [1]
    touched = (overlap.pairs == 1).any(axis=1)
    assert (overlap.agreements[touched] == 0).all()
    assert (overlap.agreements[~touched] == 1).all()


def test_a_point_behind_a_surface_may_be_hidden():
    """A view from the other side of a wall shares no surface with it."""
    capture = views_of_a_plane([0, 0])
    capture.depth[1, :, :20] = 1.0
    capture.depth[1, :, 20:] = 2.0
    overlap = measure_overlap(capture)
    assert (overlap.contradicting > 0).all()
    one_way, measured = compare(capture, np.array([[-0.2, 0, 2.0]]), 0, 1)
    assert one_way > measured


def test_neighbours_share_much_of_their_images():
    capture = views_of_a_plane(np.zeros(4), x=[0, 0.3, 5, 5.3])
    p_C = np.array([[[x, y, 2.0] for x in (-0.5, 0, 0.5) for y in (0, 0.2)]])
    pairs = neighbours(capture, np.repeat(p_C, 4, axis=0))
    assert pairs.tolist() == [[0, 1], [2, 3]]


def test_a_view_without_depth_or_company_is_not_wrong():
    capture = views_of_a_plane(np.zeros(4), x=[0, 0.1, 0.2, 9])
    capture.depth[1] = 0
    overlap = measure_overlap(capture)
    assert wrong_frames(overlap).tolist() == []
    alone = measure_overlap(capture.select(np.array([0, 3])))
    assert len(alone) == 0
    assert np.isnan(alone.agreement)
    assert np.isnan(alone.median)
    assert alone.supported == 0


@pytest.mark.parametrize("view", [0, 4, 11])
def test_a_moved_camera_is_found(scene_capture, view):
    X_WC = scene_capture.X_WC.copy()
    X_WC[view, :3, 3] += [0.15, -0.1, 0.1]
    moved = dc.replace(scene_capture, X_WC=X_WC)
    neighboured = np.unique(measure_overlap(scene_capture).pairs)
    expected = [view] if view in neighboured else []
    assert wrong_frames(measure_overlap(moved)).tolist() == expected
