"""Tests of the ground-truth solids."""

import numpy as np
from pydrake.math import RigidTransform

from remosplat_drake.scene.primitive_scene import Box, Cylinder, PrimitiveScene
from remosplat_drake.visualization.truth_view import TRUTH, TruthView


def test_truth_is_drawn_but_hidden_until_asked_for(page, is_visible, pose_of):
    X_WP = RigidTransform([1.0, 2.0, 3.0])
    scene = PrimitiveScene(
        boxes=(Box(RigidTransform(), np.array([0.1, 0.2, 0.3])),),
        cylinders=(Cylinder(X_WP, 0.1, 0.5),),
    )
    TruthView(page, scene)
    assert page.meshcat.HasPath(f"{TRUTH}/box_0")
    np.testing.assert_array_equal(
        pose_of(page.meshcat, f"{TRUTH}/cylinder_0"), X_WP.GetAsMatrix4()
    )
    assert not is_visible(page.meshcat, TRUTH)
