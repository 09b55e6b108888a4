"""Rendered captures: exact depth, steady colours, cameras in free space."""

import numpy as np
import pytest

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.capture.rendering.camera_poses import look_at
from remosplat_drake.capture.rendering.synthetic import (
    render_capture,
    survey_poses,
)
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.primitive_scene import PrimitiveScene


def test_rendered_depth_lies_on_the_primitives(scene, scene_capture):
    field = SignedDistanceField(scene)
    for view in range(len(scene_capture)):
        points = scene_capture.points_W(view).reshape(-1, 3)
        points = points[np.isfinite(points[:, 0])]
        assert len(points) > 0
        distance = field.clearances(Spheres.at(points)).distance
        # Drake draws a cylinder of 5 cm as a prism that is 0.1 mm flatter.
        assert np.abs(distance).max() < 3e-4


def test_surfaces_have_the_same_colour_in_every_view(scene_capture):
    """Light and texture are fixed in the world, as a splat needs them."""
    points, colors = [], []
    for view in range(len(scene_capture)):
        points.append(scene_capture.points_W(view).reshape(-1, 3))
        colors.append(scene_capture.rgb[view].reshape(-1, 3))
    points, colors = np.concatenate(points), np.concatenate(colors)
    floor = np.abs(points[:, 2]) < 1e-4
    cell = np.round(points[floor][:, :2] / 0.02).astype(int)
    _, group = np.unique(cell, axis=0, return_inverse=True)
    red = colors[floor][:, 0].astype(float)
    mean = np.bincount(group, red) / np.bincount(group)
    assert np.abs(red - mean[group]).mean() < 4


def test_nothing_is_seen_beyond_the_scene(scene):
    X_WC = look_at(np.array([0, 0, 1.0]), np.array([0, 0, 2.0]))
    up = render_capture(scene, [X_WC], 32, 24)
    assert (up.depth == 0).all()
    assert (up.rgb == 0).all()


def test_cameras_keep_clear_and_repeat(scene):
    poses = survey_poses(scene, n=20, seed=3, clearance=0.2)
    centers = np.array([pose.translation() for pose in poses])
    clearances = SignedDistanceField(scene).clearances(Spheres.at(centers))
    assert clearances.minimum() > 0.2
    again = survey_poses(scene, n=20, seed=3, clearance=0.2)
    assert all(a.IsExactlyEqualTo(b) for a, b in zip(poses, again, strict=True))


def test_survey_needs_a_target():
    with pytest.raises(RemoSplatError, match="no target"):
        survey_poses(PrimitiveScene())


def test_look_at_keeps_the_horizon_level():
    X_WC = look_at(np.array([1.0, 2, 3]), np.array([4.0, 2, 3]))
    R_WC = [[0, 0, 1], [-1, 0, 0], [0, -1, 0]]
    np.testing.assert_allclose(X_WC.rotation().matrix(), R_WC, atol=1e-12)
