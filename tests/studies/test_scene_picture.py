"""Pictures of scenes: robot, solids and target are where they belong."""

import dataclasses as dc

import numpy as np
import pytest
from pydrake.math import RigidTransform
from pydrake.systems.sensors import CameraInfo

from apps.studies.scenes import picture
from apps.studies.scenes.picture import SceneView, robot_solids
from remosplat_drake.capture.rendering.camera_poses import look_at
from remosplat_drake.scene.primitive_scene import Cylinder, PrimitiveScene

WIDTH, HEIGHT = 160, 120


@pytest.fixture(scope="module")
def view(frankie) -> SceneView:
    return SceneView(robot_solids(frankie), WIDTH, HEIGHT)


def pixel_of(p_W) -> np.ndarray:
    """Column and row at which a point of W is drawn."""
    X_WC = look_at(picture.CAMERA_W, picture.FOCUS_W)
    K = CameraInfo(WIDTH, HEIGHT, picture.FIELD_OF_VIEW)
    p = K.intrinsic_matrix() @ (X_WC.inverse() @ np.array(p_W))
    return (p[:2] / p[2]).astype(int)


def difference(view, scene, other) -> np.ndarray:
    """Where the pictures of two scenes differ, (h, w)."""
    a, b = (np.asarray(view.draw(s)).astype(int) for s in (scene, other))
    return np.abs(a - b).max(axis=2) > 20


def test_the_robot_stands_at_its_start(view):
    without = PrimitiveScene()
    with_robot = dc.replace(without, X_WB_start=(0.1, 0.6, 0.5))
    changed = difference(view, without, with_robot)
    column, row = pixel_of([0.1, 0.6, 0.3])
    assert changed[row - 8 : row + 9, column - 8 : column + 9].mean() > 0.3
    column, row = pixel_of([0.1, -0.6, 0.3])
    assert not changed[row - 8 : row + 9, column - 8 : column + 9].any()


def test_the_target_is_drawn_over_what_hides_it(view):
    # A post that stands between the camera and the target.
    target = np.array([0.9, 0.2, 0.6])
    post = RigidTransform(target + 0.2 * (picture.CAMERA_W - target))
    hidden = PrimitiveScene(
        cylinders=(Cylinder(post, 0.2, 0.3),),
        X_WE_target=RigidTransform(target),
    )
    free = dc.replace(hidden, X_WE_target=None)
    changed = difference(view, free, hidden)
    column, row = pixel_of(target)
    assert changed[row - 1 : row + 2, column - 1 : column + 2].any()
    rows, columns = np.nonzero(changed)
    assert np.abs(rows - row).max() < 20 and np.abs(columns - column).max() < 20


def test_a_picture_repeats(view):
    scene = PrimitiveScene(X_WB_start=(0, 0, 0))
    assert not difference(view, scene, scene).any()
    assert view.draw(scene).size == (WIDTH, HEIGHT)
